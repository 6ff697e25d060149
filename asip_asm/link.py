# SPDX-License-Identifier: Apache-2.0
"""Several programs in one image, each a function with its own entry.

The functions keep their schedules and so their cycles. Own to each: inputs, parameters, outputs,
data words, streams, and the registers of states and exports, which no other function writes.
Shared: constants of equal bits, and the registers that hold values within a run; runs do not
overlap.
Names in the image are `function.name`, `Image.function` is one function with its own names.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import msgspec

from asip_asm.debug_map import DebugMap, Span, Write
from asip_asm.disassemble import decode_bundle
from asip_asm.encode import encode_bundle
from asip_asm.expression import literal_name
from asip_asm.image import (
    ConstantEntry,
    ExportEntry,
    FunctionEntry,
    Image,
    InputEntry,
    Name,
    StateEntry,
)
from asip_asm.ir import Bundle, Operation, Output, Register, register_name
from asip_asm.isa import STREAM_BITS, STREAM_PINS, Isa, default_isa
from asip_asm.source import physical_register


class LinkError(ValueError):
    """The programs do not fit into one image; the text says what is short, and the cure."""


@dataclass
class _Places:
    """Where the registers, outputs, data and bundles of one program go."""

    registers: dict[Register, Register] = field(default_factory=dict)
    first_output: int = 0
    first_data: int = 0
    first_bundle: int = 0
    first_stream: dict[str, int] = field(default_factory=dict)

    def moved(self, name: str) -> Register:
        """Where the register of this name goes."""
        register = physical_register(name)
        if register is None:
            raise LinkError(f"{name} is no register")
        return self.registers[register]


def link(title: str, programs: Mapping[str, Image]) -> Image:
    """One image of programs by name of their function, in order; the first is where it starts.

    Raises LinkError, DecodeError for a program that holds words which are no bundles.
    """
    isa = default_isa()
    images = list(programs.values())
    decoded, places = _placed(programs, isa)
    constants, inputs, parameters = _bank_k(places, programs, isa)
    result = Image(
        title=title,
        configuration=images[0].configuration,
        bundles=[],
        sources=[source for image in images for source in image.sources],
        constants=constants,
        inputs=inputs,
        data=[word for image in images for word in image.data],
        streams=[
            msgspec.structs.replace(
                entry,
                name=f"{name}.{entry.name}",
                address=entry.address + place.first_stream[entry.pin],
            )
            for (name, image), place in zip(programs.items(), places, strict=True)
            for entry in image.streams
        ],
        parameters=parameters,
    )
    digits = isa.bundle_width(result.configuration) // 4
    for (name, image), place, bundles in zip(programs.items(), places, decoded, strict=True):
        for bundle in bundles:
            moved, labels = _moved(bundle, place, isa)
            result.bundles.append(f"{encode_bundle(moved, isa, labels):0{digits}x}")
        _add_signals(result, name, image, place)
    first = result.functions[0]
    result.entry, result.watchdog = first.entry, first.watchdog
    result.output_mask = first.output_mask
    result.check(title)
    return result


def link_maps(
    image: Image, programs: Mapping[str, Image], maps: Mapping[str, DebugMap]
) -> dict[str, DebugMap]:
    """By function, the debug map of `image.function(name)`: values, bundles and registers of that
    function alone. `image` is what `link` made of `programs`, `maps` are theirs.
    """
    places = _placed(programs, default_isa())[1]
    return {
        name: _moved_map(maps[name], image.function(name), place)
        for name, place in zip(programs, places, strict=True)
    }


def _moved_map(old: DebugMap, image: Image, place: _Places) -> DebugMap:
    first, own, total = place.first_bundle, old.bundles, len(image.bundles)
    rest = total - first - own

    def position(number: int) -> int:
        """The end of the run is the position after the last bundle of the image."""
        return total if number == own else number + first

    def spans(held: list[Span]) -> list[Span]:
        if first + own == total:
            return [(begin + first, end + first) for begin, end in held]
        inside = [(a + first, min(b, own - 1) + first) for a, b in held if a < own]
        return inside + [(total, total) for _, b in held if b == own]

    def location(text: str) -> str:
        if text[0] == "o":
            return f"o{int(text[1:]) + place.first_output}"
        return register_name(place.moved(text))

    values = [
        msgspec.structs.replace(
            value,
            place=location(value.place),
            writes=[Write(w.bundle + first, w.slot, position(w.lands)) for w in value.writes],
            held=spans(value.held),
            perhaps=spans(value.perhaps),
            spilled=value.spilled
            and (value.spilled[0] + first, value.spilled[1] + place.first_data),
        )
        for value in old.values
    ]
    follow = old.follow | {str(own - 1): old.following(own - 1)}
    calls = [(*key.partition(".")[::2], texts) for key, texts in old.calls.items()]
    return DebugMap(
        image=image.to_json()["checksum"],
        bundles=total,
        files=old.files,
        cycles=[0] * first + old.cycles + [0] * rest,
        follow={str(int(at) + first): [position(n) for n in to] for at, to in follow.items()},
        calls={f"{int(bundle) + first}.{slot}": texts for bundle, slot, texts in calls},
        values=values,
    )


def _placed(programs: Mapping[str, Image], isa: Isa) -> tuple[list[list[Bundle]], list[_Places]]:
    """Bundles of the programs, and where their outputs, data, bundles and registers go, those of
    bank K left out.
    """
    _check(programs)
    images = programs.values()
    decoded = [[decode_bundle(int(w, 16), i.configuration, isa) for w in i.bundles] for i in images]
    places = [_Places() for _ in images]
    _add_up(places, programs, isa)
    _own_registers(places, programs, decoded, isa)
    return decoded, places


def _check(programs: Mapping[str, Image]) -> None:
    if len({image.configuration for image in programs.values()}) != 1:
        raise LinkError("the functions are for different configurations; compile them for one")
    for name, image in programs.items():
        if not name.isidentifier() or not name.isascii():
            raise LinkError(f"'{name}' cannot name a function; letters, digits and _ can")
        if image.functions:
            raise LinkError(f"{name} holds functions already; link their programs")


def _add_up(places: list[_Places], programs: Mapping[str, Image], isa: Isa) -> None:
    """Outputs, data words and bundles, one program after the other."""
    sizes = {
        "outputs": ([len(i.outputs) for i in programs.values()], isa.outputs),
        "data words": ([len(i.data) for i in programs.values()], isa.data_words),
        "bundles": ([len(i.bundles) for i in programs.values()], isa.program_bundles),
    }
    configuration = next(iter(programs.values())).configuration
    room_of_streams = isa.configurations[configuration].stream_words
    for pin in STREAM_PINS:
        counts = [len(i.stream(pin)) for i in programs.values()]
        sizes[f"words in the stream of pipe {pin}"] = counts, room_of_streams
        for place, end, count in zip(places, itertools.accumulate(counts), counts, strict=True):
            place.first_stream[pin] = end - count
    for what, (counts, room) in sizes.items():
        if sum(counts) > room:
            parts = ", ".join(f"{n} {k}" for n, k in zip(programs, counts, strict=True))
            cure = "export what no drive takes" if what == "outputs" else "split them on two cores"
            raise LinkError(f"{sum(counts)} {what} ({parts}), the core has {room}; {cure}")
    first = [0, 0, 0]
    for place, image in zip(places, programs.values(), strict=True):
        place.first_output, place.first_data, place.first_bundle = first
        taken = len(image.outputs), len(image.data), len(image.bundles)
        first = [begin + count for begin, count in zip(first, taken, strict=True)]


def _own_registers(
    places: list[_Places],
    programs: Mapping[str, Image],
    decoded: Sequence[Sequence[Bundle]],
    isa: Isa,
) -> None:
    """Registers of states and exports from the top of each bank down, the others from 0 up."""
    for bank in "ABC":
        top = isa.banks[bank].size
        kept: list[set[Register]] = []
        for image in programs.values():
            entries: list[StateEntry | ExportEntry] = [*image.states, *image.exports]
            named = [physical_register(entry.register) for entry in entries]
            kept.append({r for r in named if r is not None and r.bank == bank})
        total = sum(map(len, kept))
        for place, name, bundles, own in zip(places, programs, decoded, kept, strict=True):
            for register in sorted(own, key=lambda r: r.index):
                top -= 1
                place.registers[register] = Register(bank, top)
            rest = sorted(_used(bundles, bank) - own, key=lambda r: r.index)
            if len(rest) + total > isa.banks[bank].size:
                raise LinkError(
                    f"{name} uses {len(rest)} registers of bank {bank} within a run, states and "
                    f"exports of all functions {total}; the bank has {isa.banks[bank].size}: "
                    "export less"
                )
            place.registers |= {r: Register(bank, i) for i, r in enumerate(rest)}


def _used(bundles: Sequence[Bundle], bank: str) -> set[Register]:
    found = set()
    for operation in (op for bundle in bundles for op in bundle.operations):
        for register in (operation.a, operation.b, operation.c, operation.dst):
            if isinstance(register, Register) and register.bank == bank:
                found.add(register)
    return found


def _bank_k(places: list[_Places], programs: Mapping[str, Image], isa: Isa):
    """Constants, inputs and parameters of the image; fills in where their words go."""
    constants: list[ConstantEntry] = []
    inputs: list[tuple[InputEntry, str, int]] = []
    parameters: list[str] = []
    shared: dict[str, int] = {}
    words = 0
    for place, (name, image) in zip(places, programs.items(), strict=True):
        for entry in image.inputs:
            place.registers[Register("K", entry.index)] = Register("K", words)
            inputs.append((entry, name, words))
            words += 1
        own = {c.index for c in image.constants if c.name in image.parameters}
        for constant in image.constants:
            old = Register("K", constant.index)
            if old not in place.registers:
                key = f"{name}.{old.index}" if old.index in own else constant.bits
                if key not in shared:
                    shared[key] = words
                    words += 1
                place.registers[old] = Register("K", shared[key])
            index = place.registers[old].index
            value = literal_name(int(constant.bits, 16), constant.type)
            if constant.name == value:
                if all(c.index != index for c in constants):
                    constants.append(msgspec.structs.replace(constant, index=index))
                continue
            if constant.name in image.parameters:
                parameters.append(f"{name}.{constant.name}")
            constants.append(
                msgspec.structs.replace(constant, name=f"{name}.{constant.name}", index=index)
            )
    if words > isa.banks["K"].size:
        raise LinkError(
            f"{len(inputs)} inputs and {words - len(inputs)} constants and parameters of "
            f"{len(programs)} functions, bank K holds {isa.banks['K'].size}; keep fewer constants "
            "there: a `.data` word and `ld`, asip-model does so with --constants"
        )
    named = [
        msgspec.structs.replace(entry, name=f"{name}.{entry.name}", index=index)
        for entry, name, index in inputs
    ]
    return sorted(constants, key=lambda c: c.index), named, parameters


def _moved(bundle: Bundle, place: _Places, isa: Isa) -> tuple[Bundle, dict[str, int]]:
    """The bundle at its new places; addresses of the targets of its branches."""
    labels: dict[str, int] = {}
    slots: list[Operation | None] = []
    for old in bundle.slots:
        if old is None:
            slots.append(None)
            continue
        record = isa.operations[old.mnemonic]
        new = Operation(old.mnemonic, imm=old.imm)
        for name in record.sources:
            source = getattr(old, name)
            setattr(new, name, place.registers.get(source, source))
        if isinstance(old.dst, Output):
            new.dst = Output(old.dst.index + place.first_output)
        elif isinstance(old.dst, Register):
            new.dst = place.registers[old.dst]
        if "target" in record.operands:
            new.target = f"L{old.imm}"
            labels[new.target] = (old.imm or 0) + place.first_bundle
        elif "stream" in record.operands:
            pipe = (old.imm or 0) >> STREAM_BITS
            new.imm = (old.imm or 0) + place.first_stream[STREAM_PINS[pipe]]
        elif "address" in record.operands:
            new.imm = (old.imm or 0) + place.first_data
        slots.append(new)
    return Bundle(slots, bundle.halt, bundle.ends), labels


def _add_signals(result: Image, name: str, image: Image, place: _Places) -> None:
    """What the image says of one function."""

    def qualified(text: str) -> Name:
        return f"{name}.{text}"

    def moved(register: str) -> str:
        return register_name(place.moved(register))

    replace = msgspec.structs.replace
    order = {output.index: i for i, output in enumerate(image.outputs)}
    if any(index != i for index, i in order.items()):
        raise LinkError(f"{name}: its outputs are not numbered in order")
    result.outputs += [
        replace(o, name=qualified(o.name), index=o.index + place.first_output)
        for o in image.outputs
    ]
    result.states += [
        replace(s, name=qualified(s.name), register=moved(s.register)) for s in image.states
    ]
    result.exports += [
        replace(e, name=qualified(e.name), register=moved(e.register)) for e in image.exports
    ]
    for old, new, first in (
        (image.data_names, result.data_names, place.first_data),
        (image.labels, result.labels, place.first_bundle),
    ):
        new.update({qualified(text): address + first for text, address in old.items()})
    result.labels[name] = image.entry + place.first_bundle
    result.functions.append(
        FunctionEntry(
            name,
            image.entry + place.first_bundle,
            image.watchdog,
            image.output_mask << place.first_output,
            image.cycles,
        )
    )
