# SPDX-License-Identifier: Apache-2.0
"""Reader of a subset of RS274/NGC (T. Kramer et al., NISTIR 6556): text in, list of moves out.

Accepted: G0 G1 G2 G3, G17 G18 G19, G20 G21, G90 G91, M2 M30, words X Y Z A C I J K R F N, comments
`( )` and `;`, one pair of `%` lines, blank space between words and between letter and number.
A (tilt) and C (rotation) are table axes in degrees in either length unit. I, J, K are always
distances from the start of the arc. At the start G17, G21 and G90 hold and no motion is selected.

Two points follow one reading of the standard where machines differ: the words of a block are in
the length unit the block itself selects, and a centre-format arc without end words is a full turn.

All mistakes of a file are collected (at most MAX_ERRORS) and raised together as GcodeErrors.
"""

from __future__ import annotations

import difflib
import math
import re
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

AXES = "XYZAC"
MM_PER_INCH = 25.4
MAX_ERRORS = 20
MAX_NUMBER = 1e6  # larger magnitudes are typing mistakes on any machine
MAX_LINE_NUMBER = 99999  # NISTIR 6556, 3.3.1

# NISTIR 6556, 3.5.3.2: largest difference between the radii at both ends of an arc. The same
# distance is allowed between an R-format chord and the diameter.
ARC_TOLERANCE_MM = 0.002
ARC_TOLERANCE_INCH = 0.0002

Pose = tuple[float, float, float, float, float]
"""x, y, z [mm], tilt A, rotation C [degree]."""

HOME: Pose = (0.0, 0.0, 600.0, 0.0, 0.0)


class Motion(Enum):
    RAPID = "G0"
    LINEAR = "G1"
    ARC_CW = "G2"
    ARC_CCW = "G3"

    @property
    def is_arc(self) -> bool:
        return self in (Motion.ARC_CW, Motion.ARC_CCW)


class Plane(Enum):
    XY = "G17"
    ZX = "G18"
    YZ = "G19"

    @property
    def axes(self) -> tuple[int, int]:
        """Indices (first, second) of the plane's axes; counter-clockwise turns first to second."""
        return {Plane.XY: (0, 1), Plane.ZX: (2, 0), Plane.YZ: (1, 2)}[self]


@dataclass(frozen=True)
class Move:
    """One motion block. Poses and centre in mm and degrees, in absolute coordinates.

    feed is the F number in force as mm/min, for blocks that turn only the table as degree/min;
    it is None for rapids. centre holds the two coordinates in the order of plane.axes.
    tolerance [mm]: greatest distance from the joints at the move's ends to the path run, 0 for
    G61, infinite for G64 without P; merge [mm]: Q of G64, within which lines are joined into one.
    inner: the move is a further part of its block, not a new one.
    """

    line: int
    source: str
    motion: Motion
    start: Pose
    end: Pose
    feed: float | None = None
    plane: Plane | None = None
    centre: tuple[float, float] | None = None
    tolerance: float = 0.0
    merge: float = 0.0
    inner: bool = False

    @property
    def turns_only_the_table(self) -> bool:
        return _turns_only_the_table(self.motion, self.start, self.end)


def _turns_only_the_table(motion: Motion, start: Pose, end: Pose) -> bool:
    return not motion.is_arc and start[:3] == end[:3]


@dataclass(frozen=True)
class Dwell:
    """A rest of `seconds` at the end of the moves before it (G4, G82)."""

    line: int
    source: str
    seconds: float


@dataclass(frozen=True)
class Program:
    file: str
    start: Pose
    moves: tuple[Move, ...]


class GcodeError(ValueError):
    """One mistake: file, line and column (from 1), offending text, what, expected, help."""

    def __init__(
        self,
        file: str,
        line: int,
        column: int,
        source: str,
        text: str,
        what: str,
        expected: str,
        help: str,
    ) -> None:
        self.file, self.line, self.column = file, line, column
        self.source, self.text = source, text
        self.what, self.expected, self.help = what, expected, help
        super().__init__(str(self))

    def __str__(self) -> str:
        got = repr(self.text) if self.text else "end of file"
        caret = " " * (self.column - 1) + "^" * max(1, len(self.text))
        return (
            f"{self.file}:{self.line}:{self.column}: error: {self.what}; got {got}; "
            f"expected {self.expected}\n"
            f"{self.line:5d} |   {self.source}\n"
            f"      |   {caret}  help: {self.help}"
        )


class GcodeErrors(ValueError):
    """Every mistake found in one file, in the order of the text, at most MAX_ERRORS."""

    def __init__(self, errors: tuple[GcodeError, ...]) -> None:
        self.errors = errors
        super().__init__(str(self))

    def __str__(self) -> str:
        text = "\n".join(str(error) for error in self.errors)
        if len(self.errors) == MAX_ERRORS:
            text += f"\nstopped after {MAX_ERRORS} errors, the rest of the file was not read"
        return text


@dataclass(frozen=True)
class _Word:
    letter: str
    value: float
    text: str
    column: int

    @property
    def code(self) -> str:
        """`G1` for G01 and G1.0, `G59.1` for G59.1."""
        return f"{self.letter}{self.value:.10g}"


_NUMBER_RUN = re.compile(r"[ \t]*([+\-.\d]+)")
_STRAY_RUN = re.compile(r"[^ \t(;]+")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)")

_GROUPS = {
    "motion": {motion.value for motion in Motion},
    "plane": {plane.value for plane in Plane},
    "unit": {"G20", "G21"},
    "distance": {"G90", "G91"},
    "end": {"M2", "M30"},
}
_GROUP_OF = {code: group for group, codes in _GROUPS.items() for code in codes}
_VALUE_LETTERS = AXES + "IJKRFN"
_G_CODES = "G0 G1 G2 G3 G17 G18 G19 G20 G21 G90 G91"
_OFFSETS = "IJK"


class _TooManyErrors(Exception):
    """Ends the reading of a file with MAX_ERRORS mistakes."""


class _Parser:
    def __init__(self, text: str, file: str, start: Pose) -> None:
        self.file = file
        self.lines = text.splitlines()
        self.start = start
        self.moves: list[Move] = []
        self.errors: list[GcodeError] = []
        self.position = start
        self.motion: Motion | None = None
        self.plane = Plane.XY
        self.mm_per_unit = 1.0
        self.incremental = False
        self.feed: float | None = None  # the F number as programmed
        self.feed_mm_per_unit = 1.0
        self.feed_reported = False
        self.ended = False
        self.line = 0
        self.source = ""

    def run(self) -> Program:
        try:
            self._read_lines()
        except _TooManyErrors:
            pass
        if self.errors:
            raise GcodeErrors(tuple(self.errors))
        return Program(self.file, self.start, tuple(self.moves))

    def _error(self, column: int, text: str, what: str, expected: str, help: str) -> None:
        self.errors.append(
            GcodeError(self.file, self.line, column, self.source, text, what, expected, help)
        )
        if len(self.errors) == MAX_ERRORS:
            raise _TooManyErrors

    def _error_at(self, word: _Word, what: str, expected: str, help: str) -> None:
        self._error(word.column, word.text, what, expected, help)

    # Lines and words

    def _read_lines(self) -> None:
        opened: int | None = None
        closed = False
        for number, raw in enumerate(self.lines, start=1):
            self.line, self.source = number, raw.expandtabs(1)
            if self.source.strip() == "%":
                if opened is not None:
                    closed = True
                    break
                if self.moves or self.ended or self.errors:
                    self._error(
                        self.source.index("%") + 1,
                        "%",
                        "percent line inside the program",
                        "the opening percent line before the first block",
                        "put % on the first line and on the last, or on neither",
                    )
                opened = self.line
                continue
            known = len(self.errors)
            words = self._words()
            if words:
                self._block(words, clean=len(self.errors) == known)
        self._check_end(opened is not None and not closed)

    def _check_end(self, percent_open: bool) -> None:
        if not self.lines:
            self.line, self.source = 1, ""
        column = len(self.source) + 1
        if not self.ended:
            self._error(
                column,
                "",
                "the program has no end",
                "M2 or M30",
                "end the program with M2; if it had one, the file is truncated",
            )
        elif percent_open:
            self._error(
                column,
                "",
                "the file is truncated: the opening percent line has no partner",
                "a closing % line",
                "end the file with a line that holds only %",
            )

    def _words(self) -> list[_Word]:
        words: list[_Word] = []
        source, i = self.source, 0
        while i < len(source):
            char = source[i]
            if char in " \t":
                i += 1
            elif char == ";":
                break
            elif char == "(":
                i = self._skip_comment(i)
            elif char.isascii() and char.isalpha():
                match = _NUMBER_RUN.match(source, i + 1)
                end = match.end() if match else i + 1
                text = source[i:end]
                value = self._number(i + 1, text, match.group(1) if match else "")
                if value is not None:
                    words.append(_Word(char.upper(), value, text, i + 1))
                i = end
            else:
                text = _STRAY_RUN.match(source, i).group()
                self._error(
                    i + 1,
                    text,
                    "unexpected character",
                    "a word such as X10.5, a comment, or the end of the line",
                    "parameters, expressions and block delete are outside the accepted subset"
                    if char in "#[]=*/<>"
                    else "remove it or put it into a comment ( )",
                )
                i += len(text)
        return words

    def _skip_comment(self, begin: int) -> int:
        end = self.source.find(")", begin)
        nested = self.source.find("(", begin + 1)
        if end < 0:
            self._error(
                begin + 1,
                self.source[begin:],
                "the comment is not closed",
                "`)` on the same line",
                "close it with ) or start it with ;",
            )
            return len(self.source)
        if begin < nested < end:
            self._error(
                nested + 1,
                "(",
                "comment inside a comment",
                "`)` before the next `(`",
                "comments do not nest; use other brackets inside",
            )
        return end + 1

    def _number(self, column: int, text: str, number: str) -> float | None:
        if not number:
            self._error(
                column,
                text,
                "the letter has no number",
                f"a number after {text.upper()}, such as {text.upper()}1",
                "text that is not code belongs into a comment ( )",
            )
        elif not _NUMBER.fullmatch(number):
            self._error(
                column,
                text,
                "the number is malformed",
                "an optional sign, digits and at most one decimal point",
                "write for instance -12.5",
            )
        elif abs(float(number)) > MAX_NUMBER:
            self._error(
                column,
                text,
                "the number is out of range",
                f"a magnitude of at most {MAX_NUMBER:g}",
                "check the decimal point",
            )
        else:
            return float(number)
        return None

    # Blocks

    def _block(self, words: list[_Word], clean: bool) -> None:
        known = len(self.errors)
        if self.ended:
            self._error_at(
                words[0],
                "block after the end of the program",
                "only comments after M2 or M30",
                "move the block before the end of the program",
            )
            return
        values, codes = self._sort_words(words)
        self._select_modes(codes)
        self._set_feed(values.pop("F", None))
        clean = clean and len(self.errors) == known
        self._move(words, values, codes.get("motion"), clean)
        self.ended = "end" in codes

    def _sort_words(self, words: list[_Word]) -> tuple[dict[str, _Word], dict[str, _Word]]:
        """Words with values by letter and G, M words by modal group; mistakes are reported."""
        values: dict[str, _Word] = {}
        codes: dict[str, _Word] = {}
        for position, word in enumerate(words):
            if word.letter in "GM":
                group = _GROUP_OF.get(word.code)
                if group is None:
                    self._unknown_code(word)
                elif group in codes:
                    self._error_at(
                        word,
                        f"second word of the {group} group in one block",
                        f"one of {_listing(_GROUPS[group])}",
                        f"keep {codes[group].text} or move {word.text} to a block of its own",
                    )
                else:
                    codes[group] = word
            elif word.letter not in _VALUE_LETTERS:
                self._error_at(
                    word,
                    f"unknown word {word.letter}",
                    "one of G M N F X Y Z A C I J K R",
                    "tools, spindle, coolant and other axes are outside the accepted subset",
                )
            elif word.letter in values:
                self._error_at(
                    word,
                    f"second {word.letter} word in one block",
                    f"at most one {word.letter} word",
                    f"keep one of {values[word.letter].text} and {word.text}",
                )
            elif word.letter == "N":
                self._check_line_number(word, first=position == 0)
                values["N"] = word
            else:
                values[word.letter] = word
        values.pop("N", None)
        return values, codes

    def _unknown_code(self, word: _Word) -> None:
        allowed = _G_CODES if word.letter == "G" else "M2 M30"
        near = difflib.get_close_matches(word.code, allowed.split(), n=1)
        self._error_at(
            word,
            f"{word.code} is outside the accepted subset",
            f"one of {allowed}",
            f"did you mean {near[0]}?" if near else "remove the word",
        )

    def _check_line_number(self, word: _Word, first: bool) -> None:
        if not word.value.is_integer() or not 0 <= word.value <= MAX_LINE_NUMBER:
            self._error_at(
                word,
                "the line number is not valid",
                f"an integer from 0 to {MAX_LINE_NUMBER}",
                "line numbers are optional; remove it",
            )
        elif not first:
            self._error_at(
                word,
                "the line number is not at the start of the block",
                "N as the first word",
                f"move {word.text} to the front",
            )

    def _select_modes(self, codes: dict[str, _Word]) -> None:
        if "motion" in codes:
            self.motion = Motion(codes["motion"].code)
        if "plane" in codes:
            self.plane = Plane(codes["plane"].code)
        if "unit" in codes:
            self.mm_per_unit = MM_PER_INCH if codes["unit"].code == "G20" else 1.0
        if "distance" in codes:
            self.incremental = codes["distance"].code == "G91"

    def _set_feed(self, word: _Word | None) -> None:
        if word is None:
            return
        if word.value <= 0.0:
            self._error_at(
                word, "the feed is not positive", "F greater than 0", "write for instance F2000"
            )
        self.feed = abs(word.value)
        self.feed_mm_per_unit = self.mm_per_unit

    # Motion

    def _move(
        self, words: list[_Word], values: dict[str, _Word], code: _Word | None, clean: bool
    ) -> None:
        arc_words = [values[letter] for letter in _OFFSETS + "R" if letter in values]
        axis_words = [values[letter] for letter in AXES if letter in values]
        if not arc_words and not axis_words:
            if code is not None and clean:
                self._error_at(
                    code,
                    f"{code.code} without a position",
                    "X Y Z A C" + (" I J K or R words" if self.motion.is_arc else " words"),
                    f"give the end of the move or remove {code.text}",
                )
            return
        if self.motion is None:
            if clean:
                self._error_at(
                    (axis_words + arc_words)[0],
                    "no motion is selected",
                    "G0, G1, G2 or G3 in this block or before",
                    f"write G0 or G1 before {(axis_words + arc_words)[0].text}",
                )
            self.position = self._end(values)
            return
        start, end = self.position, self._end(values)
        self.position = end
        if self.motion is not Motion.RAPID and self.feed is None and not self.feed_reported:
            self.feed_reported = True
            word = code or words[0]
            self._error_at(
                word,
                f"no feed is set for {self.motion.value}",
                "an F word in this block or before",
                "add for instance F2000 to the block",
            )
        if not self.motion.is_arc:
            for word in arc_words:
                self._error_at(
                    word,
                    f"{word.letter} does not belong to {self.motion.value}",
                    "I, J, K and R only with G2 or G3",
                    f"remove {word.text}",
                )
        centre = None
        if self.motion.is_arc and clean:
            centre = self._centre(start, end, values, code or words[0])
        if not self.errors:  # a text with a mistake yields no program
            self._append(start, end, centre)

    def _append(self, start: Pose, end: Pose, centre: tuple[float, float] | None) -> None:
        feed = None
        if self.motion is not Motion.RAPID:
            table = _turns_only_the_table(self.motion, start, end)
            feed = self.feed if table else self.feed * self.feed_mm_per_unit
        plane = self.plane if self.motion.is_arc else None
        source = self.source.strip()
        self.moves.append(Move(self.line, source, self.motion, start, end, feed, plane, centre))

    def _end(self, values: dict[str, _Word]) -> Pose:
        end = list(self.position)
        for index, letter in enumerate(AXES):
            if letter in values:
                scale = self.mm_per_unit if index < 3 else 1.0
                origin = self.position[index] if self.incremental else 0.0
                end[index] = origin + values[letter].value * scale
        return tuple(end)

    def _centre(
        self, start: Pose, end: Pose, values: dict[str, _Word], at: _Word
    ) -> tuple[float, float] | None:
        """Centre of an arc in its plane [mm], None after a mistake."""
        first, second = self.plane.axes
        offsets = {letter: values[letter] for letter in _OFFSETS if letter in values}
        chord = (end[first] - start[first], end[second] - start[second])
        if "R" in values:
            for word in offsets.values():
                self._error_at(
                    word,
                    f"{word.letter} together with R",
                    "either the radius R or centre offsets",
                    f"remove {word.text} or {values['R'].text}",
                )
            if offsets:
                return None
            return self._centre_from_radius((start[first], start[second]), chord, values["R"])
        names = _OFFSETS[first], _OFFSETS[second]
        wrong = [word for letter, word in offsets.items() if letter not in names]
        for word in wrong:
            self._error_at(
                word,
                f"{word.letter} is not in the plane {self.plane.value}",
                f"offsets {names[0]} and {names[1]}",
                f"remove {word.text} or select another plane",
            )
        if wrong:
            return None
        dx, dy = (
            offsets[name].value * self.mm_per_unit if name in offsets else 0.0 for name in names
        )
        if dx == 0.0 and dy == 0.0:
            self._error_at(
                at,
                "the arc has no centre",
                f"{names[0]} or {names[1]} different from 0, or R",
                "give the distance from the start of the arc to its centre",
            )
            return None
        radius, end_radius = math.hypot(dx, dy), math.hypot(chord[0] - dx, chord[1] - dy)
        if abs(radius - end_radius) > self._arc_tolerance():
            self._error_at(
                at,
                f"the end of the arc is not on its circle: radius {radius:.4f} mm at the start, "
                f"{end_radius:.4f} mm at the end",
                f"a difference of at most {self._arc_tolerance():g} mm",
                "check the end point and the offsets from the start to the centre",
            )
            return None
        return start[first] + dx, start[second] + dy

    def _arc_tolerance(self) -> float:
        if self.mm_per_unit == MM_PER_INCH:
            return ARC_TOLERANCE_INCH * MM_PER_INCH
        return ARC_TOLERANCE_MM

    def _centre_from_radius(
        self, start: tuple[float, float], chord: tuple[float, float], word: _Word
    ) -> tuple[float, float] | None:
        """R format: a positive R is the arc of at most half a turn, a negative R the longer one."""
        radius, distance = abs(word.value) * self.mm_per_unit, math.hypot(*chord)
        if distance == 0.0:
            self._error_at(
                word,
                "an arc with R ends where it starts",
                "an end point different from the start",
                "write a full turn with I, J, K",
            )
            return None
        if distance / 2 > radius + self._arc_tolerance():
            self._error_at(
                word,
                f"the radius is too small for the distance {distance:.4f} mm from start to end",
                f"a radius of at least {distance / 2:.4f} mm",
                "check the end point and R",
            )
            return None
        height = math.sqrt(max(0.0, radius**2 - (distance / 2) ** 2)) / distance
        if (self.motion is Motion.ARC_CCW) != (word.value > 0.0):
            height = -height  # centre to the right of the way from start to end
        return (
            start[0] + chord[0] / 2 - height * chord[1],
            start[1] + chord[1] / 2 + height * chord[0],
        )


def _listing(codes: set[str]) -> str:
    return " ".join(sorted(codes, key=lambda code: int(code[1:])))


def parse(text: str, file: str = "<text>", start: Pose = HOME) -> Program:
    """Read a program from text; start is the pose [mm, degree] before its first block.

    Raises GcodeErrors with every mistake of the text.
    """
    return _Parser(text, file, start).run()


def parse_file(path: Path, start: Pose = HOME) -> Program:
    """Read a program from a file. Raises GcodeErrors, and OSError if there is no such file."""
    return parse(path.read_text(encoding="utf-8-sig", errors="replace"), str(path), start)
