# SPDX-License-Identifier: Apache-2.0
"""A firmware file for the device on the bus, as its FoE server takes it.

    python -m sim.bus.coe.firmware program.bin firmware.mtfw

The file: magic, product code, bytes and CRC-32 of the content, then the content
(nios_sw/ethercat/image.h). A master sends it in BOOT under the name `firmware`.
"""

from __future__ import annotations

import argparse
import struct
import sys
import zlib
from collections.abc import Sequence
from pathlib import Path

from asip_asm.command import command
from sim.bus.coe.dictionary import load

NAME = "firmware"
MAGIC = b"MTFW"


def firmware(content: bytes, product: int) -> bytes:
    """The file with this content for devices of this product code (1018:02)."""
    return struct.pack("<4s3I", MAGIC, product, len(content), zlib.crc32(content)) + content


@command("python -m sim.bus.coe.firmware")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 when the file is written."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("content", type=Path, help="what the device's boot loader takes")
    parser.add_argument("file", type=Path, help="file to write")
    arguments = parser.parse_args(argv)
    content = arguments.content.read_bytes()
    arguments.file.write_bytes(firmware(content, load().device["product"]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
