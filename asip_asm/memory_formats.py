# SPDX-License-Identifier: Apache-2.0
"""Program memory of an image for other tools: $readmemh, Intel HEX, memory initialization file."""

from __future__ import annotations

from asip_asm.image import Image

HEX_RECORD_BYTES = 16


def to_readmemh(image: Image) -> str:
    """Program for $readmemh: one bundle per line."""
    return "".join(f"{bundle}\n" for bundle in image.bundles)


def to_intel_hex(image: Image) -> str:
    """Program in Intel HEX: byte address 4 * word address, little endian words."""
    blocks: list[tuple[int, bytearray]] = []
    for address, word in image.words():
        if not blocks or blocks[-1][0] + len(blocks[-1][1]) != 4 * address:
            blocks.append((4 * address, bytearray()))
        elif len(blocks[-1][1]) == HEX_RECORD_BYTES:
            blocks.append((4 * address, bytearray()))
        blocks[-1][1].extend(word.to_bytes(4, "little"))
    rows = [_hex_record(address, 0, bytes(data)) for address, data in blocks]
    return "\n".join([*rows, _hex_record(0, 1, b"")]) + "\n"


def _hex_record(address: int, kind: int, data: bytes) -> str:
    record = bytes([len(data), address >> 8, address & 0xFF, kind]) + data
    return f":{record.hex().upper()}{-sum(record) & 0xFF:02X}"


def to_mif(image: Image) -> str:
    """Program as a memory initialization file: one bundle per address."""
    width = 4 * len(image.bundles[0])
    rows = [
        f"WIDTH={width};",
        f"DEPTH={len(image.bundles)};",
        "ADDRESS_RADIX=HEX;",
        "DATA_RADIX=HEX;",
        "CONTENT BEGIN",
        *(f"  {i:x} : {bundle};" for i, bundle in enumerate(image.bundles)),
        "END;",
    ]
    return "\n".join(rows) + "\n"
