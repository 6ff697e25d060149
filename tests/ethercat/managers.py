# SPDX-License-Identifier: Apache-2.0
"""Sync managers as a master sets them up: control bytes, and the bytes of the registers."""

from sim.bus.gen.esc_regmap import SM_ACTIVATE, SM_CONTROL, SM_LENGTH, SM_PDI, SM_START

BOX_OUT = SM_CONTROL.word(mode=2, direction=1, pdi_event=1)  # a mailbox that the master writes
BOX_IN = SM_CONTROL.word(mode=2, pdi_event=1)
OUTPUTS = SM_CONTROL.word(direction=1, pdi_event=1, watchdog=1)
UNWATCHED = SM_CONTROL.word(direction=1, pdi_event=1)  # outputs without watchdog
INPUTS = SM_CONTROL.word(pdi_event=1)
WATCHED_INPUTS = SM_CONTROL.word(pdi_event=1, watchdog=1)


def registers(start: int, length: int, control: int, enable: int = 1) -> bytes:
    """Bytes from SM_START of a manager on, for an area of `length` bytes from `start` on."""
    values = (
        (SM_START, start),
        (SM_LENGTH, length),
        (SM_CONTROL, control),
        (SM_ACTIVATE, SM_ACTIVATE.word(enable=enable)),
    )
    block = bytearray(SM_PDI.address + SM_PDI.width - SM_START.address)
    for register, value in values:
        at = register.address - SM_START.address
        block[at : at + register.width] = value.to_bytes(register.width, "little")
    return bytes(block)
