# SPDX-License-Identifier: Apache-2.0
"""A debugging session: a program on a target, ticks, breakpoints and watches.

The debugger is the host here: it writes the inputs of a tick and starts the run. A stop is always
before a bundle, with everything before it done.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from asip_asm.debug_map import Value
from sim.core.backends import IDLE, Backend, Kind, Status
from sim.core.fault import fault_text
from sim.debug.asip_dbg.expressions import Expression, evaluate
from sim.debug.asip_dbg.locations import Location, find_location
from sim.debug.asip_dbg.points import Breakpoint, Hits, Message
from sim.debug.asip_dbg.program import DebuggedProgram
from sim.debug.asip_dbg.values import Reading, ValueMissing, Values, bits_of, format_word
from sim.debug.asip_run.inputs import parse_word

SLICE = 0.05
"""Seconds between two looks at a running core, and so at Ctrl-C and `pause`."""


class SessionError(Exception):
    """A command cannot be done now; the message says what to do first."""


@dataclass(frozen=True)
class Stop:
    """Why the session stopped: 'breakpoint', 'watch', 'step', 'start', 'interrupt', 'end' (of the
    last tick requested), 'fault'; and that in words. breakpoints: numbers of those hit.
    """

    kind: str
    text: str
    breakpoints: tuple[int, ...] = ()


@dataclass
class Session:
    """State of a session; `rows` are the inputs of the ticks by name, the last one stays."""

    program: DebuggedProgram
    target: Backend
    states: Mapping[str, int] = field(default_factory=dict)
    rows: Sequence[Mapping[str, int]] = ()

    def __post_init__(self) -> None:
        self.values = Values(self.program, self.target, lambda: self.position)
        self.breakpoints: dict[int, Breakpoint] = {}
        self.pause = threading.Event()
        self.last_stop: Stop | None = None
        self.log: Callable[[str], None] = lambda text: None  # takes the messages of log points
        self.tick = 0
        self._left = 0
        self._next_number = 1
        self._ran = False
        self.status = IDLE
        self.reset()

    # ------------------------------------------------------------------ where it is
    @property
    def position(self) -> int:
        """Bundle that issues next; after the last one when no run is on and one was."""
        if self.status.kind is Kind.IDLE:
            return self.program.bundles if self._ran else self.program.image.entry
        return self.status.position

    @property
    def in_run(self) -> bool:
        """Whether a run is halted inside."""
        return self.status.kind is Kind.HALTED

    # ------------------------------------------------------------------ ticks
    def reset(self) -> None:
        """Load the program again: states at their presets, no run on, tick 0."""
        self.target.load(self.program.image)
        if self.target.driven and (self.states or self.rows):
            raise SessionError("inputs and states are those of the machine's host; leave them out")
        places = {state.name: state.register for state in self.program.image.states}
        for name, word in self.states.items():
            self.target.write(places[name], word)
        self.status = IDLE
        self.tick, self._left, self._ran = 0, 0, False
        self._arm()

    def start(self) -> Stop:
        """Begin a tick and stop before its first bundle."""
        self._left = 1
        self._begin(hold=True)
        return self._wait("start")

    def run(self, ticks: int | None = None) -> Stop:
        """Run so many ticks, up to a stop; None: those of the input rows that are left, or one."""
        rest = self._left if self.in_run else len(self.rows) - self.tick
        self._left = ticks or max(rest, 1)
        return self._go_on()

    def resume(self) -> Stop:
        """Go on with the ticks requested."""
        if not self.in_run and self._left <= 0:
            raise SessionError("no tick is running; `run`, `start` or `tick N` begins one")
        return self._go_on()

    def finish(self) -> Stop:
        """Go on to the end of the tick."""
        if not self.in_run:
            raise SessionError("no tick is running; `start` begins one and stops in it")
        self._left = 1
        return self._go_on()

    def _go_on(self) -> Stop:
        """Let the tick that is on go, or begin the next one, up to a stop."""
        if self.in_run:
            self.target.resume()
        else:
            self._begin(hold=False)
        return self._wait("run")

    def step_bundles(self, count: int = 1) -> Stop:
        """Issue bundles one by one; stops at breakpoints on the way."""
        return self._step_until(count, lambda before, now: True)

    def step_lines(self, count: int = 1) -> Stop:
        """Go on to the next bundle whose operation is in another source line."""
        return self._step_until(count, lambda before, now: self._line(before) != self._line(now))

    def step_calls(self, count: int = 1) -> Stop:
        """As `step_lines`, with the operations of a macro call as one line."""
        return self._step_until(count, lambda before, now: self._call(before) != self._call(now))

    def _step_until(self, count: int, new_place: Callable[[int, int], bool]) -> Stop:
        if not self.in_run:
            return self.start()
        for _ in range(count):
            before = self.position
            while True:
                self.target.step()
                stop = self._wait("step")
                if stop.kind != "step":
                    return stop
                if new_place(before, self.position):
                    break
        return stop

    def _line(self, bundle: int) -> tuple[str, int] | None:
        entry = self.program.primary(bundle)
        return (entry.file, entry.line) if entry else None

    def _call(self, bundle: int) -> object:
        entry = self.program.primary(bundle)
        calls = self.program.calls(bundle, entry.slot) if entry else []
        return calls[-1] if calls else self._line(bundle)

    def _begin(self, hold: bool) -> None:
        if self.status.kind is Kind.FAULT:
            self.target.clear()
        if self.rows:
            self.values.inputs.update(self.rows[min(self.tick, len(self.rows) - 1)])
        self._arm()
        self._look_at_data()
        self.target.begin(self.values.inputs, hold)
        self._ran = True

    # ------------------------------------------------------------------ stops
    def _wait(self, how: str) -> Stop:
        """Let the core go until there is a reason to stop."""
        asked = False
        while True:
            try:
                self.status = self.target.poll(SLICE)
                if self.pause.is_set() and not asked:
                    asked = True
                    self.target.halt()
                    continue
                stop = self._stop(how, asked)
            except KeyboardInterrupt:
                asked = True
                self.target.halt()
                continue
            if stop is not None:
                self.pause.clear()
                self.last_stop = stop
                return stop

    def _stop(self, how: str, asked: bool) -> Stop | None:
        """Why the core is halted; None when it goes on."""
        status = self.status
        if status.kind is Kind.RUNNING:
            return None
        if status.kind is Kind.FAULT:
            self._left = 0
            assert status.fault is not None
            inputs = {} if self.target.driven else self.values.inputs
            return Stop("fault", fault_text(self.program.image, status.fault, inputs))
        if status.kind is Kind.IDLE:
            return self._tick_ended(asked)
        hits = self._hits(status)
        if hits:
            return self._stopped_by(hits)
        if asked:
            return Stop("interrupt", f"halted at bundle {self.position}")
        if how in ("step", "start"):
            return Stop(how, f"bundle {self.position}")
        self.target.resume()
        return None

    def _tick_ended(self, asked: bool) -> Stop | None:
        self.tick += 1
        self._left -= 1
        if hits := self._hits(self.status):  # the last bundle may store
            return self._stopped_by(hits, f", end of tick {self.tick - 1}")
        if self._left > 0 and not asked:
            self._begin(hold=False)
            return None
        return Stop("end", f"end of tick {self.tick - 1}")

    def _hits(self, status: Status) -> list[tuple[Breakpoint, str]]:
        """Breakpoints and watches that stop here, with what is to be said of their conditions."""
        found = []
        for point in list(self.breakpoints.values()):
            here = status.kind is Kind.IDLE or self.position in point.location.bundles
            change = ""
            if point.in_data:
                change = self._changed(point) if point.enabled and here else ""
                here = bool(change)
            elif status.kind is Kind.IDLE:
                here = False
            elif point.place and status.reason == "watch":
                here = self._watched()[status.which] is point and self._holds(point)
            if not (point.enabled and here):
                continue
            acts, why = point.passed(self._number)
            why = change + why
            if acts and point.message is not None:
                self.log(point.message.filled(self._number) + why)
            elif acts:
                found.append((point, why))
                if point.temporary:
                    del self.breakpoints[point.number]
        if any(point.temporary for point, _ in found):
            self._arm()
        return found

    def _stopped_by(self, hits: list[tuple[Breakpoint, str]], when: str = "") -> Stop:
        text = "; ".join(f"{b.kind} {b.number}, {b.location.text}{why}" for b, why in hits)
        return Stop(hits[0][0].kind, text + when, tuple(point.number for point, _ in hits))

    def _holds(self, point: Breakpoint) -> bool:
        """Whether the write was one of the watched value: registers are shared."""
        value = self.program.finder.holder(point.place, self.position)
        return not point.watch or value is None or value.name == point.watch

    def _number(self, name: str) -> float | int:
        return self.values.read(name).number

    def evaluate(self, text: str) -> float | int | bool:
        """Value of an expression. Raises ExpressionError, ValueMissing, LinkError."""
        return evaluate(text, self._number)

    def set(self, name: str, text: str) -> Reading:
        """Give a name another value: bits as `bits_of` reads them, or an expression. Raises
        ValueError, LinkError.
        """
        word = bits_of(text)
        if word is None and text[:2].lower() == "0f":
            word = parse_word(text, "float")
        number = 0.0 if word is not None else self.evaluate(text)
        reading = self.values.set(name, word, number)
        self._look_at_data()
        return reading

    # ------------------------------------------------------------------ breakpoints
    def location(self, text: str) -> Location:
        """Raises LocationError."""
        return find_location(self.program, text, self.position)

    def add_breakpoint(
        self,
        place: Location,
        condition: str = "",
        temporary: bool = False,
        hits: str = "",
        message: str = "",
    ) -> Breakpoint:
        """Raises SessionError, ExpressionError, ValueMissing."""
        parsed, text = self._parsed(condition), Message.parse(message)
        point = Breakpoint(place, parsed, temporary, counted=Hits.parse(hits), message=text)
        for piece in point.message.pieces if point.message else ():
            self._check(piece)
        return self._add(point)

    def _parsed(self, condition: str) -> Expression | None:
        """A condition whose names all exist. Raises ExpressionError, ValueMissing."""
        return self._check(Expression(condition)) if condition.strip() else None

    def _check(self, expression: Expression) -> Expression:
        for name in expression.names:
            self.values.check(name)
        return expression

    def add_watch(self, name: str, condition: str = "", hits: str = "") -> Breakpoint:
        """Watch of a value, register, output or word of a table. Raises as `add_breakpoint`."""
        values = self.program.map.named(name)
        address = None if values else self.values.data_address(name)
        if address is not None:
            return self._add_data_watch(name, address, condition, hits)
        places = list(dict.fromkeys(value.place for value in values if value.writes))
        if not places:
            try:
                places = [self.values.read(name).place]
            except ValueMissing:
                if not values:
                    raise
        if any("." in place for place in places):
            raise SessionError(
                f"{name} is a lane; watch the vector, all of whose lanes are written"
            )
        places = [place for place in places if place[0] in "abco"]
        if len(places) != 1:
            why = (
                f"is in {', '.join(places)}; watch one of its definitions"
                if places
                else ("is never written by the program")
            )
            known = ", ".join(f"{name}@{v.version}" for v in values if v.writes)
            raise SessionError(f"{name} {why}" + (f": {known}" if places and known else ""))
        base = values[0].name if values else ""
        location = Location((), f"{name} in {places[0]}")
        parsed, counted = self._parsed(condition), Hits.parse(hits)
        point = Breakpoint(location, parsed, watch=base, place=places[0], counted=counted)
        return self._add(point)

    def _add_data_watch(self, name: str, address: int, condition: str, hits: str) -> Breakpoint:
        stores = self.program.stores(address)
        if not stores:
            raise SessionError(f"{name} is never written by the program")
        follow = self.program.map.following
        bundles = sorted({i for store in stores for i in follow(store)} - {self.program.bundles})
        location = Location(tuple(bundles), f"{name} in d{address}")
        parsed, counted = self._parsed(condition), Hits.parse(hits)
        point = Breakpoint(location, parsed, place=f"d{address}", counted=counted)
        point.word = self.target.read(point.place)
        return self._add(point)

    def _changed(self, point: Breakpoint) -> str:
        """Old and new value of a watched data word, which is noted; empty if they are equal."""
        before, point.word = point.word, self.target.read(point.place)
        if before == point.word:
            return ""
        return f": {format_word(before, 'float')} -> {format_word(point.word, 'float')}"

    def _look_at_data(self) -> None:
        """Take watched data words as they are: what changed them was no store of the program."""
        for point in self.breakpoints.values():
            if point.in_data:
                point.word = self.target.read(point.place)

    def _add(self, point: Breakpoint) -> Breakpoint:
        point.number = self._next_number
        self.breakpoints[point.number] = point
        try:
            self._arm()
        except SessionError:
            del self.breakpoints[point.number]
            raise
        self._next_number += 1
        return point

    def remove_breakpoint(self, number: int) -> None:
        """Raises SessionError."""
        self._numbered(number)
        del self.breakpoints[number]
        self._arm()

    def enable(self, number: int, on: bool) -> None:
        """Raises SessionError."""
        point = self._numbered(number)
        before, point.enabled = point.enabled, on
        try:
            self._arm()
        except SessionError:
            point.enabled = before
            raise

    def ignore(self, number: int, count: int) -> None:
        """Let the next `count` hits of a breakpoint do nothing. Raises SessionError."""
        self._numbered(number).ignored = count

    def choose_hits(self, number: int, text: str) -> None:
        """Let only some hits of a breakpoint count. Raises SessionError, ExpressionError."""
        self._numbered(number).counted = Hits.parse(text)

    def commands_of(self, number: int | None) -> list[str]:
        """Commands of a breakpoint (None: the last one), emptied. Raises SessionError."""
        point = self._numbered(max(self.breakpoints, default=0) if number is None else number)
        point.commands.clear()
        return point.commands

    def until(self, place: Location | None = None) -> Stop:
        """Go on to a place, or to a later line than this one, but not beyond the end of the tick.

        Raises SessionError.
        """
        if not self.in_run:
            raise SessionError("no tick is running; `start` begins one and stops in it")
        if place is None:
            first = self.position
            return self._step_until(
                1, lambda before, now: now > first and self._line(first) != self._line(now)
            )
        point = self.add_breakpoint(place, temporary=True)
        self._left = 1
        stop = self._go_on()
        if self.breakpoints.pop(point.number, None) is not None:
            self._arm()
        return stop

    def _numbered(self, number: int) -> Breakpoint:
        if number not in self.breakpoints:
            raise SessionError(f"there is no breakpoint {number}; info breakpoints lists them")
        return self.breakpoints[number]

    def _watched(self) -> list[Breakpoint]:
        return [p for p in self.breakpoints.values() if p.place and p.enabled and not p.in_data]

    def _arm(self) -> None:
        """Give breakpoints and watches to the target. Raises SessionError, with those that it has
        unchanged, if they are too many.
        """
        points = [p for p in self.breakpoints.values() if p.enabled]
        bundles = sorted({b for p in points for b in p.location.bundles})
        watched = self._watched()
        limit, watches = self.target.breakpoints, self.target.watches
        if len(bundles) > limit:
            raise SessionError(
                f"that needs {len(bundles)} breakpoints, the {self.target.label} has {limit}; "
                "delete some, or name one bundle: break *N"
            )
        if len(watched) > watches:
            raise SessionError(f"the {self.target.label} has {watches} watches; delete one")
        self.target.arm(bundles, [point.place for point in watched])

    # ------------------------------------------------------------------ after a fault
    def not_finite(self) -> list[tuple[Value, int]]:
        """Values still in their registers that are NaN or infinite, with their bits, in the order
        of computation.
        """
        found = []
        for value in self.program.map.values:
            where = self.program.finder.where(value, self.position)
            if where.place[:1] in ("a", "b", "c") and not where.text and value.type == "float":
                word = self.target.read(where.place)
                if word >> 23 & 0xFF == 0xFF:
                    found.append((value, word))
        return sorted(found, key=lambda item: item[0].first)

    def abandon(self) -> None:
        """Give up the run that is on."""
        self.target.abort()
        self.status = self.target.poll(1.0)
        if self.status.kind is Kind.FAULT:
            self.target.clear()
            self.status = IDLE
        self._left = 0

    def reconnect(self) -> None:
        """Find a target that is gone again, and give it program and breakpoints. Raises
        LinkError.
        """
        self.target.reconnect()
        self.reset()
