# SPDX-License-Identifier: Apache-2.0
"""The program for FPGA2 by which tests run a law's C without the cross compiler.

`python -m tests.model_compiler.law_image`, which `microtick nios-sw` calls, builds it.
"""

from __future__ import annotations

import sys
from pathlib import Path

from asip_asm.command import command
from asip_asm.model.compiler import compile_law
from asip_asm.project import BUILD
from sim.bench.platforms.nios import build_elf
from sim.laws.native.law import CompilerError
from tests.model_compiler.laws import sample

IMAGE = Path(__file__).with_name("law_fpga2.elf")
ROWS = 100


@command("python -m tests.model_compiler.law_image")
def main() -> int:
    """Build the image; returns the exit status."""
    try:
        elf = build_elf(compile_law(sample()), BUILD / "nios_sw/law", ROWS)
    except CompilerError as error:
        print(error, file=sys.stderr)
        return 1
    IMAGE.write_bytes(elf.read_bytes())
    return 0


if __name__ == "__main__":
    sys.exit(main())
