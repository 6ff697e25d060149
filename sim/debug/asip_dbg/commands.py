# SPDX-License-Identifier: Apache-2.0
"""Commands of asip-dbg: GDB's names and habits, any unambiguous beginning of a name."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from asip_asm.diagnostics import closest, shortened
from asip_asm.files import read_text
from sim.debug.asip_dbg.command_table import (
    COMMANDS,
    TOPICS,
    AssertionMissed,
    CommandError,
    Quit,
    command,
    condition_of,
    count_of,
    find_command,
    form_of,
    nothing_in,
    numbers_of,
)
from sim.debug.asip_dbg.expressions import ExpressionError, is_name
from sim.debug.asip_dbg.locations import LocationError
from sim.debug.asip_dbg.session import Session, SessionError, Stop
from sim.debug.asip_dbg.show import Show
from sim.debug.asip_dbg.values import Reading, ValueMissing, format_word, text_of
from sim.debug.asip_run.inputs import UserError, read_inputs
from sim.rtl.asip_bus import AsipError, LinkError

SCRIPT_BYTES = 1 << 20
SCRIPT_DEPTH = 16
EXAMINED = 1024
"""Most words of one `x`."""
_FORM = re.compile(r"/([0-9]{0,4})([fxdut]?)")
REFUSALS = (SessionError, LocationError, ValueMissing, ExpressionError, UserError, AsipError)
"""Errors of a session whose text is for the user."""


class Commands:
    """Carries out commands on a session; `write` gets the text of the answers."""

    def __init__(self, session: Session, write: Callable[[str], None], color: bool = False) -> None:
        self.session = session
        self.write = write
        self.show = Show(session, write, color)
        self.displays: dict[int, tuple[str, str]] = {}
        self._next_display = 1
        self._again = ""
        self._depth = 0
        self._given_to: list[str] | None = None  # the commands of a breakpoint, while they are read
        self._pending: list[str] = []  # commands of the breakpoints at which the core has stopped

    def execute(self, line: str) -> None:
        """One line; empty repeats the last command if that makes sense. Raises CommandError, Quit,
        LinkError.
        """
        self._pending = []
        self._execute(line)
        while self._pending:
            self._execute(self._pending.pop(0))

    def _execute(self, line: str) -> None:
        line = line.strip()
        if line.startswith("#"):
            return
        if self._given_to is not None:
            if line == "end":
                self._given_to = None
            elif line:
                self._given_to.append(line)
            return
        line = line or self._again
        if not line:
            return
        # GDB's habit: `x/8f`, `print/x` need no blank.
        match = re.match(r"([A-Za-z_-]+)(.*)", line, re.DOTALL)
        if match is None:
            raise CommandError(f"'{shortened(line)}' is no command; help lists them")
        entry = find_command(match.group(1))
        self._again = line if entry.repeats else ""
        try:
            rest = match.group(2).strip()
            if entry.usage == entry.names[0]:
                nothing_in(rest, entry.usage)
            entry.function(self, rest)
        except LinkError:
            raise
        except REFUSALS as error:
            raise CommandError(str(error)) from None

    # ------------------------------------------------------------------ running
    def _stopped(self, stop: Stop) -> None:
        self.show.stop(stop)
        for number, (expression, form) in self.displays.items():
            try:
                text = self._printed(expression, form)
            except (ValueMissing, ExpressionError) as error:
                text = str(error)
            self.write(f"{number}: {text}")
        points = (self.session.breakpoints.get(number) for number in stop.breakpoints)
        self._pending = [line for point in points if point for line in point.commands]

    @command("run", "r", runs=True)
    def run(self, rest: str) -> None:
        """Run ticks up to a stop: one for each row of inputs, or one. Inside a tick: go on."""
        self._stopped(self.session.run())

    @command("start", runs=True)
    def start(self, rest: str) -> None:
        """Begin a tick and stop before its first bundle."""
        if self.session.in_run:
            self.session.abandon()
            self.write("the tick that was on is given up")
        self._stopped(self.session.start())

    @command("tick", usage="[N]", repeats=True, runs=True)
    def tick(self, rest: str) -> None:
        """Run N ticks (1) to their ends, with stops at breakpoints. Inside a tick, its rest is the
        first.
        """
        self._stopped(self.session.run(count_of(rest)))

    @command("continue", "c", "cont", repeats=True, runs=True)
    def resume(self, rest: str) -> None:
        """Go on to the next stop, or to the end of the ticks that run or tick requested."""
        self._stopped(self.session.resume())

    @command("step", "s", usage="[N]", repeats=True, runs=True)
    def step(self, rest: str) -> None:
        """Go on to the next bundle whose operation is in another line, N times. A bundle with
        several operations goes by that of its lowest slot. Without a tick it begins one.
        """
        self._stopped(self.session.step_lines(count_of(rest)))

    @command("next", "n", usage="[N]", repeats=True, runs=True)
    def next(self, rest: str) -> None:
        """As step, but the operations of a macro call count as one line."""
        self._stopped(self.session.step_calls(count_of(rest)))

    @command("stepi", "si", "nexti", "ni", usage="[N]", repeats=True, runs=True)
    def stepi(self, rest: str) -> None:
        """Issue N bundles (1)."""
        self._stopped(self.session.step_bundles(count_of(rest)))

    @command("finish", "fin", runs=True)
    def finish(self, rest: str) -> None:
        """Go on to the end of the tick."""
        self._stopped(self.session.finish())

    @command("until", "advance", usage="[PLACE]", runs=True)
    def until(self, rest: str) -> None:
        """Go on to a place, or without one to a later line, as out of a loop. The end of the tick
        stops too.
        """
        place = self.session.location(rest) if rest else None
        self._stopped(self.session.until(place))

    @command("kill", "k")
    def kill(self, rest: str) -> None:
        """Give up the tick that is on."""
        self.session.abandon()

    @command("reset")
    def reset(self, rest: str) -> None:
        """Load the program again: states at their first values, tick 0."""
        self.session.reset()
        self.write("program loaded, tick 0")

    @command("reconnect")
    def reconnect(self, rest: str) -> None:
        """Look for a target that did not answer, and load the program again."""
        self.session.reconnect()
        self.write(f"connected: {self.session.target.label}; program loaded, tick 0")

    # ------------------------------------------------------------------ breakpoints
    @command("break", "b", usage="[PLACE] [if EXPRESSION]")
    def set_break(self, rest: str) -> None:
        """Stop before a place: LINE, FILE:LINE, (28) for equation 28, *7 for bundle 7, a label, the
        name of a value for where it is computed. Nothing: here.
        """
        self._break(rest, temporary=False)

    @command("tbreak", "tb", usage="[PLACE] [if EXPRESSION]")
    def set_temporary(self, rest: str) -> None:
        """As break, for one stop."""
        self._break(rest, temporary=True)

    def _break(self, rest: str, temporary: bool) -> None:
        text, condition = condition_of(rest)
        location = self.session.location(text)
        point = self.session.add_breakpoint(location, condition, temporary)
        self.write(f"breakpoint {point.number}: {location.text}")

    @command("watch", "wa", usage="NAME [if EXPRESSION]")
    def watch(self, rest: str) -> None:
        """Stop after each write of a value, register or output, or when a store changes a word of
        a table: watch table[3]. The core stops a few bundles later, when the write is done.
        """
        name, condition = condition_of(rest)
        if not name:
            raise CommandError("watch what? watch NAME")
        point = self.session.add_watch(name, condition)
        self.write(f"watch {point.number}: {point.location.text}")

    @command("ignore", usage="NUMBER COUNT")
    def ignore(self, rest: str) -> None:
        """Let the next COUNT hits of a breakpoint or watch do nothing."""
        words = rest.split()
        if len(words) != 2:
            raise CommandError("ignore NUMBER COUNT")
        number, count = (count_of(word, least=0) for word in words)
        self.session.ignore(number, count)
        self.write(f"the next {count} hits of {number} do nothing")

    @command("hits", usage="NUMBER [CONDITION]")
    def hits(self, rest: str) -> None:
        """Choose the hits of a breakpoint that count: 5 the fifth, >= 5 from it on, % 5 every
        fifth. Without a condition all do.
        """
        number, _, text = rest.partition(" ")
        self.session.choose_hits(count_of(number, least=0), text)

    @command("commands", usage="[NUMBER]")
    def commands(self, rest: str) -> None:
        """Give a breakpoint, or the last one, commands that follow each stop at it: one a line, up
        to `end`. One that lets the core go is the last.
        """
        self._given_to = self.session.commands_of(count_of(rest, least=0) if rest else None)

    @command("dprintf", usage='PLACE, "TEXT" [if EXPRESSION]')
    def log_point(self, rest: str) -> None:
        """Write a text at each pass of a place, and do not stop. {EXPRESSION} in the text becomes
        its value: dprintf 17, "e is {e}".
        """
        match = re.fullmatch(r'(.+?)\s*,\s*"(.*)"(?:\s+if\s+(.*))?', rest)
        if match is None:
            raise CommandError('dprintf PLACE, "TEXT" [if EXPRESSION]')
        location = self.session.location(match[1])
        point = self.session.add_breakpoint(location, match[3] or "", message=match[2])
        self.write(f"log point {point.number}: {location.text}")

    @command("delete", "d", usage="[NUMBER ...]")
    def delete(self, rest: str) -> None:
        """Delete breakpoints and watches, all without a number."""
        for number in numbers_of(rest) or list(self.session.breakpoints):
            self.session.remove_breakpoint(number)

    @command("enable", usage="NUMBER ...")
    def enable(self, rest: str) -> None:
        """Switch breakpoints on."""
        self._switch(rest, True)

    @command("disable", usage="NUMBER ...")
    def disable(self, rest: str) -> None:
        """Switch breakpoints off, and keep them."""
        self._switch(rest, False)

    def _switch(self, rest: str, on: bool) -> None:
        for number in numbers_of(rest) or list(self.session.breakpoints):
            self.session.enable(number, on)

    # ------------------------------------------------------------------ values
    @command("print", "p", "inspect", usage="[/FORM] EXPRESSION")
    def print(self, rest: str) -> None:
        """Value of a name or expression. /x hexadecimal, /d int, /u unsigned, /t bits, /f float.

        A name is one of the source (`e1`; `e1@2` is its second definition), a register (`a3`,
        `$a3`), a word of bank K (`k7`), an output (`F1`, `o0`), of data memory or of a stream
        (`table[3]`), or a lane of a vector (`v[2]`; the core shows lane 0, --iss all).
        Expressions are computed in double precision: + - * / ( ), comparisons, and, or, not, abs,
        sqrt, sin, cos, min, max, isnan, isfinite.
        """
        form, text = form_of(rest)
        if not text:
            raise CommandError("print what? print NAME, or an expression of names")
        self.write(self._printed(text, form))

    def _printed(self, text: str, form: str) -> str:
        if text in self.session.values.names() or is_name(text):
            return f"{text} = {_described(self.session.values.read(text), form)}"
        value = self.session.evaluate(text)
        if isinstance(value, bool):
            return f"{text} = {'true' if value else 'false'}"
        if form:
            kind = "int" if isinstance(value, int) else "float"
            return (
                f"{text} = {format_word(self.session.values.word(text, kind, value), kind, form)}"
            )
        return f"{text} = {value:.9g}" if isinstance(value, float) else f"{text} = {value}"

    @command("display", usage="[/FORM] [EXPRESSION]")
    def display(self, rest: str) -> None:
        """Print an expression at every stop; without one, print all that are displayed."""
        form, text = form_of(rest)
        if text:
            line = self._printed(text, form) if self.session.in_run else text
            number, self._next_display = self._next_display, self._next_display + 1
            self.displays[number] = (text, form)
            self.write(f"{number}: {line}")
            return
        for number, (expression, shape) in self.displays.items():
            self.write(f"{number}: {self._printed(expression, shape)}")

    @command("undisplay", usage="[NUMBER ...]")
    def undisplay(self, rest: str) -> None:
        """Print an expression at stops no longer; all without a number."""
        for number in numbers_of(rest) or list(self.displays):
            if self.displays.pop(number, None) is None:
                raise CommandError(f"there is no display {number}")

    @command("set", usage="NAME = VALUE")
    def set(self, rest: str) -> None:
        """Give a value: to an input for the next ticks, to a state, register or value here. VALUE
        is an expression, or bits as print/x and print/t show them: 0x3f800000 with all 8 digits.
        """
        name, equals, text = rest.removeprefix("var ").partition("=")
        name, text = name.strip(), text.strip()
        if not equals or not name or not text:
            raise CommandError("set NAME = VALUE")
        try:
            reading = self.session.set(name, text)
        except ValueError as error:
            raise CommandError(str(error)) from None
        self.write(f"{name} = {_described(reading, '')}")

    @command("inputs", usage="FILE")
    def inputs(self, rest: str) -> None:
        """Take the inputs of the ticks from a CSV file with a row for each tick."""
        if not rest:
            raise CommandError("inputs FILE")
        types = {entry.name: entry.type for entry in self.session.program.image.inputs}
        self.session.rows = read_inputs(Path(rest), types)
        self.write(f"{len(self.session.rows)} rows of inputs")

    @command("x", usage="[/COUNT FORM] NAME or ADDRESS", repeats=True)
    def examine(self, rest: str) -> None:
        """Words of data memory or of a stream: x/8f table, x/4x 16. Forms as in print."""
        match = _FORM.match(rest)
        count = int(match.group(1) or 1) if match else 1
        form = (match.group(2) if match else "") or "f"
        text = rest[match.end() :].strip() if match else rest
        names = self.session.program.image.data_names
        if not text or not 1 <= count <= EXAMINED:
            raise CommandError(f"x/COUNT FORM NAME: 1 to {EXAMINED} words, as x/8f table")
        if text in (block.name for block in self.session.program.image.streams):
            self.show.stream_words(text, count, form)
            return
        if text in names:
            start = names[text]
        elif re.fullmatch(r"0[xX][0-9a-fA-F]{1,4}|[0-9]{1,4}", text):
            start = int(text, 0)
        else:
            known = f"it has {', '.join(names)}" if names else "it has none; give an address"
            raise CommandError(
                f"no table '{shortened(text)}' in data memory; " + (closest(text, names) or known)
            )
        self.show.data(start, count, form)

    @command("assert", usage="EXPRESSION")
    def check(self, rest: str) -> None:
        """For scripts: fail with exit status 3 unless the expression is true."""
        if not self.session.evaluate(rest):
            raise AssertionMissed(f"assert {rest}: false")

    # ------------------------------------------------------------------ looking
    @command("info", "i", usage="TOPIC")
    def info(self, rest: str) -> None:
        """What there is of a topic: registers [NAME ...], state, faults, breakpoints, inputs,
        values [PART], outputs, streams, display, line N, target.
        """
        topic, _, detail = rest.partition(" ")
        found = [name for name in TOPICS if topic and name.startswith(topic)]
        found = ["state"] if topic == "s" else found
        if len(found) != 1:
            raise CommandError(f"info {', '.join(TOPICS)}")
        if found[0] == "display":
            for number, (expression, form) in self.displays.items():
                self.write(f"{number}: {f'/{form} ' if form else ''}{expression}")
            return
        getattr(self.show, found[0])(detail.strip())

    @command("list", "l", usage="[PLACE]", repeats=True)
    def list(self, rest: str) -> None:
        """Source around a place, or where the program is; again, the lines that follow."""
        self.show.list(rest)

    @command("disassemble", "disas", usage="[FIRST] [LAST]")
    def disassemble(self, rest: str) -> None:
        """Bundles with their operations and source lines: around where the program is, or from
        FIRST to LAST.
        """
        bounds = numbers_of(rest)
        if len(bounds) > 2:
            raise CommandError("disassemble FIRST LAST")
        self.show.disassemble(bounds)

    @command("backtrace", "bt", "where")
    def backtrace(self, rest: str) -> None:
        """Where the program is, and the macro calls around that."""
        self.show.backtrace()

    # ------------------------------------------------------------------ the debugger itself
    @command("source", usage="SCRIPT")
    def source(self, rest: str) -> None:
        """Commands of a file, one a line, `#` begins a comment. The first error ends it."""
        if not rest:
            raise CommandError("source SCRIPT")
        if self._depth >= SCRIPT_DEPTH:
            raise CommandError(f"{rest}: scripts call one another more than {SCRIPT_DEPTH} deep")
        try:
            text = read_text(Path(rest), SCRIPT_BYTES, "a script")
        except OSError as error:
            raise CommandError(f"{rest}: {error.strerror or error}") from None
        self._depth += 1
        try:
            for number, line in enumerate(text.splitlines(), 1):
                if not line.strip():
                    continue
                try:
                    self.execute(line)
                except CommandError as error:
                    raise type(error)(f"{rest}:{number}: {error}") from None
        finally:
            self._depth -= 1

    @command("echo", usage="TEXT")
    def echo(self, rest: str) -> None:
        """Write a text, for scripts."""
        self.write(rest)

    @command("help", "h", usage="[COMMAND]")
    def help(self, rest: str) -> None:
        """What there is, or what a command does."""
        if rest:
            entry = find_command(rest.split()[0])
            also = f"\nalso: {', '.join(entry.names[1:])}" if entry.names[1:] else ""
            self.write(f"{entry.usage}\n{entry.doc}{also}")
            return
        for entry in dict.fromkeys(COMMANDS.values()):
            first = re.split(r"(?<=[.:])\s", entry.doc.replace("\n", " "), maxsplit=1)[0]
            self.write(f"{entry.usage:<34}{first.rstrip(':.')}")
        self.write("Any unambiguous beginning of a name will do; an empty line repeats a step.")

    @command("quit", "q", "exit", usage="[STATUS]")
    def quit(self, rest: str) -> None:
        """End the session."""
        raise Quit(count_of(rest, least=0, most=255) if rest else 0)


def _described(reading: Reading, form: str) -> str:
    if form:
        return text_of(reading, form)
    bits = "vector" if reading.lanes else f"0x{reading.word:08x}"
    note = f", {reading.note}" if reading.note else ""
    return f"{text_of(reading)}  ({bits}, {reading.place}{note})"
