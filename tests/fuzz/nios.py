# SPDX-License-Identifier: Apache-2.0
"""Campaigns of nios-run: damaged ELF files and mutated command lines."""

from __future__ import annotations

from pathlib import Path
from random import Random

from sim.debug import nios_run
from sim.rtl.nios_image import IMAGES
from sim.rtl.nios_rtl import NiosRtl
from tests.fuzz.engine import Campaign
from tests.fuzz.mutate import files_of_every_kind, mutated_arguments

HEADERS = 52 + 8 * 32  # bytes: ELF header and program headers
WORDS = (0, 1, 4, 16, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x10000000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
OPTIONS = "--system fpga1 fpga2 fpga3 --profile --max-cycles 0 1 1000 -5 1e6 x.elf folder zero pipe"
# ELF files to damage, the smallest and the largest.
PROGRAMS = [(IMAGES / "tests" / name).read_bytes() for name in ("sieve.elf", "float_sqrt.elf")]


def damaged(rng: Random, data: bytes) -> bytes:
    """The file after 1 to 4 edits, mostly of headers and of the tables at its end."""
    content = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 4))):
        places = (rng.randrange(HEADERS), rng.randrange(len(content)), -1 - rng.randrange(600))
        at = max(-len(content), rng.choice(places)) % len(content)
        kind = rng.randrange(4)
        if kind == 0:
            content[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            content[at & ~3 : (at & ~3) + 4] = rng.choice(WORDS).to_bytes(4, "little")
        elif kind == 2:
            content[at : at + 8] = rng.randbytes(8)
        elif len(content) > HEADERS:
            del content[at:]
            content = content or bytearray(b"\0")
    return bytes(content)


def elf(rng: Random) -> int:
    """One damaged file: refused, or run for a while."""
    Path("x.elf").write_bytes(damaged(rng, rng.choice(PROGRAMS)))
    status = nios_run.main(["--max-cycles", "2000", "x.elf"])
    return 1 if status == nios_run.FILE_STATUS else 0


def command_line(rng: Random) -> int:
    """One mutated command line next to files of every kind."""
    Path("x.elf").write_bytes(PROGRAMS[0])
    files_of_every_kind()
    line = "--system fpga2 --max-cycles 2000 x.elf".split()
    status = nios_run.main(mutated_arguments(rng, line, OPTIONS.split()))
    return 1 if status == nios_run.FILE_STATUS else 0


def prepare() -> None:
    """Models, once for all cases."""
    for system in ("fpga1", "fpga2"):
        NiosRtl(system)


CAMPAIGNS = (
    Campaign("elf", 20_000, elf, prepare),
    Campaign("nios-run", 5_000, command_line, prepare),
)
