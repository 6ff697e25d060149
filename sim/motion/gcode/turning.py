# SPDX-License-Identifier: Apache-2.0
"""A block with a lathe cycle (G70 to G72.2): its words, its contour, and its moves."""

from __future__ import annotations

from sim.motion.gcode.actions import Actions
from sim.motion.gcode.arcs import radii_fit
from sim.motion.gcode.contour import Contour, pose_at
from sim.motion.gcode.lathe import Numbers, finishing, roughing
from sim.motion.gcode.oword import Head
from sim.motion.gcode.segments import NEAR, ContourError, vanished
from sim.motion.gcode.words import Word
from sim.motion.geometry.moves import Motion, Plane

MAX_PASSES = 1000  # P of G70
LEAST_DEPTH = 2 * NEAR  # I; LinuxCNC takes this for smaller ones
SAME = 1e-4  # LinuxCNC leaves out arcs of a cycle that are shorter, in the unit of the program


class Turning:
    """Call `begin`, then give every line of the contour to `contour`, then call `cut`.

    word: the cycle; codes: words of the block by modal group; values: by letter. Mistakes are
    reported; a mistake of the contour as a whole at the word of the cycle.
    """

    def __init__(
        self, actions: Actions, word: Word, codes: dict[str, Word], values: dict[str, Word]
    ) -> None:
        self.actions, self.word, self.codes, self.values = actions, word, codes, values
        self.state, self.report = actions.state, actions.report
        self.numbers = Numbers()
        self.head = Head(0, "call", word.column, word.text)

    def begin(self) -> bool:
        """Goes to the start; False after a mistake."""
        known = len(self.state.mistakes.found)
        self._check_numbers()
        if "Q" in self.values:
            self._check_modes()
        if len(self.state.mistakes.found) != known:
            return False
        state, scale = self.state, self.state.modes.mm_per_unit
        x, y, z, tilt, rotation = state.programmed()
        x = self.values["X"].value * scale if "X" in self.values else x
        z = self.values["Z"].value * scale if "Z" in self.values else z
        self.actions.run(Motion.RAPID, (x, y, z, tilt, rotation))
        self.start = complex(z / scale, x / scale)
        for letter in "XZ":
            if letter in self.values:  # without the rounding of the unit
                value = self.values[letter].value
                x_z = (self.start.real, value) if letter == "X" else (value, self.start.imag)
                self.start = complex(*x_z)
        self.position = state.position
        self.contour = Contour(state, self.start)
        return True

    def _check_modes(self) -> None:
        modes, code = self.state.modes, self.word.code
        for group in ("single", "stop"):
            if group in self.codes:
                other = self.codes[group]
                self.report(
                    other,
                    f"{other.code} shares its block with {code}",
                    f"{code} with its letters and modes",
                    f"move {other.text} to a block of its own",
                )
        if modes.plane is not Plane.ZX:
            self._wrong(f"{code} in {modes.plane.value}", "the plane G18", "write G18 before")
        if modes.inverse_time:
            self._wrong(f"{code} with G93", "feed per minute (G94)", "write G94 before")
        elif modes.feed is None:
            self._wrong(f"no feed is set for {code}", "an F word before", "add for instance F200")
        if self.state.rotation:
            self._wrong(
                f"{code} in a rotated coordinate system",
                "a coordinate system with R0",
                "write G10 L2 R0 with P of the system before",
            )
        given = [self.values[letter] for letter in "XZ" if letter in self.values]
        if modes.incremental and given:
            self.report(
                given[0],
                f"{given[0].letter} of {code} with G91",
                "X and Z of the start as coordinates (G90)",
                "go to the start before and leave them out; the contour may use G91",
            )

    def _wrong(self, what: str, expected: str, help: str) -> None:
        self.report(self.word, what, expected, help)

    def _check_numbers(self) -> None:
        values, code = self.values, self.word.code
        if "Q" not in values:
            self._wrong(
                f"{code} without Q",
                "Q with the number of the subroutine that has the contour",
                f"write for instance {code} Q100 X20 Z2 D0.2, and the contour as O100 sub"
                + ("; inches are G20, mm are G21" if code in ("G70", "G71") else ""),
            )
            return
        checks = (
            ("Q", "a whole number of at least 0", values["Q"].value >= 0),
            (
                "I",
                f"of at least {LEAST_DEPTH:g}, the depth of a pass",
                self._value("I", 1.0) >= LEAST_DEPTH,
            ),
            ("R", "of at least 0", self._value("R", 0.0) >= 0),
            (
                "P",
                f"a whole number from 1 to {MAX_PASSES}",
                1 <= self._value("P", 1.0) <= MAX_PASSES,
            ),
        )
        for letter, expected, good in checks:
            whole = letter in "IR" or self._value(letter, 1.0).is_integer()
            if letter in values and not (good and whole):
                self.report(
                    values[letter],
                    f"{letter} of {code} is {values[letter].value:g}",
                    f"{letter} {expected}",
                    f"correct {values[letter].text}",
                )
                return
        self.head = Head(int(values["Q"].value), "call", values["Q"].column, values["Q"].text)
        self.numbers = Numbers(
            distance=self._value("D", 0.0),
            last=self._value("E", 0.0),
            passes=int(self._value("P", 1.0)),
            increment=self._value("I", 1.0),
            retract=self._value("R", 0.5),
        )

    def _value(self, letter: str, default: float) -> float:
        return self.values[letter].value if letter in self.values else default

    def cut(self) -> None:
        """The moves along the contour; the position is then at its end."""
        self.state.position = self.position
        segments, last = self.contour.segments, self.contour.last
        if self.state.mistakes.found:
            return
        if last is not None:
            self._wrong(
                f"the contour ends with {last.text}, a corner without a move after it",
                "a move after the last A or C",
                f"remove {last.text} in O{self.head.label}",
            )
            return
        if len(segments) < 2 or segments[0].line == segments[-1].line:
            self._wrong(
                f"the contour O{self.head.label} has {len(segments)} moves",
                "one move to the contour, and one or more along it",
                "write X and Z of its points, which differ from the start of the cycle",
            )
            return
        try:
            self._moves()
        except ContourError as error:
            self._wrong(*error.args)
        except ZeroDivisionError:
            self._wrong(*vanished().args)

    def _moves(self) -> None:
        name, _, form = self.word.code.partition(".")
        segments, numbers = self.contour.segments, self.numbers
        if name == "G70":
            steps = finishing(segments, self.start, numbers)
        else:
            steps = roughing(segments, self.start, numbers, name == "G72", int(form or 0))
        place, scale = self.start, self.state.modes.mm_per_unit
        for motion, end, centre in steps:
            middle = None
            if centre is not None:
                way = end - place
                if abs(way.real) < SAME and abs(way.imag) < SAME:
                    continue
                radii = abs(place - centre), abs(end - centre)
                if not radii_fit(self.state, *radii, self.word):
                    return
                middle = centre.real * scale, centre.imag * scale
            self.actions.run(motion, pose_at(self.state, end), middle)
            if self.state.mistakes.found:
                return
            place = end
