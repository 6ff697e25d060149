# SPDX-License-Identifier: Apache-2.0
"""Where things are on the bus of the ASIP, and the writes that load a program."""

from __future__ import annotations

from collections.abc import Iterator

from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image
from asip_asm.isa import STREAM_BITS, STREAM_PINS, default_isa

CSR = {name: REGMAP.address(name) for name in REGMAP.registers}
BLOCK = {name: block.base for name, block in REGMAP.blocks.items()}
STATUS = REGMAP.registers["STATUS"].fields
START = REGMAP.registers["CONTROL"].word(start=1)
CLEAR = REGMAP.registers["CONTROL"].word(clear=1)
IRQ_DONE = REGMAP.registers["IRQ_ENABLE"].word(done=1)
IRQ_FAULT = REGMAP.registers["IRQ_ENABLE"].word(fault=1)
IRQ_ALL = IRQ_DONE | IRQ_FAULT
FAULT_NAMES = {fault.code: fault.name for fault in REGMAP.faults.values()}
# Words of the banks that a host addresses by name.
PLACES = {"a": 64, "b": 64, "c": 64, "k": 128, "o": 32}


class AsipError(RuntimeError):
    """A core cannot do what was requested, or stopped unexpectedly; the text states the cure."""


class LinkError(AsipError):
    """Nothing answers, or the link is gone; the text names the place and the cure."""


def register_address(name: str) -> int:
    """Bus address of a physical register such as 'c12' (banks A, B, C)."""
    bank, index = name[0].upper(), int(name[1:])
    return BLOCK["registers"] + 64 * default_isa().banks[bank].code + index


def place_address(name: str) -> int:
    """Bus address of a register ('a3'), an output ('o2') or a word of bank K ('k5').

    Raises ValueError.
    """
    letter, digits = name[:1].lower(), name[1:]
    if letter not in PLACES or not digits.isdecimal() or int(digits) >= PLACES[letter]:
        raise ValueError(f"'{name}' is no register: a0..a63, b, c, k0..k127, o0..o31")
    if letter == "k":
        return BLOCK["constants"] + int(digits)
    if letter == "o":
        return BLOCK["outputs"] + int(digits)
    return register_address(name.lower())


def load_words(image: Image) -> Iterator[tuple[int, int]]:
    """Writes (address, word) that load a program as a driver would, states at their initial
    values, both interrupts enabled. A fault is to be cleared before."""
    for offset, word in image.words():
        yield BLOCK["program"] + offset, word
    for constant in image.constants:
        yield BLOCK["constants"] + constant.index, int(constant.bits, 16)
    for address, bits in enumerate(image.data):
        yield BLOCK["data"] + address, int(bits, 16)
    for pipe, pin in enumerate(STREAM_PINS):
        vectors = any(block.lanes for block in image.streams if block.pin == pin)
        lanes = default_isa().configurations[image.configuration].lanes if vectors else 0
        for lane in range(1 + lanes):
            first = (lane << 1 | pipe) << STREAM_BITS
            for address, word in enumerate(image.stream(pin, lane)):
                page, offset = divmod(first + address, REGMAP.blocks["streams"].words)
                if not offset:
                    yield CSR["STREAM"], REGMAP.registers["STREAM"].word(page=page)
                yield BLOCK["streams"] + offset, word
    for output in image.outputs:
        yield BLOCK["safe"] + output.index, int(output.safe, 16)
    for state in image.states:
        yield register_address(state.register), int(state.bits, 16)
    yield from run_words(image)
    yield CSR["IRQ_ENABLE"], IRQ_ALL


def run_words(image: Image) -> Iterator[tuple[int, int]]:
    """Writes that state which program the next run is."""
    yield CSR["ENTRY"], image.entry
    yield CSR["WATCHDOG"], image.watchdog
    yield CSR["OUTPUT_MASK"], image.output_mask
