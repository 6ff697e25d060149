# SPDX-License-Identifier: Apache-2.0
"""Put ports, latencies, evidence and synthesis figures of the arithmetic units into docs/units.md.

The prose is written by hand; the blocks between `<!-- begin NAME -->` and `<!-- end NAME -->`
come from the RTL (headers, ports, parameters, fp_pkg), the bench's table of operations, the table
of proofs in docs/formal.md and docs/data/units_synthesis.json. `--check` refuses a page whose
blocks differ. `--measure UNIT ...` synthesises units with scripts/synth_unit.py and stores their
area and Fmax with a hash of the sources, so that figures of an earlier version show as such.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from asip_asm.command import command, script_parser
from asip_asm.files import write_text
from asip_asm.isa import default_isa
from asip_asm.machine import fp_latencies
from asip_asm.project import ROOT
from scripts.generated import keep_page, table
from scripts.synth_unit import SynthesisError, synthesise
from sim.core.fpbench.native import angle_bound, operations
from sim.rtl.figures import rtl_mark
from sim.rtl.sources import sources_of

RTL = ROOT / "rtl/fpu"
PAGE = ROOT / "docs/units.md"
DATA = ROOT / "docs/data/units_synthesis.json"
PROOFS = ROOT / "docs/formal.md"
COMMAND = "python scripts/units_page.py"
DEVICE = {"area": "Cyclone V (Yosys synth_intel_alm)", "speed": "ECP5-85, speed grade 8 (nextpnr)"}
PACKAGE = "fp_pkg"
TABLES = {"fp_sincos_rom", "fp_sincos_memory"}  # coefficients
FOLDED = "_folded"  # ends the name of a unit that gives the results of another, less often
VARIANTS = (FOLDED, "_overlapped")  # .. or, with a latency of its own, more often
ANGLES = ("fp_sincos", "fp_sincos_overlapped")


class PageError(ValueError):
    """The RTL or the page is not as expected; the text is `file: error: what; cure`."""


@dataclass(frozen=True)
class Port:
    """One port or, with the direction `parameter`, one parameter with its default."""

    direction: str
    name: str
    type: str
    note: str


def units(rtl: Path = RTL) -> list[str]:
    """Units with a file list of their own, in the order of the package's latencies."""
    listed = {path.stem for path in rtl.glob("*.f")}
    named = [name.lower() for name in latencies(rtl)]
    folded = [f"{name}{FOLDED}" for name in named if f"{name}{FOLDED}" in listed]
    if listed != {*named, *folded}:
        raise PageError(
            f"{rtl}/{PACKAGE}.sv: error: latencies of {sorted(named)}, but file lists of "
            f"{sorted(listed)}; each unit needs both"
        )
    return sorted([*named, *folded], key=lambda name: named.index(name.removesuffix(FOLDED)))


def blocks_of(rtl: Path = RTL) -> list[str]:
    """Building blocks: every module that is neither unit, package nor table."""
    stems = {path.stem for path in rtl.glob("*.sv")}
    return sorted(stems - set(units(rtl)) - {PACKAGE} - TABLES)


def latencies(rtl: Path = RTL) -> dict[str, int]:
    """`{"FP_ADD": 4, ...}` from fp_pkg.sv, in register ranks."""
    found = fp_latencies(rtl / f"{PACKAGE}.sv")
    return {name.removesuffix("_LATENCY"): ranks for name, ranks in found.items()}


def latency(unit: str, rtl: Path = RTL) -> int:
    """Register ranks of a unit; a folded one has those of the unit whose results it gives."""
    return latencies(rtl)[unit.removesuffix(FOLDED).upper()]


def header(module: str, rtl: Path = RTL) -> str:
    """The contract at the top of a module's file as one paragraph, without the SPDX line."""
    lines = []
    for line in (rtl / f"{module}.sv").read_text(encoding="utf-8").splitlines():
        if not line.startswith("//"):
            break
        if "SPDX" not in line:
            lines.append(line.removeprefix("//").strip())
    if not lines or not lines[0].startswith(f"{module}: "):
        raise PageError(f"{rtl / module}.sv: error: header must start with `// {module}: `")
    return " ".join(lines).removeprefix(f"{module}: ")


def prose(text: str) -> str:
    """Text of the RTL as Markdown prose: a star stays a star."""
    return text.replace("*", r"\*")


def ports(module: str, rtl: Path = RTL) -> list[Port]:
    """Parameters and ports of a module in the order of its header.

    Read as text: of slang's tree each note would have to be found again in the trivia of the token
    after it.
    """
    path = rtl / f"{module}.sv"
    text = path.read_text(encoding="utf-8")
    head = re.search(rf"^module {module}\b(.*?)^\);", text, re.DOTALL | re.MULTILINE)
    if head is None:
        raise PageError(f"{path}: error: no `module {module} ... );`")
    found = []
    for line in head[1].splitlines():
        code, _, note = line.partition("//")
        parameter = re.match(r"\s*parameter\s+(.+?)\s+(\w+)\s*=\s*([^,]+?),?\s*$", code)
        port = re.match(r"\s*(input|output)\s+([\w:]+)\s*(\[[^\]]*\])?\s*(\w+)\s*,?\s*$", code)
        if parameter:
            kind, name, default = parameter.groups()
            found.append(Port("parameter", name, kind, f"default {default} {note.strip()}".strip()))
        elif port:
            direction, kind, width, name = port.groups()
            found.append(Port(direction, name, f"{kind} {width or ''}".strip(), note.strip()))
        elif code.strip() not in ("", "#(", ") (", "("):
            raise PageError(f"{path}: error: cannot read `{line.strip()}` of the module's header")
    return found


def interval(unit: str, rtl: Path = RTL) -> int:
    """Clocks between two operations: one, the latency of a unit that has to become ready, or what a
    variant of another unit states.
    """
    if unit.endswith(VARIANTS):
        path = rtl / f"{unit}.sv"
        stated = re.search(r"\bInterval = (\d+);", path.read_text(encoding="utf-8"))
        if stated is None:
            raise PageError(f"{path}: error: no `Interval = <clocks>;`")
        return int(stated[1])
    waits = any(port.name == "ready_o" for port in ports(unit, rtl))
    return latency(unit, rtl) if waits else 1


def error_bound(unit: str, rtl: Path = RTL) -> str:
    """What the result may differ from the exact one."""
    if unit in ANGLES:
        return f"below {angle_bound(rtl)} ulp for abs(a) <= 256"
    if unit == "fp_cmp":
        return "exact"
    if unit == "fp_f2i":
        return "correctly rounded to an integer"
    return "correctly rounded (half an ulp)"


def overview() -> list[str]:
    """Table of the units."""
    rows = [
        [
            f"[`{unit}`](#{unit})",
            prose(re.split(r"\. |, pipelined|, iterative|, one per clock", header(unit))[0]),
            str(latency(unit)),
            str(interval(unit)),
            error_bound(unit),
        ]
        for unit in units()
    ]
    return table(["unit", "what", "latency", "interval", "error"], rows)


def measured(data: dict) -> list[str]:
    """Table of area and speed, one row per unit."""
    rows = []
    for unit in units():
        entry = data.get(unit)
        if entry is None:
            rows.append([f"`{unit}`", *["-"] * 6, "not measured"])
            continue
        speeds = entry["fmax_mhz"]
        rows.append(
            [
                f"`{unit}`",
                *(str(entry[name]) for name in ("alut", "ff", "mul18", "memory_bits")),
                ", ".join(f"{mhz:g}" for mhz in speeds.values()),
                ", ".join(speeds),
                "present" if entry["sources"] == rtl_mark(unit) else "an earlier version",
            ]
        )
    head = ["unit", "ALUTs", "registers", "18x18", "memory bits", "MHz", "seeds", "sources"]
    lines = table(head, rows)
    return [*lines, "", f"Area: {DEVICE['area']}. Fmax: {DEVICE['speed']}, one value per seed."]


def evidence(unit: str) -> list[str]:
    """Lines of commands that repeat what is known of a unit."""
    variant = next((ending for ending in VARIANTS if unit.endswith(ending)), "")
    owner = unit.removesuffix(variant)
    ops = [op for op, (name, _) in operations().items() if name == owner]
    proofs = re.findall(
        rf"^\| {unit} \|.*\| `(python -m tests\.formal --only \w+)` \|$",
        PROOFS.read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    named = " ".join(f"`{op}`" for op in ops)
    bench = (
        f"pytest tests/fpu/test_{unit}.py -k bench"
        if variant
        else f"microtick fp bench --op {ops[0]}"
    )
    lines = [f"- short set, host arithmetic: `{bench}`, operations {named}"]
    if proofs:
        lines.append(
            "- proofs (`docs/formal.md` has their state): "
            + ", ".join(f"`{proof}`" for proof in proofs)
        )
    lines.append(f"- simulation against SoftFloat or MPFR: `pytest tests/fpu/test_{unit}.py`")
    lines.append(f"- planted faults: `python -m tests.mutants --only {unit}`")
    return lines


def comparison_codes() -> list[str]:
    """Table of the operations of fp_cmp from their records."""
    rows = [
        [f"`FP_CMP_{name}`", str(record.control["cmp_op"]), record.doc.removeprefix("dst = ")]
        for name, record in default_isa().comparisons.items()
    ]
    return table(["operation", "`op_i`", "result and flag"], rows)


def checked_files(unit: str, rtl: Path = RTL) -> list[str]:
    """Names of the unit's files that hold checks for simulation under `ifndef SYNTHESIS."""
    files = sources_of(unit, (rtl,))
    return [file.name for file in files if "`ifndef SYNTHESIS" in file.read_text(encoding="utf-8")]


def port_table(module: str) -> list[str]:
    """Parameters and ports as a table."""
    rows = [[f"`{p.name}`", p.direction, f"`{p.type}`", p.note] for p in ports(module)]
    return table(["port", "direction", "type", ""], rows)


def facts(module: str) -> list[str]:
    """Generated block of a unit or building block."""
    lines = [f"> {prose(header(module))}", "", *port_table(module)]
    if module not in units():
        return lines
    if module == "fp_cmp":
        lines += ["", *comparison_codes()]
    files = [str(path.relative_to(ROOT)) for path in sources_of(module, (RTL,))]
    checked = " and ".join(f"`{name}`" for name in checked_files(module))
    macro = f"define it for synthesis, for the checks in {checked}" if checked else "not used"
    return [
        *lines,
        "",
        f"Latency {latency(module)}, interval {interval(module)}. Error: "
        f"{error_bound(module)}. File list `rtl/fpu/{module}.f`: "
        + ", ".join(f"`{Path(file).name}`" for file in files)
        + f". `SYNTHESIS`: {macro}.",
        "",
        "Evidence:",
        "",
        *evidence(module),
    ]


def page(text: str, data: dict) -> str:
    """The page with its generated blocks replaced. Raises PageError if one has no place."""
    wanted = {
        "overview": overview(),
        "synthesis": measured(data),
        **{module: facts(module) for module in [*units(), *blocks_of()]},
    }
    for name, lines in wanted.items():
        marks = re.compile(rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
        body = "\n".join(["", *lines, ""])
        inside = f"{body}\n".replace("\\", "\\\\")
        text, count = marks.subn(rf"\g<1>{inside}\g<2>", text)
        if count != 1:
            raise PageError(
                f"{PAGE}: error: {count} places `<!-- begin {name} -->` .. `<!-- end {name} -->`, "
                "not one; write the section of this module"
            )
    return text


def measure(names: Sequence[str], seeds: Sequence[int], path: Path = DATA) -> None:
    """Synthesise units and put their figures into `path`. Raises SynthesisError."""
    data = load(path)
    for name in names:
        result = synthesise(name, sources_of(name, (RTL,)), seeds)
        entry = {key: result["alm"][key] for key in ("alut", "ff", "mul18", "memory_bits")}
        data[name] = {
            "sources": rtl_mark(name),
            "command": f"{COMMAND} --measure {name} --seeds {' '.join(map(str, seeds))}",
            **entry,
            "fmax_mhz": result["ecp5"]["fmax_mhz"],
        }
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, json.dumps(dict(sorted(data.items())), indent=2) + "\n")


def load(path: Path = DATA) -> dict:
    """Stored figures by unit; none yet if there is no file."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


@command("scripts/units_page.py")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 written or equal, 1 if the page differs or a tool failed, 2 usage."""
    parser = script_parser(__doc__, f"{COMMAND} --measure fp_cmp fp_f2i --seeds 1 2 3")
    parser.add_argument("--check", action="store_true", help="compare with the page, write nothing")
    parser.add_argument("--page", type=Path, default=PAGE, help="the page")
    parser.add_argument("--measure", nargs="+", choices=units(), default=[], metavar="UNIT")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    options = parser.parse_args(argv)
    try:
        measure(options.measure, options.seeds)
        new = page(options.page.read_text(encoding="utf-8"), load())
    except (PageError, SynthesisError) as error:
        sys.stderr.write(f"{error}\n")
        return 1
    stale = f"{options.page}: error: differs from the RTL or its figures; {COMMAND}"
    return keep_page(options.page, new, options.check, stale, sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
