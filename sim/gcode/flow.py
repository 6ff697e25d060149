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

from collections.abc import Iterator

from sim.gcode.branches import Branches
from sim.gcode.errors import MistakeError, Mistakes
from sim.gcode.execution import Execution, FlowStop, Line
from sim.gcode.oword import ARGUMENTS, O_LINE, HeadReader
from sim.gcode.state import State
from sim.gcode.subroutines import Subroutines

VALUES = {
    "call": (0, ARGUMENTS),
    "return": (0, 1),
    "endsub": (0, 1),
    "if": (1, 1),
    "while": (1, 1),
    "repeat": (1, 1),
}
"""Least and greatest number of values behind an O word; others take none."""


class Flow(Execution):
    """Runs the O words of a program and yields its other lines in the order in which they act.

    mistakes is told the line under work before parameters are read.
    """

    def __init__(self, source: Iterator[Line], mistakes: Mistakes, state: State) -> None:
        super().__init__(source, mistakes, state)
        self._acts = Branches(self).acts | Subroutines(self).acts

    def lines(self) -> Iterator[Line]:
        """Lines without O words, in the order in which they run. Raises FlowStop."""
        while (line := self.next()) is not None:
            if O_LINE.match(line[1]):
                self._act(line)
            else:
                yield line
        self.check_closed()

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
            least, most = VALUES.get(head.keyword, (0, 0))
            if head.keyword == "elseif":  # its value counts only if no branch has run
                values = []
            else:
                values = reader.arguments(head, least, most)
        except MistakeError:
            raise FlowStop from None
        if self.mistakes.found:  # of a comment
            raise FlowStop
        self._acts[head.keyword](head, line, values)
