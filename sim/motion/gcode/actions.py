# SPDX-License-Identifier: Apache-2.0
"""What the words of a block do at once: rests, moves, cycles, the way home."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

from sim.motion.gcode.arcs import Centre, arc_centre, turns_of
from sim.motion.gcode.block import CYCLES, POLAR, PROBES, THREADS
from sim.motion.gcode.cycles import drill
from sim.motion.gcode.output import Output
from sim.motion.gcode.runs import machine_moves, program_moves
from sim.motion.gcode.splines import Splines
from sim.motion.gcode.state import State
from sim.motion.gcode.table_frame import MAX_PIECES, TooManyPiecesError
from sim.motion.gcode.targets import absolute_target, target
from sim.motion.gcode.words import OFFSETS, Word
from sim.motion.geometry.moves import AXES, Dwell, Motion, Pose, pose_of

MAX_REST = 3600.0  # s, of one G4
_OWN_AXES = {"G10", "G28", "G28.1", "G52", "G92"}  # take the axis words of their block


class Actions:
    """Turns blocks into moves and rests, which are put into `output`; the state goes along."""

    def __init__(self, state: State) -> None:
        self.state, self.report = state, state.report
        self.output = Output(state)
        self.splines = Splines(state)
        self.feed_reported = False

    def single(
        self, word: Word, codes: dict[str, Word], values: dict[str, Word], clean: bool
    ) -> None:
        """A word that acts once, without G53."""
        motion = codes.get("motion")
        if motion is not None and motion.code != "G80" and word.code in _OWN_AXES:
            self.report(
                motion,
                f"{motion.code} and {word.code} both take the axis words",
                "one of them",
                f"move {motion.text} to a block of its own",
            )
            return
        if word.code == "G4":
            self._dwell(word, values, clean)
            values = {letter: value for letter, value in values.items() if letter != "P"}
        elif word.code == "G10":
            self.state.set_data(word, values)
        elif word.code == "G28":
            self._home(values)
        elif word.code == "G28.1":
            self.state.store_home()
        else:
            self.state.set_shift(word, values)
        if word.code not in _OWN_AXES:
            self.move([word], values, motion, None, clean)

    def side_words(self, codes: dict[str, Word], values: dict[str, Word]) -> None:
        """Words that have no way of their own and take letters of a motion: M19, M66. The path
        stops; M66 reads an input, which is 0, since nothing is connected."""
        spindle, signal = codes.get("spindle"), codes.get("signal")
        if spindle is not None and spindle.code == "M19":
            values.pop("R", None)
            self.rest(0.0)
        if signal is None:
            return
        number = values.get("E") or values.get("P")
        if number is not None and (number.value < 0.0 or not number.value.is_integer()):
            self.report(
                number,
                f"{signal.code} with {number.text}",
                "the number of the signal, a whole one of at least 0",
                f"write for instance {signal.code} {number.letter}0",
            )
            return
        if signal.code != "M66":
            needed = "E" if signal.code in ("M67", "M68") else "P"
            if needed not in values:
                self.report(
                    signal,
                    f"{signal.code} without the number of its output",
                    needed,
                    f"write for instance {signal.code} {needed}0",
                )
            return
        kind = values.get("L")
        if kind is not None and kind.value != 0.0:
            self.report(
                kind,
                "a wait for a signal, which never comes here",
                "L0, which reads the input once",
                "there are no inputs for programs here; M0 stops for the operator",
            )
        elif ("P" in values) == ("E" in values):
            self.report(
                signal,
                "M66 reads one input",
                "P (digital) or E (analog) with its number",
                "write for instance M66 P0 L0",
            )
        else:
            self.state.store_input()
            self.rest(0.0)

    def _dwell(self, word: Word, values: dict[str, Word], clean: bool) -> None:
        seconds = values.get("P")
        if seconds is None or seconds.value < 0.0:
            self.report(
                seconds or word,
                "G4 needs a time",
                "P in seconds, of at least 0",
                "write for instance G4 P0.5",
            )
        elif seconds.value > MAX_REST:
            self.report(
                seconds,
                f"a rest of {seconds.value:g} s",
                f"at most {MAX_REST:g} s",
                "P counts seconds; M0 stops for the operator",
            )
        elif clean:
            self.rest(seconds.value)

    def _home(self, values: dict[str, Word]) -> None:
        """By way of the words' point to the stored pose, in the axes of the words or in all."""
        home, named = self.state.home, [letter in values for letter in AXES]
        if any(named):
            self.run(Motion.RAPID, target(self.state, values))
        end = home
        if any(named):
            turned = bool(self.state.rotation) and not self.state.modes.in_table_frame
            goal = self.state.of_frame(home) if turned else home
            here = self.state.programmed() if turned else self.state.position
            place = pose_of(
                h if wanted else p for h, p, wanted in zip(goal, here, named, strict=True)
            )
            end = self.state.end_in_frame(place) if turned else place
        if self.state.mistakes.found:
            self.state.position = end
        else:
            moves = machine_moves(self.state, Motion.RAPID, end)
            self.output.put(moves)

    # Motion

    def move(
        self,
        words: list[Word],
        values: dict[str, Word],
        code: Word | None,
        absolute: Word | None,
        clean: bool,
    ) -> None:
        """The motion in force to the place of the words; absolute: the word G53."""
        state = self.state
        arc_words = [values[letter] for letter in OFFSETS + "R" if letter in values]
        places = [values[letter] for letter in AXES + POLAR if letter in values] + arc_words
        if not places:
            self._check_alone(code, clean)
            if absolute is not None and clean:
                self.report(
                    absolute,
                    "G53 without a position",
                    "X Y Z A C words, which it makes coordinates of the machine",
                    "remove G53; it acts in its own block only",
                )
            return
        if state.motion is None or state.motion == "G80":
            if clean:
                self.report(
                    places[0],
                    "no motion is selected",
                    "G0, G1, G2 or G3 in this block or before",
                    f"write G0 or G1 before {places[0].text}",
                )
            state.position = state.machine(target(state, values))
            return
        at = code or words[0]
        self.splines.onward = None
        if state.motion not in THREADS:
            self._check_feed(state.motion, at)
        if state.motion in CYCLES:
            if clean and state.modes.feed is not None:
                self._cycle(values, at)
            return
        end = target(state, values)
        if absolute is not None:
            end = absolute_target(state, absolute, values)
        if state.motion in (*THREADS, *PROBES):
            act = self._thread if state.motion in THREADS else self._probe
            act(state.motion, end, values, at, clean)
            return
        motion = Motion(state.motion)
        if motion.is_arc:
            self._arc(motion, end, values, at, clean)
            return
        self.run(motion, end)

    def _check_alone(self, code: Word | None, clean: bool) -> None:
        """A block without a place: only some motion words may be alone."""
        if code is not None and clean and code.code not in ("G0", "G1", "G80"):
            arc = self.state.motion in ("G2", "G3")
            self.report(
                code,
                f"{code.code} without a position",
                "X Y Z A C" + (" I J K or R words" if arc else " words"),
                f"give the end of the move or remove {code.text}",
            )

    def _check_feed(self, motion: str, at: Word) -> None:
        modes = self.state.modes
        if motion != "G0" and modes.feed is None and not self.feed_reported:
            self.feed_reported = not modes.inverse_time
            self.report(
                at,
                f"no feed is set for {motion}",
                "an F word in this block" + ("" if modes.inverse_time else " or before"),
                "add for instance F2000 to the block",
            )
        elif motion != "G0" and modes.per_turn and not (modes.turning and modes.speed):
            self.report(
                at,
                "G95 with a spindle that does not turn",
                "S greater than 0 and M3 or M4 before",
                "write for instance S400 M3, or G94 for a feed per minute",
            )

    def _arc(
        self, motion: Motion, end: Pose, values: dict[str, Word], at: Word, clean: bool
    ) -> None:
        centre = None
        if clean and self.output.must_be_straight:
            self.report(
                at,
                "the move after G40 is an arc",
                "G0 or G1",
                "leave the contour on a straight line",
            )
        elif clean:
            centre = arc_centre(self.state, motion, end, values, at)
        self.run(motion, end, centre, turns_of(self.state, values.get("P")))

    def _thread(
        self, motion: str, end: Pose, values: dict[str, Word], at: Word, clean: bool
    ) -> None:
        """G33: the tool moves by K for each turn of a spindle at S; G33.1: and then back."""
        state, modes, pitch = self.state, self.state.modes, values.get("K")
        start = state.programmed()
        if not clean or self._compensated(motion, at):
            pass
        elif pitch is None or pitch.value <= 0.0:
            self.report(
                pitch or at,
                f"{motion} without a pitch",
                "K greater than 0, the way for a turn of the spindle",
                "write for instance G33 Z-5 K1.25",
            )
        elif not modes.turning or modes.speed == 0.0:
            self.report(
                at,
                f"{motion} with a spindle that does not turn",
                "S greater than 0 and M3 or M4 before",
                "write for instance S400 M3",
            )
        elif modes.inverse_time:
            self.report(at, f"{motion} with G93", "feed per minute (G94)", "write G94 before")
        elif start[:3] == end[:3]:
            self.report(
                at,
                f"{motion} without a way of the tool",
                "X, Y or Z of another place",
                "K counts the way of the tool; turn the table with G1",
            )
        else:
            feed = pitch.value * modes.mm_per_unit * modes.speed
            thread = replace(modes, feed=feed, feed_mm_per_unit=1.0, override=False)
            state.modes = replace(thread, per_turn=False)
            if motion == "G33.1":
                state.modes.tolerance = state.modes.merge = 0.0
            self.run(Motion.LINEAR, end)
            if motion == "G33.1":
                self.run(Motion.LINEAR, start)
            state.modes = modes

    def _probe(
        self, motion: str, end: Pose, values: dict[str, Word], at: Word, clean: bool
    ) -> None:
        """G38.2 to G38.5 up to their end, because nothing touches the probe in a plan."""
        state, modes = self.state, self.state.modes
        if not clean or modes.feed is None or self._compensated(motion, at):
            return
        if modes.inverse_time or modes.per_turn:
            mode = "G93" if modes.inverse_time else "G95"
            self.report(at, f"{motion} with {mode}", "feed per minute (G94)", "write G94 before")
            return
        state.modes = replace(modes, tolerance=0.0, merge=0.0)
        self.run(Motion.LINEAR, end)
        state.modes = modes
        state.store_probed()
        self.rest(0.0)

    def _compensated(self, motion: str, at: Word) -> bool:
        """Whether cutter compensation is on, which is a mistake then."""
        if self.state.compensation is not None:
            self.report(
                at,
                f"{motion} during cutter compensation",
                "G0 G1 G2 G3",
                f"write G40 before {at.text}",
            )
        return self.state.compensation is not None

    def spline(
        self, codes: dict[str, Word], values: dict[str, Word], at: Word, clean: bool
    ) -> None:
        """G5 to G5.3, and control points between them."""
        state = self.state
        self._check_feed(codes["motion"].code if "motion" in codes else "G5.2", at)
        ends = self.splines.block(codes, values, at) if clean else []
        if self.state.mistakes.found or not ends:
            return
        start = state.programmed()
        points = [start[:2], *ends]
        length = sum(math.dist(a, b) for a, b in itertools.pairwise(points))
        for number, point in enumerate(ends):
            end = pose_of((*point, *start[2:]))
            for move in program_moves(state, Motion.LINEAR, end):
                feed = state.modes.rate * length if state.modes.inverse_time else move.feed
                inner, merge = number > 0, move.merge if len(ends) == 1 else 0.0
                self.output.put([replace(move, feed=feed, inner=inner, merge=merge)])

    def run(self, motion: Motion, end: Pose, centre: Centre | None = None, turns: int = 1) -> None:
        """Moves to `end` in programmed coordinates, centre likewise."""
        if self.state.mistakes.found:  # a text with a mistake yields no program
            self.state.position = self.state.machine(end)
        else:
            try:
                moves = program_moves(self.state, motion, end, centre, turns)
            except TooManyPiecesError:
                self.report(
                    self.output.at,
                    f"the curve of the tool needs more than {MAX_PIECES} chords",
                    "a smaller turn of the table",
                    "check A and C, or divide the move",
                )
                return
            self.output.put(moves)

    def rest(self, seconds: float) -> None:
        """The path stops."""
        self.output.put([Dwell(*self.state.block, seconds)])

    def _cycle(self, values: dict[str, Word], at: Word) -> None:
        """Path control is that of G61 meanwhile."""
        modes = self.state.modes
        saved = modes.tolerance, modes.merge
        modes.tolerance, modes.merge = 0.0, 0.0
        for step in drill(self.state, values, at):
            if isinstance(step, float):
                self.rest(step)
            else:
                self.run(*step)
        modes.tolerance, modes.merge = saved
