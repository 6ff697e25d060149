# SPDX-License-Identifier: Apache-2.0
"""Branches and loops of O words: if, while, do, repeat, break, continue; grammar in flow.py."""

from __future__ import annotations

from sim.motion.gcode.execution import Execution, Line, Open
from sim.motion.gcode.expressions import Key
from sim.motion.gcode.oword import Head

MAX_OPEN = 1000  # branches and loops inside each other


class Branches:
    """Acts on the O words of branches and loops: each gets the word, its line and its values."""

    def __init__(self, run: Execution) -> None:
        self.run = run
        self.labels: dict[tuple[Key | None, Key], int] = {}

    def _label(self, head: Head) -> None:
        """Registers the label of a branch or loop, which is to be the only one of that name."""
        at = self.run.at - 1
        if self.labels.setdefault((self.run.frame.label, head.label), at) != at:
            self.run.fail(
                head,
                "the label is used twice",
                "a label of its own for each if, while, do and repeat",
                "choose another number; those of other subroutines may be equal",
            )

    def _top(self, head: Head, *kinds: str) -> Open:
        """The innermost open branch or loop, which must have the label and be of a kind."""
        wanted = " or ".join(kinds)
        if not self.run.frame.open:
            self.run.fail(
                head,
                f"{head.keyword} without {wanted}",
                f"an open {wanted} with this label before",
                "check the label, or remove the line",
            )
        open_ = self.run.frame.open[-1]
        if open_.head.label != head.label or open_.kind not in kinds:
            self.run.fail(
                head,
                f"{head.keyword} does not belong to {open_.head.text} of line {open_.line[0]}",
                f"the end of {open_.head.text} before",
                "check the labels; branches and loops nest",
            )
        return open_

    def _enter(self, kind: str, head: Head, line: Line) -> Open:
        self._label(head)
        if kind != "if" and self.run.at - 1 not in self.run.bodies:
            self.run.kept[self.run.at - 1] = line
        if len(self.run.frame.open) == MAX_OPEN:
            self.run.fail(
                head,
                f"branches and loops are nested deeper than {MAX_OPEN}",
                "fewer inside each other",
                "check that each is closed",
            )
        open_ = Open(head, kind, self.run.at - 1, line, kind != "if" or self.run.repeating())
        self.run.frame.open.append(open_)
        return open_

    def if_(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._enter("if", head, line)
        taken = values[0] != 0.0
        while not taken:
            line, head = self.run.seek(open_, "elseif", "else", "endif")
            if head.keyword == "endif":
                self.run.frame.open.pop()
                return
            open_.last_branch = head.keyword == "else"
            taken = head.keyword == "else" or self.run.condition(head, line) != 0.0

    def elseif(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._top(head, "if")
        if open_.last_branch:
            self.run.fail(
                head,
                f"{head.keyword} behind the else of line {open_.line[0]}'s if",
                "endif",
                "put else last",
            )
        self.run.close(open_)
        self.run.frame.open.pop()

    def endif(self, head: Head, line: Line, values: list[float]) -> None:
        self._top(head, "if")
        self.run.frame.open.pop()

    def while_(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self.run.frame.open[-1] if self.run.frame.open else None
        if open_ is not None and open_.kind == "do" and open_.head.label == head.label:
            if values[0] != 0.0:
                self.run.count(head)
                self.run.at = open_.at + 1
            else:
                self.run.frame.open.pop()
            return
        open_ = self._enter("while", head, line)
        if values[0] == 0.0:
            self.run.close(open_)
            self.run.frame.open.pop()

    def endwhile(self, head: Head, line: Line, values: list[float]) -> None:
        self._again(self._top(head, "while"), head)

    def _again(self, open_: Open, head: Head) -> None:
        """To the condition of a while."""
        self.run.count(head)
        self.run.frame.open.pop()
        self.run.at = open_.at

    def do(self, head: Head, line: Line, values: list[float]) -> None:
        self._enter("do", head, line)

    def repeat(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._enter("repeat", head, line)
        open_.repeats = round(values[0])
        if open_.repeats < 1:
            self.run.close(open_)
            self.run.frame.open.pop()

    def endrepeat(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._top(head, "repeat")
        open_.repeats -= 1
        if open_.repeats > 0:
            self.run.count(head)
            self.run.at = open_.at + 1
        else:
            self.run.frame.open.pop()

    def _loop(self, head: Head) -> Open:
        """The while or do of break or continue; what is open inside it is left."""
        for number, open_ in reversed(list(enumerate(self.run.frame.open))):
            if open_.head.label == head.label and open_.kind in ("while", "do"):
                del self.run.frame.open[number + 1 :]
                return open_
        self.run.fail(
            head,
            f"{head.keyword} without its loop",
            "an open while or do with this label",
            "the label is that of the loop; repeat has neither break nor continue",
        )
        raise AssertionError

    def break_(self, head: Head, line: Line, values: list[float]) -> None:
        self.run.close(self._loop(head))
        self.run.frame.open.pop()

    def continue_(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._loop(head)
        if open_.kind == "while":
            self._again(open_, head)
        else:
            self.run.close(open_)
            self.run.at -= 1  # while is to run
