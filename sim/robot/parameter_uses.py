# SPDX-License-Identifier: Apache-2.0
"""Entries of the robot's file that a command does not use; every other entry acts or is refused.

The lists are in docs/robot_parameters.md. A test changes every entry and compares the results of
the commands with these lists.
"""

from __future__ import annotations

from dataclasses import fields

from sim.robot.drives import Drives
from sim.robot.parameters import Robot

_ROBOT = tuple(field.name for field in fields(Robot))
_DRIVES = tuple(field.name for field in fields(Drives) if field.name not in _ROBOT)
_LOOK_AHEAD = tuple(name for name in _ROBOT if name.startswith(("a_max_", "j_max_")))
_TANH = ("friction_speed_legs", "friction_speed_table")
_TRACKING = (
    *("m_s", "m_p", "J_a", "l_c", "mr_c", "J_44", "J_55", "m_4", "r_4", "g"),
    *("f_legs", "f_table", "s_max_legs", "s_max_table", "xi_c", "T_c", "e_c_legs", "e_c_table"),
    *("F_max", "tau_max_4", "tau_max_5"),
    *("friction_legs", "friction_table", *_TANH, "encoder_legs", "turn_table"),
)

UNUSED: dict[str, tuple[str, ...]] = {
    "run": _DRIVES,
    "dual": ("v_max_leg", *_LOOK_AHEAD, *_DRIVES),
    "drive": ("v_max_tool", *_LOOK_AHEAD, *_TANH),
    "bus": ("v_max_tool", "v_max_leg", *_LOOK_AHEAD, *_DRIVES),
    "motion": _DRIVES,
    "lookahead": (*_TRACKING, *_DRIVES),
    "trajectory": ("R", "v_max_leg", *_LOOK_AHEAD, *_TRACKING, *_DRIVES),
}
"""By command: `make run`, `microtick dual`, `microtick drive`, `microtick bus`, `microtick motion`,
`python -m sim.motion.lookahead` and `sim.motion.trajectory`."""
