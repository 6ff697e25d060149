# SPDX-License-Identifier: Apache-2.0
"""What asip-dbg shows: stops, sources, bundles, registers, values, faults."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Sequence

from asip_asm.debug_map import Value
from asip_asm.image import SourceEntry
from asip_asm.isa import default_isa
from sim.core.backends import Kind
from sim.core.fault import fault_text
from sim.debug.asip_dbg.locations import LocationError
from sim.debug.asip_dbg.points import Breakpoint
from sim.debug.asip_dbg.session import Session, Stop
from sim.debug.asip_dbg.values import ValueMissing, format_word
from sim.rtl.asip_bus import LinkError

LINES = 10
"""Source lines that `list` shows."""
AROUND = 3
"""Bundles that `disassemble` shows on each side."""
WIDE = 1000
"""Columns of a table: no cell is cut."""
NOT_FINITE = 8
"""Values that are not finite of which `info faults` reports."""


class Show:
    """Writes views of a session through `write`; `color` marks where the program is."""

    def __init__(self, session: Session, write: Callable[[str], None], color: bool) -> None:
        self.session = session
        self.write = write
        self.color = color
        self._listed: tuple[str, int] | None = None

    # ------------------------------------------------------------------ stops
    def stop(self, stop: Stop) -> None:
        """Why the program stopped, and what comes next."""
        self._listed = None
        if stop.kind == "fault":
            self.faults("", stop.text)
            return
        if stop.kind == "end":
            self.write(f"{stop.text}{self._counters()}")
            self.outputs("")
            return
        if stop.kind != "step":
            self.write(stop.text)
        self.here()

    def here(self) -> None:
        """The bundle that issues next, with its operations."""
        program, bundle = self.session.program, self.session.position
        cycle = program.cycle(bundle)
        when = f", cycle {cycle}" if cycle is not None else ""
        self.write(self._bold(f"=> bundle {bundle}{when}"))
        for entry in program.entries(bundle):
            self.write(f"     {_operation(entry)}")

    def _counters(self) -> str:
        name, count = self.session.target.count()
        return f", {count} {name.lower()}"

    def _bold(self, text: str) -> str:
        return f"\033[1m{text}\033[0m" if self.color else text

    def _table(self, head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        from rich.console import Console  # takes a while, and not every session shows a table
        from rich.table import Table

        table = Table(box=None, pad_edge=False, header_style="bold")
        for title in head:
            table.add_column(title, no_wrap=True)
        for row in rows:
            table.add_row(*row)
        console = Console(
            file=io.StringIO(), width=WIDE, markup=False, force_terminal=self.color, no_color=True
        )
        with console.capture() as text:
            console.print(table, end="")
        for line in text.get().splitlines():
            self.write(line.rstrip())

    # ------------------------------------------------------------------ sources
    def list(self, rest: str) -> None:
        """Lines around a place."""
        program = self.session.program
        if self._listed and not rest:
            file, first = self._listed
        else:
            if rest:
                place = self.session.location(rest)
                entry = place if place.file else program.primary(place.bundles[0])
            else:
                entry = program.primary(min(self.session.position, program.bundles - 1))
            file, line = (entry.file, entry.line) if entry else (program.main, 1)
            first = line - LINES // 2
        lines = program.lines(file)
        if not lines:
            raise LocationError(f"{file}: cannot be read; the program was made from it")
        first = max(first, 1)
        if first > len(lines):
            raise LocationError(f"{file} has {len(lines)} lines; that was its end")
        here = program.entries(self.session.position) if self.session.in_run else []
        current = {entry.line for entry in here if entry.file == file}
        for number in range(first, min(first + LINES, len(lines) + 1)):
            mark = "=>" if number in current else "  "
            text = f"{mark} {number:5d}  {lines[number - 1]}".rstrip()
            self.write(self._bold(text) if number in current else text)
        self._listed = (file, first + LINES)

    def disassemble(self, bounds: Sequence[int]) -> None:
        """Bundles from the first to the last address, or around the position."""
        program, position = self.session.program, self.session.position
        if bounds:
            first, last = bounds[0], bounds[-1] if len(bounds) > 1 else bounds[0] + 2 * AROUND
        else:
            first, last = position - AROUND, position + AROUND
        if first > last:
            raise LocationError(f"disassemble FIRST LAST: {first} is after {last}")
        last = min(last, program.bundles - 1)
        if first > last:
            raise LocationError(f"there is no bundle {first}; they go to {program.bundles - 1}")
        labels: dict[int, list[str]] = {}
        for name, address in program.image.labels.items():
            labels.setdefault(address, []).append(name)
        for bundle in range(max(first, 0), last + 1):
            for label in labels.get(bundle, ()):
                self.write(f"{label}:")
            mark = "=>" if bundle == position else "  "
            text = f"{mark} {bundle:4d}  {program.text(bundle)}"
            self.write(self._bold(text) if bundle == position else text)
            for entry in program.entries(bundle):
                self.write(f"            {_operation(entry)}")

    def backtrace(self) -> None:
        """The place and the macro calls around it."""
        program, bundle = self.session.program, self.session.position
        entry = program.primary(bundle)
        if entry is None:
            self.write(f"bundle {bundle}, no source line")
            return
        self.write(f"#0  bundle {bundle}, {entry.file}:{entry.line}  {entry.text}")
        for depth, call in enumerate(program.calls(bundle, entry.slot), 1):
            self.write(f"#{depth}  macro {call.name}, called at {call.file}:{call.line}")

    def line(self, rest: str) -> None:
        """Bundles of a place, and where their results are."""
        program = self.session.program
        place = self.session.location(rest)
        self.write(place.text)
        for bundle in place.bundles:
            for entry in program.entries(bundle):
                self.write(f"  bundle {bundle}  {_operation(entry)}")
                for value in program.map.values:
                    for write in value.writes:
                        if (write.bundle, write.slot) == (bundle, entry.slot):
                            self.write(f"    {self._life(value, bundle, write.lands)}")

    def _life(self, value: Value, bundle: int, lands: int) -> str:
        """Where a value of a bundle is how long; at full speed it is in flight at first."""
        spans = [last for first, last in value.held if first <= bundle + 1 <= last]
        end = self.session.program.bundles
        if spans:
            until = "the end" if spans[0] >= end else f"bundle {spans[0]}"
            text = f"{value.name}: in {value.place} up to {until}"
        else:
            text = f"{value.name}: in {value.place}, how long depends on branches"
        if lands > bundle + 1:
            text += f"; without a halt in flight up to bundle {min(lands, end) - 1}"
        return text

    # ------------------------------------------------------------------ state
    def state(self, rest: str) -> None:
        """What the core does, and the states of the program."""
        session = self.session
        status = session.status
        where = f" before bundle {session.position}" if session.in_run else ""
        self.write(f"core {status.kind.value}{where}, tick {session.tick}{self._counters()}")
        self._named(state.name for state in session.program.image.states)

    def inputs(self, rest: str) -> None:
        """Inputs of the next tick, or of the one that is on."""
        self._named(self.session.values.inputs)

    def outputs(self, rest: str) -> None:
        """Output words as the host reads them."""
        rows = []
        for output in self.session.program.image.outputs:
            word = self.session.target.read(f"o{output.index}")
            rows.append((output.name, format_word(word, "float"), f"0x{word:08x}"))
        if rows:
            self._table(("output", "value", "bits"), rows)

    def _named(self, names: Iterable[str]) -> None:
        rows = []
        for name in names:
            try:
                reading = self.session.values.read(name)
                value = format_word(reading.word, reading.type)
                rows.append((name, value, f"0x{reading.word:08x}", reading.place, reading.note))
            except ValueMissing as error:
                rows.append((name, "-", "", "", str(error).removeprefix(f"{name}: ")))
        if rows:
            self._table(("name", "value", "bits", "place", ""), rows)

    def values(self, rest: str) -> None:
        """Every value of the source, those with a part in their name."""
        names = [name for name in self.session.program.map.names() if rest in name]
        if not names:
            raise ValueMissing(f"no value has '{rest}' in its name")
        self._named(names)

    def registers(self, rest: str) -> None:
        """Registers that hold a value of the source, or those named."""
        program, position = self.session.program, self.session.position
        names = rest.split()
        if not names:
            used = {value.place for value in program.map.values if value.place[0] in "abc"}
            order = {bank.lower(): i for i, bank in enumerate(default_isa().banks)}
            names = sorted(used, key=lambda place: (order.get(place[0], 0), int(place[1:])))
        rows = []
        for name in names:
            reading = self.session.values.read(name)
            holder = program.finder.holder(reading.place, position)
            rows.append(
                (
                    name,
                    format_word(reading.word, "float"),
                    f"0x{reading.word:08x}",
                    format_word(reading.word, "int"),
                    holder.name if holder else "",
                )
            )
        self._table(("register", "float", "bits", "int", "holds"), rows)

    def faults(self, rest: str, text: str = "") -> None:
        """The fault that ended the run, and values that are not finite."""
        session = self.session
        if session.status.kind is not Kind.FAULT:
            self.write("no fault")
            return
        assert session.status.fault is not None
        self.write(text or fault_text(session.program.image, session.status.fault))
        if session.status.fault.cause != "NOT_FINITE":
            return
        found = session.not_finite()
        for n, (value, word) in enumerate(found[:NOT_FINITE]):
            line = f"{value.file}:{value.line}" if value.line else "kept from the run before"
            order = "then" if n else "first computed"
            number = format_word(word, "float")
            self.write(f"  not finite, {order}: {value.name} = {number} in {value.place}, {line}")
        if found:
            self.write(f"  `break {found[0][0].name}` stops before it is computed")

    def breakpoints(self, rest: str) -> None:
        """Breakpoints and watches."""
        points = self.session.breakpoints.values()
        if not points:
            self.write("no breakpoints")
            return
        rows = [
            (
                str(p.number),
                p.kind + (", once" if p.temporary else ""),
                "on" if p.enabled else "off",
                str(p.hits),
                p.location.text + _conditions(p),
            )
            for p in points
        ]
        self._table(("number", "kind", "", "hits", "place"), rows)

    def target(self, rest: str) -> None:
        """The target and its limits."""
        target = self.session.target
        try:
            target.poll(0.0)
        except LinkError as error:
            self.write(str(error))
        self.write(
            f"{target.label}: {target.breakpoints} breakpoints, {target.watches} watches; program "
            f"'{self.session.program.image.title}', {self.session.program.image.configuration}, "
            f"{self.session.program.bundles} bundles"
        )

    def streams(self, rest: str) -> None:
        """Blocks of the streams, and the words that the pipes take next."""
        blocks = self.session.program.image.streams
        if not blocks:
            self.write("the program has no streams")
            return
        rows = [
            (
                block.name,
                block.pin,
                f"{block.address}..{block.address + len(block.words) - 1}",
                "vectors" if block.lanes else "words",
            )
            for block in blocks
        ]
        self._table(("block", "pipe", "places", ""), rows)
        for pin, place in self.session.target.stream_places().items():
            self.write(f"pipe {pin} takes place {place} next")

    def stream_words(self, name: str, count: int, form: str) -> None:
        """First words of a block of a stream, four a line, a vector a line."""
        for line in range(0, count, 4):
            readings = [
                self.session.values.read(f"{name}[{i}]") for i in range(line, min(line + 4, count))
            ]
            cells = "  ".join(format_word(each.word, "float", form) for each in readings)
            self.write(f"{name}[{line}]:  {cells}")

    def data(self, start: int, count: int, form: str) -> None:
        """Words of data memory, four a line."""
        names = {address: name for name, address in self.session.program.image.data_names.items()}
        words = default_isa().data_words
        if start + count > words:
            raise ValueMissing(f"data memory has words 0..{words - 1}")
        for line in range(start, start + count, 4):
            cells = []
            for address in range(line, min(line + 4, start + count)):
                word = self.session.values.target_word(f"d{address}")
                cells.append(format_word(word, "float", form))
            name = f"  {names[line]}" if line in names else ""
            self.write(f"{line:4d}{name}:  {'  '.join(cells)}")


def _conditions(point: Breakpoint) -> str:
    """When a breakpoint acts, and what it does instead of a stop."""
    text = f" if {point.condition.text}" if point.condition else ""
    text += f", hits {point.counted.text}" if point.counted else ""
    text += f", ignores the next {point.ignored}" if point.ignored else ""
    text += f', writes "{point.message.text}"' if point.message else ""
    return text + "".join(f"\n    {line}" for line in point.commands)


def _operation(entry: SourceEntry) -> str:
    equation = f"  ({entry.equation})" if entry.equation else ""
    return f"{entry.file}:{entry.line}  {entry.text}{equation}"
