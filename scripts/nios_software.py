# SPDX-License-Identifier: Apache-2.0
"""Build the programs of the Nios II systems, their committed images and docs/own_c_program.md.

Needs the cross compiler: `make tools T=nios-toolchain` builds it once.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence

from asip_asm.command import command, script_parser
from asip_asm.project import ROOT

STEPS = (
    ("make", "--no-print-directory", "-C", "nios_sw", "all", "images"),
    (sys.executable, "-m", "tests.model_compiler.law_image"),
    (sys.executable, "scripts/own_c_page.py"),
)


@command("scripts/nios_software.py")
def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; exit status of the first step that fails, else 0."""
    prog = "python scripts/nios_software.py"
    script_parser(__doc__, prog, prog).parse_args(arguments)
    return next(
        (status for step in STEPS if (status := subprocess.run(step, cwd=ROOT).returncode)), 0
    )


if __name__ == "__main__":
    sys.exit(main())
