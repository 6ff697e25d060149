# SPDX-License-Identifier: Apache-2.0
"""Order in which the lines of a program run: O words (LinuxCNC, "O Codes"), ahead of the parser.

line    = [N word] O label keyword arguments [comments]; an O word stands first in its line
label   = number | #value | [expression] | <name>; case and blanks do not count in names
keyword = sub endsub call return | if elseif else endif | while do endwhile | repeat endrepeat
          | break continue (of while and do)

`call` takes up to 30 values [a] [b] as #1, #2, ...; the rest of #1 to #30 is 0 in the subroutine,
and all 30 have their former values after it; names without a leading underscore are the
subroutine's own. `return [v]`, with any label, and `endsub [v]` leave #<_value> and
#<_value_returned>. A subroutine may stand behind its first call. Labels of subroutines hold in the
whole file, others in the subroutine (or main program) they stand in. Subroutines in other files
are not looked for.

Lines that do not run, those of a branch not taken or a subroutine not called, are not read for
mistakes. A mistake in an O word ends the reading; so does an O word behind a mistake.

Memory: nothing without O words. Otherwise the text of all subroutines, of the loops that are open,
and, from a call of a subroutine that comes later, of the lines up to its definition.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from sim.gcode.errors import MistakeError, Report
from sim.gcode.expressions import Key
from sim.gcode.oword import ARGUMENTS, CLOSING, O_LINE, Head, HeadReader, shown_label

MAX_DEPTH = 9  # calls inside calls, as rs274
MAX_IDLE = 100_000  # repeats and calls without a way between them
MAX_AGAIN = 300_000  # lines of them
MAX_OPEN = 1000  # branches and loops inside each other
VALUE, RETURNED = "_value", "_value_returned"

Line = tuple[int, str]
"""Number, from 1, and text."""


class FlowStop(Exception):
    """Ends the reading; the mistake has been reported."""


@dataclass
class _Open:
    """A branch or loop that runs; at: place of its first line."""

    head: Head
    kind: str
    at: int
    line: Line
    in_loop: bool = False  # it is a loop or inside one, that of a caller too
    repeats: int = 0
    last_branch: bool = False


@dataclass
class Frame:
    """Main program, or a subroutine that runs. names: its own named parameters."""

    label: Key | None = None
    back: int = 0
    line: Line = (0, "")  # of the call
    head: Head | None = None
    in_loop: bool = False  # the call
    saved: dict[Key, float] = field(default_factory=dict)
    names: dict[Key, float] = field(default_factory=dict)
    open: list[_Open] = field(default_factory=list)
    state: Any = None  # M70, M73
    restores: bool = False  # M73


class Flow:
    """Runs the O words of a program and yields its other lines in the order in which they act.

    place is told the line under work before report and read are called; parameters holds numbers
    and global names, read gives values of all (words.py); mistakes tells whether there are
    any; left is called with the frame of each subroutine that ends.
    """

    def __init__(
        self,
        source: Iterator[Line],
        place: Callable[[int, str], None],
        report: Report,
        read: Callable[[Key], float | None],
        parameters: dict[Key, float],
        mistakes: Callable[[], bool],
        left: Callable[[Frame], None],
    ) -> None:
        self.source, self.place, self.report, self.read = source, place, report, read
        self.parameters, self.mistakes, self.left = parameters, mistakes, left
        self.frames = [Frame()]
        self.at = 0  # of the next line to run
        self.unread = 0  # place of the next line of source
        self.kept: dict[int, Line] = {}
        self.bodies: dict[int, Line] = {}  # lines of subroutines
        self.subs: dict[Key, tuple[int, int]] = {}  # places of sub and endsub
        self.labels: dict[tuple[Key | None, Key], int] = {}
        self.searching = False
        self.idle = 0  # repeats and calls, and
        self.again = 0  # lines of them, since the last move
        self.used = False  # there was an O word
        parameters[VALUE] = parameters[RETURNED] = 0.0

    @property
    def frame(self) -> Frame:
        return self.frames[-1]

    @property
    def inside(self) -> bool:
        """Whether a subroutine, branch or loop runs."""
        return len(self.frames) > 1 or bool(self.frame.open)

    def moved(self) -> None:
        """To be told of every move that goes anywhere: the program is not idle."""
        self.idle = self.again = 0

    def lines(self) -> Iterator[Line]:
        """Lines without O words, in the order in which they run. Raises FlowStop."""
        while True:
            if self.kept or self.searching or self.inside or self.at != self.unread:
                line = self._next()
            else:
                line = next(self.source, None)
                self.at = self.unread = self.at + (line is not None)
            if line is None:
                self._check_closed()
                return
            if O_LINE.match(line[1]):
                self.used = True
                self._run(line)
            else:
                yield line

    def finish(self) -> None:
        """After the end of the program inside an O word: its branches and loops must be closed."""
        while True:
            for open_ in reversed(self.frame.open):
                self._close(open_)
            if len(self.frames) == 1:
                break
            self.at = self.frames.pop().back
        self.frame.open.clear()
        for _ in self.source:
            pass

    # Lines

    def _next(self) -> Line | None:
        """The line at self.at, which is advanced."""
        if self.kept and self.at == self.unread and not self.searching and not self._repeating():
            self.kept.clear()
        self.again += self.at < self.unread
        line = self._line(self.at)
        if line is not None:
            if self.again > MAX_AGAIN:
                self.place(*line)
                self.report(
                    1,
                    line[1],
                    f"the program runs {MAX_AGAIN} lines again without a move that goes anywhere",
                    "a loop or recursion that ends or moves",
                    "check the condition and that the loop changes what it asks for",
                )
                raise FlowStop
            self.at += 1
        return line

    def _repeating(self) -> bool:
        """Whether lines are in a loop and may run again."""
        frame = self.frame
        return frame.open[-1].in_loop if frame.open else frame.in_loop

    def _line(self, at: int) -> Line | None:
        if at < self.unread:
            return self.bodies.get(at) or self.kept[at]
        line = next(self.source, None)
        if line is None:
            return None
        self.unread += 1
        if self.searching or self._repeating():
            self.kept[at] = line
        return line

    def _head(self, line: Line) -> Head | None:
        """The O word of a line passed over, None if there is none that can be read."""
        if not O_LINE.match(line[1]):
            return None
        try:
            return HeadReader(line[1], lambda *_: None, self.read).head()
        except MistakeError:
            return None

    def _fail(self, head: Head, what: str, expected: str, help: str) -> None:
        self.report(head.column, head.text, what, expected, help)
        raise FlowStop

    def _fail_open(self, line: Line, head: Head, closing: str) -> None:
        self.place(*line)
        name = head.text[: len(head.text) - len(head.keyword)].rstrip()
        self._fail(
            head,
            f"{head.text} is not closed",
            f"{name} {closing} behind it",
            "write the closing line with the same label; the file may be truncated",
        )

    def _seek(self, open_: _Open, *keywords: str) -> tuple[Line, Head]:
        """Passes lines over up to an O word with the label of open_ and one of the keywords."""
        while True:
            line = self._next()
            if line is None:
                self._fail_open(open_.line, open_.head, CLOSING[open_.kind])
            head = self._head(line)
            if head is None:
                continue
            if head.label == open_.head.label and head.keyword in keywords:
                return line, head
            if head.label == self.frame.label and head.keyword == "endsub":
                self._fail_open(open_.line, open_.head, CLOSING[open_.kind])

    def _close(self, open_: _Open) -> None:
        self._seek(open_, CLOSING[open_.kind])

    def _check_closed(self) -> None:
        """At the end of the text."""
        for frame in reversed(self.frames):
            if frame.open:
                open_ = frame.open[-1]
                self._fail_open(open_.line, open_.head, CLOSING[open_.kind])

    # O words

    def _run(self, line: Line) -> None:
        if self.mistakes():
            raise FlowStop
        self.place(*line)
        reader = HeadReader(line[1], self.report, self.read)
        try:
            head = reader.head()
            act = getattr(self, f"_{head.keyword}")
            least, most = {
                "call": (0, ARGUMENTS),
                "return": (0, 1),
                "endsub": (0, 1),
                "if": (1, 1),
                "while": (1, 1),
                "repeat": (1, 1),
            }.get(head.keyword, (0, 0))
            if head.keyword == "elseif":  # its value counts only if no branch has run
                values = []
            else:
                values = reader.arguments(head, least, most)
        except MistakeError:
            raise FlowStop from None
        if self.mistakes():  # of a comment
            raise FlowStop
        act(head, line, values)

    def _condition(self, head: Head, line: Line) -> float:
        """Value of elseif."""
        self.place(*line)
        reader = HeadReader(line[1], self.report, self.read)
        try:
            reader.head()
            return reader.arguments(head, 1, 1)[0]
        except MistakeError:
            raise FlowStop from None

    def _label(self, head: Head) -> None:
        """Registers the label of a branch or loop, which is to be the only one of that name."""
        at = self.at - 1
        if self.labels.setdefault((self.frame.label, head.label), at) != at:
            self._fail(
                head,
                "the label is used twice",
                "a label of its own for each if, while, do and repeat",
                "choose another number; those of other subroutines may be equal",
            )

    def _top(self, head: Head, *kinds: str) -> _Open:
        """The innermost open branch or loop, which must have the label and be of a kind."""
        wanted = " or ".join(kinds)
        if not self.frame.open:
            self._fail(
                head,
                f"{head.keyword} without {wanted}",
                f"an open {wanted} with this label before",
                "check the label, or remove the line",
            )
        open_ = self.frame.open[-1]
        if open_.head.label != head.label or open_.kind not in kinds:
            self._fail(
                head,
                f"{head.keyword} does not belong to {open_.head.text} of line {open_.line[0]}",
                f"the end of {open_.head.text} before",
                "check the labels; branches and loops nest",
            )
        return open_

    def _count(self, head: Head) -> None:
        self.idle += 1
        if self.idle > MAX_IDLE:
            self._fail(
                head,
                f"the program repeats {MAX_IDLE} times without a move that goes anywhere",
                "a loop or recursion that ends or moves",
                "check the condition and that the loop changes what it asks for",
            )

    def _enter(self, kind: str, head: Head, line: Line) -> _Open:
        self._label(head)
        if kind != "if" and self.at - 1 not in self.bodies:
            self.kept[self.at - 1] = line
        if len(self.frame.open) == MAX_OPEN:
            self._fail(
                head,
                f"branches and loops are nested deeper than {MAX_OPEN}",
                "fewer inside each other",
                "check that each is closed",
            )
        open_ = _Open(head, kind, self.at - 1, line, kind != "if" or self._repeating())
        self.frame.open.append(open_)
        return open_

    # Branches

    def _if(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._enter("if", head, line)
        taken = values[0] != 0.0
        while not taken:
            line, head = self._seek(open_, "elseif", "else", "endif")
            if head.keyword == "endif":
                self.frame.open.pop()
                return
            open_.last_branch = head.keyword == "else"
            taken = head.keyword == "else" or self._condition(head, line) != 0.0

    def _elseif(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._top(head, "if")
        if open_.last_branch:
            self._fail(
                head,
                f"{head.keyword} behind the else of line {open_.line[0]}'s if",
                "endif",
                "put else last",
            )
        self._close(open_)
        self.frame.open.pop()

    _else = _elseif

    def _endif(self, head: Head, line: Line, values: list[float]) -> None:
        self._top(head, "if")
        self.frame.open.pop()

    # Loops

    def _while(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self.frame.open[-1] if self.frame.open else None
        if open_ is not None and open_.kind == "do" and open_.head.label == head.label:
            if values[0] != 0.0:
                self._count(head)
                self.at = open_.at + 1
            else:
                self.frame.open.pop()
            return
        open_ = self._enter("while", head, line)
        if values[0] == 0.0:
            self._close(open_)
            self.frame.open.pop()

    def _endwhile(self, head: Head, line: Line, values: list[float]) -> None:
        self._again(self._top(head, "while"), head)

    def _again(self, open_: _Open, head: Head) -> None:
        """To the condition of a while."""
        self._count(head)
        self.frame.open.pop()
        self.at = open_.at

    def _do(self, head: Head, line: Line, values: list[float]) -> None:
        self._enter("do", head, line)

    def _repeat(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._enter("repeat", head, line)
        open_.repeats = round(values[0])
        if open_.repeats < 1:
            self._close(open_)
            self.frame.open.pop()

    def _endrepeat(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._top(head, "repeat")
        open_.repeats -= 1
        if open_.repeats > 0:
            self._count(head)
            self.at = open_.at + 1
        else:
            self.frame.open.pop()

    def _loop(self, head: Head) -> _Open:
        """The while or do of break or continue; what is open inside it is left."""
        for number, open_ in reversed(list(enumerate(self.frame.open))):
            if open_.head.label == head.label and open_.kind in ("while", "do"):
                del self.frame.open[number + 1 :]
                return open_
        self._fail(
            head,
            f"{head.keyword} without its loop",
            "an open while or do with this label",
            "the label is that of the loop; repeat has neither break nor continue",
        )
        raise AssertionError

    def _break(self, head: Head, line: Line, values: list[float]) -> None:
        self._close(self._loop(head))
        self.frame.open.pop()

    def _continue(self, head: Head, line: Line, values: list[float]) -> None:
        open_ = self._loop(head)
        if open_.kind == "while":
            self._again(open_, head)
        else:
            self._close(open_)
            self.at -= 1  # while is to run

    # Subroutines

    def _sub(self, head: Head, line: Line, values: list[float]) -> None:
        if self.frame.label is not None:
            self._fail(
                head,
                f"subroutine inside O{shown_label(self.frame.label)} sub",
                "endsub before the next sub",
                "define subroutines beside each other",
            )
        self._define(head, line)

    def _define(self, head: Head, line: Line) -> None:
        """Passes a subroutine over and keeps its lines; self.at is behind its first one."""
        begin = self.at - 1
        known = self.subs.get(head.label)
        if known is not None and known[0] == begin:
            self.at = known[1] + 1
            return
        if known is not None:
            self.place(*line)
            self._fail(
                head,
                "the subroutine is defined twice",
                f"one sub with the label {shown_label(head.label)}",
                "choose another label",
            )
        self.bodies[begin] = line
        while True:
            body = self._line(self.at)
            if body is None:
                self._fail_open(line, head, "endsub")
            self.bodies[self.at] = body
            self.kept.pop(self.at, None)
            self.at += 1
            inner = self._head(body)
            if inner is not None and inner.label == head.label and inner.keyword == "endsub":
                break
        self.subs[head.label] = begin, self.at - 1

    def _call(self, head: Head, line: Line, values: list[float]) -> None:
        back = self.at
        if head.label not in self.subs:
            self._search(head, line)
        if len(self.frames) > MAX_DEPTH:
            self._fail(
                head,
                f"calls inside calls are deeper than {MAX_DEPTH}",
                f"at most {MAX_DEPTH}",
                "check that the recursion ends, or replace it by a loop",
            )
        self._count(head)
        saved = {n: self.parameters.get(n, 0.0) for n in range(1, ARGUMENTS + 1)}
        for number in saved:
            self.parameters[number] = values[number - 1] if number <= len(values) else 0.0
        self.frames.append(Frame(head.label, back, line, head, self._repeating(), saved))
        self.at = self.subs[head.label][0] + 1

    def _search(self, head: Head, line: Line) -> None:
        """Reads on to the definition of a subroutine."""
        self.searching = True
        self.at = self.unread
        while head.label not in self.subs:
            later = self._next()
            if later is None:
                self.place(*line)
                self._fail(
                    head,
                    f"there is no subroutine {shown_label(head.label)} in this file",
                    f"O{shown_label(head.label)} sub",
                    "check the label; subroutines in files of their own are not looked for",
                )
            found = self._head(later)
            if found is not None and found.keyword == "sub":
                self._define(found, later)
        self.searching = False

    def _endsub(self, head: Head, line: Line, values: list[float]) -> None:
        frame = self._inner_frame(head)
        if frame.label != head.label:
            self._fail(
                head,
                f"endsub does not belong to O{shown_label(frame.label)} sub, which runs",
                f"O{shown_label(frame.label)} endsub",
                "check the labels",
            )
        if frame.open:
            open_ = frame.open[-1]
            self._fail_open(open_.line, open_.head, CLOSING[open_.kind])
        self._leave(frame, values)

    def _return(self, head: Head, line: Line, values: list[float]) -> None:
        self._leave(self._inner_frame(head), values)

    def _inner_frame(self, head: Head) -> Frame:
        if len(self.frames) == 1:
            self._fail(
                head,
                f"{head.keyword} outside of a subroutine",
                "a line of a subroutine",
                f"write O{shown_label(head.label)} sub before, or remove the line",
            )
        return self.frame

    def _leave(self, frame: Frame, values: list[float]) -> None:
        self.frames.pop()
        self.parameters.update(frame.saved)
        self.parameters[VALUE] = values[0] if values else 0.0
        self.parameters[RETURNED] = float(bool(values))
        self.at = frame.back
        self.left(frame)
