# SPDX-License-Identifier: Apache-2.0
"""Operands of operations: registers, words of bank K, types, and their declarations."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

from asip_asm.blocks import Step
from asip_asm.diagnostics import Place, Reporter, SourceError, closest, counted
from asip_asm.expression import literal_name, word_bits
from asip_asm.ir import (
    ZERO,
    FixedState,
    Operation,
    Output,
    OutputWord,
    Program,
    Register,
    State,
    Virtual,
    Word,
    register_name,
)
from asip_asm.isa import STREAM_PINS, Configuration, Isa
from asip_asm.loops import immediate
from asip_asm.source import (
    NOUNS,
    Declaration,
    Operand,
    RawOperation,
    Source,
    output_index,
    physical_register,
    stream_words,
)


@dataclass(eq=False)
class Operands:
    """Resolves operands against the declarations of a source; places constants in bank K.

    `declare` fills the program's inputs, outputs, states and placed constants, `step` resolves one
    operation; `written` holds the first write of every symbolic name, `taken` the words of bank K
    that constants have.
    """

    source: Source
    isa: Isa
    reporter: Reporter
    configuration: Configuration
    program: Program
    taken: set[int] = field(default_factory=set)
    named_words: dict[str, int] = field(default_factory=dict)
    literals: dict[tuple[int, str], int] = field(default_factory=dict)
    written: dict[str, Place] = field(default_factory=dict)
    vectors: dict[str, int] = field(default_factory=dict)
    """Pipes of the names that vector operations write."""

    def __post_init__(self) -> None:
        self.first_free = len(self.source.of_kind("input"))
        self.labels = {s.label for s in self.source.statements if s.kind == "label"}

    # ------------------------------------------------------------------ declarations

    def declare(self) -> None:
        """Declarations of the source into the program."""
        program, source = self.program, self.source
        program.watchdog = source.watchdog
        program.data = list(source.data)
        program.data_names = {d.name: int(d.value or 0) for d in source.of_kind("data")}
        program.streams = list(source.streams)
        self._check_streams()
        for declaration in source.of_kind("input"):
            program.inputs.append(Word(declaration.name, len(program.inputs), declaration.type))
        for declaration in source.of_kind("output"):
            program.outputs.append(
                OutputWord(declaration.name, len(program.outputs), declaration.bits)
            )
        for declaration in source.placed:
            assert isinstance(declaration.pin, Register)
            index = declaration.pin.index
            self.taken.add(index)
            if index < len(program.inputs):
                self.reporter.add(
                    declaration.place,
                    f"k{index} holds the input '{program.inputs[index].name}'",
                    f"pin constants to k{len(program.inputs)} or higher",
                )
            if declaration.name:
                self._name_word(declaration, index)
            else:
                self._name_literal((declaration.bits, declaration.type), index)
        owners: dict[Register, str] = {}
        for declaration in source.of_kind("state"):
            try:
                self._declare_state(declaration, owners)
            except SourceError as error:
                self.reporter.take(error.diagnostic)

    def _check_streams(self) -> None:
        """Whether the configuration has the streams, and room for their words."""
        room = self.configuration.stream_words
        for declaration in self.source.of_kind("stream"):
            words = stream_words(self.source.streams, str(declaration.pin))
            if not room or words > room:
                self.reporter.add(
                    declaration.place,
                    f"the stream of pipe {declaration.pin} has {counted(words, 'word')}, "
                    f"configuration '{self.configuration.name}' holds {room}",
                    "put blocks into the other stream, or constants into data memory"
                    if room
                    else self._core_with("streams"),
                )
                return

    def _core_with(self, what: str) -> str:
        builds = self.isa.configurations.values()
        field = {"streams": "stream_words"}.get(what, what)
        names = [c.name for c in builds if getattr(c, field)]
        return f"{what} are in .config {' or '.join(names)}"

    def _declare_state(self, declaration: Declaration, owners: dict[Register, str]) -> None:
        pin = declaration.pin
        if isinstance(pin, Register):
            self.check_exists(pin, declaration.place)
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
            self.check_exists(Register(pin, 0), declaration.place)
        first = Virtual(declaration.name, 0)
        self.program.states.append(
            State(declaration.name, declaration.type, declaration.bits, first, pin=pin)
        )

    def _name_word(self, declaration: Declaration, index: int) -> None:
        self.named_words[declaration.name] = index
        self.program.constants.append(
            Word(declaration.name, index, declaration.type, declaration.bits)
        )

    def _new_word(self, place: Place) -> int:
        index = next(i for i in itertools.count(self.first_free) if i not in self.taken)
        self.first_free = index
        size = self.isa.banks["K"].size
        if index >= size:
            raise SourceError(
                place,
                f"too many constants: bank K has {size} words for inputs and constants",
                "keep values in registers or in data memory",
            )
        self.taken.add(index)
        return index

    # ------------------------------------------------------------------ operands

    def step(self, raw: RawOperation) -> Step:
        """The operation with its operands; errors go to the reporter."""
        record = raw.record
        operation = Operation(record.name, source=raw.source)
        step = Step(operation, raw)
        for kind, operand in raw.operands.items():
            try:
                if kind == "dst":
                    self._destination(step, operand)
                elif kind == "target":
                    self._target(operation, operand)
                elif kind == "stream":
                    self._check_core(operand, "streams", self.configuration.stream_words)
                    operation.imm = int(operand.value)
                elif kind == "count":
                    self._check_core(operand, "loops", self.configuration.loops)
                    operation.imm = immediate(0, int(operand.value))
                elif kind == "lane":
                    operation.imm = int(operand.value)
                elif kind == "address":
                    operation.imm = int(operand.value)
                    if operand.index is not None:
                        self._source(step, "b", operand.index)
                else:
                    self._source(step, kind, operand)
            except SourceError as error:
                self.reporter.take(error.diagnostic)
        try:
            self._check_vectors(step)
        except SourceError as error:
            self.reporter.take(error.diagnostic)
        return step

    def _pipe_of(self, step: Step) -> int:
        """Pipe of an operation on vectors and words. Raises SourceError unless its vectors are of
        one pipe, and its words in a bank that no pipe writes.
        """
        operation, operands = step.operation, step.raw.operands
        pipe = operation.stream
        vectors = {"a"} if pipe is not None else set()
        for kind in step.raw.record.sources:
            name, found = step.reads.get(kind), getattr(operation, kind)
            here = self.vectors.get(name) if name is not None else None
            if name is None and isinstance(found, Register) and found.bank in STREAM_PINS:
                here = STREAM_PINS.index(found.bank)
            if here is None and isinstance(found, Virtual):
                raise SourceError(
                    operands[kind].place,
                    f"'{operands[kind].text}' is no vector, constant or input",
                    "vfmul v, W+, word makes a vector of a word with a stream of ones",
                )
            if here is not None and pipe is not None and here != pipe:
                raise SourceError(
                    operands[kind].place,
                    f"'{operands[kind].text}' is no vector of pipe {STREAM_PINS[pipe]}",
                    "write it in the pipe of the others",
                )
            if here is not None:
                pipe = here
                vectors.add(kind)
        if pipe is None:
            raise SourceError(
                operands["a"].place,
                f"{step.raw.record.name} has no vector among its operands",
                "write one before with vfmul or vfmadd",
            )
        needed = step.raw.record.vector
        if needed is not None and needed not in vectors:
            raise SourceError(
                operands[needed].place,
                f"operand {needed} of {step.raw.record.name} is no vector",
                "vfmul v, W+, word makes a vector of a word with a stream of ones",
            )
        return pipe

    def _check_vectors(self, step: Step) -> None:
        """Raises SourceError unless vectors are written and read as such, in one pipe each."""
        operation, record, operands = step.operation, step.raw.record, step.raw.operands
        if record.unit != "lanes":
            for kind, name in step.reads.items():
                if name in self.vectors:
                    raise SourceError(
                        step.raw.read_as(kind).place,
                        f"'{name}' is a vector, {record.name} reads one word",
                        f"take a lane of it: vout word, zero, {name}, 0",
                    )
            if step.write in self.vectors:
                raise SourceError(operands["dst"].place, f"'{step.write}' is a vector already")
            return
        self._check_core(operands["dst"], "lanes", self.configuration.lanes)
        vector, c = step.reads.get("c"), operation.c
        if "lane" in record.operands:
            bank = c.bank if isinstance(c, Register) and c != ZERO else ""
            operation.lanes_of = (
                STREAM_PINS.find(bank) if bank else self.vectors.get(vector or "", -1)
            )
            if operation.lanes_of < 0:
                raise SourceError(
                    operands["c"].place,
                    f"'{operands['c'].text}' is no vector",
                    "write it before with vfmul or vfmadd",
                )
            if step.write in self.vectors:
                raise SourceError(operands["dst"].place, f"'{step.write}' is a vector already")
            return
        pipe = operation.stream
        if pipe is None and operands["a"].kind == "stream":
            return  # It is no such stream, which is reported.
        if record.every:
            pipe = operation.lanes_of = self._pipe_of(step)
        elif pipe is None:
            raise SourceError(
                operands["a"].place,
                f"{record.name} multiplies the next vector of a stream",
                "declare it with .vectors W, pin A = words, and write W+",
            )
        pin = STREAM_PINS[pipe]
        if vector is not None and self.vectors.get(vector) != pipe and not record.every:
            raise SourceError(
                operands["c"].place,
                f"'{vector}' is no vector of pipe {pin}",
                f"vectors of pipe {pin} come from its stream",
            )
        other = vector is None and isinstance(c, Register) and c.bank not in ("zero", pin)
        if other and isinstance(c, Register) and not record.every:
            raise SourceError(
                operands["c"].place,
                f"{register_name(c)} is no vector of pipe {pin}",
                f"vectors of pipe {pin} are in bank {pin}",
            )
        if step.write is None:
            return
        declaration = self.source.names.get(step.write)
        if declaration is not None and declaration.kind == "state":
            raise SourceError(
                operands["dst"].place, f"state '{step.write}' is one word", "write another name"
            )
        if any(export == step.write for export, *_ in self.source.exports):
            raise SourceError(
                operands["dst"].place, f"export '{step.write}' is one word", "export its lanes"
            )
        if self.vectors.setdefault(step.write, pipe) != pipe:
            raise SourceError(
                operands["dst"].place, f"'{step.write}' is a vector of the other pipe already"
            )

    def _target(self, operation: Operation, operand: Operand) -> None:
        operation.target = operand.text
        if operand.text not in self.labels and operand.text not in self.source.doubtful:
            raise SourceError(
                operand.place,
                f"label '{operand.text}' is not defined",
                closest(operand.text, self.labels),
            )

    def _destination(self, step: Step, operand: Operand) -> None:
        name, record = operand.text, step.raw.record
        unit = self.isa.units[record.unit]
        register = physical_register(name)
        declaration = self.source.names.get(name)
        if register is None and declaration is not None and declaration.kind == "state":
            self._check_type(declaration, record.type_of("dst"), operand.place, record.name, False)
            if isinstance(declaration.pin, Register):
                register = declaration.pin
        if register is not None:
            self.check_exists(register, operand.place)
            allowed = self.result_banks(record.name)
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

    def _source(self, step: Step, kind: str, operand: Operand) -> None:
        record = step.raw.record
        wanted = record.type_of(kind)
        if operand.kind == "value" or operand.text == "pi":
            value = operand.value if operand.kind == "value" else 3.141592653589793
            type_name = "int" if wanted == "int" else "float"
            key = (word_bits(value, type_name, operand.place), type_name)
            setattr(step.operation, kind, self._literal(key, operand.place))
            return
        name = operand.text
        register = physical_register(name)
        declaration = self.source.names.get(name)
        if operand.kind == "stream":
            self._stream_word(step, kind, operand)
            return
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
            self.check_exists(register, operand.place)
            setattr(step.operation, kind, ZERO if register.bank == "zero" else register)
            return
        if output_index(name) is not None or (declaration and declaration.kind == "output"):
            raise SourceError(
                operand.place,
                f"the output '{name}' cannot be read",
                "write a register, read that, and mov it to the output",
            )
        if declaration is not None and declaration.kind == "stream":
            raise SourceError(
                operand.place,
                f"'{name}' is a block of a stream, not a register",
                f"take its next word: {name}+",
            )
        if declaration is not None and declaration.kind == "data":
            raise SourceError(
                operand.place,
                f"'{name}' is the address of data memory, not a register",
                f"load it: ld register, {name}",
            )
        step.reads[kind] = name

    def _check_core(self, operand: Operand, what: str, there: int) -> None:
        """Raises SourceError unless the configuration has streams, or loops."""
        if not there:
            raise SourceError(
                operand.place,
                f"configuration '{self.configuration.name}' has no {what}",
                self._core_with(what),
            )

    def _stream_word(self, step: Step, kind: str, operand: Operand) -> None:
        """The operand is the next word of a stream, by the name of a block or of the pipe."""
        name, record = operand.text, step.raw.record
        declaration = self.source.names.get(name)
        pin = name if name in tuple(STREAM_PINS) and declaration is None else None
        if pin is not None:
            self.source.used.update(b.name for b in self.source.streams if b.pin == pin)
        if declaration is not None and declaration.kind == "stream":
            pin = str(declaration.pin)
            self.source.used.add(name)
        if pin is None:
            if name in self.source.doubtful:
                return
            raise SourceError(
                operand.place,
                f"'{name}+' takes the next word of a stream, and '{name}' is none",
                closest(name, [d.name for d in self.source.of_kind("stream")])
                or "declare it above: .stream name, pin A = words; a sum is written in parentheses",
            )
        self._check_core(operand, "streams", self.configuration.stream_words)
        if self.isa.units[record.unit].bank != "pipe" or "lane" in record.operands:
            raise SourceError(
                operand.place,
                f"{record.name} cannot read a stream",
                "multiply-adds can: write a register with fadd register, "
                f"zero, {name}+ and read that",
            )
        if step.operation.stream is not None:
            raise SourceError(
                operand.place,
                "an operation takes one word of its stream",
                "write the other word to a register before",
            )
        block = next((b for b in self.source.streams if b.name == name), None)
        if block is not None and bool(block.lanes) != (record.unit == "lanes"):
            held, wanted = ("vectors", ".stream") if block.lanes else ("words", ".vectors")
            raise SourceError(
                operand.place,
                f"'{name}' holds {held}, {record.name} takes the other kind",
                f"declare the words with {wanted}",
            )
        setattr(step.operation, kind, Register("S", STREAM_PINS.index(pin)))
        dst = step.operation.dst
        if isinstance(dst, Register) and dst.bank != pin:
            raise SourceError(
                operand.place,
                f"'{name}' is a stream of pipe {pin}, whose results go to bank {pin}, and "
                f"{register_name(dst)} is of another",
                f"write a register of bank {pin}, or declare the words with pin {dst.bank}",
            )

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

    def check_exists(self, register: Register, place: Place) -> None:
        """Raises SourceError unless the configuration has the register."""
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

    def result_banks(self, mnemonic: str) -> list[str]:
        """Banks that the operation's result can go to."""
        unit = self.isa.unit_of(mnemonic)
        build = self.configuration
        slots = range(len(build.slots))
        return [build.result_bank(slot, unit) for slot in slots if build.allows(slot, unit)]

    def _constant(self, declaration: Declaration, place: Place) -> Register:
        """Word of bank K of a named constant. Zero needs none, equal constants share one."""
        if declaration.name in self.named_words:
            return Register("K", self.named_words[declaration.name])
        if declaration.bits == 0 and not declaration.replaceable:
            return ZERO
        key = (declaration.bits, declaration.type)
        if declaration.replaceable:
            index = self._new_word(place)
        else:
            if key not in self.literals:
                self.literals[key] = self._new_word(place)
            index = self.literals[key]
        self._name_word(declaration, index)
        return Register("K", index)

    def _literal(self, key: tuple[int, str], place: Place) -> Register:
        if key[0] == 0:
            return ZERO
        if key not in self.literals:
            self._name_literal(key, self._new_word(place))
        return Register("K", self.literals[key])

    def _name_literal(self, key: tuple[int, str], index: int) -> None:
        bits, type_name = key
        self.literals[key] = index
        self.program.constants.append(Word(literal_name(*key), index, type_name, bits))
