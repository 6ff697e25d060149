# SPDX-License-Identifier: Apache-2.0
"""Order in which the lines of a program run: O words (LinuxCNC, "O Codes"), ahead of the parser.

line    = [N word] O label keyword arguments [comments]; an O word comes first in its line
label   = number | #value | [expression] | <name>; case and blanks do not count in names
keyword = sub endsub call return | if elseif else endif | while do endwhile | repeat endrepeat
          | break continue (of while and do)

`call` takes up to 30 values [a] [b] as #1, #2, ...; the rest of #1 to #30 is 0 in the subroutine,
and all 30 have their former values after it; names without a leading underscore are the
subroutine's own. `return [v]`, with any label, and `endsub [v]` leave #<_value> and
#<_value_returned>. A subroutine may be after its first call. Labels of subroutines hold in the
whole file, others in the subroutine (or main program) they are in. Subroutines in other files
are not looked for.

A line with O and a number alone begins a subprogram of M98 P L, as Fanuc's controls and LinuxCNC
have them; it ends at M99, and comes after the call. It has the caller's numbered parameters and
names of its own. In the main program such a line is a number without effect.

Lines that do not run, those of a branch not taken or a subroutine not called, are not read for
mistakes. A mistake in an O word ends the reading; so does an O word after a mistake.

Memory: nothing without O words. Otherwise the text of all subroutines, of the loops that are open,
and, from a call of a subroutine that comes later, of the lines up to its definition.
"""

from __future__ import annotations

from collections.abc import Iterator

from sim.motion.gcode.branches import Branches
from sim.motion.gcode.errors import MistakeError, Mistakes
from sim.motion.gcode.execution import Execution, FlowStop, Line
from sim.motion.gcode.oword import ARGUMENTS, NUMBER, O_LINE, Head, HeadReader
from sim.motion.gcode.state import State
from sim.motion.gcode.subroutines import Subroutines


class Flow(Execution):
    """Runs the O words of a program and yields its other lines in the order in which they act.

    mistakes gets the line under work before parameters are read.
    """

    def __init__(self, source: Iterator[Line], mistakes: Mistakes, state: State) -> None:
        super().__init__(source, mistakes, state)
        branches, subroutines = Branches(self), Subroutines(self)
        self.subroutines = subroutines
        self._acts = {  # by keyword, with the least and the greatest number of values after it
            "if": (branches.if_, 1, 1),
            "elseif": (branches.elseif, 0, 0),  # its value is read where no branch has run
            "else": (branches.elseif, 0, 0),
            "endif": (branches.endif, 0, 0),
            "while": (branches.while_, 1, 1),
            "endwhile": (branches.endwhile, 0, 0),
            "do": (branches.do, 0, 0),
            "repeat": (branches.repeat, 1, 1),
            "endrepeat": (branches.endrepeat, 0, 0),
            "break": (branches.break_, 0, 0),
            "continue": (branches.continue_, 0, 0),
            "sub": (subroutines.sub, 0, 0),
            "endsub": (subroutines.endsub, 0, 1),
            "call": (subroutines.call, 0, ARGUMENTS),
            "return": (subroutines.return_, 0, 1),
            NUMBER: (subroutines.number, 0, 0),
        }

    def lines(self) -> Iterator[Line]:
        """Lines without O words, in the order in which they run. Raises FlowStop."""
        while (line := self.next()) is not None:
            if O_LINE.match(line[1]):
                self._act(line)
            else:
                yield line
        self.check_closed()

    def call_lines(self, head: Head) -> Iterator[Line]:
        """Calls the subroutine of the label; its lines without O words, until it returns."""
        depth = len(self.frames)
        self.subroutines.call(head, (self.mistakes.line, self.mistakes.source), [])
        while len(self.frames) > depth and (line := self.next()) is not None:
            if O_LINE.match(line[1]):
                self._act(line)
            else:
                yield line

    def finish(self) -> None:
        """After the end of the program inside an O word: its branches and loops must be closed."""
        while True:
            for open_ in reversed(self.frame.open):
                self.close(open_)
            if len(self.frames) == 1:
                break
            self.at = self.leave().back
        self.frame.open.clear()
        for _ in self.source:
            pass

    def _act(self, line: Line) -> None:
        if self.mistakes.found:
            raise FlowStop
        self.mistakes.place(*line)
        reader = HeadReader(line[1], self.mistakes.report, self.state.read)
        try:
            head = reader.head()
            act, least, most = self._acts[head.keyword]
            values = [] if head.keyword == "elseif" else reader.arguments(head, least, most)
        except MistakeError:
            raise FlowStop from None
        if self.mistakes.found:  # of a comment
            raise FlowStop
        act(head, line, values)
