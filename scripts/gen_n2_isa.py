# SPDX-License-Identifier: Apache-2.0
"""Generate rtl/gen/n2_isa_pkg.sv from nios_sw/isa.toml; --check refuses a stale one."""

from __future__ import annotations

import sys
from pathlib import Path

from scripts.generated import commented, run, sv_header
from sim.rtl.n2_lockstep_isa import ISA_FILE, OP_R, Isa, load_isa

SCRIPT = "scripts/gen_n2_isa.py"


def constant(name: str, width: int, value: int, doc: str = "") -> str:
    return commented(f"  localparam logic [{width - 1}:0] {name} = {width}'d{value};", doc)


def isa_package(isa: Isa) -> str:
    """Text of the SystemVerilog package."""
    purpose = "opcodes, control registers, exception causes and registers of Nios II R1."
    lines = [
        *sv_header(SCRIPT, "nios_sw/isa.toml", "n2_isa_pkg", purpose),
        "  // Bits 5:0 of the instruction word.",
        constant("OP_R", 6, OP_R, "bits 16:11 decide"),
    ]
    rows = isa.instructions.values()
    lines += [constant(f"OP_{i.name.upper()}", 6, i.op, i.doc) for i in rows if i.opx is None]
    lines += ["", "  // Bits 16:11 of an R-format word."]
    lines += [constant(f"OPX_{i.name.upper()}", 6, i.opx, i.doc) for i in rows if i.opx is not None]
    for title, prefix, table in (
        ("Control registers.", "CTL", isa.control),
        ("Causes, exception[6:2].", "CAUSE", isa.cause),
        ("Registers.", "REG", isa.register),
    ):
        lines += ["", f"  // {title}"]
        lines += [constant(f"{prefix}_{name.upper()}", 5, code) for name, code in table.items()]
    return "\n".join([*lines, "", "endpackage", ""])


def generate(source: Path) -> dict[str, str]:
    """Text of the package by its path. Raises N2IsaError, OSError."""
    return {"rtl/gen/n2_isa_pkg.sv": isa_package(load_isa(source))}


if __name__ == "__main__":
    purpose = "Generate the Nios II instruction package from nios_sw/isa.toml."
    option = ("--isa", ISA_FILE, "the instruction set")
    sys.exit(run(SCRIPT, purpose, generate, source=option))
