# SPDX-License-Identifier: Apache-2.0
"""Points that the words of a block name: axis words, polar words @ ^, machine coordinates (G53)."""

from __future__ import annotations

import math

from sim.motion.gcode.block import POLAR
from sim.motion.gcode.state import State
from sim.motion.gcode.words import Word
from sim.motion.geometry.moves import Pose, pose_of


def target(state: State, values: dict[str, Word]) -> Pose:
    """End of the block in programmed coordinates; axes without a word keep their coordinate."""
    end = list(state.programmed())
    incremental = state.modes.incremental
    for index, value in state.axis_values(values):
        end[index] = end[index] + value if incremental else value
    if "@" in values or "^" in values:
        add_polar(state, values, end)
    return pose_of(end)


def add_polar(state: State, values: dict[str, Word], place: list[float]) -> None:
    """Radius @ and angle ^ about the origin of the program's X and Y; place is changed."""
    given = [values[letter] for letter in POLAR if letter in values]
    mixed = [values[letter] for letter in "XY" if letter in values]
    if mixed:
        state.report(
            mixed[0],
            f"{mixed[0].letter} together with {given[0].letter}",
            "either @ and ^ or X and Y",
            f"remove {mixed[0].text} or {given[0].text}",
        )
        return
    incremental = state.modes.incremental
    radius = math.hypot(place[0], place[1])
    angle = math.atan2(place[1], place[0])
    if radius == 0.0 and (incremental or "^" not in values):
        state.report(
            given[0],
            "at the origin there is no angle",
            "@ and ^ with G90, or another place before",
            "write for instance G90 G0 @10 ^30",
        )
        return
    if "@" in values:
        value = values["@"].value * state.modes.mm_per_unit
        radius = radius + value if incremental else value
    if "^" in values:
        value = math.radians(values["^"].value)
        angle = angle + value if incremental else value
    place[0], place[1] = radius * math.cos(angle), radius * math.sin(angle)


def absolute_target(state: State, word: Word, values: dict[str, Word]) -> Pose:
    """End of a block with G53, as `word`: coordinates of the machine, turned into programmed."""
    modes = state.modes
    polar = any(letter in values for letter in POLAR)
    if modes.incremental or modes.in_table_frame or polar or state.motion not in ("G0", "G1"):
        state.report(
            word,
            "G53 counts from the origin of the machine",
            "G0 or G1 with X Y Z A C, with G90 and outside G43.4",
            "remove G53 or switch the mode before",
        )
    end = list(state.position)
    for index, value in state.axis_values(values):
        end[index] = value
    return state.of_frame(end)
