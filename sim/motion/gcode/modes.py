# SPDX-License-Identifier: Apache-2.0
"""Words of a block that change the state for the following blocks: modes, feed, path, tools."""

from __future__ import annotations

import math

from sim.motion.gcode.block import CYCLES, SPLINES, SYSTEMS
from sim.motion.gcode.state import State
from sim.motion.gcode.tools import Tool
from sim.motion.gcode.words import Word
from sim.motion.geometry.moves import MM_PER_INCH, Plane


def select_modes(state: State, codes: dict[str, Word], values: dict[str, Word]) -> None:
    """Takes over the modal words of a block; codes by modal group, values by letter."""
    modes = state.modes
    for group, word in codes.items():
        code = word.code
        if group == "motion" and code not in SPLINES:
            if code != state.motion:
                state.sticky = {}
                if code in CYCLES and state.motion not in CYCLES:
                    axis = 3 - sum(modes.plane.axes)
                    state.initial_level = state.programmed()[axis]
            state.motion = code
        elif group == "plane":
            modes.plane = Plane(code)
        elif group == "unit":
            modes.mm_per_unit = MM_PER_INCH if code == "G20" else 1.0
        elif group == "distance":
            modes.incremental = code == "G91"
        elif group == "arc distance":
            modes.absolute_centres = code == "G90.1"
        elif group == "feed mode":
            kind = code == "G93", code == "G95"
            if kind != (modes.inverse_time, modes.per_turn):
                modes.feed = None  # the number means something else now
            modes.inverse_time, modes.per_turn = kind
        elif group == "coordinate system":
            if SYSTEMS.index(code) != modes.system_index:  # as in rs274, the one in force stays
                state.select_system(SYSTEMS.index(code))
        elif group == "retract":
            modes.retract_to_r = code == "G99"
        elif group == "tool":
            _select_tool_frame(state, word, values)
        elif group == "spindle":
            modes.turning = code if code in ("M3", "M4") else ""
            if code == "M19":
                _check_orientation(state, values)
        elif group == "lathe":
            modes.diameter = code == "G7"
        elif group == "override":
            modes.override = _override(state, word, values.get("P"))
    if "path control" in codes:
        _select_path(state, codes, values)


def _check_orientation(state: State, values: dict[str, Word]) -> None:
    """M19 R (angle) P (direction) Q (how long to wait): the numbers of LinuxCNC."""
    for letter, good, expected in (
        ("R", lambda value: 0.0 <= value <= 360.0, "R from 0 to 360, in degrees"),
        ("P", lambda value: value in (0.0, 1.0, 2.0), "P0, P1 or P2"),
        ("Q", lambda value: value > 0.0, "Q greater than 0, in seconds"),
    ):
        word = values.get(letter)
        if word is not None and not good(word.value):
            state.report(word, f"M19 with {word.text}", expected, "write for instance M19 R90")


def _override(state: State, word: Word, switch: Word | None) -> bool:
    """Whether the feed override acts after `word`, which is M48, M49 or M50 P."""
    if word.code == "M50" and switch is not None and switch.value not in (0.0, 1.0):
        state.report(
            switch, "M50 switches the feed override on or off", "P1 or P0", "write M50 P0 for off"
        )
    return word.code == "M48" or (word.code == "M50" and (switch is None or switch.value != 0.0))


def _select_path(state: State, codes: dict[str, Word], values: dict[str, Word]) -> None:
    modes, code = state.modes, codes["path control"].code
    modes.tolerance, modes.merge = (math.inf if code == "G64" else 0.0), 0.0
    modes.exact_stop = code == "G61.1"
    if code != "G64" or "single" in codes:
        return
    tolerance, merge = values.get("P"), values.get("Q")
    for word in (tolerance, merge):
        if word is not None and word.value < 0.0:
            state.report(
                word,
                "the tolerance is negative",
                f"{word.letter} of at least 0",
                "write for instance G64 P0.01",
            )
    if tolerance is not None:
        modes.tolerance = tolerance.value * modes.mm_per_unit
    merge = merge or tolerance  # as in LinuxCNC
    if merge is not None:
        modes.merge = merge.value * modes.mm_per_unit


def set_feed(state: State, word: Word | None, mm_per_unit: float) -> None:
    """F, as `word`, in a unit of so many mm; with G93 each block needs its own."""
    modes = state.modes
    if modes.inverse_time:
        modes.feed = None
    if word is None:
        return
    if word.value < 0.0:
        state.report(word, "the feed is negative", "F greater than 0", "write for instance F2000")
    modes.feed = abs(word.value) or None  # F0 is no feed; only rapids may follow
    modes.feed_mm_per_unit = mm_per_unit


def tool_number(state: State, word: Word) -> int:
    """Number of a tool of the table, 0 also after a mistake."""
    number = word.value
    if number != 0.0 and number not in state.tools:
        state.report(
            word,
            f"there is no tool {number:g}",
            f"0 or a tool of the table, which has {len(state.tools)}",
            "give the tool table, or remove the word where the tool is the one mounted",
        )
        return 0
    return int(number)


def _select_tool_frame(state: State, word: Word, values: dict[str, Word]) -> None:
    modes = state.modes
    modes.in_table_frame = word.code == "G43.4"
    modes.tool_offset = (0.0,) * 5
    if word.code == "G43":
        number = tool_number(state, values["H"]) if "H" in values else state.loaded
        modes.tool_offset = state.tools.get(number, Tool()).offset
