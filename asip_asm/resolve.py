# SPDX-License-Identifier: Apache-2.0
"""From parsed statements to the IR: names, regions, data flow between regions, renaming.

Errors that concern more than one statement are found here: registers read before they are written,
outputs written twice or not at all, labels, code that is never reached.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

from asip_asm.diagnostics import Place, Reporter, SourceError, closest
from asip_asm.expression import literal_name, word_bits
from asip_asm.flow import certain_before, live_after, possible_before, reachable
from asip_asm.ir import (
    ZERO,
    Bundle,
    Export,
    FixedState,
    Operation,
    Output,
    OutputWord,
    Program,
    Region,
    Register,
    State,
    Virtual,
    Word,
    register_name,
)
from asip_asm.isa import Configuration, Isa
from asip_asm.lint import lint
from asip_asm.source import (
    NOUNS,
    Declaration,
    Operand,
    RawOperation,
    Source,
    Statement,
    output_index,
    physical_register,
)

DEFAULT_CONFIGURATION = "fast"
BRANCHES = ("jmp", "bz", "bnz")


@dataclass(eq=False)
class _Step:
    """Operation with the symbolic names that it still holds: reads by field, and its write."""

    operation: Operation
    raw: RawOperation
    reads: dict[str, str] = field(default_factory=dict)
    write: str | None = None

    @property
    def place(self) -> Place:
        return self.raw.place


@dataclass(eq=False)
class _Block:
    """Region in the making. `groups` are the operations that read at the same time: bundles, or one
    each; `follow` the blocks that may run next, `ends` whether a run may end here.
    """

    labels: list[str] = field(default_factory=list)
    groups: list[list[_Step]] = field(default_factory=list)
    braces: bool = False
    halt: bool = False
    closed: bool = False
    place: Place | None = None
    follow: list[int] = field(default_factory=list)

    def steps(self) -> Iterator[_Step]:
        for group in self.groups:
            yield from group


def resolve(
    source: Source, isa: Isa, reporter: Reporter, configuration: str | None = None
) -> Program:
    """Program of the source in the given configuration; errors go to the reporter.

    Without `configuration` the file's own one or `fast` is taken. The result is complete only if
    the reporter has no error.
    """
    return _Resolver(source, isa, reporter, configuration).run()


class _Resolver:
    def __init__(
        self, source: Source, isa: Isa, reporter: Reporter, configuration: str | None
    ) -> None:
        self.source = source
        self.isa = isa
        self.reporter = reporter
        self.configuration = self._choose(configuration)
        self.program = Program(title=source.title, configuration=self.configuration.name)
        self.words: dict[int, tuple[int, str]] = {}
        self.named_words: dict[str, int] = {}
        self.literals: dict[tuple[int, str], int] = {}
        self.first_free = len(source.of_kind("input"))
        self.labels = [s.label for s in source.statements if s.kind == "label"]
        self.blocks: list[_Block] = []
        self.open_labels: list[str] = []
        self.written: dict[str, Place] = {}

    def run(self) -> Program:
        self._declare()
        self._build_blocks()
        self._check_flow()
        self._connect()
        if self.blocks:
            self._check_reads()
            self._check_outputs()
            self._rename()
        if not self.reporter.diagnostics:
            steps = [step for block in self.blocks for step in block.steps()]
            lint(self.source, self.program, steps, self.reporter)
        self.program.files = self.source.files
        self.program.warnings = self.reporter.warnings
        return self.program

    def _choose(self, configuration: str | None) -> Configuration:
        insisted = self.source.configuration
        if insisted is not None and configuration is not None and insisted[0] != configuration:
            self.reporter.add(
                insisted[1],
                f"the file insists on configuration '{insisted[0]}', the command line says "
                f"'{configuration}'",
                f"use --config {insisted[0]} or change .config",
            )
        name = insisted[0] if insisted else configuration or DEFAULT_CONFIGURATION
        return self.isa.configurations[name]

    # ------------------------------------------------------------------ declarations

    def _declare(self) -> None:
        program, source = self.program, self.source
        program.watchdog = source.watchdog
        program.data = list(source.data)
        program.data_names = {d.name: int(d.value or 0) for d in source.of_kind("data")}
        for declaration in source.of_kind("input"):
            index = len(program.inputs)
            program.inputs.append(Word(declaration.name, index, declaration.type))
        for declaration in source.of_kind("output"):
            program.outputs.append(
                OutputWord(declaration.name, len(program.outputs), declaration.bits)
            )
        for declaration in source.placed:
            assert isinstance(declaration.pin, Register)
            index = declaration.pin.index
            if index < len(program.inputs):
                self.reporter.add(
                    declaration.place,
                    f"k{index} holds the input '{program.inputs[index].name}'",
                    f"pin constants to k{len(program.inputs)} or higher",
                )
            if declaration.name:
                self._name_word(declaration, index)
            else:
                self._name_literal(declaration.bits, declaration.type, index)
        owners: dict[Register, str] = {}
        for declaration in source.of_kind("state"):
            try:
                self._declare_state(declaration, owners)
            except SourceError as error:
                self.reporter.take(error.diagnostic)

    def _declare_state(self, declaration: Declaration, owners: dict[Register, str]) -> None:
        pin = declaration.pin
        if isinstance(pin, Register):
            self._check_exists(pin, declaration.place)
            if pin in owners:
                self.reporter.add(
                    declaration.place,
                    f"{register_name(pin)} is the register of state '{owners[pin]}' already",
                )
            owners[pin] = declaration.name
            self.program.fixed_states.append(
                FixedState(declaration.name, declaration.type, declaration.bits, pin)
            )
            return
        if pin is not None:
            self._check_exists(Register(pin, 0), declaration.place)
        first = Virtual(declaration.name, 0)
        self.program.states.append(
            State(declaration.name, declaration.type, declaration.bits, first, pin=pin)
        )

    def _name_word(self, declaration: Declaration, index: int) -> None:
        self.named_words[declaration.name] = index
        self.words[index] = (declaration.bits, declaration.type)
        self.program.constants.append(
            Word(declaration.name, index, declaration.type, declaration.bits)
        )

    def _new_word(self, bits: int, type_name: str, place: Place) -> int:
        index = self.first_free
        while index in self.words:
            index += 1
        self.first_free = index
        size = self.isa.banks["K"].size
        if index >= size:
            raise SourceError(
                place,
                f"too many constants: bank K has {size} words for inputs and constants",
                "keep values in registers or in data memory",
            )
        self.words[index] = (bits, type_name)
        return index

    # ------------------------------------------------------------------ operands

    def _step(self, raw: RawOperation) -> _Step:
        record = raw.record
        operation = Operation(record.name, source=raw.source)
        step = _Step(operation, raw)
        for kind, operand in raw.operands.items():
            try:
                if kind == "dst":
                    self._destination(step, operand)
                elif kind == "target":
                    self._target(operation, operand)
                elif kind == "address":
                    operation.imm = int(operand.value)
                    if operand.index is not None:
                        self._source(step, "b", operand.index)
                else:
                    self._source(step, kind, operand)
            except SourceError as error:
                self.reporter.take(error.diagnostic)
        return step

    def _target(self, operation: Operation, operand: Operand) -> None:
        operation.target = operand.text
        if operand.text not in self.labels and operand.text not in self.source.doubtful:
            raise SourceError(
                operand.place,
                f"label '{operand.text}' is not defined",
                closest(operand.text, self.labels),
            )

    def _destination(self, step: _Step, operand: Operand) -> None:
        name, record = operand.text, step.raw.record
        unit = self.isa.units[record.unit]
        register = physical_register(name)
        declaration = self.source.names.get(name)
        if register is None and declaration is not None and declaration.kind == "state":
            self._check_type(declaration, record.type_of("dst"), operand.place, record.name, False)
            if isinstance(declaration.pin, Register):
                register = declaration.pin
        if register is not None:
            self._check_exists(register, operand.place)
            allowed = self._result_banks(record.name)
            if register.bank in ("zero", "K"):
                raise SourceError(
                    operand.place, f"'{name}' cannot be written", "banks A, B and C can"
                )
            if register.bank not in allowed:
                raise SourceError(
                    operand.place,
                    f"{record.name} cannot write '{name}': its results go to bank "
                    + " or ".join(allowed),
                    "copy with mov" if "C" not in allowed else "",
                )
            step.operation.dst = register
            return
        index = output_index(name)
        outputs = self.source.of_kind("output")
        if index is not None and index >= len(outputs):
            raise SourceError(
                operand.place,
                f"there is no output '{name}'",
                f"{len(outputs)} declared with .output",
            )
        if declaration is not None and declaration.kind == "output":
            index = outputs.index(declaration)
        if index is not None:
            if unit.bank != "C":
                raise SourceError(
                    operand.place,
                    f"{record.name} cannot write the output '{name}'",
                    "only auxiliary operations write outputs: write a register and mov it",
                )
            step.operation.dst = Output(index)
            return
        if declaration is not None and declaration.kind not in ("state", "register"):
            raise SourceError(
                operand.place, f"'{name}' is {NOUNS[declaration.kind]} and cannot be written"
            )
        if name == "pi":
            raise SourceError(operand.place, "'pi' is a constant and cannot be written")
        step.write = name
        self.written.setdefault(name, operand.place)

    def _source(self, step: _Step, kind: str, operand: Operand) -> None:
        record = step.raw.record
        wanted = record.type_of(kind)
        if operand.kind == "value" or operand.text == "pi":
            value = operand.value if operand.kind == "value" else 3.141592653589793
            type_name = "int" if wanted == "int" else "float"
            bits = word_bits(value, type_name, operand.place)
            setattr(step.operation, kind, self._literal(bits, type_name, operand.place))
            return
        name = operand.text
        register = physical_register(name)
        declaration = self.source.names.get(name)
        if declaration is not None and declaration.kind in ("input", "constant", "state"):
            self.source.used.add(name)
            self._check_type(declaration, wanted, operand.place, record.name, True)
            if declaration.kind == "input":
                register = Register("K", int(declaration.value or 0))
            elif declaration.kind == "constant":
                register = self._constant(declaration, operand.place)
            elif isinstance(declaration.pin, Register):
                register = declaration.pin
        if register is not None:
            self._check_exists(register, operand.place)
            setattr(step.operation, kind, ZERO if register.bank == "zero" else register)
            return
        if output_index(name) is not None or (declaration and declaration.kind == "output"):
            raise SourceError(
                operand.place,
                f"the output '{name}' cannot be read",
                "write a register, read that, and mov it to the output",
            )
        if declaration is not None and declaration.kind == "data":
            raise SourceError(
                operand.place,
                f"'{name}' is the address of data memory, not a register",
                f"load it: ld register, {name}",
            )
        step.reads[kind] = name

    def _check_type(
        self, declaration: Declaration, wanted: str, place: Place, mnemonic: str, reads: bool
    ) -> None:
        if wanted in ("any", declaration.type):
            return
        help_text = {"float": "convert with i2f", "int": "convert with f2i or f2it"}[wanted]
        if not reads:
            help_text = "write a symbolic register first and convert it"
        raise SourceError(
            place,
            f"'{declaration.name}' is of type {declaration.type}, {mnemonic} "
            f"{'reads' if reads else 'writes'} type {wanted}",
            help_text,
        )

    def _check_exists(self, register: Register, place: Place) -> None:
        bank = self.isa.banks[register.bank]
        if register.bank == "B" and self.configuration.fma_pipes < 2:
            raise SourceError(
                place, f"configuration '{self.configuration.name}' has no bank B", "use bank A"
            )
        if register.index >= bank.size:
            letter = bank.name.lower()
            raise SourceError(
                place,
                f"there is no register '{register_name(register)}'",
                f"bank {bank.name} is {letter}0..{letter}{bank.size - 1}",
            )

    def _result_banks(self, mnemonic: str) -> list[str]:
        """Banks that the operation's result can go to."""
        unit = self.isa.unit_of(mnemonic)
        slots = range(len(self.configuration.slots))
        return [
            self.configuration.result_bank(slot, unit)
            for slot in slots
            if self.configuration.allows(slot, unit)
        ]

    def _constant(self, declaration: Declaration, place: Place) -> Register:
        """Word of bank K of a named constant. Zero needs none, equal constants share one."""
        if declaration.name in self.named_words:
            return Register("K", self.named_words[declaration.name])
        if declaration.bits == 0 and not declaration.replaceable:
            return ZERO
        key = (declaration.bits, declaration.type)
        if declaration.replaceable:
            index = self._new_word(*key, place)
        else:
            index = self.literals.get(key, -1)
            if index < 0:
                index = self.literals[key] = self._new_word(*key, place)
        self._name_word(declaration, index)
        return Register("K", index)

    def _literal(self, bits: int, type_name: str, place: Place) -> Register:
        if bits == 0:
            return ZERO
        key = (bits, type_name)
        if key not in self.literals:
            self._name_literal(bits, type_name, self._new_word(bits, type_name, place))
        return Register("K", self.literals[key])

    def _name_literal(self, bits: int, type_name: str, index: int) -> None:
        self.literals[bits, type_name] = index
        self.words[index] = (bits, type_name)
        name = literal_name(bits, type_name)
        self.program.constants.append(Word(name, index, type_name, bits))

    # ------------------------------------------------------------------ regions

    def _build_blocks(self) -> None:
        labels: list[str] = []
        current: _Block | None = None
        last: Place | None = None

        def block(statement: Statement, braces: bool) -> _Block:
            nonlocal current, labels
            if current is None or current.closed or labels or current.braces != braces:
                current = _Block(labels, braces=braces, place=statement.place)
                labels = []
                self.blocks.append(current)
            return current

        for statement in self.source.statements:
            last = statement.place
            if statement.kind == "label":
                labels.append(statement.label)
            elif statement.kind == "halt":
                block(statement, False)
                assert current is not None
                current.halt = current.closed = True
            else:
                steps = [self._step(raw) for raw in statement.operations]
                target = block(statement, statement.kind == "bundle")
                target.groups.append(steps)
                if statement.kind == "bundle":
                    self._check_bundle(steps, statement)
                if any(step.operation.mnemonic in BRANCHES for step in steps):
                    target.closed = True
                if statement.halt:
                    target.halt = target.closed = True
        self.open_labels = labels
        if labels:
            self.reporter.add(
                last, f"label '{labels[-1]}' stands before no operation", "add halt behind it"
            )
        if not self.blocks and not self.source.incomplete:
            self.reporter.add(self.source.last_place, "the program has no operation", "add halt")

    def _check_bundle(self, steps: list[_Step], statement: Statement) -> None:
        destinations: dict[object, _Step] = {}
        for step in steps:
            destination = step.operation.dst or step.write
            if destination is not None and destination in destinations:
                operand = step.raw.operands["dst"]
                self.reporter.add(
                    operand.place, f"two operations of one bundle write '{operand.text}'"
                )
            destinations[destination] = step
            if statement.halt and step.operation.mnemonic in BRANCHES:
                self.reporter.add(
                    step.place, f"{step.operation.mnemonic} in a bundle that ends the run"
                )

    def _check_flow(self) -> None:
        if not self.blocks or self.open_labels or self.source.incomplete:
            return
        if not self.blocks[-1].halt and not self._jumps(self.blocks[-1]):
            self.reporter.add(
                self.source.last_place or self.blocks[-1].place,
                "the program ends without halt",
                "add halt behind the last operation",
            )

    def _jumps(self, block: _Block) -> bool:
        return any(step.operation.mnemonic == "jmp" for step in block.steps())

    def _connect(self) -> None:
        at = {label: i for i, block in enumerate(self.blocks) for label in block.labels}
        for i, block in enumerate(self.blocks):
            if not block.halt and not self._jumps(block) and i + 1 < len(self.blocks):
                block.follow.append(i + 1)
            for step in block.steps():
                target = step.operation.target
                if target in at:
                    block.follow.append(at[target])
        reached = reachable(self._follow()) if self.blocks else set()
        for i, block in enumerate(self.blocks):
            if i not in reached and not self.source.incomplete:
                self.reporter.add(
                    block.place,
                    "this is never reached",
                    "the run ends or jumps away before it, and no branch leads to it",
                )

    def _follow(self) -> list[list[int]]:
        return [block.follow for block in self.blocks]

    # ------------------------------------------------------------------ data flow

    def _check_reads(self) -> None:
        """Every read of a name must see a write on every path from the start."""
        states = {state.name for state in self.program.states} | self.source.doubtful
        everything = set(self.written) | states
        blocks = self.blocks
        writes = [{s.write for s in b.steps() if s.write} for b in blocks]
        before = certain_before(self._follow(), writes, states, everything)
        for block, known in zip(blocks, before, strict=True):
            seen = set(known)
            for group in block.groups:
                for step in group:
                    for kind, name in step.reads.items():
                        if name not in seen:
                            self._report_read(step, kind, name)
                            seen.add(name)
                seen.update(step.write for step in group if step.write)
        ends = [
            known | written
            for block, known, written in zip(blocks, before, writes, strict=True)
            if block.halt
        ]
        self._resolve_exports(set.intersection(*ends) if ends else everything)

    def _report_read(self, step: _Step, kind: str, name: str) -> None:
        operand = step.raw.operands.get(kind)
        if operand is None:
            operand = step.raw.operands["address"].index
        assert operand is not None
        first = self.written.get(name)
        if first is not None:
            problem = "is read before it is written"
            if len(self.blocks) > 1:
                problem = "is not written on every path before it is read"
            self.reporter.add(
                operand.place,
                f"'{name}' {problem}",
                f"its first write is in {first.line.file}:{first.line.number}",
            )
        elif name in self.source.names:
            self.reporter.add(operand.place, f"'{name}' is read but never written")
        else:
            known = [*self.source.names, *self.written]
            self.reporter.add(
                operand.place,
                f"unknown name '{name}'",
                closest(name, known) or "it is neither declared nor written",
            )

    def _resolve_exports(self, at_end: set[str]) -> None:
        for name, place, register in self.source.exports:
            try:
                self._export(name, place, register, at_end)
            except SourceError as error:
                self.reporter.take(error.diagnostic)

    def _export(self, name: str, place: Place, register: str | None, at_end: set[str]) -> None:
        declaration = self.source.names.get(name)
        value: Register | None
        if register is not None:
            value = physical_register(register)
            if value is None or value.bank == "zero":
                raise SourceError(
                    place, f"'{register}' is no physical register", "a0.., b0.., c0.. or k0.."
                )
        else:
            value = physical_register(name)
        if value is None and declaration is not None:
            if declaration.kind == "input":
                value = Register("K", int(declaration.value or 0))
            elif declaration.kind == "state" and isinstance(declaration.pin, Register):
                value = declaration.pin
            elif declaration.kind not in ("state", "register"):
                raise SourceError(
                    place,
                    f"'{name}' is {NOUNS[declaration.kind]} and cannot be exported",
                    "registers, states and inputs can",
                )
        if value is not None:
            self._check_exists(value, place)
            self.program.exports.append(Export(name, value))
            return
        if name in self.source.doubtful:
            return
        if name not in self.written and (declaration is None or declaration.kind != "state"):
            raise SourceError(
                place,
                f"'{name}' is exported but never written",
                closest(name, [*self.written, *self.source.names]),
            )
        if name not in at_end:
            raise SourceError(
                place,
                f"'{name}' is exported but not written on every path",
                f"its first write is in {self.written[name].line.file}:"
                f"{self.written[name].line.number}",
            )
        self.program.exports.append(Export(name, Virtual(name, 0)))

    def _check_outputs(self) -> None:
        """Every output must be written exactly once on every path."""
        blocks = self.blocks
        everything = set(range(len(self.program.outputs)))
        writes = [
            [(s.operation.dst.index, s) for s in b.steps() if isinstance(s.operation.dst, Output)]
            for b in blocks
        ]
        written = [{index for index, _ in pairs} for pairs in writes]
        names = {o.index: o.name for o in self.program.outputs}
        for before, pairs in zip(possible_before(self._follow(), written), writes, strict=True):
            seen = set(before)
            for index, step in pairs:
                if index in seen:
                    self.reporter.add(
                        step.raw.operands["dst"].place,
                        f"output '{names[index]}' is written twice",
                        "select the value first, then write the output once",
                    )
                seen.add(index)
        certain = certain_before(self._follow(), written, set(), everything)
        missing: set[int] = set()
        for block, before, here in zip(blocks, certain, written, strict=True):
            if block.halt:
                missing |= everything - before - here
        ever = set().union(*written)
        for declaration in self.source.of_kind("output"):
            index = int(declaration.value or 0)
            if index in missing and declaration.name not in self.source.doubtful:
                how = " on every path" if index in ever else ""
                self.reporter.add(
                    declaration.place,
                    f"output '{declaration.name}' is not written{how}",
                    f"write it once: mov {declaration.name}, value",
                )

    def _live_out(self) -> list[set[str]]:
        """Names whose value a later block, the host or the next run reads, by block."""
        blocks = self.blocks
        kept = {export.name for export in self.program.exports if isinstance(export.value, Virtual)}
        kept |= {state.name for state in self.program.states}
        exposed: list[set[str]] = []
        written: list[set[str]] = []
        for block in blocks:
            reads: set[str] = set()
            writes: set[str] = set()
            for group in block.groups:
                reads.update(n for s in group for n in s.reads.values() if n not in writes)
                writes.update(s.write for s in group if s.write)
            exposed.append(reads)
            written.append(writes)
        at_end = [kept if block.halt else set() for block in blocks]
        return live_after(self._follow(), exposed, written, at_end)

    # ------------------------------------------------------------------ renaming

    def _rename(self) -> None:
        several = len(self.blocks) > 1
        live = self._live_out() if several else [set()]
        counter: dict[str, int] = defaultdict(int)
        shared: dict[str, list[_Step]] = defaultdict(list)
        current: dict[str, Virtual] = {}
        for block, live_out in zip(self.blocks, live, strict=True):
            last = {s.write: s for s in block.steps() if s.write in live_out}
            current = {}
            if not several:
                current = {state.name: state.first for state in self.program.states}
            for group in block.groups:
                for step in group:
                    for kind, name in step.reads.items():
                        setattr(step.operation, kind, current.get(name, Virtual(name, -1)))
                for step in group:
                    if step.write is None:
                        continue
                    if last.get(step.write) is step:
                        value = Virtual(step.write, -1)
                        shared[step.write].append(step)
                    else:
                        counter[step.write] += 1
                        value = Virtual(step.write, counter[step.write])
                    step.operation.dst = current[step.write] = value
            self.program.regions.append(self._region(block))
        for state in self.program.states:
            if several:
                if state.name in self.written:
                    state.first = state.last = Virtual(state.name, -1)
            elif current.get(state.name, state.first) != state.first:
                state.last = current[state.name]
            self._check_pin(state, shared)
        if several:
            for block in self.blocks:
                self._read_unwritten_states(block)
        for export in self.program.exports:
            if isinstance(export.value, Virtual):
                export.value = self._exported(export.name, several, current)
        for name, steps in shared.items():
            self._check_one_kind(name, steps)

    def _exported(self, name: str, several: bool, current: dict[str, Virtual]) -> Virtual:
        if not several:
            return current.get(name, Virtual(name, 0))
        unwritten = {s.name: s.first for s in self.program.states if s.name not in self.written}
        return unwritten.get(name, Virtual(name, -1))

    def _read_unwritten_states(self, block: _Block) -> None:
        """States that nothing writes keep the symbol of their first value."""
        unwritten = {s.name: s.first for s in self.program.states if s.name not in self.written}
        for step in block.steps():
            for kind, name in step.reads.items():
                if name in unwritten:
                    setattr(step.operation, kind, unwritten[name])

    def _kind(self, step: _Step) -> str:
        return "fma" if self.isa.units[step.raw.record.unit].bank == "pipe" else "aux"

    def _check_one_kind(self, name: str, steps: list[_Step]) -> None:
        kinds = [self._kind(step) for step in steps]
        for step, kind in zip(steps, kinds, strict=True):
            if kind != kinds[0]:
                first = steps[0].place.line
                self.reporter.add(
                    step.raw.operands["dst"].place,
                    f"'{name}' keeps its value from one part of the program to another, but "
                    f"{step.raw.record.name} writes another bank than {steps[0].raw.record.name} "
                    f"in {first.file}:{first.number}",
                    f"insert mov: write another name and mov it to '{name}'",
                )
                return

    def _check_pin(self, state: State, shared: dict[str, list[_Step]]) -> None:
        if state.pin is None or state.last is None:
            return
        steps = shared.get(state.name) or [
            step
            for block in self.blocks
            for step in block.steps()
            if step.operation.dst == state.last
        ]
        for step in steps:
            if state.pin not in self._result_banks(step.raw.record.name):
                self.reporter.add(
                    step.raw.operands["dst"].place,
                    f"state '{state.name}' is pinned to bank {state.pin}, "
                    f"{step.raw.record.name} cannot write there",
                    "pin another bank, or insert mov"
                    if state.pin == "C"
                    else "pin C, or write it with a multiply-add operation",
                )

    def _region(self, block: _Block) -> Region:
        region = Region(labels=block.labels, halt=block.halt)
        if not block.braces:
            region.operations = [step.operation for step in block.steps()]
            return region
        region.bundles = []
        for group in block.groups:
            try:
                region.bundles.append(Bundle(self._slots(group)))
            except SourceError as error:
                self.reporter.take(error.diagnostic)
        if region.bundles:
            region.bundles[-1].halt = block.halt
        return region

    def _slots(self, group: list[_Step]) -> list[Operation | None]:
        """Slot of every operation of a bundle: named registers first, then in the order written."""
        slots: list[Operation | None] = [None] * len(self.configuration.slots)
        steps = [step for step in group if step.operation.mnemonic != "nop"]
        steps.sort(key=lambda step: not isinstance(step.operation.dst, Register))
        for step in steps:
            if step.operation.dst in [op.dst for op in slots if op is not None and op.dst]:
                continue
            unit = self.isa.units[step.raw.record.unit]
            choices = [
                slot
                for slot in range(len(slots))
                if self.configuration.allows(slot, unit)
                and not (
                    isinstance(step.operation.dst, Register)
                    and self.configuration.result_bank(slot, unit) != step.operation.dst.bank
                )
            ]
            free = [slot for slot in choices if slots[slot] is None]
            if not free:
                taken = [f"{op.mnemonic} takes slot {i}" for i in choices if (op := slots[i])]
                kind = "multiply-add" if unit.bank == "pipe" else "auxiliary"
                raise SourceError(
                    step.place,
                    f"no slot left for {step.raw.record.name}: configuration "
                    f"'{self.configuration.name}' has slots {', '.join(self.configuration.slots)}; "
                    + ", ".join(taken),
                    f"put this {kind} operation into another bundle",
                )
            slots[free[0]] = step.operation
        return slots
