# SPDX-License-Identifier: Apache-2.0
"""Interpreter of RS274/NGC programs (T. Kramer et al., NISTIR 6556; LinuxCNC where that is silent).

Text in, moves out, as a stream or one Program. Accepted: G0 G1 G2 G3 (I J K or R, helices), G4, G5
G5.1 G5.2 G5.3 (splines.py), G33 G33.1 (threads), G38.2-G38.5 (probing, up to the end), G7 G8, G10
L1 L2 L10 L11 L20, G17-G19, G20 G21, G28 G28.1, G40-G42 with D and G41.1 G42.1 (cutter
compensation), G43 H G49, G43.4 (coordinates of the table, table_frame.py), G52, G53, G54-G59.3, G61
G61.1 G64 P Q, G73 G74 G80-G85 G89 with G98 G99, lathe cycles G70-G72.2 (lathe.py), G90 G91, G90.1
G91.1, G92 G92.1-G92.3, G93 G94 G95 G97, polar words @ ^, T M6 M61, M2 M30, M66, M70-M73, O words
(flow.py), parameters and expressions (expressions.py), comments `( )` and `;`, one pair of `%`
lines. M0 M1 M60 and M6 are rests of 0 s: the path stops, no operator is waited for.
M7-M9, M62-M65, M67 and M68 are read and do nothing, S and M3-M5 only give G33 and G95 their feed
and let G74 and G84 run, because coolant, signals and spindle have no output here. A (tilt) and C
(rotation) are table axes in degrees in either length unit. At the start G8, G17, G21, G40, G54,
G61, G90, G91.1, G94 and G99 hold and no motion is selected.

Two points follow one reading of the standard where machines differ: the words of a block but F are
in the length unit the block itself selects, and a centre-format arc without end words is a full
turn.

All mistakes of a file are collected (at most MAX_ERRORS) and raised together as GcodeErrors.

Here is the order in which the parts of a block act; the parts are: words.py (words of a
line), block.py (modal groups), state.py (modes, coordinates, parameters),
modes.py (words that change them), actions.py (rests and moves), targets.py
(ends), arcs.py (centres), cycles.py (drilling), turning.py (lathe cycles),
runs.py (moves of the machine, as in moves.py), output.py and compensation.py
(radius of the tool).
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from asip_asm.files import open_regular
from sim.motion.gcode.actions import Actions
from sim.motion.gcode.block import ENDS, LATHE, PAUSES, SPLINES, THREADS, check_unused, sort_words
from sim.motion.gcode.errors import GcodeError, GcodeErrors, Mistakes, TooManyErrors
from sim.motion.gcode.execution import FlowStop
from sim.motion.gcode.expressions import Key, shown
from sim.motion.gcode.flow import Flow
from sim.motion.gcode.modes import select_modes, set_feed, tool_number
from sim.motion.gcode.oword import Head
from sim.motion.gcode.state import State
from sim.motion.gcode.subroutines import RETURNED, VALUE
from sim.motion.gcode.tools import NO_TOOLS, Tool
from sim.motion.gcode.turning import Turning
from sim.motion.gcode.words import LineReader, Word
from sim.motion.geometry.moves import Dwell, GcodeProgram, Move, Pose
from sim.motion.geometry.workspace import default_robot, pivot_of, start_of
from sim.robot.parameters import Robot

MAX_LINE = 10_000  # characters
_COMMENTS = re.compile(r"\([^)]*\)|;.*")
_PROGRAM_NAME = re.compile(r"[oO][ \t]*(\d+|<[^<>]*>)")  # O0001, as other controls begin a program
MAX_HELD = 100_000  # moves and rests of a Program, which is held in memory


def _goes_anywhere(item: Move | Dwell) -> bool:
    return isinstance(item, Move) and (item.start != item.end or item.motion.is_arc)


class _Parser:
    """One pass over the lines of a program; `items` yields its moves and dwells."""

    def __init__(
        self,
        lines: Iterable[str],
        file: str,
        start: Pose | None,
        tools: Mapping[int, Tool],
        robot: Robot | None = None,
    ) -> None:
        robot = robot or default_robot()
        self.lines = lines
        self.mistakes = Mistakes(file)
        self.any_output = False
        self.state = State(start or start_of(robot), pivot_of(robot), dict(tools), self.mistakes)
        self.actions = Actions(self.state)
        self.output = self.actions.output
        self.ended = False
        self.percent_open, self.percent_closed = False, False
        self.last = 1, ""  # line read
        self.flow = Flow(self._numbered(), self.mistakes, self.state)

    def items(self) -> Iterator[Move | Dwell]:
        try:
            for _ in self._read_lines():
                if not self.mistakes.found:  # a text with a mistake yields nothing more
                    if self.output.items:
                        self.any_output = True
                        if any(map(_goes_anywhere, self.output.items)):
                            self.flow.moved()
                    yield from self.output.items
                self.output.items.clear()
        except (TooManyErrors, FlowStop):
            pass
        if self.mistakes.found:
            raise GcodeErrors(tuple(self.mistakes.found))

    # Lines and words

    def _numbered(self) -> Iterator[tuple[int, str]]:
        """Lines with their numbers, without the percent lines and what follows the second."""
        started = False
        for number, raw in enumerate(self.lines, start=1):
            text = raw.rstrip("\r\n").expandtabs(1)
            self.last = number, text
            self._check_text(number, text)
            if text.strip() != "%":
                code = _COMMENTS.sub("", text).strip()
                if not started and _PROGRAM_NAME.fullmatch(code):
                    continue
                started = started or bool(code)
                yield number, text
                continue
            if self.percent_open or self.ended or self.flow.searching:
                self.percent_closed = True
                return
            if self.any_output or self.mistakes.found:
                self.mistakes.place(number, text)
                self.mistakes.report(
                    text.index("%") + 1,
                    "%",
                    "percent line inside the program",
                    "the opening percent line before the first block",
                    "put % on the first line and on the last, or on neither",
                )
            self.percent_open = True

    def _check_text(self, number: int, text: str) -> None:
        """Ends the reading at a line that is no text of a program."""
        if len(text) > MAX_LINE:
            self.mistakes.place(number, text)
            self.mistakes.report(
                MAX_LINE + 1,
                text[MAX_LINE:],
                f"the line has more than {MAX_LINE} characters",
                "shorter lines",
                "a program has one block on each line; is this file one?",
            )
        elif "\0" in text:
            self.mistakes.place(number, text)
            self.mistakes.report(
                text.index("\0") + 1,
                "\0",
                "the file is not a text",
                "characters",
                "give the G-code program, not a binary file",
            )
        else:
            return
        raise TooManyErrors

    def _read_lines(self) -> Iterator[None]:
        for number, text in self.flow.lines():
            self.mistakes.place(number, text)
            known = len(self.mistakes.found)
            words, settings = LineReader(text, self.mistakes.report, self.state.read).words()
            if words or settings:
                self._block(words, settings, clean=len(self.mistakes.found) == known)
            yield
            if self.ended:
                if self.flow.inside:
                    self.flow.finish()
                break  # nothing after M2 or M30 is read
        if not self.mistakes.found:
            self.output.finish()
            yield
        self._check_end()

    def _check_end(self) -> None:
        self.mistakes.place(*self.last)
        column = len(self.mistakes.source) + 1
        if self.actions.splines.open and not self.mistakes.found:
            self.mistakes.report(column, "", "G5.2 without G5.3", "G5.3", "end the control points")
        if not self.ended and not (self.percent_open and self.percent_closed):
            self.mistakes.report(
                column,
                "",
                "the program has no end",
                "M2 or M30",
                "end the program with M2; if it had one, the file is truncated",
            )

    # Parameters

    def _set_parameters(self, settings: list[tuple[Key, float, int, str]]) -> None:
        for key, value, column, text in settings:
            if self.state.is_read_only(key) or key in (VALUE, RETURNED):
                self.mistakes.report(
                    column,
                    text,
                    f"the parameter #{shown(key)} is read only",
                    "another parameter",
                    "use #1 to #5000 for values of your own",
                )
            else:
                self.state.write(key, value)

    # Blocks

    def _block(
        self, words: list[Word], settings: list[tuple[Key, float, int, str]], clean: bool
    ) -> None:
        known = len(self.mistakes.found)
        values, codes = sort_words(words, self.state.report)
        self._set_parameters(settings)
        if not words:
            return
        if "stop" in codes and codes["stop"].code in ("M98", "M99"):
            self._subprogram(codes["stop"], words, values, clean)
            return
        if "stop" in codes and codes["stop"].code in ("M70", "M73"):
            self.flow.frame.state = self.state.saved()
            self.flow.frame.restores |= codes["stop"].code == "M73"
        if "T" in values:
            self.state.chosen = tool_number(self.state, values.pop("T"))
        if "S" in values:
            self.state.modes.speed = values.pop("S").value
        if "tool change" in codes:
            self._change_tool(codes["tool change"], values)
        # F comes before the unit of its block (NISTIR 6556, 3.8).
        scale = self.state.modes.mm_per_unit
        select_modes(self.state, codes, values)
        if self.state.modes.diameter and "X" in values:
            values["X"] = replace(values["X"], value=values["X"].value / 2)
        self.output.at = codes.get("motion") or words[0]
        self.output.select(codes, values)
        feed = values.pop("F", None)
        set_feed(self.state, feed, scale)
        single, motion = codes.get("single"), codes.get("motion")
        spline = motion.code if motion is not None and motion.code in SPLINES else ""
        if clean and len(self.mistakes.found) == known:
            mode = spline or self.state.motion
            inverse = self.state.modes.inverse_time and not self.actions.splines.open
            own = inverse or mode in THREADS
            check_unused(values, codes, mode, feed if own else None, self.state.report)
        clean = clean and len(self.mistakes.found) == known
        self.actions.side_words(codes, values)
        if spline or self.actions.splines.open:
            self.actions.spline(codes, values, motion or words[0], clean)
        elif motion is not None and motion.code in LATHE:
            self._turn(motion, codes, values, clean)
        elif single is not None and single.code != "G53":
            self.actions.single(single, codes, values, clean)
        else:
            self.actions.move(words, values, motion, single, clean)
        if "stop" in codes:
            self._stop(codes["stop"], words, clean)

    def _change_tool(self, word: Word, values: dict[str, Word]) -> None:
        """M6, for which the path stops; or M61 Q, by which another tool is the one mounted."""
        if word.code == "M6":
            self.state.loaded = self.state.chosen
        elif "Q" in values:
            self.state.loaded = tool_number(self.state, values["Q"])
        else:
            self.state.report(word, "M61 without a tool", "Q with its number", "M61 Q3")
        self.output.tool_changed()
        if word.code == "M6":
            self.actions.rest(0.0)

    def _turn(
        self, word: Word, codes: dict[str, Word], values: dict[str, Word], clean: bool
    ) -> None:
        """A lathe cycle reads its subroutine as a contour, and cuts. It selects no motion."""
        cycle = Turning(self.actions, word, codes, values)
        if clean and cycle.begin():
            block = self.mistakes.line, self.mistakes.source
            for number, text in self.flow.call_lines(cycle.head):
                self.mistakes.place(number, text)
                words, settings = LineReader(text, self.mistakes.report, self.state.read).words()
                self._set_parameters(settings)
                cycle.contour.block(words)
            self.mistakes.place(*block)
            cycle.cut()
        self.state.motion = None

    # Stops, saved state, subprograms

    def _alone(self, word: Word, words: list[Word], letters: str) -> bool:
        """Whether a word has its block for itself, except N and the letters; reports if not."""
        others = [other for other in words if other is not word and other.letter not in letters]
        if others:
            self.state.report(
                others[0],
                f"{word.code} shares its block",
                f"{word.code} alone",
                f"move {others[0].text} to a block of its own",
            )
        return not others

    def _subprogram(
        self, word: Word, words: list[Word], values: dict[str, Word], clean: bool
    ) -> None:
        """M98 P L and M99."""
        call = word.code == "M98"
        if not self._alone(word, words, "NPL" if call else "N") or not clean:
            return
        head = Head(0, word.code, word.column, word.text)
        if not call:
            self.flow.subroutines.end_numbered(head)
            return
        label, times = values.get("P"), values.get("L")
        for number in (label or word, times):
            if number is not None and (number.value != int(number.value) or number.value < 0):
                self.state.report(
                    number,
                    f"M98 with {number.text}",
                    "whole numbers of at least 0",
                    "write for instance M98 P100 L2",
                )
                return
        if label is None:
            self.state.report(
                word, "M98 without P", "P with the number of the subprogram", "M98 P100 calls O100"
            )
        elif times is None or times.value:
            count = int(times.value) if times else 1
            head = replace(head, label=int(label.value))
            self.flow.subroutines.call_numbered(head, self.state.block, count)

    def _stop(self, word: Word, words: list[Word], clean: bool) -> None:
        code = word.code
        if code in ENDS:
            self.ended = True
            self.output.finish()
        elif not clean:
            return
        elif code in PAUSES:
            self.actions.rest(0.0)
        elif code == "M71":
            self.flow.frame.state, self.flow.frame.restores = None, False
        elif code == "M72":
            if not self._alone(word, words, "N"):
                return
            if self.flow.frame.state is None:
                self.state.report(
                    word,
                    "there is no saved state",
                    "M70 or M73 before, in the same subroutine or main program",
                    "states are not passed to subroutines",
                )
            else:
                self.state.restore(self.flow.frame.state)


def stream(
    lines: Iterable[str],
    file: str = "<text>",
    start: Pose | None = None,
    tools: Mapping[int, Tool] = NO_TOOLS,
    robot: Robot | None = None,
) -> Iterator[Move | Dwell]:
    """Moves and dwells of a program of any length, as they are read.

    Memory: one line, and what flow.py keeps for O words. tools: by number; robot: whose table and
    start pose hold, None for that of `sim/robot.toml`; start [mm, degree]: another start pose.
    Raises GcodeErrors after the last good block, with every mistake of the rest of the text.
    """
    return _Parser(lines, file, start, tools, robot).items()


def stream_file(
    path: Path,
    start: Pose | None = None,
    tools: Mapping[int, Tool] = NO_TOOLS,
    robot: Robot | None = None,
) -> Iterator[Move | Dwell]:
    """As `stream`, from a regular file. Raises GcodeErrors, and OSError if there is none."""
    with open_regular(path, "a G-code program") as file:
        with io.TextIOWrapper(file, encoding="utf-8-sig", errors="replace") as text:
            lines = iter(lambda: text.readline(MAX_LINE + 2), "")
            yield from stream(lines, str(path), start, tools, robot)


def parse(
    text: str,
    file: str = "<text>",
    start: Pose | None = None,
    tools: Mapping[int, Tool] = NO_TOOLS,
    robot: Robot | None = None,
) -> GcodeProgram:
    """Read a program from text; start, tools, robot as for `stream`.

    Raises GcodeErrors with every mistake of the text, and for more than MAX_HELD moves and rests.
    """
    start = start or start_of(robot or default_robot())
    return _held(stream(text.splitlines(), file, start, tools, robot), file, start)


def parse_file(
    path: Path,
    start: Pose | None = None,
    tools: Mapping[int, Tool] = NO_TOOLS,
    robot: Robot | None = None,
) -> GcodeProgram:
    """As `parse`, from a regular file. Raises GcodeErrors, and OSError if there is none."""
    start = start or start_of(robot or default_robot())
    return _held(stream_file(path, start, tools, robot), str(path), start)


def _held(items: Iterable[Move | Dwell], file: str, start: Pose) -> GcodeProgram:
    moves: list[Move] = []
    dwells: list[tuple[int, Dwell]] = []
    for item in items:
        if len(moves) + len(dwells) == MAX_HELD:
            mistake = GcodeError(
                file,
                item.line,
                1,
                item.source,
                item.source,
                f"the program makes more than {MAX_HELD} moves",
                "fewer, because all are held in memory here",
                "check its loops; python -m sim.motion.lookahead plans programs of any length",
            )
            raise GcodeErrors((mistake,))
        if isinstance(item, Move):
            moves.append(item)
        else:
            dwells.append((len(moves), item))
    return GcodeProgram(file, start, tuple(moves), tuple(dwells))
