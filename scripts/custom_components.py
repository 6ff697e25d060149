# SPDX-License-Identifier: Apache-2.0
"""Components of custom instructions for Platform Designer: a script each, ports as in the RTL."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from scripts.generated import template
from sim.rtl.custom_table import ROOT, TYPES, Component, CustomError, Platform
from sim.rtl.sources import sources_of

RTL = ROOT / "rtl"
# Roles of the vendor's interface: width, direction; None: 1..8 bits.
ROLES: dict[str, tuple[int | None, str]] = {
    **{name: (1, "Input") for name in ("clk", "reset", "clk_en", "start")},
    **{name: (32, "Input") for name in ("dataa", "datab")},
    "n": (None, "Input"),
    **{name: (1, "Input") for name in ("readra", "readrb", "writerc")},
    **{name: (5, "Input") for name in ("a", "b", "c")},
    "done": (1, "Output"),
    "result": (32, "Output"),
}
CLOCKED = {"clk", "reset", "clk_en"}


def ports_of(component: Component, rtl: Path = RTL) -> dict[str, tuple[str, int, str]]:
    """Ports of the component's module: name -> (role, width, direction). Raises CustomError.

    A port is named by its role and _i or _o. Roles and widths are those of the vendor's interface.
    """
    path = rtl / "custom" / f"{component.name}.sv"
    if not path.is_file():
        raise CustomError(f"{path}:1:1: error: {component.name}: no such module; write it first")
    ports: dict[str, tuple[str, int, str]] = {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        found = re.match(
            r"\s*(input|output)\s+logic\s*(?:\[(\d+):0\])?\s*(\w+)_([io])\s*(,|$|//)", line
        )
        if not found:
            continue
        role, width = found[3], int(found[2] or 0) + 1
        direction = found[1].capitalize()
        wanted = ROLES.get(role)
        if wanted is None or wanted[1] != direction or found[4] != found[1][0]:
            raise CustomError(f"{path}:{number}:1: error: port {role}_{found[4]} has no role")
        needed = wanted[0] or component.bits
        if width != needed:
            raise CustomError(f"{path}:{number}:1: error: {role} has {width} bits, not {needed}")
        ports[f"{role}_{found[4]}"] = (role, width, direction)
    roles = {role for role, _, _ in ports.values()}
    must = {"result"} | ({"n"} if component.bits else set())
    must |= CLOCKED if component.type != "combinational" else set()
    must |= {"start", "done"} if component.type == "variable" else set()
    for role in sorted(must - roles):
        raise CustomError(f"{path}:1:1: error: a {component.type} component needs a port {role}")
    if component.type != "variable" and "done" in roles:
        raise CustomError(f"{path}:1:1: error: a {component.type} component has no done")
    return ports


def hardware_script(component: Component, cycles: int) -> str:
    """Text of <component>_hw.tcl; `cycles` is the fixed number, 1 for the other types."""
    ports = ports_of(component)
    properties = {
        "clockCycle": cycles,
        "clockCycleType": TYPES[component.type],
        "operands": sum(role in ("dataa", "datab") for role, _, _ in ports.values()),
        "opcodeExtensionLocked": "true",
        "opcodeExtensionLockedValue": f"{component.base:#04x}",
    }
    return template("component_hw.tcl.j2").render(
        name=component.name,
        doc=component.doc,
        sources=[path.relative_to(ROOT) for path in sources_of(component.name)],
        properties=properties,
        ports=ports,
    )


def hardware_scripts(platforms: Mapping[str, Platform]) -> dict[str, str]:
    """Every component's script by its path below the repository."""
    scripts = {}
    for platform in platforms.values():
        for part in platform.components.values():
            mine = [i for i in platform.instructions.values() if i.component == part.name]
            cycles = mine[0].cycles if part.type == "multicycle" else 1
            name = f"scripts/platform_designer/{part.name}_hw.tcl"
            scripts[name] = hardware_script(part, cycles)
    return scripts
