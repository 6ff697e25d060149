# SPDX-License-Identifier: Apache-2.0
"""Contour of a lathe cycle: the lines of its subroutine, read but not run, as lines and arcs.

The subroutine has G0 to G3 with X Z or, as distances under G90, U W; I K or R of arcs; A for a
rounding, C for a chamfer at the end of a move; parameters and O words. LinuxCNC passes over all
other words of a contour; here they are mistakes.
"""

from __future__ import annotations

import math

from sim.motion.gcode.arcs import radii_fit
from sim.motion.gcode.block import sort_words
from sim.motion.gcode.lathe import MAX_SEGMENTS
from sim.motion.gcode.segments import Arc, Line, Segment
from sim.motion.gcode.state import State
from sim.motion.gcode.words import Word
from sim.motion.geometry.moves import Pose

LETTERS = "XZUWIKRAC"
_MOTIONS = ("G0", "G1", "G2", "G3")


class Contour:
    """Takes the blocks of the subroutine. start: the point z + ix where the cycle begins; all in
    the unit of the program, X as a radius. The position of the state goes along the contour."""

    def __init__(self, state: State, start: complex) -> None:
        self.state, self.report = state, state.report
        self.place, self.motion = start, "G0"
        self.segments: list[Segment] = []
        self.last: Word | None = None  # A or C of the last move

    def block(self, words: list[Word]) -> None:
        """One line of the subroutine; its mistakes are reported."""
        known = len(self.state.mistakes.found)
        values, codes = sort_words(words, self.report, more="UW")
        for group, code in codes.items():
            if group != "motion" or code.code not in _MOTIONS:
                self._refuse(code, code.code)
        for letter, word in values.items():
            if letter not in LETTERS:
                self._refuse(word, letter)
        if "motion" in codes:
            self.motion = codes["motion"].code
        if len(self.state.mistakes.found) != known:
            return
        end = self._end(values)
        if end is None or not self._letters_fit(values, end):
            return
        if end == self.place:
            return
        if len(self.segments) >= MAX_SEGMENTS:
            self.report(
                words[0],
                f"the contour has more than {MAX_SEGMENTS} moves",
                "fewer and longer moves",
                "write chords as arcs; check the loops of the subroutine",
            )
            return
        line = self.state.mistakes.line
        if self.motion in ("G0", "G1"):
            self.segments.append(Line(self.place, end, line))
        else:
            centre = self._centre(values, end, codes.get("motion") or words[0])
            if centre is None:
                return
            self.segments.append(Arc(self.place, end, centre, self.motion == "G3", line))
        self.last = values.get("A") or values.get("C")
        if "A" in values:
            self.segments.append(Arc(end, end, end, False, line, values["A"].value))
        elif "C" in values:
            self.segments.append(Line(end, end, line, values["C"].value))
        self._go(end)

    def _go(self, end: complex) -> None:
        """The position, which parameters read, is the end of the move."""
        self.place = end
        self.state.position = self.state.machine(pose_at(self.state, end))

    def _refuse(self, word: Word, what: str) -> None:
        self.report(
            word,
            f"{what} in the contour of a lathe cycle",
            "G0 G1 G2 G3 with X Z U W, I K or R, A or C, parameters and O words",
            f"move {word.text} before the cycle; the lines of a contour are read, not run",
        )

    def _end(self, values: dict[str, Word]) -> complex | None:
        """End of the move, None after a mistake."""
        state, place = self.state, [self.place.real, self.place.imag]
        incremental = state.modes.incremental
        for index, letters in enumerate(("ZW", "XU")):
            given = [values[letter] for letter in letters if letter in values]
            if not given:
                continue
            word = given[-1]
            if len(given) > 1 or (incremental and word.letter in "UW"):
                self.report(
                    word,
                    f"{word.letter} together with " + (letters[0] if len(given) > 1 else "G91"),
                    f"either {letters[0]} or {letters[1]}, and {letters[1]} with G90",
                    f"remove {word.text}",
                )
                return None
            value = word.value / (2 if index and state.modes.diameter else 1)
            place[index] = place[index] + value if word.letter in "UW" or incremental else value
        return complex(*place)

    def _letters_fit(self, values: dict[str, Word], end: complex) -> bool:
        """Whether the letters belong to the move; reports if not."""
        arc = self.motion in ("G2", "G3")
        for letter in "IKR" if not arc else "":
            if letter in values:
                self.report(
                    values[letter],
                    f"{letter} does not belong to {self.motion}",
                    "X Z U W A C",
                    f"remove {values[letter].text}, or write G2 or G3",
                )
                return False
        given = [values[letter] for letter in "IKRAC" if letter in values]
        if given and end == self.place:
            self.report(
                given[0],
                f"{given[0].letter} of a move that stays where it is",
                "an end that differs from the start",
                f"give X or Z of another place, or remove {given[0].text}",
            )
            return False
        corner = [word for word in given if word.letter in "AC"]
        if len(corner) > 1 or any(word.value <= 0 for word in corner):
            self.report(
                corner[-1],
                "a corner needs one size greater than 0",
                "A for a rounding, or C for a chamfer",
                "write for instance G1 Z-10 A0.5",
            )
            return False
        return True

    def _centre(self, values: dict[str, Word], end: complex, at: Word) -> complex | None:
        """Centre of an arc, None after a mistake."""
        chord = end - self.place
        offsets = [values[letter] for letter in "IK" if letter in values]
        if "R" in values:
            radius = values["R"].value
            square = radius * radius - (chord.real**2 + chord.imag**2) / 4
            if offsets or radius <= 0 or square < 0:
                self.report(
                    offsets[0] if offsets else values["R"],
                    f"R{radius:g} does not give the centre of the arc",
                    f"R of at least {abs(chord) / 2:.4f}, half the way, and neither I nor K",
                    "write I and K for an arc of more than half a turn",
                )
                return None
            aside = 1j * math.sqrt(square / (chord.real**2 + chord.imag**2)) * chord
            middle = (self.place + end) / 2.0
            return middle + aside if self.motion == "G3" else middle - aside
        absolute = self.state.modes.absolute_centres
        if not offsets or (absolute and len(offsets) < 2):
            self.report(
                at,
                "the arc has no centre",
                "I and K" if absolute else "I or K, or R",
                "give the distance from the start of the arc to its centre"
                if not absolute
                else "under G90.1 both are coordinates",
            )
            return None
        numbers = [values[letter].value if letter in values else 0.0 for letter in "KI"]
        centre = complex(*numbers) + (0 if absolute else self.place)
        radii = abs(self.place - centre), abs(end - centre)
        return centre if radii_fit(self.state, *radii, at) else None


def pose_at(state: State, point: complex) -> Pose:
    """A point z + ix of the contour in programmed coordinates [mm, degree]."""
    _, y, _, tilt, rotation = state.programmed()
    scale = state.modes.mm_per_unit
    return point.imag * scale, y, point.real * scale, tilt, rotation
