# SPDX-License-Identifier: Apache-2.0
"""The slave information interface: what the configuration EEPROM of the device holds.

Layout: ETG.1000.6 table 16 and 17, ETG.2010; words of 16 bits, little endian. Word 7 has the check
sum of words 0 to 6, a CRC with the polynomial x^8 + x^2 + x + 1 and start value 0xFF.
"""

from __future__ import annotations

import struct

from sim.bus.coe.dictionary import TYPES, Device

BYTES = 2048
STRINGS, GENERAL, FMMU, SYNC_MANAGER, TX_PDO, RX_PDO, CLOCK = 10, 30, 40, 41, 50, 51, 60
END = 0xFFFF
COE_PROTOCOL, FOE_PROTOCOL = 0x0004, 0x0008
FOE_DETAILS = 0x01  # FoE is there
IDENTIFIES = 0x08  # flag of the general category: the AL status code shows the identification value
# CoE details: SDO, SDO information, PDO assignment, PDO configuration, complete access.
COE_DETAILS = 0x01 | 0x02 | 0x04 | 0x08 | 0x20
# Name of an operating mode, its SYNC0 in cycles of the bus, and its activation word.
MODES = (("SM-Synchron", 0, 0), ("DC-Synchron", 1, 0x0300))


def crc8(data: bytes) -> int:
    """Check sum of the configuration area."""
    crc = 0xFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07 if crc & 0x80 else crc << 1) & 0xFF
    return crc


class Strings:
    """The strings of the category; a text's number counts from 1, 0 is no text."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def number(self, text: str) -> int:
        if not text:
            return 0
        if text not in self.texts:
            self.texts.append(text)
        return self.texts.index(text) + 1

    def category(self) -> bytes:
        body = bytes([len(self.texts)])
        for text in self.texts:
            body += bytes([len(text)]) + text.encode()
        return body


def image(device: Device) -> bytes:
    """The whole image, padded with 0xFF."""
    head = device.device
    area = struct.pack("<4H", *head["pdi"]) + bytes(6)  # alias and two reserved words
    area += struct.pack("<H", crc8(area))
    area += struct.pack("<4I", *(head[k] for k in ("vendor", "product", "revision", "serial")))
    area += bytes(8) + 2 * mailboxes(device)  # reserved; bootstrap, standard
    area += struct.pack("<H", COE_PROTOCOL | FOE_PROTOCOL)
    area += bytes(2 * 0x3E - len(area)) + struct.pack("<2H", BYTES * 8 // 1024 - 1, 1)
    strings = Strings()
    strings.number(head["name"])  # masters take the first string for the name
    rest = b"".join(
        [
            category(GENERAL, general(device, strings)),
            category(FMMU, bytes([1, 2, 3, 0])),  # outputs, inputs, mailbox state
            category(SYNC_MANAGER, sync_managers(device)),
            category(TX_PDO, pdos(device, "tx", 3, strings)),
            category(RX_PDO, pdos(device, "rx", 2, strings)),
            category(CLOCK, clock(strings)),
        ]
    )
    whole = area + category(STRINGS, strings.category()) + rest + struct.pack("<H", END)
    if len(whole) > BYTES:
        raise ValueError(f"SII image: {len(whole)} bytes, the EEPROM has {BYTES}")
    return whole.ljust(BYTES, b"\xff")


def mailboxes(device: Device) -> bytes:
    """Start and length of the mailbox from the master, and of that to it; the same in BOOT."""
    mailbox = device.mailbox
    return struct.pack("<4H", mailbox["out"], mailbox["bytes"], mailbox["in"], mailbox["bytes"])


def category(kind: int, body: bytes) -> bytes:
    body += bytes(len(body) % 2)
    return struct.pack("<2H", kind, len(body) // 2) + body


def general(device: Device, strings: Strings) -> bytes:
    head = device.device
    names = [head["group"], "", head["order"], head["name"]]
    return struct.pack(
        "<4B B 6B B h 2B H 14x",
        *(strings.number(name) for name in names),
        0,
        COE_DETAILS,
        *(FOE_DETAILS, 0, 0),  # FoE, EoE, channels of SoE
        head["axes"],  # channels of CiA 402
        0,  # class of sync managers
        IDENTIFIES,  # flags
        0,  # current of the E-bus
        *(0, 0),
        0x0011,  # ports 0 and 1: MII
    )


def managers(device: Device) -> list[tuple[str, int, int, int]]:
    """Name, start, length and control byte of the sync managers 0 to 3."""
    mailbox, process = device.mailbox, device.process_data
    return [
        ("MBoxOut", mailbox["out"], mailbox["bytes"], 0x26),
        ("MBoxIn", mailbox["in"], mailbox["bytes"], 0x22),
        ("Outputs", process["outputs"], device.bytes("rx"), 0x64),
        ("Inputs", process["inputs"], device.bytes("tx"), 0x20),
    ]


def sync_managers(device: Device) -> bytes:
    """Rows: start, length, control, status, enable, type."""
    return b"".join(
        struct.pack("<2H4B", start, length, control, 0, 1, kind)
        for kind, (_, start, length, control) in enumerate(managers(device), start=1)
    )


def pdos(device: Device, direction: str, manager: int, strings: Strings) -> bytes:
    body = b""
    for pdo in device.direction(direction):
        title = strings.number(pdo.name)
        body += struct.pack("<H4BH", pdo.index, len(pdo.entries), manager, 0, title, 0)
        for index, subindex, bits in pdo.entries:
            name, code = "", 0
            if index:
                entry = device.object(index).entry(subindex)
                name, code = entry.name, TYPES[entry.type].code
            body += struct.pack("<H4BH", index, subindex, strings.number(name), code, bits, 0)
    return body


def clock(strings: Strings) -> bytes:
    """Operating modes: with the outputs, and with SYNC0 of the distributed clocks."""
    return b"".join(
        struct.pack("<3IhHh2B4x", 0, 0, 0, 0, activate, factor, strings.number(name), 0)
        for name, factor, activate in MODES
    )
