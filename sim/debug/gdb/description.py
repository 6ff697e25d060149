# SPDX-License-Identifier: Apache-2.0
"""What GDB reads of a Nios II system: registers (target.xml) and memory map.

Names and order of the feature org.gnu.gdb.nios2.cpu are those of gdb/features/nios2-cpu.xml.
Those of the custom instructions come from nios_sw/custom.toml.
"""

from __future__ import annotations

import tomllib
from functools import cache

from asip_asm.project import ROOT
from sim.rtl.nios_map import SystemMap

GENERAL = ["zero", "at", *(f"r{n}" for n in range(2, 24))]
GENERAL += ["et", "bt", "gp", "sp", "fp", "ea", "sstatus", "ra"]
PC = len(GENERAL)
CONTROL = ["status", "estatus", "bstatus", "ienable", "ipending", "cpuid", "ctl6", "exception"]
CONTROL += ["pteaddr", "tlbacc", "tlbmisc", "eccinj", "badaddr", "config", "mpubase", "mpuacc"]
CPU = [*GENERAL, "pc", *CONTROL]
FIRST_CONTROL, FIRST_CUSTOM = PC + 1, len(CPU)
BOUNDS = 32  # pairs of ci_fsat
TYPES = {"gp": "data_ptr", "sp": "data_ptr", "fp": "data_ptr"}
TYPES |= {"ea": "code_ptr", "ra": "code_ptr", "pc": "code_ptr"}


@cache
def saturation() -> dict[str, int]:
    """Numbers n of the instructions that reach the bounds of ci_fsat: `set`, `low`, `high`."""
    table = tomllib.loads((ROOT / "nios_sw/custom.toml").read_text(encoding="utf-8"))
    records = table["fpga2"]["instructions"]
    return {name: records[f"fsat_{name}"]["n"] for name in ("set", "low", "high")}


def custom_registers(system: str) -> list[str]:
    """Internal registers of the custom instructions of a system."""
    if system != "fpga2":
        return []
    return [f"fsat{n}_{bound}" for n in range(BOUNDS) for bound in ("low", "high")]


def target_xml(system: str) -> str:
    """Target description of 'fpga1' or 'fpga2'."""
    cpu = "".join(
        f'<reg name="{name}" bitsize="32" type="{TYPES.get(name, "uint32")}"/>' for name in CPU
    )
    custom = "".join(
        f'<reg name="{name}" bitsize="32" type="ieee_single" group="custom" save-restore="no"/>'
        for name in custom_registers(system)
    )
    features = f'<feature name="org.gnu.gdb.nios2.cpu">{cpu}</feature>'
    if custom:
        features += f'<feature name="microtick.{system}.custom">{custom}</feature>'
    return (
        '<?xml version="1.0"?><!DOCTYPE target SYSTEM "gdb-target.dtd">'
        f"<target><architecture>nios2</architecture>{features}</target>"
    )


def memory_map(system: SystemMap) -> str:
    """Memories and I/O; GDB touches nothing else."""
    ranges = [(memory.base, 4 * memory.words) for memory in system.memories.values()]
    ranges.append((system.io.base, system.io.bytes))
    rows = "".join(f'<memory type="ram" start="{b:#x}" length="{n:#x}"/>' for b, n in ranges)
    return (
        '<?xml version="1.0"?><!DOCTYPE memory-map PUBLIC "+//IDN gnu.org//DTD GDB Memory Map V1.0'
        f'//EN" "http://sourceware.org/gdb/gdb-memory-map.dtd"><memory-map>{rows}</memory-map>'
    )
