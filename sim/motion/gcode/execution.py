# SPDX-License-Identifier: Apache-2.0
"""Where a program with O words is: running frames, the next line, lines stored for repetition."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NoReturn

from sim.motion.gcode.errors import MistakeError, Mistakes
from sim.motion.gcode.expressions import Key
from sim.motion.gcode.oword import CLOSING, O_LINE, Head, HeadReader
from sim.motion.gcode.state import Modes, State

MAX_AGAIN = 1_000_000  # characters that loops and calls run again without a move: a few seconds
LINE_COST = 10  # characters that a line counts in addition to its own

Line = tuple[int, str]
"""Number, from 1, and text."""


class FlowStop(Exception):
    """Ends the reading; the mistake has been reported."""


@dataclass
class Open:
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

    label: Key = ""  # empty for the main program
    back: int = 0
    line: Line = (0, "")  # line of the call
    head: Head | None = None
    in_loop: bool = False  # the call
    saved: dict[Key, float] = field(default_factory=dict)
    names: dict[Key, float] = field(default_factory=dict)
    open: list[Open] = field(default_factory=list)
    state: Modes | None = None  # M70, M73
    restores: bool = False  # M73: `state` is restored at the end of the frame
    times: int = 0  # remaining repetitions of a subprogram of M98
    begin: int | None = None  # place of its first line


class Execution:
    """Reads the lines of a program in the order in which they run; stores those needed again."""

    def __init__(self, source: Iterator[Line], mistakes: Mistakes, state: State) -> None:
        self.source, self.mistakes, self.state = source, mistakes, state
        self.frames = [Frame(names=state.names)]
        self.at = 0  # place of the next line to run
        self.unread = 0  # place of the next line of source
        self.kept: dict[int, Line] = {}
        self.bodies: dict[int, Line] = {}  # lines of subroutines
        self.searching = False
        self.again = 0  # characters of lines that ran again since the last move

    @property
    def frame(self) -> Frame:
        return self.frames[-1]

    @property
    def inside(self) -> bool:
        """Whether a subroutine, branch or loop runs."""
        return len(self.frames) > 1 or bool(self.frame.open)

    def enter(self, frame: Frame) -> None:
        """Enter a subroutine, with its own names."""
        self.frames.append(frame)
        self.state.names = frame.names

    def leave(self) -> Frame:
        """The subroutine that runs ends."""
        frame = self.frames.pop()
        self.state.names = self.frame.names
        return frame

    def moved(self) -> None:
        """Call this for every move that changes the position: the program is not idle."""
        self.again = 0

    def next(self) -> Line | None:
        """The line at self.at, which is advanced."""
        if self.kept and self.at == self.unread and not self.searching and not self.repeating():
            self.kept.clear()
        again = self.at < self.unread
        line = self.take(self.at)
        if line is not None:
            self.again += again * (len(line[1]) + LINE_COST)
            self.at += 1
        return line

    def repeating(self) -> bool:
        """Whether lines are in a loop and may run again."""
        frame = self.frame
        return frame.open[-1].in_loop if frame.open else frame.in_loop

    def take(self, at: int) -> Line | None:
        if at < self.unread:
            return self.bodies.get(at) or self.kept[at]
        line = next(self.source, None)
        if line is None:
            return None
        self.unread += 1
        if self.searching or self.repeating():
            self.kept[at] = line
        return line

    def head(self, line: Line) -> Head | None:
        """The O word of a line passed over, None if there is none that can be read."""
        if not O_LINE.match(line[1]):
            return None
        try:
            return HeadReader(line[1], lambda *_: None, self.state.read).head()
        except MistakeError:
            return None

    def fail(self, head: Head, what: str, expected: str, help: str) -> NoReturn:
        self.mistakes.report(head.column, head.text, what, expected, help)
        raise FlowStop

    def fail_open(self, line: Line, head: Head, closing: str) -> NoReturn:
        self.mistakes.place(*line)
        name = head.text[: len(head.text) - len(head.keyword)].rstrip()
        self.fail(
            head,
            f"{head.text} is not closed",
            f"{name} {closing} after it",
            "write the closing line with the same label; the file may be truncated",
        )

    def seek(self, open_: Open, *keywords: str) -> tuple[Line, Head]:
        """Passes lines over up to an O word with the label of open_ and one of the keywords."""
        while True:
            line = self.next()
            if line is None:
                self.fail_open(open_.line, open_.head, CLOSING[open_.kind])
            head = self.head(line)
            if head is None:
                continue
            if head.label == open_.head.label and head.keyword in keywords:
                return line, head
            if head.label == self.frame.label and head.keyword == "endsub":
                self.fail_open(open_.line, open_.head, CLOSING[open_.kind])

    def close(self, open_: Open) -> None:
        self.seek(open_, CLOSING[open_.kind])

    def check_closed(self) -> None:
        """At the end of the text."""
        for frame in reversed(self.frames):
            if frame.open:
                open_ = frame.open[-1]
                self.fail_open(open_.line, open_.head, CLOSING[open_.kind])
            if frame.begin is not None and frame.head is not None:
                self.mistakes.place(*frame.line)
                self.fail(
                    frame.head,
                    f"the subprogram O{frame.label} has no end",
                    "M99 after its last block",
                    "write M99; the file may be truncated",
                )

    def count(self, head: Head) -> None:
        """To be called where lines run again. Fails after more than MAX_AGAIN without a move."""
        if self.again > MAX_AGAIN:
            self.fail(
                head,
                f"the program runs {MAX_AGAIN} characters of loops and calls again without a move "
                "that goes anywhere",
                "a loop or recursion that ends or moves",
                "check the condition and that the loop changes what it asks for",
            )

    def condition(self, head: Head, line: Line) -> float:
        """Value of elseif."""
        self.mistakes.place(*line)
        reader = HeadReader(line[1], self.mistakes.report, self.state.read)
        try:
            reader.head()
            return reader.arguments(head, 1, 1)[0]
        except MistakeError:
            raise FlowStop from None
