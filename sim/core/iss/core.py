# SPDX-License-Identifier: Apache-2.0
"""Instruction-set model: executes a program image bundle by bundle, without timing.

Written from docs/assembly.md and `isa.toml`. All operations of a bundle read before any writes; a
branch or halt takes effect after its bundle. Registers, data memory and outputs keep their values
between runs. A fault ends the run: an illegal bundle does nothing, a bad data address stops its own
bundle before any write, a value that is not finite stops the run at its bundle; the outputs then
read as their safe values. The watchdog counts executed bundles, which is less than the cycles.
"""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import CodeType
from typing import Any

from asip_asm.image import Image
from asip_asm.isa import LOOP_BITS, STREAM_BITS, STREAM_PINS
from sim.core.iss import arithmetic, isa
from sim.core.iss.arithmetic import SinCos, Word, bits_of, from_float, to_float, to_int, word
from sim.core.iss.isa import Decoded, Fault, IllegalOperation

TABLE_1 = ("add_sub", "mul", "div", "sqrt", "sin", "float_int", "sat")
"""Classes of table 1; a fused multiply-add counts as one multiplication and one addition."""


@dataclass(frozen=True)
class RunResult:
    """One run: outputs by name as floats and bits, flags {nv, dz, of, uf, nx}, fault and place.

    counts: executed operations per mnemonic; bundles: number of bundles executed; writes: with
    tracing, the bits written per register or output ('a3', 'o0') in order.
    """

    outputs: dict[str, float]
    output_bits: dict[str, int]
    flags: int
    fault: Fault
    fault_bundle: int | None
    counts: Counter[str]
    bundles: int
    writes: dict[str, list[int]] = field(default_factory=dict)

    @property
    def table1(self) -> dict[str, int]:
        """Executed operations per class of table 1."""
        total = dict.fromkeys(TABLE_1, 0)
        for mnemonic, executed in self.counts.items():
            for name, each in isa.ISA.operations[mnemonic].counts.items():
                total[name] += executed * each
        return total


class RunFault(Exception):
    """A fault ends the run."""

    def __init__(self, fault: Fault) -> None:
        super().__init__(fault)
        self.fault = fault


@dataclass
class _Step:
    """A decoded bundle: values to compute, then where they go, then where the run goes on.

    `quick` does all of a bundle but to find the next one. It is compiled when the bundle runs
    again; None before, with outputs, at a branch or the end, and for tracing.
    """

    operations: list[Decoded]
    compute: list[Callable[[], Any]]
    destinations: list[int]  # operand codes, aligned with compute
    outputs: list[tuple[Callable[[], Word], int]]
    stores: list[tuple[Callable[[], int], int]]  # address, operand code of the word
    branch: Callable[[], int | None] | None
    halt: bool
    takes: list[int]  # pipes whose streams give a word
    seek: int | None  # {pipe, address}
    loop: tuple[int, int] | None  # level, rounds after the first one
    ends: tuple[int, ...]  # levels of loops marked, from inside
    lanes: list[Callable[[], None]]  # compute what vectors write in further lanes
    counts: Counter[str]
    straight: bool = False  # neither loop nor mark
    compiles: bool = False
    met: bool = False
    quick: Callable[[], None] | None = None


def _vectors(op: Decoded) -> list[bool]:
    """Which operands of a vector operation are vectors."""
    assert op.dst is not None
    own = op.dst // isa.BANK_WORDS
    return [
        (code // isa.BANK_WORDS == own and (i == 2 or op.mnemonic in isa.EVERY))
        or (i == 2 and code == 0)
        or (i == 0 and code >= isa.S_BASE)
        for i, code in enumerate(op.sources)
    ]


@functools.lru_cache(maxsize=1 << 12)
def _code(text: str) -> CodeType:
    """Compiled text: bundles of one shape are frequent, and a program is loaded again and again."""
    return compile(text, "<bundle>", "exec")


class Iss:
    """A loaded program image, given as such or as its JSON data.

    sincos replaces the correctly rounded sine and cosine; trace records every write of a run.
    Raises ImageError for what is no image, KeyError for unknown names.
    """

    def __init__(
        self,
        image: Image | Mapping[str, Any],
        sincos: SinCos = arithmetic.sincos_rounded,
        trace: bool = False,
    ) -> None:
        if isinstance(image, Image):
            image.check()
        else:
            image = Image.from_json(image)
        self.image = image
        self._trace = trace
        self._operations = arithmetic.operations(sincos)
        self._registers: list[Word] = [arithmetic.ZERO] * (7 * isa.BANK_WORDS)
        self._data: list[Word] = [arithmetic.ZERO] * isa.DATA_WORDS
        self._outputs = [arithmetic.ZERO] * isa.OUTPUTS
        self._load_streams(image)
        self._words = [int(text, 16) for text in image.bundles]
        self._steps: list[_Step | None] = [None] * len(self._words)
        self._counted: tuple[tuple[int, ...], Counter[str]] = ((), Counter())
        for constant in image.constants:
            self._registers[isa.K_BASE + constant.index] = word(int(constant.bits, 16))
        self.select(image)
        self.set_outputs_safe()
        self.reset()

    def _load_streams(self, image: Image) -> None:
        """Streams by pipe, and those of its further lanes, with the registers there."""
        build = isa.ISA.configurations[image.configuration]
        lanes = range(1, 1 + build.lanes)
        self._streams: list[list[Word]] = []
        self._lane_streams: list[list[list[Word]]] = []
        for pin in STREAM_PINS:
            first, *others = (
                [word(bits) for bits in image.stream(pin, lane)] for lane in (0, *lanes)
            )
            for stream in (first, *others):
                stream += [arithmetic.ZERO] * (build.stream_words - len(stream))
            self._streams.append(first)
            self._lane_streams.append(others)
        size = 7 * isa.BANK_WORDS  # of the places of all banks
        self._lane_registers = [[arithmetic.ZERO] * size for _ in lanes]
        self._lane_writes: list[tuple[list[Word], int, Word]] = []
        self.stream_places = [0] * len(self._streams)
        self.begin()

    def begin(self) -> None:
        """A run starts: the streams are at their first words, no loop is open."""
        self.stream_places[:] = [0] * len(self._streams)
        levels = isa.ISA.configurations[self.image.configuration].loops
        self._rounds_left, self._bodies = [0] * levels, [0] * levels
        self._turn = (0, 0)  # bundles to come before the body is entered again, its first one

    def _take(self, pipe: int) -> Word:
        """Next word of the stream of a pipe."""
        stream, place = self._streams[pipe], self.stream_places[pipe]
        self.stream_places[pipe] = (place + 1) % len(stream)
        code = isa.S_BASE + pipe
        for registers, words in zip(self._lane_registers, self._lane_streams[pipe], strict=True):
            registers[code] = words[place]
        return stream[place]

    def select(self, image: Image) -> None:
        """Go on with another function of the image loaded (`Image.function`), by its names."""
        self.image = image
        self._places: dict[str, tuple[int, str]] = {}
        for constant in image.constants:
            self._places[constant.name] = (isa.K_BASE + constant.index, constant.type)
        for entry in image.inputs:
            self._places[entry.name] = (isa.K_BASE + entry.index, entry.type)
        for state in image.states:
            self._places[state.name] = (isa.register_code(state.register), state.type)
        for export in image.exports:
            self._places.setdefault(export.name, (isa.register_code(export.register), "float"))
        self._inputs = {entry.name for entry in image.inputs}
        self._safe = {entry.index: word(int(entry.safe, 16)) for entry in image.outputs}
        self._outputs_named = {entry.name: entry.index for entry in image.outputs}

    def reset(self) -> None:
        """States and data memory to their initial values."""
        for state in self.image.states:
            self._registers[self._places[state.name][0]] = word(int(state.bits, 16))
        for address, bits in enumerate(self.image.data):
            self._data[address] = word(int(bits, 16))

    def _write(self, name: str, value: float) -> None:
        code, kind = self._places[name]
        self._registers[code] = word(int(value)) if kind == "int" else from_float(float(value))

    def set_inputs(self, values: Mapping[str, float]) -> None:
        """Write inputs, floats rounded to binary32. KeyError for another name."""
        for name, value in values.items():
            if name not in self._inputs:
                raise KeyError(f"{name}: the program has no such input")
            self._write(name, value)

    def set_state(self, values: Mapping[str, float]) -> None:
        """Preset state registers. KeyError for another name."""
        known = {state.name for state in self.image.states}
        for name, value in values.items():
            if name not in known:
                raise KeyError(f"{name}: the program has no such state")
            self._write(name, value)

    def set_words(self, words: Mapping[str, int]) -> None:
        """Write inputs or preset states as raw 32-bit words. KeyError for another name."""
        known = self._inputs | {state.name for state in self.image.states}
        for name, bits in words.items():
            if name not in known:
                raise KeyError(f"{name}: the program has no such input or state")
            self._registers[self._places[name][0]] = word(bits)

    @property
    def state(self) -> dict[str, float | int]:
        """States by name, as floats or integers by their type."""
        return {state.name: self.read(state.name) for state in self.image.states}

    def read(self, name: str) -> float | int:
        """Value of an export, state, input or constant by its type, or of a register as a float."""
        code, kind = self._places.get(name) or (isa.register_code(name), "float")
        value = self._registers[code]
        return to_int(value) if kind == "int" else to_float(value)

    def read_bits(self, name: str) -> int:
        """Bits of what `read` names."""
        code, _ = self._places.get(name) or (isa.register_code(name), "float")
        return bits_of(self._registers[code])

    def read_data(self, address: int) -> int:
        """Bits of a word of data memory."""
        return bits_of(self._data[address])

    def read_place(self, place: str) -> int:
        """Bits of a register ('a3', 'k7', 'a3.2' in lane 2), an output ('o0') or a data word
        ('d12'). Raises KeyError.
        """
        words, index = self._words_of(place)
        return bits_of(words[index])

    def write_place(self, place: str, bits: int) -> None:
        """Inverse of `read_place`."""
        words, index = self._words_of(place)
        words[index] = word(bits)

    def _words_of(self, place: str) -> tuple[list[Word], int]:
        for letter, words in (("o", self._outputs), ("d", self._data)):
            if place[:1] == letter and place[1:].isdecimal() and int(place[1:]) < len(words):
                return words, int(place[1:])
        name, _, lane = place.partition(".")
        code = isa.register_code(name)
        if not lane:
            return self._registers, code
        if not lane.isdecimal() or not 0 < int(lane) <= len(self._lane_registers) or name[0] == "k":
            raise KeyError(place)
        return self._lane_registers[int(lane) - 1], code

    # ------------------------------------------------------------------ decoding into closures

    def _value(self, op: Decoded) -> Callable[[], Word]:
        registers, data = self._registers, self._data
        if op.mnemonic == "ld":
            address = self._address(op, op.sources[0])
            return lambda: data[address()]
        function = self._operations[op.mnemonic]
        if op.mnemonic in isa.PICK:
            a, c = op.sources
            addends = self._lane_registers[op.imm - 1] if op.imm else registers
            return lambda: function(registers[a], addends[c])
        if len(op.sources) == 3:
            a, b, c = op.sources
            return lambda: function(registers[a], registers[b], registers[c])
        if len(op.sources) == 2:
            a, b = op.sources
            return lambda: function(registers[a], registers[b])
        (a,) = op.sources
        return lambda: function(registers[a])

    def _lane(self, op: Decoded, lane: list[Word]) -> Callable[[], None]:
        """Computes what a vector operation writes in a further lane, of which these are the
        registers; operands that are no vectors are the pipe's own.
        """
        registers, writes, dst = self._registers, self._lane_writes, op.dst
        function = self._operations[op.mnemonic]
        assert dst is not None
        vectors = zip(op.sources, _vectors(op), strict=True)
        places = [(lane if vector else registers, code) for code, vector in vectors]

        def compute() -> None:
            value = function(*(words[code] for words, code in places))
            writes.append((lane, dst, value))

        return compute

    def _address(self, op: Decoded, index: int) -> Callable[[], int]:
        registers, offset = self._registers, op.imm

        def address() -> int:
            result = to_int(registers[index]) + offset
            if not 0 <= result < isa.DATA_WORDS:
                raise RunFault(Fault.ADDRESS)
            return result

        return address

    def _branch(self, op: Decoded) -> Callable[[], int | None]:
        registers, target = self._registers, op.imm
        if op.mnemonic == "jmp":
            return lambda: target
        (a,) = op.sources
        taken_if_zero = op.mnemonic == "bz"

        def branch() -> int | None:
            zero = bits_of(registers[a]) & 0x7FFF_FFFF == 0
            return target if zero == taken_if_zero else None

        return branch

    def _decode(self, bundle: int) -> _Step:
        configuration = self.image.configuration
        operations, halt, marks = isa.decode_bundle(self._words[bundle], configuration)
        ends = tuple(n for n in reversed(range(marks.bit_length())) if marks >> n & 1)
        present = [op for op in operations if op is not None]
        step = _Step(present, [], [], [], [], None, halt, [], None, None, ends, [], Counter())
        for slot, op in enumerate(operations):
            if op is None:
                continue
            step.counts[op.mnemonic] += 1
            if op.mnemonic == "seek":
                step.seek = op.imm
                continue
            if op.mnemonic == "loop":
                step.loop = divmod(op.imm, 1 << LOOP_BITS)
                continue
            if isa.S_BASE + slot in op.sources:
                step.takes.append(slot)
            if op.mnemonic in isa.VECTOR:
                step.lanes += [self._lane(op, registers) for registers in self._lane_registers]
            if op.mnemonic in isa.ISA.branches:
                step.branch = self._branch(op)
            elif op.mnemonic == "st":
                step.stores.append((self._address(op, op.sources[1]), op.sources[0]))
            elif op.output is not None:
                step.outputs.append((self._value(op), op.output))
            elif op.dst is not None:
                step.compute.append(self._value(op))
                step.destinations.append(op.dst)
        step.straight = step.loop is None and not ends
        step.compiles = not (step.outputs or step.branch or halt or self._trace)
        return step

    def _compile(self, step: _Step) -> Callable[[], None]:
        """One Python function for what `execute` does of a bundle: all reads, then all writes."""
        names: dict[str, Any] = {"r": self._registers, "d": self._data, "at": self.stream_places}
        names |= {f"r{n}": registers for n, registers in enumerate(self._lane_registers)}
        lines, targets, values = [], [], []
        lanes = range(len(self._lane_registers))
        for pipe in step.takes:
            code, stream = isa.S_BASE + pipe, self._streams[pipe]
            names |= {f"s{pipe}": stream}
            names |= {f"s{pipe}_{n}": words for n, words in enumerate(self._lane_streams[pipe])}
            lines += [f"n = at[{pipe}]", f"at[{pipe}] = (n + 1) % {len(stream)}"]
            lines += [f"r[{code}] = s{pipe}[n]", *(f"r{n}[{code}] = s{pipe}_{n}[n]" for n in lanes)]
        if step.seek is not None:
            pipe, place = divmod(step.seek, 1 << STREAM_BITS)
            lines.append(f"at[{pipe}] = {place % len(self._streams[pipe])}")
        vectors: list[tuple[str, str]] = []
        for i, op in enumerate(step.operations):
            if op.dst is None:
                continue
            words = [f"r[{code}]" for code in op.sources]
            if op.mnemonic == "ld":
                names[f"address{i}"] = self._address(op, op.sources[0])
                value = f"d[address{i}()]"
            else:
                names[f"f{i}"] = self._operations[op.mnemonic]
                if op.mnemonic in isa.PICK and op.imm:
                    words[1] = f"r{op.imm - 1}[{op.sources[1]}]"
                value = f"f{i}({', '.join(words)})"
            targets.append(f"r[{op.dst}]")
            values.append(value)
            if op.mnemonic in isa.VECTOR:
                for n in lanes:
                    own = zip(op.sources, words, _vectors(op), strict=True)
                    given = [f"r{n}[{code}]" if vector else word for code, word, vector in own]
                    vectors.append((f"r{n}[{op.dst}]", f"f{i}({', '.join(given)})"))
        for target, value in vectors:
            targets.append(target)
            values.append(value)
        if step.stores:
            lines += [f"v = {', '.join(values)}," if values else "v = ()"]
            for i, (address, code) in enumerate(step.stores):
                names[f"store{i}"] = address
                lines.append(f"p{i}, w{i} = store{i}(), r[{code}]")
            lines += [f"d[p{i}] = w{i}" for i in range(len(step.stores))]
            values = [f"v[{i}]" for i in range(len(values))]
        if targets:
            lines.append(f"{', '.join(targets)} = {', '.join(values)}")
        exec(_code("\n    ".join(["def quick():", *(lines or ["pass"])])), names)  # our own text
        return names["quick"]

    # ------------------------------------------------------------------ execution

    def run(self) -> RunResult:
        """Execute one run from the entry to halt or fault."""
        executed = [0] * len(self._words)
        writes: dict[str, list[int]] = {}
        written: set[int] = set()
        fault, place = Fault.NONE, None
        position: int | None = self.image.entry
        bundles = 0
        self.begin()
        with arithmetic.environment():
            try:
                while position is not None:
                    place = position
                    if position >= len(self._words):
                        raise self._outside(position)
                    if bundles >= self.image.watchdog:
                        raise RunFault(Fault.WATCHDOG)
                    step = self._steps[position] or self.decoded(position)
                    executed[position] += 1
                    bundles += 1
                    if step.quick:
                        step.quick()
                        straight = step.straight and not self._turn[0]
                        position = position + 1 if straight else self._next(step, position)
                        continue
                    if step.compiles and step.met:
                        step.quick = self._compile(step)
                    step.met = True
                    position = self.execute(
                        step, position, written, writes if self._trace else None
                    )
                if self.misses_outputs(written):
                    raise RunFault(Fault.OUTPUT_MISSING)
                place = None
            except IllegalOperation:
                fault = Fault.ILLEGAL
            except RunFault as stop:
                fault = stop.fault
            flags = arithmetic.flags()
        if fault is not Fault.NONE:
            self.set_outputs_safe()
        named = {name: self._outputs[index] for name, index in self._outputs_named.items()}
        return RunResult(
            outputs={name: to_float(value) for name, value in named.items()},
            output_bits={name: bits_of(value) for name, value in named.items()},
            flags=flags,
            fault=fault,
            fault_bundle=place,
            counts=self._count(tuple(executed)),
            bundles=bundles,
            writes=writes,
        )

    def _count(self, executed: tuple[int, ...]) -> Counter[str]:
        """Operations per mnemonic; the result of the last pattern of bundles is cached."""
        if executed != self._counted[0]:
            counts: Counter[str] = Counter()
            for step, times in zip(self._steps, executed, strict=True):
                if times and step is not None:
                    for mnemonic, each in step.counts.items():
                        counts[mnemonic] += each * times
            self._counted = executed, counts
        return self._counted[1].copy()

    def _outside(self, position: int) -> RunFault:
        """Fault of a bundle after the program; empty program memory reads as zero."""
        return RunFault(Fault.ADDRESS if position >= isa.PROGRAM_BUNDLES else Fault.ILLEGAL)

    def misses_outputs(self, written: set[int]) -> bool:
        """Whether a run that wrote these outputs has left one of the mask out."""
        return bool(self.image.output_mask & ~sum(1 << index for index in written))

    def set_outputs_safe(self) -> None:
        """What the host reads after a fault."""
        for index, safe in self._safe.items():
            self._outputs[index] = safe

    def decoded(self, position: int) -> _Step:
        """The bundle at a position. Raises RunFault, IllegalOperation."""
        if position >= len(self._words):
            raise self._outside(position)
        step = self._steps[position]
        if step is None:
            step = self._steps[position] = self._decode(position)
        return step

    def _next(self, step: _Step, position: int) -> int:
        """The bundle after this one, by the loops. The third bundle from one with a mark on is the
        first one of the body, if the innermost of its loops that has a round left goes on.
        """
        following = position + 1
        left, body = self._turn
        if left:
            self._turn = (left - 1, body)
            following = body if left == 1 else following
        else:
            for level in step.ends:
                if self._rounds_left[level]:
                    self._rounds_left[level] -= 1
                    self._turn = (2, self._bodies[level])
                    break
        if step.loop is not None:
            level, rounds = step.loop
            self._rounds_left[level], self._bodies[level] = rounds, position + 1
        return following

    def execute(
        self,
        step: _Step,
        position: int,
        written: set[int],
        writes: dict[str, list[int]] | None,
    ) -> int | None:
        """Do a bundle; adds the outputs to `written`, the bits of all writes to `writes`. The next
        position, None after the last bundle. Raises RunFault.
        """
        registers = self._registers
        for pipe in step.takes:
            registers[isa.S_BASE + pipe] = self._take(pipe)
        if step.seek is not None:
            pipe, place = divmod(step.seek, 1 << STREAM_BITS)
            self.stream_places[pipe] = place % len(self._streams[pipe])
        values = [compute() for compute in step.compute]
        for compute_lane in step.lanes:
            compute_lane()
        following = self._next(step, position)
        if step.outputs or step.stores or step.branch:
            outputs = [(compute(), index) for compute, index in step.outputs]
            stores = [(address(), registers[code]) for address, code in step.stores]
            if step.branch:
                target = step.branch()
                if target is not None:
                    following, self._turn = target, (0, 0)
            for address, value in stores:
                self._data[address] = value
            for value, index in outputs:
                if writes is not None:
                    writes.setdefault(f"o{index}", []).append(bits_of(value))
                if bits_of(value) >> 23 & 0xFF == 0xFF:
                    raise RunFault(Fault.NOT_FINITE)
                self._outputs[index] = value
                written.add(index)
        for words, code, value in self._lane_writes:
            words[code] = value
        self._lane_writes.clear()
        for code, value in zip(step.destinations, values, strict=True):
            registers[code] = value
            if writes is not None:
                writes.setdefault(isa.register_name(code), []).append(bits_of(value))
        return None if step.halt else following
