# SPDX-License-Identifier: Apache-2.0
"""Moves and rests on their way out of the reader, through cutter compensation while it is on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from sim.motion.gcode.block import CYCLES, LATHE, PROBES, SPLINES, THREADS
from sim.motion.gcode.compensation import Compensation, CompensationError
from sim.motion.gcode.state import State
from sim.motion.gcode.tools import Tool
from sim.motion.gcode.words import Word
from sim.motion.geometry.moves import Dwell, Move, Plane, Pose

# Words that would shift or break the contour, by modal group (those of rs274, and some more).
_REFUSED_GROUPS = ("coordinate system", "path control", "retract", "tool")
_REFUSED_BEFORE = ("tool change", "plane", "stop")
_KEPT_STOPS = ("M0", "M1", "M2", "M30", "M60", "M71")


class Output:
    """`items` of the block under work; at: word where its mistakes are reported."""

    def __init__(self, state: State) -> None:
        self.state = state
        self.items: list[Move | Dwell] = []
        self.at = Word("G", 0.0, "", 1)
        self.left: Pose | None = None  # where the tool is after G40: next to the contour
        self.must_be_straight = False  # the next move, which is the first one after G40

    def put(self, items: Iterable[Move | Dwell]) -> None:
        """Takes items with positions on the contour."""
        compensation = self.state.compensation
        for item in items:
            if isinstance(item, Move):
                self.must_be_straight = False
                if self.left is not None:
                    item = self._from(self.left, item)
                    self.left = None
            if compensation is None or compensation.radius == 0.0:
                self.items.append(item)
                continue
            try:
                self.items += compensation.add(item)
            except CompensationError as error:
                self.state.report(self.at, *error.args)
                return

    def _from(self, place: Pose, move: Move) -> Move:
        """The first move after G40, from where the tool is."""
        moved = replace(move, start=place)
        if move.feed is not None and move.turns_only_the_table != moved.turns_only_the_table:
            moved = replace(moved, feed=move.feed * self.state.modes.feed_mm_per_unit)
        return moved

    def tool_changed(self) -> None:
        """After M6 the position is where the tool is, also after G40 (as rs274)."""
        self.state.position = self.left or self.state.position
        self.left = None

    # G40, G41, G42

    def finish(self) -> None:
        """G40, or the end of the program."""
        compensation, self.state.compensation = self.state.compensation, None
        if compensation is None or not compensation.entered:
            return
        try:
            self.items += compensation.finish()
        except CompensationError as error:
            self.state.report(self.at, *error.args)
        self.left = compensation.at
        self.must_be_straight = True

    def select(self, codes: dict[str, Word], values: dict[str, Word]) -> None:
        """Takes over G40 to G42.1 and refuses words that do not go together with compensation."""
        word, before = codes.get("cutter compensation"), self.state.compensation
        if before is not None:
            self._refuse(before.plane, codes, values, _REFUSED_BEFORE)
        if word is not None and word.code == "G40":
            self.finish()
        elif word is not None:
            if before is not None:
                self.state.report(
                    word,
                    "cutter compensation is on already",
                    "G40 before, then a straight move",
                    f"write G40 before {word.text}",
                )
                return
            self._start(word, values)
        if self.state.compensation is not None:
            groups = (*_REFUSED_GROUPS, "single", "motion")
            self._refuse(self.state.compensation.plane, codes, values, groups)

    def _refuse(
        self,
        plane: Plane,
        codes: dict[str, Word],
        values: dict[str, Word],
        groups: tuple[str, ...],
    ) -> None:
        for word in (codes[group] for group in groups if group in codes):
            code = word.code
            allowed = code in _KEPT_STOPS or code == "G4"
            if code in ("G17", "G18", "G19"):
                allowed = Plane(code) is plane
            elif code == "G10":
                number = values["P"].value if "P" in values else 0.0
                allowed = number not in (0.0, self.state.modes.system_index + 1)
            elif word.letter == "G" and "motion" in groups and codes.get("motion") is word:
                allowed = code not in (*CYCLES, *LATHE, *SPLINES, *THREADS, *PROBES)
            if not allowed:
                self.state.report(
                    word,
                    f"{code} during cutter compensation",
                    "G0 G1 G2 G3 G4 and modes that do not move the contour",
                    f"write G40 before {word.text}",
                )

    def _start(self, word: Word, values: dict[str, Word]) -> None:
        found = self._radius(word, values)
        if found is None:
            return
        modes = self.state.modes
        side = 1 if word.code.startswith("G41") else -1
        if found < 0.0:
            side = -side
        if modes.in_table_frame or modes.plane is Plane.YZ:
            self.state.report(
                word,
                f"{word.code} with {'G43.4' if modes.in_table_frame else 'G19'}",
                "G17 or G18, and coordinates of the machine",
                "cutter compensation is defined in the planes XY and ZX of the machine only",
            )
            return
        start = self.left or self.state.position
        if self.state.rotation and modes.plane is not Plane.XY:
            self.state.report(
                word,
                f"{word.code} in {modes.plane.value} of a rotated coordinate system",
                "G17, or a coordinate system with R0",
                "write G10 L2 R0 with P of the system before",
            )
            return
        compensation = Compensation(modes.plane, side, abs(found), self.state.position)
        compensation.at = start
        self.left = None
        self.state.compensation = compensation

    def _radius(self, word: Word, values: dict[str, Word]) -> float | None:
        """Radius [mm] for G41 to G42.1, None after a mistake."""
        number = values.get("D")
        if word.code in ("G41.1", "G42.1"):
            if number is None:
                self.state.report(word, f"{word.code} without D", "D with the diameter", "G41.1 D6")
                return None
            return number.value * self.state.modes.mm_per_unit / 2
        tool = self.state.loaded if number is None else number.value
        if tool == 0.0 and number is None:
            self.state.report(
                word,
                f"{word.code} without a tool",
                "T and M6 before, or D with a tool of the table",
                "give the tool table with --tools, or the diameter: G41.1 D6",
            )
            return None
        if tool == 0.0:
            tool = self.state.loaded
        if tool not in self.state.tools and tool != 0.0:
            self.state.report(
                number or word,
                f"there is no tool {tool:g}",
                f"0 or a tool of the table, which has {len(self.state.tools)}",
                "give the tool table with --tools, or the diameter: G41.1 D6",
            )
            return None
        chosen = self.state.tools.get(int(tool), Tool())
        if chosen.orientation not in (0, 9):
            self.state.report(
                word,
                f"tool {tool:g} is a lathe tool (orientation {chosen.orientation})",
                "a tool that turns",
                "this machine has no lathe spindle; correct Q of the tool table",
            )
            return None
        return chosen.diameter / 2
