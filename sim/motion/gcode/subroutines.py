# SPDX-License-Identifier: Apache-2.0
"""Subroutines of O words: sub, endsub, call, return; grammar in flow.py."""

from __future__ import annotations

from sim.motion.gcode.execution import Execution, Frame, Line
from sim.motion.gcode.expressions import Key, shown
from sim.motion.gcode.oword import ARGUMENTS, CLOSING, NUMBER, Head

MAX_DEPTH = 9  # calls inside calls, as rs274
VALUE, RETURNED = "_value", "_value_returned"


def _has_repeats(head: Head) -> bool:
    """Whether P of M98 may have the repeats before the number of four digits, as on Fanuc's."""
    return head.keyword == "M98" and isinstance(head.label, int) and head.label > 9999


class Subroutines:
    """Acts on the O words of subroutines: each gets the word, its line and its values."""

    def __init__(self, run: Execution) -> None:
        self.run = run
        self.known: dict[Key, tuple[int, int]] = {}  # places of sub and endsub
        self.numbered: dict[Key, int] = {}  # places of the numbers of subprograms of M98
        self._returns([])

    def sub(self, head: Head, line: Line, values: list[float]) -> None:
        if self.run.frame.label != "":
            self.run.fail(
                head,
                f"subroutine inside O{shown(self.run.frame.label)} sub",
                "endsub before the next sub",
                "define subroutines one after the other",
            )
        self._define(head, line)

    def _define(self, head: Head, line: Line) -> None:
        """Passes a subroutine over and stores its lines; self.run.at is after its first one."""
        begin = self.run.at - 1
        known = self.known.get(head.label)
        if known is not None and known[0] == begin:
            self.run.at = known[1] + 1
            return
        if known is not None:
            self.run.mistakes.place(*line)
            self.run.fail(
                head,
                "the subroutine is defined twice",
                f"one sub with the label {shown(head.label)}",
                "choose another label",
            )
        self.run.bodies[begin] = line
        while True:
            body = self.run.take(self.run.at)
            if body is None:
                self.run.fail_open(line, head, "endsub")
            self.run.bodies[self.run.at] = body
            self.run.kept.pop(self.run.at, None)
            self.run.at += 1
            inner = self.run.head(body)
            if inner is not None and inner.label == head.label and inner.keyword == "endsub":
                break
        self.known[head.label] = begin, self.run.at - 1

    def call(self, head: Head, line: Line, values: list[float]) -> None:
        back = self.run.at
        if head.label not in self.known:
            self._search(head, line)
        self._check_depth(head)
        self.run.count(head)
        numbers = self.run.state.parameters
        saved: dict[Key, float] = {n: numbers.get(n, 0.0) for n in range(1, ARGUMENTS + 1)}
        numbers.update(zip(saved, [*values, *[0.0] * (ARGUMENTS - len(values))], strict=True))
        self.run.enter(Frame(head.label, back, line, head, self.run.repeating(), saved))
        self.run.at = self.known[head.label][0] + 1

    def _check_depth(self, head: Head) -> None:
        if len(self.run.frames) > MAX_DEPTH:
            self.run.fail(
                head,
                f"calls inside calls are deeper than {MAX_DEPTH}",
                f"at most {MAX_DEPTH}",
                "check that the recursion ends, or replace it by a loop",
            )

    def _search(self, head: Head, line: Line) -> None:
        """Reads on to the definition of a subroutine."""
        number = head.keyword == "M98"
        self.run.searching = True
        self.run.at = self.run.unread
        while head.label not in (self.numbered if number else self.known):
            later = self.run.next()
            if later is None:
                self.run.mistakes.place(*line)
                self.run.fail(
                    head,
                    f"there is no {'subprogram' if number else 'subroutine'} {shown(head.label)} "
                    + ("after its call" if number else "in this file"),
                    f"O{shown(head.label)}" + ("" if number else " sub"),
                    "check the label; subroutines in files of their own are not looked for"
                    + ("; repeats are L, as in M98 P1000 L3" if _has_repeats(head) else ""),
                )
            found = self.run.head(later)
            if found is None:
                continue
            if found.keyword == "sub":
                self._define(found, later)
            elif found.keyword == NUMBER:
                self._define_numbered(found, later)
        self.run.searching = False

    # Subprograms of M98

    def number(self, head: Head, line: Line, values: list[float]) -> None:
        if self.run.frame.begin is not None:
            label = shown(self.run.frame.label)
            self.run.fail(
                head,
                f"O{shown(head.label)} inside the subprogram O{label}",
                f"M99 at the end of O{label}",
                "write M99 before",
            )

    def _define_numbered(self, head: Head, line: Line) -> None:
        """Stores the lines of a subprogram: to the next one, or to the end of the text."""
        while True:
            self.numbered.setdefault(head.label, self.run.at)
            self.run.bodies[self.run.at - 1] = line
            while (body := self.run.take(self.run.at)) is not None:
                line = body
                self.run.bodies[self.run.at] = line
                self.run.kept.pop(self.run.at, None)
                self.run.at += 1
                inner = self.run.head(line)
                if inner is not None and inner.keyword in (NUMBER, "sub"):
                    head = inner
                    break
            if body is None:
                return
            if head.keyword == "sub":
                self._define(head, line)
                return

    def call_numbered(self, head: Head, line: Line, times: int) -> None:
        """M98."""
        back = self.run.at
        if head.label not in self.numbered:
            self._search(head, line)
        self._check_depth(head)
        self.run.count(head)
        begin = self.numbered[head.label]
        inside = self.run.repeating()
        self.run.enter(
            Frame(head.label, back, line, head, inside or times > 1, times=times - 1, begin=begin)
        )
        self.run.at = begin

    def end_numbered(self, head: Head) -> None:
        """M99."""
        frame = self.run.frame
        if frame.begin is None:
            self.run.fail(
                head,
                "M99 outside of a subprogram",
                "M99 at the end of the lines that M98 calls",
                "end the program with M2; LinuxCNC repeats it without end",
            )
        if frame.times:
            self.run.count(head)
            frame.times -= 1
            frame.open.clear()
            self.run.at = frame.begin
            return
        self.run.leave()
        self.run.at = frame.back
        if frame.restores and frame.state is not None:
            self.run.state.restore(frame.state)

    def endsub(self, head: Head, line: Line, values: list[float]) -> None:
        frame = self._inner_frame(head)
        if frame.label != head.label:
            self.run.fail(
                head,
                f"endsub does not belong to O{shown(frame.label)} sub, which runs",
                f"O{shown(frame.label)} endsub",
                "check the labels",
            )
        if frame.open:
            open_ = frame.open[-1]
            self.run.fail_open(open_.line, open_.head, CLOSING[open_.kind])
        self._leave(frame, values)

    def return_(self, head: Head, line: Line, values: list[float]) -> None:
        self._leave(self._inner_frame(head), values)

    def _inner_frame(self, head: Head) -> Frame:
        if len(self.run.frames) == 1 or self.run.frame.begin is not None:
            self.run.fail(
                head,
                f"{head.keyword} outside of a subroutine",
                "a line of a subroutine",
                f"write O{shown(head.label)} sub before, or remove the line",
            )
        return self.run.frame

    def _leave(self, frame: Frame, values: list[float]) -> None:
        self.run.leave()
        self.run.state.parameters.update(frame.saved)
        self._returns(values)
        self.run.at = frame.back
        if frame.restores and frame.state is not None:
            self.run.state.restore(frame.state)

    def _returns(self, values: list[float]) -> None:
        numbers = self.run.state.parameters
        numbers[VALUE], numbers[RETURNED] = values[0] if values else 0.0, float(bool(values))
