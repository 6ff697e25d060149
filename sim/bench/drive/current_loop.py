# SPDX-License-Identifier: Apache-2.0
"""The current loops as a program alone, and that of one axis closed around an exact motor."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.program import Built, build
from sim.bench.drive.motor import Windings, phase_currents, space_vector
from sim.core.api import Core
from sim.laws.drive.current_law import AXES, MAGIC, Setting, current_law
from sim.robot.drives import Drives

OPTIONS = Options(reassociate=True, reciprocal=True)
SETTLED = 200  # periods before the step: the speed is filtered, the back EMF met


def loop_program(
    drives: Drives, setting: Setting, configuration: str = "fast", axes: Sequence[int] = AXES
) -> Built:
    """The program of these axes for a configuration of the core."""
    options = replace(OPTIONS, configuration=configuration)
    law = compile_law(current_law(drives, setting, axes), options)
    with tempfile.TemporaryDirectory() as folder:
        return build(law, Path(folder) / "current_loops.s")


def respond(
    drives: Drives,
    setting: Setting,
    axis: int,
    wanted: float,
    periods: int,
    speed: float = 0.0,
) -> np.ndarray:
    """(i_d, i_q) [A] at each period's end from a step of the ordered i_q on, shape (periods, 2).

    The program runs on the instruction-set model, on an inverter without dead time that holds the
    mean voltage ordered, and a rotor at a constant speed [m/s or rad/s].
    """
    motor = drives.motors[axis]
    scale = drives.current_scale * setting.ampere_per_count
    windings, travel, found = Windings(motor), 0.0, []
    waiting = (0.0, 0.0)  # in force in the next period
    image = loop_program(drives, setting, axes=(axis,)).image
    with Core(image, backend="iss") as core:
        for number in range(SETTLED + periods):
            angle = motor.wave * travel
            a, b, _ = phase_currents(windings.i_d, windings.i_q, angle)
            words = {
                f"q{axis}": round(travel / setting.resolution[axis]),
                f"ia{axis}": round(a / scale),
                f"ib{axis}": round(b / scale),
                f"age{axis}": 0,
                "bus": round(drives.U_dc / setting.bus_scale),
            }
            values = {name: MAGIC + word for name, word in words.items()}
            order = wanted * motor.force_per_ampere if number >= SETTLED else 0.0
            out = core.tick(**values, **{f"force{axis}": order})
            duties = [(out[f"pwm{axis}{phase}"] - MAGIC) / setting.half for phase in "abc"]
            windings.advance(*waiting, angle, motor.wave * speed, setting.period)
            waiting = space_vector(*(drives.U_dc * duty for duty in duties))
            travel += speed * setting.period
            found.append((windings.i_d, windings.i_q))
    return np.array(found[SETTLED:])


def rise_and_overshoot(i_q: np.ndarray, period: float) -> tuple[float, float]:
    """(seconds from 10 % to 90 % of the final change, overshoot as a share of it)."""
    change = i_q - i_q[0]
    final = change[-50:].mean()
    rise = int(np.argmax(change > 0.9 * final) - np.argmax(change > 0.1 * final))
    return rise * period, float(change.max() / final - 1)
