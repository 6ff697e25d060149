# SPDX-License-Identifier: Apache-2.0
"""Bits of operations and bundles, and the image of an allocated program."""

from __future__ import annotations

from asip_asm.image import (
    ConstantEntry,
    ExportEntry,
    Image,
    InputEntry,
    OutputEntry,
    SourceEntry,
    StateEntry,
    StreamEntry,
)
from asip_asm.ir import (
    Bundle,
    FixedState,
    Operation,
    Output,
    Program,
    Register,
    State,
    register_name,
)
from asip_asm.isa import Isa
from asip_asm.regmap import compose


class EncodeError(ValueError):
    """The program does not fit the core, or an operand is not a physical register."""


def encode_register(register: Register, isa: Isa) -> int:
    """Source field of a register: {bank code, index}; EncodeError if it does not exist."""
    bank = isa.banks[register.bank]
    if not 0 <= register.index < bank.size:
        raise EncodeError(f"there is no register {register_name(register)}")
    return (bank.code << isa.index_bits) + register.index


def encode_operation(operation: Operation, isa: Isa, labels: dict[str, int]) -> int:
    """Operation word. `labels` gives the bundle address of each branch target."""
    record = isa.operations[operation.mnemonic]
    values = {"op": record.opcode}
    for name in record.sources:
        register = getattr(operation, name)
        if not isinstance(register, Register):
            raise EncodeError(f"{operation.mnemonic}: operand {name} is no physical register")
        values[name] = encode_register(register, isa)
    if record.writes:
        dst = operation.dst
        if isinstance(dst, Output):
            values["dst"] = 1 << isa.index_bits | dst.index
        elif isinstance(dst, Register):
            encode_register(dst, isa)
            values["dst"] = dst.index
        else:
            raise EncodeError(f"{operation.mnemonic}: destination is no physical register")
    if "lane" in record.operands:
        values["b"] = operation.imm or 0
    if record.immediate_high is not None:
        immediate = operation.imm or 0
        if "target" in record.operands:
            immediate = labels[operation.target or ""]
        high, values["c"] = divmod(immediate, 1 << isa.fields["c"].width)
        values[record.immediate_high] = high
    try:
        return compose(isa.fields, values)
    except ValueError as error:
        raise EncodeError(f"{operation.mnemonic}: {error}") from None


def encode_bundle(bundle: Bundle, isa: Isa, labels: dict[str, int]) -> int:
    """{control, slot n-1, ..., slot 0}; empty slots are nop."""
    nop = encode_operation(Operation("nop"), isa, labels)
    word = bundle.halt << isa.halt_bit | bundle.ends << isa.loop_bit
    for operation in reversed(bundle.slots):
        slot = nop if operation is None else encode_operation(operation, isa, labels)
        word = word << isa.word_width | slot
    return word


def label_addresses(program: Program) -> dict[str, int]:
    """Bundle address of every label."""
    labels: dict[str, int] = {}
    address = 0
    for region in program.regions:
        labels.update(dict.fromkeys(region.labels, address))
        address += len(region.bundles or [])
    return labels


def encode_program(program: Program, isa: Isa, cycles: int | None) -> Image:
    """Image of a scheduled and allocated program. Raises EncodeError."""
    bundles = program.bundles
    if len(bundles) > isa.program_bundles:
        raise EncodeError(
            f"too many bundles: the program has {len(bundles)}, the core's program memory holds "
            f"{isa.program_bundles}"
        )
    labels = label_addresses(program)
    digits = isa.bundle_width(program.configuration) // 4
    declared: list[State | FixedState] = [*program.states, *program.fixed_states]
    states = [
        StateEntry(s.name, register_name(_placed(s.name, s.register)), s.type, f"{s.bits:08x}")
        for s in declared
    ]
    constants = sorted(program.constants, key=lambda word: word.index)
    return Image(
        title=program.title,
        configuration=program.configuration,
        bundles=[f"{encode_bundle(bundle, isa, labels):0{digits}x}" for bundle in bundles],
        sources=[_sources(bundle) for bundle in bundles],
        constants=[ConstantEntry(c.name, c.index, c.type, f"{c.bits:08x}") for c in constants],
        inputs=[InputEntry(i.name, i.index, i.type) for i in program.inputs],
        outputs=[OutputEntry(o.name, o.index, f"{o.safe:08x}") for o in program.outputs],
        states=states,
        exports=[
            ExportEntry(e.name, register_name(_placed(e.name, e.register))) for e in program.exports
        ],
        data=[f"{word:08x}" for word in program.data],
        data_names=dict(program.data_names),
        labels=labels,
        watchdog=program.watchdog,
        output_mask=sum(1 << output.index for output in program.outputs),
        cycles=cycles,
        parameters=list(program.parameters),
        streams=[
            StreamEntry(
                s.name,
                s.pin,
                s.address,
                [f"{word:08x}" for word in s.words],
                [[f"{word:08x}" for word in lane] for lane in s.lanes],
            )
            for s in program.streams
        ],
    )


def _placed(name: str, register: Register | None) -> Register:
    if register is None:
        raise EncodeError(f"'{name}' has no register")
    return register


def _sources(bundle: Bundle) -> list[SourceEntry]:
    return [
        SourceEntry(
            slot,
            op.mnemonic,
            op.source.text,
            op.source.file,
            op.source.line,
            op.source.equation,
        )
        for slot, op in bundle.placed()
        if op.source is not None
    ]
