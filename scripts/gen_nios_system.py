# SPDX-License-Identifier: Apache-2.0
"""Generate what hardware and software of the Nios II systems share.

Sources: nios_sw/system.toml (memory map), rtl/nios/io_regmap.rdl (I/O registers), the interface
record of asip_asm/programs that the map names (words of a tick) and the constants of
sim/robot/float32.py (layout of the parameter block). Outputs: rtl/gen/n2_system_pkg.sv,
nios_sw/include/gen/system.h, tick.h and parameters.h, nios_sw/link/gen/system.ld,
docs/nios_regmap.md, docs/tracking_interface.md. With --check nothing is written; exit 1 if a file
would differ.
"""

from __future__ import annotations

import sys

from asip_asm.command import command
from asip_asm.interface_text import c_struct, markdown
from asip_asm.project import ROOT
from asip_asm.regmap import NUMBER
from scripts.generated import run, sv_header, sv_int, sv_logic, template
from scripts.regmap_source import read_map
from sim.robot.float32 import Constants
from sim.robot.parameters import Robot
from sim.rtl.nios_map import SystemMap, load_system_map

SCRIPT = "scripts/gen_nios_system.py"


def package(system: SystemMap) -> str:
    """rtl/gen/n2_system_pkg.sv."""
    lines = [
        *sv_header(
            SCRIPT, "nios_sw/system.toml", "n2_system_pkg", "memory map of the Nios II systems."
        ),
        sv_logic("RESET_VECTOR", 32, system.reset_vector),
        sv_logic("EXCEPTION_VECTOR", 32, system.exception_vector),
    ]
    for memory in system.memories.values():
        name = memory.name.upper()
        lines += [
            "",
            f"  // {memory.doc}",
            sv_logic(f"{name}_BASE", 32, memory.base),
            sv_int(f"{name}_WORDS", memory.words),
            sv_int(f"{name}_ADDRESS_WIDTH", (memory.words - 1).bit_length(), "of a word address"),
        ]
    lines += [
        "",
        f"  // {system.io.doc}",
        sv_logic("IO_BASE", 32, system.io.base),
        sv_int("IO_ADDRESS_WIDTH", system.io_word_width, "of a word address"),
    ]
    return "\n".join([*lines, "", "endpackage", ""])


def generate() -> dict[str, str]:
    """Text of each generated file by its path. Raises SystemMapError or ParameterError."""
    system = load_system_map()
    interface = system.interface
    values = {
        "script": SCRIPT,
        "system": system,
        "io": read_map(ROOT / "rtl/nios/io_regmap.rdl", "n2_io"),
        "number": NUMBER,
        "block": Constants(Robot.load()).block(),
        "source": interface.file.relative_to(ROOT).as_posix(),
        "input": c_struct(interface, "input", "tick_input"),
        "output": c_struct(interface, "output", "tick_output"),
        "interface": interface,
        "tables": markdown(interface),
    }
    files = {
        "nios_sw/include/gen/system.h": "nios_system.h.j2",
        "nios_sw/include/gen/parameters.h": "nios_parameters.h.j2",
        "nios_sw/include/gen/tick.h": "nios_tick.h.j2",
        "docs/tracking_interface.md": "tracking_interface.md.j2",
        "nios_sw/link/gen/system.ld": "nios_system.ld.j2",
        "docs/nios_regmap.md": "nios_regmap.md.j2",
    }
    texts = {file: template(name).render(values) for file, name in files.items()}
    return {"rtl/gen/n2_system_pkg.sv": package(system), **texts}


@command("scripts/gen_nios_system.py")
def main(arguments: list[str] | None = None) -> int:
    purpose = "Generate what hardware and software of the Nios II systems share."
    return run(SCRIPT, purpose, generate, arguments)


if __name__ == "__main__":
    sys.exit(main())
