# SPDX-License-Identifier: Apache-2.0
"""Interpreter of RS274/NGC programs (T. Kramer et al., NISTIR 6556; LinuxCNC where that is silent).

Text in, moves out, as a stream or one Program. Accepted: G0 G1 G2 G3 (I J K or R, helices), G4,
G7 G8, G10 L2 L20, G17-G19, G20 G21, G28 G28.1, G40 (nothing to end), G43 H G49, G43.4 (coordinates
of the table, gcode_table.py), G53, G54-G59.3, G61 G61.1 G64 P Q, G80-G83 with G98 G99, G90 G91,
G90.1 G91.1, G92 G92.1-G92.3, G93 G94, polar words @ ^, T M6, M2 M30, M70-M73, O words
(gcode_flow.py), parameters and expressions (gcode_words.py), comments `( )` and `;`, one pair of
`%` lines. M0 M1 M60 and M6 are rests of 0 s: the path stops, no operator is waited for. S, M3-M5
and M7-M9 are read and do nothing, because spindle and coolant have no output here. A (tilt) and C
(rotation) are table axes in degrees in either length unit. At the start G8, G17, G21, G54, G61,
G90, G91.1, G94 and G98 hold and no motion is selected.

Two points follow one reading of the standard where machines differ: the words of a block are in
the length unit the block itself selects, and a centre-format arc without end words is a full turn.

All mistakes of a file are collected (at most MAX_ERRORS) and raised together as GcodeErrors.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from sim.motion import gcode_table as table_frame
from sim.motion.gcode_arcs import OFFSETS, Centre, arc_centre
from sim.motion.gcode_block import CYCLES, ENDS, PAUSES, POLAR, SYSTEMS, check_unused, sort_words
from sim.motion.gcode_flow import RETURNED, VALUE, Flow, FlowStop, Frame
from sim.motion.gcode_tools import NO_TOOLS
from sim.motion.gcode_words import (
    MAX_ERRORS,
    GcodeError,
    GcodeErrors,
    Key,
    LineReader,
    Word,
)
from sim.motion.moves import (
    AXES,
    HOME,
    MM_PER_INCH,
    Dwell,
    Motion,
    Move,
    Plane,
    Pose,
    Program,
    turns_only_the_table,
)
from sim.motion.path import curve_of

# LinuxCNC's G83_RAPID_DELTA: the rapid back into the hole ends so far above its bottom.
PECK_CLEARANCE_MM = 0.254


_STATE = (  # of M70, LinuxCNC's list where it has an effect here; the motion is not in it
    *("plane", "mm_per_unit", "incremental", "absolute_centres", "inverse_time", "diameter"),
    *("feed", "feed_mm_per_unit", "tolerance", "merge", "retract_to_r", "system_index"),
    *("in_table_frame", "tool_offset"),
)
_OWN_AXES = {"G10", "G28", "G28.1", "G92"}  # take the axis words of their block

# Parameters of the coordinate systems (LinuxCNC, "Numbered parameters"), in the order of AXES.
_AXIS_PARAMETER = (0, 1, 2, 3, 5)
_HOME, _G92_ACTIVE, _G92, _SYSTEM, _SYSTEM_1, _POSITION = 5161, 5210, 5211, 5220, 5221, 5420


class _TooManyErrors(Exception):
    """Ends the reading of a file with MAX_ERRORS mistakes."""


class _Parser:
    """One pass over the lines of a program; `items` yields its moves and dwells."""

    def __init__(
        self, lines: Iterable[str], file: str, start: Pose, tools: Mapping[int, Pose]
    ) -> None:
        self.file = file
        self.lines = lines
        self.errors: list[GcodeError] = []
        self.out: list[Move | Dwell] = []
        self.any_output = False
        self.position = start  # of the machine
        self.motion: str | None = None
        self.plane = Plane.XY
        self.mm_per_unit = 1.0
        self.incremental = False
        self.absolute_centres = False
        self.inverse_time = False
        self.feed: float | None = None  # the F number as programmed
        self.feed_mm_per_unit = 1.0
        self.feed_reported = False
        self.tolerance, self.merge = 0.0, 0.0
        self.in_table_frame = False
        self.diameter = False
        self.tools = tools
        self.chosen = self.loaded = 0  # tools, 0 for none
        self.tool_offset: Pose = (0.0,) * 5
        self.summed: tuple[tuple[Pose, ...], Pose] = ((), (0.0,) * 5)  # parts and sum of _offset
        self.retract_to_r = False
        self.sticky: dict[str, float] = {}  # numbers a cycle keeps, in mm and s
        self.initial_level = 0.0
        self.system: Pose = (0.0,) * 5  # offset of the coordinate system
        self.shift: Pose = (0.0,) * 5  # of G92
        self.system_index = 0
        self.parameters: dict[Key, float] = {_G92_ACTIVE: 0.0, _SYSTEM: 1.0}
        for first in (_HOME, _G92, *(_SYSTEM_1 + 20 * n for n in range(9))):
            for number in range(9):
                self.parameters[first + number] = 0.0
        self._store(_HOME, start)
        self.ended = False
        self.percent_open, self.percent_closed = False, False
        self.line, self.source = 0, ""
        self.last = 1, ""  # line read
        self.flow = Flow(
            self._numbered(),
            self._place,
            self._error,
            self._parameter,
            self.parameters,
            lambda: bool(self.errors),
            self._left,
        )

    def items(self) -> Iterator[Move | Dwell]:
        try:
            for _ in self._read_lines():
                if not self.errors:  # a text with a mistake yields nothing more
                    if self.out:
                        self.any_output = True
                        self.flow.moved()
                    yield from self.out
                self.out.clear()
        except (_TooManyErrors, FlowStop):
            pass
        if self.errors:
            raise GcodeErrors(tuple(self.errors))

    def _error(self, column: int, text: str, what: str, expected: str, help: str) -> None:
        self.errors.append(
            GcodeError(self.file, self.line, column, self.source, text, what, expected, help)
        )
        if len(self.errors) == MAX_ERRORS:
            raise _TooManyErrors

    def _error_at(self, word: Word, what: str, expected: str, help: str) -> None:
        self._error(word.column, word.text, what, expected, help)

    # Lines and words

    def _numbered(self) -> Iterator[tuple[int, str]]:
        """Lines with their numbers, without the percent lines and what follows the second."""
        for number, raw in enumerate(self.lines, start=1):
            text = raw.rstrip("\r\n").expandtabs(1)
            self.last = number, text
            if text.strip() != "%":
                yield number, text
                continue
            if self.percent_open or self.ended:
                self.percent_closed = True
                return
            if self.any_output or self.errors:
                self._place(number, text)
                self._error(
                    self.source.index("%") + 1,
                    "%",
                    "percent line inside the program",
                    "the opening percent line before the first block",
                    "put % on the first line and on the last, or on neither",
                )
            self.percent_open = True

    def _place(self, line: int, source: str) -> None:
        """Line under work, of which mistakes are told."""
        self.line, self.source = line, source

    def _read_lines(self) -> Iterator[None]:
        for number, text in self.flow.lines():
            self._place(number, text)
            known = len(self.errors)
            words, settings = LineReader(self.source, self._error, self._parameter).words()
            if words or settings:
                self._block(words, settings, clean=len(self.errors) == known)
            yield
            if self.ended and self.flow.inside:
                self.flow.finish()
                break
        self._check_end()

    def _check_end(self) -> None:
        self._place(*self.last)
        column = len(self.source) + 1
        if not self.ended and not (self.percent_open and self.percent_closed):
            self._error(
                column,
                "",
                "the program has no end",
                "M2 or M30",
                "end the program with M2; if it had one, the file is truncated",
            )
        elif self.percent_open and not self.percent_closed:
            self._error(
                column,
                "",
                "the file is truncated: the opening percent line has no partner",
                "a closing % line",
                "end the file with a line that holds only %",
            )

    # Parameters

    def _parameter(self, key: Key) -> float | None:
        if isinstance(key, int) and _POSITION <= key < _POSITION + 9:
            if key - _POSITION not in _AXIS_PARAMETER:
                return 0.0
            index = _AXIS_PARAMETER.index(key - _POSITION)
            value = self._programmed()[index]
            return value / (self.mm_per_unit if index < 3 else 1.0)
        if isinstance(key, str):
            return self._names(key).get(key)
        return self.parameters.get(key, 0.0)

    def _names(self, key: str) -> dict[Key, float]:
        """Where a name has its value: global ones begin with an underscore."""
        return self.parameters if key.startswith("_") else self.flow.frame.names

    def _store(self, first: int, pose: Pose) -> None:
        for offset, value in zip(_AXIS_PARAMETER, pose, strict=True):
            self.parameters[first + offset] = value

    def _stored(self, first: int) -> Pose:
        return tuple(self.parameters[first + offset] for offset in _AXIS_PARAMETER)

    def _set_parameters(self, settings: list[tuple[Key, float, int, str]]) -> None:
        for key, value, column, text in settings:
            if isinstance(key, int) and (_POSITION <= key < _POSITION + 9 or key == _SYSTEM):
                read_only = f"#{key}"
            elif key in (VALUE, RETURNED):
                read_only = f"#<{key}>"
            else:
                read_only = ""
            if read_only:
                self._error(
                    column,
                    text,
                    f"the parameter {read_only} is read only",
                    "another parameter",
                    "use #1 to #5000 for values of your own",
                )
            elif isinstance(key, str):
                self._names(key)[key] = value
            else:
                self.parameters[key] = value

    # Coordinates

    def _programmed(self) -> Pose:
        """The position in the coordinates of the program [mm, degree]."""
        frame = table_frame.from_machine(self.position) if self.in_table_frame else self.position
        return tuple(p - o for p, o in zip(frame, self._offset, strict=True))

    def _machine(self, programmed: Sequence[float]) -> Pose:
        frame = tuple(p + o for p, o in zip(programmed, self._offset, strict=True))
        return table_frame.to_machine(frame) if self.in_table_frame else frame

    @property
    def _offset(self) -> Pose:
        """Of programmed coordinates: coordinate system, G92 and tool."""
        parts = self.system, self.shift, self.tool_offset
        if self.summed[0] != parts:
            total = tuple(s + g + t for s, g, t in zip(*parts, strict=True))
            self.summed = parts, total
        return self.summed[1]

    def _target(self, values: dict[str, Word]) -> Pose:
        """End of the block in programmed coordinates; axes left out keep theirs."""
        end = list(self._programmed())
        for index, letter in enumerate(AXES):
            if letter in values:
                scale = self.mm_per_unit if index < 3 else 1.0
                value = values[letter].value * scale
                end[index] = end[index] + value if self.incremental else value
        if "@" in values or "^" in values:
            self._add_polar(values, end)
        return tuple(end)

    def _add_polar(self, values: dict[str, Word], place: list[float]) -> None:
        """Radius @ and angle ^ about the origin of the program's X and Y; place is changed."""
        given = [values[letter] for letter in POLAR if letter in values]
        mixed = [values[letter] for letter in "XY" if letter in values]
        if mixed:
            self._error_at(
                mixed[0],
                f"{mixed[0].letter} together with {given[0].letter}",
                "either @ and ^ or X and Y",
                f"remove {mixed[0].text} or {given[0].text}",
            )
            return
        radius = math.hypot(place[0], place[1])
        angle = math.atan2(place[1], place[0])
        if radius == 0.0 and (self.incremental or "^" not in values):
            self._error_at(
                given[0],
                "at the origin there is no angle",
                "@ and ^ with G90, or another place before",
                "write for instance G90 G0 @10 ^30",
            )
            return
        if "@" in values:
            value = values["@"].value * self.mm_per_unit
            radius = radius + value if self.incremental else value
        if "^" in values:
            value = math.radians(values["^"].value)
            angle = angle + value if self.incremental else value
        place[0], place[1] = radius * math.cos(angle), radius * math.sin(angle)

    # Blocks

    def _block(
        self, words: list[Word], settings: list[tuple[Key, float, int, str]], clean: bool
    ) -> None:
        known = len(self.errors)
        if self.ended:
            if words:
                self._error_at(
                    words[0],
                    "block after the end of the program",
                    "only comments after M2 or M30",
                    "move the block before the end of the program",
                )
            return
        values, codes = sort_words(words, self._error_at)
        self._set_parameters(settings)
        if not words:
            return
        if "stop" in codes and codes["stop"].code in ("M70", "M73"):
            self._save_state(restores=codes["stop"].code == "M73")
        if "T" in values or "tool change" in codes:
            self._select_tool(values.pop("T", None), codes)
        self._select_modes(codes, values)
        if self.diameter and "X" in values:
            values["X"] = replace(values["X"], value=values["X"].value / 2)
        self._set_feed(values.pop("F", None), codes)
        clean = clean and len(self.errors) == known
        single = codes.get("single")
        if single is not None and single.code != "G53":
            self._single(single, codes, values, clean)
        else:
            self._move(words, values, codes.get("motion"), single, clean)
        if clean:
            check_unused(values, codes, self.motion, self._error_at)
        if "stop" in codes:
            self._stop(codes["stop"], words, clean)

    def _select_modes(self, codes: dict[str, Word], values: dict[str, Word]) -> None:
        for group, word in codes.items():
            code = word.code
            if group == "motion":
                if code != self.motion:
                    self.sticky = {}
                    if code in CYCLES and self.motion not in CYCLES:
                        axis = 3 - sum(self.plane.axes)
                        self.initial_level = self._programmed()[axis]
                self.motion = code
            elif group == "plane":
                self.plane = Plane(code)
            elif group == "unit":
                self.mm_per_unit = MM_PER_INCH if code == "G20" else 1.0
            elif group == "distance":
                self.incremental = code == "G91"
            elif group == "arc distance":
                self.absolute_centres = code == "G90.1"
            elif group == "feed mode":
                self.inverse_time = code == "G93"
            elif group == "coordinate system":
                self._select_system(SYSTEMS.index(code))
            elif group == "retract":
                self.retract_to_r = code == "G99"
            elif group == "tool":
                self._select_tool_frame(word, values)
            elif group == "lathe":
                self.diameter = code == "G7"
        if "path control" in codes:
            self._select_path(codes["path control"].code, codes, values)

    def _select_path(self, code: str, codes: dict[str, Word], values: dict[str, Word]) -> None:
        self.tolerance, self.merge = (math.inf if code == "G64" else 0.0), 0.0
        if code != "G64" or "single" in codes:
            return
        tolerance, merge = values.get("P"), values.get("Q")
        for word in (tolerance, merge):
            if word is not None and word.value < 0.0:
                self._error_at(
                    word,
                    "the tolerance is negative",
                    f"{word.letter} of at least 0",
                    "write for instance G64 P0.01",
                )
        if tolerance is not None:
            self.tolerance = tolerance.value * self.mm_per_unit
        if merge is not None:
            self.merge = merge.value * self.mm_per_unit

    def _set_feed(self, word: Word | None, codes: dict[str, Word]) -> None:
        if self.inverse_time:
            self.feed = None  # each block needs its own
        if word is None:
            return
        if word.value <= 0.0:
            self._error_at(
                word, "the feed is not positive", "F greater than 0", "write for instance F2000"
            )
        self.feed = abs(word.value)
        self.feed_mm_per_unit = self.mm_per_unit

    # Stops, saved state, tools

    def _stop(self, word: Word, words: list[Word], clean: bool) -> None:
        code = word.code
        if code in ENDS:
            self.ended = True
        elif not clean:
            return
        elif code in PAUSES:
            self.out.append(Dwell(self.line, self.source.strip(), 0.0))
        elif code == "M71":
            self.flow.frame.state = None
            self.flow.frame.restores = False
        elif code == "M72":
            others = [other for other in words if other is not word and other.letter != "N"]
            if others:
                self._error_at(
                    others[0],
                    "M72 shares its block",
                    "M72 alone",
                    f"move {others[0].text} to a block of its own",
                )
            elif self.flow.frame.state is None:
                self._error_at(
                    word,
                    "there is no saved state",
                    "M70 or M73 before, in the same subroutine or main program",
                    "states are not passed to subroutines",
                )
            else:
                self._restore(self.flow.frame)

    def _save_state(self, restores: bool) -> None:
        frame = self.flow.frame
        frame.state = {name: getattr(self, name) for name in _STATE}
        frame.restores = frame.restores or restores

    def _restore(self, frame: Frame) -> None:
        for name, value in frame.state.items():
            setattr(self, name, value)
        self._select_system(self.system_index)

    def _left(self, frame: Frame) -> None:
        """A subroutine has ended."""
        if frame.restores:
            self._restore(frame)

    def _select_system(self, index: int) -> None:
        self.system_index = index
        self.parameters[_SYSTEM] = float(index + 1)
        self.system = self._stored(_SYSTEM_1 + 20 * index)

    def _tool_number(self, word: Word) -> int:
        """Number of a tool of the table, 0 also after a mistake."""
        number = word.value
        if number != 0.0 and number not in self.tools:
            self._error_at(
                word,
                f"there is no tool {number:g}",
                f"0 or a tool of the table, which has {len(self.tools)}",
                "give the tool table, or remove the word where the tool is the one mounted",
            )
            return 0
        return int(number)

    def _select_tool(self, word: Word | None, codes: dict[str, Word]) -> None:
        if word is not None:
            self.chosen = self._tool_number(word)
        if "tool change" in codes:
            self.loaded = self.chosen
            if "tool" in codes:  # rs274 alone, which tests compare with, loses its position here
                self._error_at(
                    codes["tool"],
                    f"{codes['tool'].code} in the block of M6",
                    "M6 without G43 G43.4 G49",
                    f"move {codes['tool'].text} to the next block",
                )
            self.out.append(Dwell(self.line, self.source.strip(), 0.0))

    def _select_tool_frame(self, word: Word, values: dict[str, Word]) -> None:
        self.in_table_frame = word.code == "G43.4"
        self.tool_offset = (0.0,) * 5
        if word.code == "G43":
            number = self._tool_number(values["H"]) if "H" in values else self.loaded
            self.tool_offset = self.tools.get(number, self.tool_offset)

    # Words that act once

    def _single(
        self, word: Word, codes: dict[str, Word], values: dict[str, Word], clean: bool
    ) -> None:
        motion = codes.get("motion")
        if motion is not None and motion.code != "G80" and word.code in _OWN_AXES:
            self._error_at(
                motion,
                f"{motion.code} and {word.code} both take the axis words",
                "one of them",
                f"move {motion.text} to a block of its own",
            )
            return
        polar = [values[letter] for letter in POLAR if letter in values]
        if polar and word.code in _OWN_AXES:
            self._error_at(
                polar[0],
                f"{polar[0].letter} with {word.code}",
                "X Y Z A C",
                "@ and ^ are for moves",
            )
            return
        if word.code == "G4":
            self._dwell(word, values, clean)
            if any(letter in values for letter in AXES + POLAR):
                rest = {letter: value for letter, value in values.items() if letter != "P"}
                self._move([word], rest, motion, None, clean)
        elif word.code == "G10":
            self._set_system(word, values)
        elif word.code == "G28":
            self._home(values)
        elif word.code == "G28.1":
            self._store(_HOME, self.position)
        else:
            self._set_shift(word, values)

    def _dwell(self, word: Word, values: dict[str, Word], clean: bool) -> None:
        seconds = values.get("P")
        if seconds is None or seconds.value < 0.0:
            self._error_at(
                seconds or word,
                "G4 needs a time",
                "P in seconds, of at least 0",
                "write for instance G4 P0.5",
            )
        elif clean:
            self.out.append(Dwell(self.line, self.source.strip(), seconds.value))

    def _set_system(self, word: Word, values: dict[str, Word]) -> None:
        kind, number = values.get("L"), values.get("P")
        if kind is None or kind.value not in (2.0, 20.0):
            self._error_at(
                kind or word,
                "G10 without a known L",
                "L2 (offsets) or L20 (coordinates of the position)",
                "write for instance G10 L2 P1 X10",
            )
            return
        if number is None or number.value not in range(10):
            self._error_at(
                number or word,
                "G10 without a coordinate system",
                "P1 to P9 for G54 to G59.3, P0 for the present one",
                "write for instance G10 L2 P1 X10",
            )
            return
        index = int(number.value) - 1 if number.value else int(self.parameters[_SYSTEM]) - 1
        offsets = list(self._stored(_SYSTEM_1 + 20 * index))
        frame = [
            p + s + g for p, s, g in zip(self._programmed(), self.system, self.shift, strict=True)
        ]
        for axis, letter in enumerate(AXES):
            if letter in values:
                value = values[letter].value * (self.mm_per_unit if axis < 3 else 1.0)
                if kind.value == 2.0:
                    offsets[axis] = value
                else:
                    offsets[axis] = frame[axis] - self.shift[axis] - value
        self._store(_SYSTEM_1 + 20 * index, tuple(offsets))
        if index == int(self.parameters[_SYSTEM]) - 1:
            self.system = tuple(offsets)

    def _set_shift(self, word: Word, values: dict[str, Word]) -> None:
        if word.code == "G92":
            here, shift = self._programmed(), list(self.shift)
            if not any(letter in values for letter in AXES):
                self._error_at(
                    word,
                    "G92 without axis words",
                    "the coordinates that the position shall have",
                    "write for instance G92 X0",
                )
            for axis, letter in enumerate(AXES):
                if letter in values:
                    value = values[letter].value * (self.mm_per_unit if axis < 3 else 1.0)
                    shift[axis] += here[axis] - value
            self.shift = tuple(shift)
            self._store(_G92, self.shift)
            self.parameters[_G92_ACTIVE] = 1.0
        elif word.code == "G92.3":
            self.shift = self._stored(_G92)
            self.parameters[_G92_ACTIVE] = 1.0
        else:
            self.shift = (0.0,) * 5
            self.parameters[_G92_ACTIVE] = 0.0
            if word.code == "G92.1":
                self._store(_G92, self.shift)

    def _home(self, values: dict[str, Word]) -> None:
        home, named = self._stored(_HOME), [letter in values for letter in AXES]
        if any(named):
            self._run(Motion.RAPID, self._target(values))
        end = [
            h if wanted or not any(named) else p
            for h, p, wanted in zip(home, self.position, named, strict=True)
        ]
        self._append(Motion.RAPID, tuple(end))

    # Motion

    def _move(
        self,
        words: list[Word],
        values: dict[str, Word],
        code: Word | None,
        absolute: Word | None,
        clean: bool,
    ) -> None:
        cycle = self.motion in CYCLES
        arc_words = [values[letter] for letter in OFFSETS + "R" if letter in values]
        axis_words = [values[letter] for letter in AXES + POLAR if letter in values]
        arc = self.motion in ("G2", "G3")
        if not arc_words and not axis_words:
            if code is not None and clean and code.code not in ("G0", "G1", "G80"):
                self._error_at(
                    code,
                    f"{code.code} without a position",
                    "X Y Z A C" + (" I J K or R words" if arc else " words"),
                    f"give the end of the move or remove {code.text}",
                )
            return
        if self.motion is None or self.motion == "G80":
            if clean:
                self._error_at(
                    (axis_words + arc_words)[0],
                    "no motion is selected",
                    "G0, G1, G2 or G3 in this block or before",
                    f"write G0 or G1 before {(axis_words + arc_words)[0].text}",
                )
            self.position = self._machine(self._target(values))
            return
        if self.motion != "G0" and self.feed is None and not self.feed_reported:
            self.feed_reported = not self.inverse_time
            word = code or words[0]
            self._error_at(
                word,
                f"no feed is set for {self.motion}",
                "an F word in this block" + ("" if self.inverse_time else " or before"),
                "add for instance F2000 to the block",
            )
        if cycle:
            if clean and self.feed is not None:
                self._cycle(words, values, code)
            return
        motion = Motion(self.motion)
        end = self._target(values)
        if absolute is not None:
            end = self._absolute_target(absolute, values)
        if not arc:
            for word in arc_words:
                self._error_at(
                    word,
                    f"{word.letter} does not belong to {motion.value}",
                    "I, J, K and R only with G2 or G3",
                    f"remove {word.text}",
                )
        centre = None
        if arc and clean:
            centre = arc_centre(
                motion,
                self.plane,
                self._programmed(),
                end,
                values,
                code or words[0],
                self.mm_per_unit,
                self.absolute_centres,
                self._error_at,
            )
        self._run(motion, end, centre)

    def _absolute_target(self, word: Word, values: dict[str, Word]) -> Pose:
        """G53: the words are coordinates of the machine, here turned into programmed ones."""
        polar = any(letter in values for letter in POLAR)
        if self.incremental or self.in_table_frame or polar or self.motion not in ("G0", "G1"):
            self._error_at(
                word,
                "G53 counts from the origin of the machine",
                "G0 or G1 with X Y Z A C, with G90 and outside G43.4",
                "remove G53 or switch the mode before",
            )
        end = list(self.position)
        for index, letter in enumerate(AXES):
            if letter in values:
                end[index] = values[letter].value * (self.mm_per_unit if index < 3 else 1.0)
        return tuple(p - o for p, o in zip(end, self._offset, strict=True))

    def _run(self, motion: Motion, end: Pose, centre: Centre | None = None) -> None:
        """Moves to `end` in programmed coordinates, centre likewise."""
        if self.in_table_frame:
            self._run_in_table_frame(motion, end, centre)
            return
        if centre is not None:
            first, second = self.plane.axes
            offset = self._offset
            centre = centre[0] + offset[first], centre[1] + offset[second]
        self._append(motion, self._machine(end), centre)

    def _append(self, motion: Motion, end: Pose, centre: Centre | None = None) -> None:
        """Adds a move to `end` in machine coordinates."""
        start, self.position = self.position, end
        if self.errors:  # a text with a mistake yields no program
            return
        arc = motion.is_arc
        feed = None
        if motion is not Motion.RAPID and not self.inverse_time:
            feed = self._feed_per_minute(motion, start, end)
        move = Move(
            self.line,
            self.source.strip(),
            motion,
            start,
            end,
            feed,
            self.plane if arc else None,
            centre,
            self.tolerance,
            self.merge,
        )
        if motion is not Motion.RAPID and self.inverse_time:
            move = replace(move, feed=self._feed(move))
        self.out.append(move)

    def _feed(self, move: Move) -> float:
        """Feed of a move as mm/min, of one that turns only the table degree/min."""
        if self.inverse_time:
            return self.feed * _length(move)
        return self._feed_per_minute(move.motion, move.start, move.end)

    def _feed_per_minute(self, motion: Motion, start: Pose, end: Pose) -> float:
        turn = turns_only_the_table(motion, start, end)
        return self.feed if turn else self.feed * self.feed_mm_per_unit

    def _run_in_table_frame(self, motion: Motion, end: Pose, centre: Centre | None) -> None:
        """The move in pieces that are straight for the machine."""
        offset = self._offset
        start = table_frame.from_machine(self.position)
        finish = tuple(p + o for p, o in zip(end, offset, strict=True))
        if centre is not None:
            first, second = self.plane.axes
            centre = centre[0] + offset[first], centre[1] + offset[second]
        if self.errors:
            self.position = table_frame.to_machine(finish)
            return
        plane = self.plane if motion.is_arc else None
        whole = Move(self.line, self.source.strip(), motion, start, finish, 1.0, plane, centre)
        straight = Motion.RAPID if motion is Motion.RAPID else Motion.LINEAR
        # Minutes of the whole move at its feed, as the tool sees it on the work piece.
        length = _length(whole)
        feed = 0.0 if motion is Motion.RAPID else self._feed(whole)
        poses = table_frame.pieces(whole)
        for number, pose in enumerate(poses):
            move = Move(
                self.line,
                whole.source,
                straight,
                self.position,
                pose,
                None,
                None,
                None,
                self.tolerance,
                self.merge if len(poses) == 1 else 0.0,
                number > 0,
            )
            if feed > 0.0 and length > 0.0:
                move = replace(move, feed=_length(move) * len(poses) * feed / length)
            self.position = pose
            if move.feed is None and straight is Motion.LINEAR:
                continue  # stays where it is
            if straight is Motion.LINEAR and not move.feed > 0.0:
                continue
            self.out.append(move)

    # Canned cycles: LinuxCNC's sequence of moves

    def _cycle(self, words: list[Word], values: dict[str, Word], code: Word | None) -> None:
        at = code or words[0]
        first, second = self.plane.axes
        axis = 3 - first - second
        letters = AXES[:3]
        for letter in (*OFFSETS, "A", "C"):
            if letter in values:
                self._error_at(
                    values[letter],
                    f"{letter} does not belong to {self.motion}",
                    f"X Y Z R L{' P' * (self.motion == 'G82')}{' Q' * (self.motion == 'G83')}",
                    f"remove {values[letter].text}",
                )
                return
        if self.inverse_time:
            self._error_at(
                at, f"{self.motion} with G93", "feed per minute (G94)", "write G94 before"
            )
            return
        here = self._programmed()
        needed = {letters[axis]: letters[axis], "R": "R"}
        needed |= {"G82": {"P": "P"}, "G83": {"Q": "Q"}}.get(self.motion, {})
        for letter in needed:
            if letter in values:
                scale = 1.0 if letter == "P" else self.mm_per_unit
                self.sticky[letter] = values[letter].value * scale
            elif letter not in self.sticky:
                self._error_at(
                    at,
                    f"{self.motion} without {letter}",
                    f"{letter} in the first block of the cycle",
                    "write for instance G81 X10 Y10 Z-5 R2",
                )
                return
        repeats = values.get("L")
        if repeats is not None and (repeats.value < 1 or not repeats.value.is_integer()):
            self._error_at(repeats, "the number of repeats", "an integer of at least 1", "L3")
            return
        if self.sticky.get("Q", 1.0) <= 0.0 or self.sticky.get("P", 0.0) < 0.0:
            self._error_at(
                values.get("Q") or values.get("P") or at,
                "the number is too small for the cycle",
                "Q greater than 0, P of at least 0",
                "write for instance G83 Z-5 R2 Q1",
            )
            return
        retract, bottom = self.sticky["R"], self.sticky[letters[axis]]
        if self.incremental:
            retract += self.initial_level  # of the whole series, as rs274
            bottom += retract
        if bottom > retract:
            self._error_at(
                values.get("R") or at,
                "the retract plane is below the bottom of the hole",
                f"R of at least {letters[axis]}",
                "R is the height from which the feed begins",
            )
            return
        saved = self.tolerance, self.merge
        self.tolerance, self.merge = 0.0, 0.0
        place = list(here)
        level = here[axis]
        if level < retract:
            level = place[axis] = retract
            self._run(Motion.RAPID, tuple(place))
        clear = retract
        if not self.retract_to_r:
            clear = max(self.initial_level, retract)
            place[axis] = max(level, clear)  # LinuxCNC: also the way to the hole is at that level
        for _ in range(int(repeats.value) if repeats else 1):
            for index in (first, second):
                if letters[index] in values:
                    value = values[letters[index]].value * self.mm_per_unit
                    place[index] = place[index] + value if self.incremental else value
            if "@" in values or "^" in values:
                self._add_polar(values, place)
            self._hole(place, axis, retract, bottom, clear)
        self.tolerance, self.merge = saved

    def _hole(
        self, place: list[float], axis: int, retract: float, bottom: float, clear: float
    ) -> None:
        def to(motion: Motion, height: float) -> None:
            place[axis] = height
            self._run(motion, tuple(place))

        self._run(Motion.RAPID, tuple(place))
        to(Motion.RAPID, retract)
        if self.motion == "G83":
            depth = retract - self.sticky["Q"]
            while depth > bottom:
                to(Motion.LINEAR, depth)
                to(Motion.RAPID, retract)
                to(Motion.RAPID, depth + PECK_CLEARANCE_MM)
                depth -= self.sticky["Q"]
        to(Motion.LINEAR, bottom)
        if self.motion == "G82" and not self.errors:
            self.out.append(Dwell(self.line, self.source.strip(), self.sticky["P"]))
        to(Motion.RAPID, clear)


def _length(move: Move) -> float:
    """Length of a move as its feed counts it: mm of tool path, or degree of the table alone."""
    curve = curve_of(move)
    if curve is None:
        return 0.0
    return math.degrees(curve.length) if move.turns_only_the_table else curve.length * 1e3


def stream(
    lines: Iterable[str],
    file: str = "<text>",
    start: Pose = HOME,
    tools: Mapping[int, Pose] = NO_TOOLS,
) -> Iterator[Move | Dwell]:
    """Moves and dwells of a program of any length, as they are read.

    Memory: one line, and what gcode_flow.py keeps for O words. tools: offsets [mm, degree] of G43
    by number of the tool. Raises GcodeErrors behind the last good block, with every mistake of the
    rest of the text.
    """
    return _Parser(lines, file, start, tools).items()


def stream_file(
    path: Path, start: Pose = HOME, tools: Mapping[int, Pose] = NO_TOOLS
) -> Iterator[Move | Dwell]:
    """As `stream`, from a file. Raises GcodeErrors, and OSError if there is no such file."""
    with path.open(encoding="utf-8-sig", errors="replace") as lines:
        yield from stream(lines, str(path), start, tools)


def parse(
    text: str, file: str = "<text>", start: Pose = HOME, tools: Mapping[int, Pose] = NO_TOOLS
) -> Program:
    """Read a program from text; start is the pose [mm, degree] before its first block.

    tools as for `stream`.

    Raises GcodeErrors with every mistake of the text.
    """
    moves: list[Move] = []
    dwells: list[tuple[int, Dwell]] = []
    for item in stream(text.splitlines(), file, start, tools):
        if isinstance(item, Move):
            moves.append(item)
        else:
            dwells.append((len(moves), item))
    return Program(file, start, tuple(moves), tuple(dwells))


def parse_file(path: Path, start: Pose = HOME, tools: Mapping[int, Pose] = NO_TOOLS) -> Program:
    """Read a program from a file. Raises GcodeErrors, and OSError if there is no such file."""
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    return parse(text, str(path), start, tools)
