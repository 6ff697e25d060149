# SPDX-License-Identifier: Apache-2.0
"""From an image back to source text that assembles to the same image."""

from __future__ import annotations

from asip_asm.assembly_text import quoted
from asip_asm.expression import literal_name
from asip_asm.image import Image
from asip_asm.ir import ZERO, Bundle, Operation, Output, Register, register_name
from asip_asm.isa import STREAM_BITS, STREAM_PINS, Isa, default_isa
from asip_asm.loops import back_edges, level_and_rounds

WORDS_PER_LINE = 8


class DecodeError(ValueError):
    """A word is no operation of the configuration; the message says why."""


def decode_register(field: int, isa: Isa) -> Register:
    """Register of a source field. Raises DecodeError."""
    code, index = field >> isa.index_bits, field & ((1 << isa.index_bits) - 1)
    for bank in isa.banks.values():
        offset = ((code - bank.code) << isa.index_bits) + index
        if code >= bank.code and 0 <= offset < bank.size:
            return Register(bank.name, offset)
    raise DecodeError(f"source field {field:#05x} names no register")


def _physical(operand: object) -> str:
    """Name of an operand of decoded words, which have registers alone."""
    assert isinstance(operand, Register), operand
    return register_name(operand)


def decode_operation(word: int, slot: int, configuration: str, isa: Isa) -> Operation:
    """Operation of a word in a slot; branch targets and data addresses are in `imm`.

    Raises DecodeError if the word is illegal in this slot, or has bits that an assembler would not
    set.
    """
    fields = {name: field.of(word) for name, field in isa.fields.items()}
    record = isa.by_opcode.get(fields["op"])
    if record is None:
        raise DecodeError(f"opcode {fields['op']:#04x} does not exist")
    build = isa.configurations[configuration]
    unit = isa.units[record.unit]
    if record.name != "nop" and not build.allows(slot, unit):
        raise DecodeError(f"{record.name} cannot be in slot {slot} of '{configuration}'")
    operation = Operation(record.name)
    used = {"op"}
    for name in record.sources:
        register = decode_register(fields[name], isa)
        if register.bank == "B" and build.fma_pipes < 2:
            raise DecodeError(f"configuration '{configuration}' has no bank B")
        if register.bank == "S" and not (build.streams(slot) and register.index == slot):
            raise DecodeError(f"slot {slot} of '{configuration}' has no stream {register.index}")
        setattr(operation, name, ZERO if register == ZERO else register)
        used.add(name)
    if record.writes:
        to_output, index = divmod(fields["dst"], 1 << isa.index_bits)
        if to_output:
            if unit.bank != "C" or index >= isa.outputs:
                raise DecodeError(f"{record.name} cannot write output {index}")
            operation.dst = Output(index)
        else:
            operation.dst = Register(build.result_bank(slot, unit), index)
        used.add("dst")
    if "lane" in record.operands:
        operation.imm = fields["b"]
        operation.lanes_of = slot
        used.add("b")
    if unit.name == "lanes":
        if (operation.imm or 0) > build.lanes or not build.lanes:
            raise DecodeError(f"configuration '{configuration}' has no such lanes")
        assert isinstance(operation.c, Register)
        if record.every:
            operation.lanes_of = slot
            own = (build.result_bank(slot, unit), *(("S",) if record.vector == "a" else ()))
            vector = getattr(operation, record.vector) if record.vector else None
            if isinstance(vector, Register) and vector.bank not in own:
                raise DecodeError(f"operand {record.vector} of {record.name} is no vector")
        elif operation.c.bank not in ("zero", build.result_bank(slot, unit)):
            raise DecodeError(f"{record.name} adds a register of another bank")
        elif "lane" not in record.operands and operation.stream is None:
            raise DecodeError(f"{record.name} takes no word of its stream")
    if "stream" in record.operands and not build.stream_words:
        raise DecodeError(f"configuration '{configuration}' has no streams")
    if "count" in record.operands and not build.loops:
        raise DecodeError(f"configuration '{configuration}' has no loops")
    if record.immediate_high is not None:
        high = fields[record.immediate_high]
        width = isa.fields["c"].width
        if high >> (isa.fields["dst"].width):
            raise DecodeError(f"{record.name} has reserved bits set")
        operation.imm = high << width | fields["c"]
        used |= {record.immediate_high, "c"}
    for name, value in fields.items():
        if name not in used and value:
            raise DecodeError(f"{record.name} has bits set in its unused field {name}")
    return operation


def decode_bundle(word: int, configuration: str, isa: Isa) -> Bundle:
    """Bundle of a word; nop gives an empty slot. Raises DecodeError."""
    slots: list[Operation | None] = []
    for slot in range(len(isa.configurations[configuration].slots)):
        bits = (word >> (slot * isa.word_width)) & ((1 << isa.word_width) - 1)
        operation = decode_operation(bits, slot, configuration, isa)
        slots.append(None if operation.mnemonic == "nop" else operation)
    control = word >> (len(slots) * isa.word_width)
    ends = control >> isa.loop_bit & (1 << isa.configurations[configuration].loops) - 1
    halt = control >> isa.halt_bit & 1
    if reserved := control & ~(halt << isa.halt_bit | ends << isa.loop_bit):
        raise DecodeError(f"control bits {reserved:#04x} are reserved")
    return Bundle(slots, bool(halt), ends)


def operation_text(operation: Operation, isa: Isa, labels: dict[int, str]) -> str:
    """Assembly text of a decoded operation; `labels` names the targets of its branches."""
    record = isa.operations[operation.mnemonic]
    texts = []
    for operand in record.operands:
        if operand == "dst":
            dst = operation.dst
            text = f"o{dst.index}" if isinstance(dst, Output) else _physical(dst)
        elif operand == "target":
            text = labels[operation.imm or 0]
        elif operand == "stream":
            pipe, address = divmod(operation.imm or 0, 1 << STREAM_BITS)
            text = f"{STREAM_PINS[pipe]}+{address}"
        elif operand == "lane":
            text = str(operation.imm)
        elif operand == "count":
            text = str(level_and_rounds(operation)[1])
        elif operand == "address":
            text = str(operation.imm)
            if operation.b != ZERO:
                text += f"[{_physical(operation.b)}]"
        else:
            text = _physical(getattr(operation, operand))
        texts.append(text)
    return f"{operation.mnemonic} {', '.join(texts)}".strip()


def bundle_text(bundle: Bundle, isa: Isa, labels: dict[int, str]) -> str:
    """Assembly text of a bundle."""
    texts = [operation_text(op, isa, labels) for op in bundle.operations]
    return "{ " + (" | ".join(texts) or "nop") + " }" + (" halt" if bundle.halt else "")


def disassemble(image: Image) -> str:
    """Source text that assembles to the same image, source references apart.

    Branch targets without a label get one, `L<address>`. Raises DecodeError naming the bundle that
    is none.
    """
    isa = default_isa()
    rows = _declarations(image)
    labels: dict[int, list[str]] = {}
    for name, address in image.labels.items():
        labels.setdefault(address, []).append(name)
    bundles = []
    for address, word in enumerate(image.bundles):
        try:
            bundles.append(decode_bundle(int(word, 16), image.configuration, isa))
        except DecodeError as error:
            raise DecodeError(f"bundle {address}: {error}") from None
    for operation in (op for bundle in bundles for op in bundle.operations):
        if "target" in isa.operations[operation.mnemonic].operands:
            labels.setdefault(operation.imm or 0, [f"L{operation.imm}"])
    turns = back_edges(bundles)
    first = {address: names[0] for address, names in labels.items()}
    for address, bundle in enumerate(bundles):
        rows += [f"{name}:" for name in labels.get(address, [])]
        rows.append(f"        {bundle_text(bundle, isa, first)}")
        rows += ["        endloop"] * len(turns.get(address, []))
    return "\n".join(rows) + "\n"


def _declarations(image: Image) -> list[str]:
    rows = [f".program {quoted(image.title)}"] if image.title else []
    rows += [f".config {image.configuration}", f".watchdog {image.watchdog}"]
    rows += [f".input {i.name} : {i.type}" for i in image.inputs]
    for c in image.constants:
        value = f"{_bits(c.bits, c.type)} : {c.type}"
        if c.name == literal_name(int(c.bits, 16), c.type):
            rows.append(f".const k{c.index} = {value}")
        else:
            directive = ".param" if c.name in image.parameters else ".const"
            rows.append(f"{directive} {c.name} = {value}, pin k{c.index}")
    rows += [f".output {o.name}, safe = 0f{o.safe}" for o in image.outputs]
    rows += [
        f".state {s.name} : {s.type} = {_bits(s.bits, s.type)}, pin {s.register}"
        for s in image.states
    ]
    rows += [f".export {e.name} = {e.register}" for e in image.exports]
    return rows + _data(image) + _streams(image)


def _data(image: Image) -> list[str]:
    starts = sorted((address, name) for name, address in image.data_names.items())
    rows = []
    if not starts or starts[0][0] > 0:
        starts.insert(0, (0, ""))
    ends = [address for address, _ in starts[1:]] + [len(image.data)]
    for (address, name), end in zip(starts, ends, strict=True):
        for start in range(address, end, WORDS_PER_LINE):
            words = image.data[start : min(start + WORDS_PER_LINE, end)]
            head = f".data {name} : int = " if name and start == address else ".data : int = "
            rows.append(head + ", ".join(f"0x{word}" for word in words))
    return rows


def _streams(image: Image) -> list[str]:
    rows = []
    for entry in image.streams:
        directive = ".vectors" if entry.lanes else ".stream"
        all_words = [
            word for words in zip(entry.words, *entry.lanes, strict=True) for word in words
        ]
        for start in range(0, len(all_words), WORDS_PER_LINE):
            words = all_words[start : start + WORDS_PER_LINE]
            head = f"{directive} {entry.name}, pin {entry.pin} =" if start == 0 else directive
            rows.append(f"{head} {', '.join(f'0f{word}' for word in words)}")
    return rows


def _bits(bits: str, type_name: str) -> str:
    return ("0x" if type_name == "int" else "0f") + bits
