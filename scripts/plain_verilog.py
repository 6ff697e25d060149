# SPDX-License-Identifier: Apache-2.0
"""Write each core as one plain Verilog-2001 file, for tools that refuse our SystemVerilog.

    microtick plain                       every core, to build/plain/<top>.v
    microtick plain --only asip n2_core      some of them

Yosys reads the RTL and writes it at word level: no technology mapping, so memories, multipliers and
adders stay inferable. A file holds one module, with the core's ports and its default parameters.
With asip_de3 comes quartus/asip_de3.v, in which the PLL is that of the device.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rich.console import Console

from asip_asm.command import command, script_parser
from scripts.lint_rtl import TOPS
from sim.rtl.plain_verilog import PlainError, write_plain
from sim.rtl.sources import ROOT

FOLDER = ROOT / "build/plain"
CORES = tuple(top.name for top in TOPS)
DE3 = "asip_de3"
PLL = ROOT / "scripts/quartus/altpll.v"


@command("microtick plain")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 written, 1 if Yosys refuses a core."""
    prog = "python -m scripts.plain_verilog"
    parser = script_parser(__doc__, f"{prog} --only asip", prog)
    parser.add_argument("--only", nargs="+", choices=CORES, metavar="MODULE", default=CORES)
    options = parser.parse_args(argv)
    console = Console(soft_wrap=True, highlight=False, markup=False)
    for top in options.only:
        written = [FOLDER / f"{top}.v"]
        try:
            write_plain(top, written[0])
            if top == DE3:
                written.append(FOLDER / f"quartus/{top}.v")
                write_plain(top, written[1], defines=["QUARTUS"], boxes=[PLL])
        except PlainError as error:
            console.print(f"error: {error}")
            return 1
        for file in written:
            console.print(f"{file.relative_to(ROOT)}: {len(file.read_text().splitlines())} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
