# SPDX-License-Identifier: Apache-2.0
"""Generate package, C header, compiler flags and reference page of the custom instructions.

Source: nios_sw/custom.toml. Outputs: rtl/gen/ci_pkg.sv, nios_sw/include/gen/ci.h,
nios_sw/include/gen/ci_flags.mk, docs/ci.md, and for each component its Platform Designer script
scripts/platform_designer/<component>_hw.tcl, whose ports are those of rtl/custom/<component>.sv.
With --check nothing is written; exit 1 if a file differs from what would be generated, or if the
source is refused.
"""

from __future__ import annotations

import argparse
import difflib
import re
import sys
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from scripts.generated import deliver, sv_int, sv_logic, table  # noqa: E402
from sim.harness.sources import sources_of  # noqa: E402

SOURCE = ROOT / "nios_sw/custom.toml"
FP_PACKAGE = ROOT / "rtl/fpu/fp_pkg.sv"
RTL = ROOT / "rtl"
PLATFORMS = ("fpga1", "fpga2")
FPGA_OF = {name: number for number, name in enumerate(PLATFORMS, 1)}  # number in C and RTL
# Type -> clockCycleType of the vendor's interface.
TYPES = {"combinational": "COMBINATORIAL", "multicycle": "MULTICYCLE", "variable": "VARIABLE"}
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
COMPONENT_KEYS = {"type", "select", "macro", "doc"}
INSTRUCTION_KEYS = {"component", "n", "cycles", "operands", "software", "doc"}
OPTIONAL_KEYS = {"gcc", "registers"}
C_TYPES = {"f": "float", "i": "int", "v": "void"}
MAX_CYCLES = 128  # of the vendor's master
CPU_REGISTERS = "rrr"  # c, a, b: result and operands in registers of the CPU


class CustomError(ValueError):
    """A record that cannot be; the message is `file:line:1: error: what; cure`."""


@dataclass(frozen=True)
class Component:
    """A module of rtl/custom: `bits` of its own n, first number `base` of its aligned block."""

    name: str
    type: str
    bits: int
    base: int
    macro: str
    doc: str

    @property
    def numbers(self) -> range:
        """Instruction numbers that the component owns."""
        return range(self.base, self.base + (1 << self.bits))


@dataclass(frozen=True)
class Instruction:
    """One function of a component; `unit` names the latency constant that `cycles` is one above."""

    name: str
    component: str
    n: int
    cycles: int
    unit: str | None
    operands: str
    registers: str
    gcc: str | None
    software: str
    doc: str

    @property
    def result(self) -> str:
        """Letter of the C result type: f, i or v."""
        return self.operands[0]

    @property
    def arguments(self) -> str:
        """Letters of the C argument types."""
        return self.operands[2:]

    @property
    def builtin(self) -> str:
        """GCC builtin with this signature, for operands in CPU registers."""
        result = "" if self.result == "v" else self.result
        return f"__builtin_custom_{result}n{self.arguments}"

    @property
    def verilog_cycles(self) -> str:
        """A number: Yosys refuses a package that names another; gen-check keeps it true."""
        return str(self.cycles)


@dataclass(frozen=True)
class Platform:
    """Components and instructions of a platform, instructions in ascending order of n."""

    name: str
    doc: str
    components: Mapping[str, Component]
    instructions: Mapping[str, Instruction]

    @property
    def combinational(self) -> int:
        """Bit n is set where instruction number n is combinational."""
        numbers = [c.numbers for c in self.components.values() if c.type == "combinational"]
        return sum(1 << n for block in numbers for n in block)


class _Reader:
    """Turns the parsed TOML into records; every refusal names the line of the record."""

    def __init__(self, path: Path, latencies: Mapping[str, int]) -> None:
        self.path = path
        self.text = path.read_text(encoding="utf-8")
        self.latencies = latencies

    def fail(self, header: str, what: str) -> CustomError:
        """The error of the record under `[header]`."""
        lines = self.text.splitlines()
        line = next((i for i, text in enumerate(lines, 1) if text.strip() == f"[{header}]"), 1)
        return CustomError(f"{self.path}:{line}:1: error: {header}: {what}")

    def keys(self, header: str, record: Mapping, needed: set[str], optional: set[str]) -> None:
        for key in record:
            if key not in needed | optional:
                close = difflib.get_close_matches(key, needed | optional, 1)
                hint = (
                    f"did you mean `{close[0]}`?"
                    if close
                    else "known: " + ", ".join(sorted(needed | optional))
                )
                raise self.fail(header, f"unknown key `{key}`; {hint}")
        for key in sorted(needed - set(record)):
            raise self.fail(header, f"key `{key}` is missing")

    def cycles(self, header: str, value: object) -> tuple[int, str | None]:
        if isinstance(value, str):
            if value not in self.latencies:
                known = ", ".join(sorted(self.latencies))
                raise self.fail(
                    header, f"cycles: {FP_PACKAGE.name} has no `{value}`; one of {known}"
                )
            return self.latencies[value] + 1, value
        if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= MAX_CYCLES:
            raise self.fail(header, f"cycles = {value!r}: an integer 1..{MAX_CYCLES} or a latency")
        return value, None

    def instruction(self, header: str, name: str, record: Mapping) -> Instruction:
        self.keys(header, record, INSTRUCTION_KEYS, OPTIONAL_KEYS)
        n, operands = record["n"], record["operands"]
        if not isinstance(n, int) or isinstance(n, bool) or not 0 <= n <= 255:
            raise self.fail(header, f"n = {n!r}: an integer 0..255")
        if not re.fullmatch(r"[fiv]=[fi]{1,3}", operands):
            raise self.fail(header, f'operands = "{operands}": result=arguments, as in "f=ff"')
        registers = record.get("registers", CPU_REGISTERS)
        if not re.fullmatch(r"[rc]{3}", registers):
            raise self.fail(header, f'registers = "{registers}": r or c for each of c, a, b')
        if registers == CPU_REGISTERS and (len(operands) > 4 or operands[0] == "v"):
            raise self.fail(header, f'operands = "{operands}": a result and at most two arguments')
        cycles, unit = self.cycles(header, record["cycles"])
        return Instruction(
            name,
            record["component"],
            n,
            cycles,
            unit,
            operands,
            registers,
            record.get("gcc"),
            record["software"],
            record["doc"],
        )

    def platform(self, name: str, record: Mapping) -> Platform:
        self.keys(name, record, {"doc", "components", "instructions"}, set())
        instructions: dict[str, Instruction] = {}
        taken: dict[tuple[int, str], str] = {}
        for key, entry in record["instructions"].items():
            header = f"{name}.instructions.{key}"
            item = self.instruction(header, key, entry)
            if item.component not in record["components"]:
                raise self.fail(header, f"no component `{item.component}`")
            other = taken.setdefault((item.n, item.registers), key)
            if other != key:
                raise self.fail(header, f"n = {item.n} is already that of `{other}`")
            instructions[key] = item
        components: dict[str, Component] = {}
        owner: dict[int, str] = {}
        for key, entry in record["components"].items():
            header = f"{name}.components.{key}"
            item = self.component(header, key, entry, instructions)
            for n in item.numbers:
                other = owner.setdefault(n, key)
                if other != key:
                    raise self.fail(header, f"numbers {block(item)} overlap `{other}` at n = {n}")
            for other in components.values():
                if other.macro == item.macro:
                    raise self.fail(header, f"macro {item.macro} is already that of `{other.name}`")
            components[key] = item
        ordered = dict(sorted(instructions.items(), key=lambda pair: pair[1].n))
        return Platform(name, record["doc"], components, ordered)

    def component(
        self, header: str, name: str, record: Mapping, instructions: Mapping[str, Instruction]
    ) -> Component:
        self.keys(header, record, COMPONENT_KEYS, set())
        mine = [item for item in instructions.values() if item.component == name]
        if not mine:
            raise self.fail(header, "no instruction uses the component")
        if record["type"] not in TYPES:
            raise self.fail(header, f"type `{record['type']}`; one of {', '.join(TYPES)}")
        bits = record["select"]
        if not isinstance(bits, int) or isinstance(bits, bool) or not 0 <= bits <= 8:
            raise self.fail(header, f"select = {bits!r}: an integer 0..8")
        base = mine[0].n >> bits << bits
        for item in mine:
            if item.n >> bits << bits != base:
                raise self.fail(
                    header,
                    f"`{item.name}` n = {item.n} is outside the aligned block "
                    f"{base}..{base + (1 << bits) - 1} of `{mine[0].name}`; "
                    "raise select or move the number",
                )
            if (record["type"] == "combinational") and item.cycles != 1:
                raise self.fail(
                    header, f"combinational, but `{item.name}` has cycles = {item.cycles}"
                )
        if record["type"] == "multicycle" and len({item.cycles for item in mine}) > 1:
            raise self.fail(
                header, "multicycle has one number of cycles; type `variable` has several"
            )
        return Component(name, record["type"], bits, base, record["macro"], record["doc"])


def block(component: Component) -> str:
    """`252` or `252..255`."""
    first, last = component.numbers[0], component.numbers[-1]
    return str(first) if first == last else f"{first}..{last}"


def latencies(package: Path = FP_PACKAGE) -> dict[str, int]:
    """Latencies of the arithmetic units, in register ranks, by the names of fp_pkg."""
    found = re.findall(r"\b(FP_\w+_LATENCY)\s*=\s*(\d+)\s*;", package.read_text(encoding="utf-8"))
    return {name: int(value) for name, value in found}


def load(path: Path = SOURCE) -> dict[str, Platform]:
    """Platforms by name. Raises CustomError."""
    reader = _Reader(path, latencies())
    try:
        data = tomllib.loads(reader.text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"line (\d+), column (\d+)", str(error))
        at = f"{place[1]}:{place[2]}" if place else "1:1"
        raise CustomError(f"{path}:{at}: error: {error}") from None
    for name in PLATFORMS:
        if name not in data:
            raise CustomError(f"{path}:1:1: error: platform `{name}` is missing")
    for name in data:
        if name not in PLATFORMS:
            known = ", ".join(PLATFORMS)
            raise CustomError(f"{path}:1:1: error: platform `{name}` is unknown; known: {known}")
    return {name: reader.platform(name, data[name]) for name in PLATFORMS}


def package(platforms: Mapping[str, Platform]) -> str:
    """Text of ci_pkg.sv."""
    lines = [
        "// SPDX-License-Identifier: Apache-2.0",
        "// GENERATED by scripts/gen_custom.py from nios_sw/custom.toml - edit that file.",
        "// ci_pkg: numbers and cycles of the custom instructions of both platforms.",
        "// Cycles are those of the CPU, from start to the one whose end takes the result.",
        "package ci_pkg;",
    ]
    for platform in platforms.values():
        upper = platform.name.upper()
        lines += ["", f"  // {upper}: {platform.doc}."]
        seen: set[int] = set()
        for item in platform.instructions.values():
            if item.n not in seen:
                seen.add(item.n)
                lines.append(sv_logic(f"{upper}_N_{item.name.upper()}", 8, item.n))
        for part in platform.components.values():
            prefix = f"{upper}_{part.name.upper().removeprefix('CI_')}"
            mine = [i for i in platform.instructions.values() if i.component == part.name]
            lines.append(sv_logic(f"{prefix}_BASE", 8, part.base, f"{part.name}: {block(part)}"))
            lines.append(sv_int(f"{prefix}_SELECT", part.bits))
            if part.type == "multicycle":
                expression = mine[0].verilog_cycles
                lines.append(f"  localparam int unsigned {prefix}_CYCLES = {expression};")
            if part.type == "variable":
                lines += [
                    f"  localparam int unsigned {prefix}_{item.name.upper()}_CYCLES = "
                    f"{item.verilog_cycles};"
                    for item in mine
                ]
        lines.append("  // Bit n: instruction number n belongs to the combinational group.")
        lines.append(
            f"  localparam logic [255:0] {upper}_COMBINATIONAL =\n"
            f"      256'h{platform.combinational:064x};"
        )
    return "\n".join([*lines, "", "endpackage", ""])


def _arguments(item: Instruction) -> str:
    names = argument_names(item)
    return ", ".join(f"{C_TYPES[t]} {n}" for t, n in zip(item.arguments, names, strict=True))


def argument_names(item: Instruction) -> tuple[str, ...]:
    """C names of the arguments: those of the fields, `c` first where c is an internal register."""
    return (
        ("c", "a", "b")[: len(item.arguments)]
        if item.registers[0] == "c"
        else ("a", "b")[: len(item.arguments)]
    )


def _inline(item: Instruction) -> list[str]:
    names = argument_names(item)
    head = f"static inline {C_TYPES[item.result]} ci_{item.name}({_arguments(item)})"
    call = f"{item.builtin}(CI_{item.name.upper()}_N, {', '.join(names)})"
    return [f"{head} {{ return {call}; }}"]


def _assembly(item: Instruction) -> list[str]:
    """A macro of inline assembly: internal registers are constants in the instruction word."""
    names = argument_names(item)
    types = dict(zip(names, item.arguments, strict=True))
    inputs, fields = [], []
    for place, field in enumerate("cab"):
        internal = item.registers[place] == "c"
        if place == 0 and not internal:
            fields.append("%[y]")
            continue
        if field not in names:
            fields.append("c0" if internal else "r0")
            continue
        fields.append(f"c%[{field}]" if internal else f"%[{field}]")
        kind = "i" if internal else "r"
        value = f"(ARG_{field})" if internal else f"(({C_TYPES[types[field]]})(ARG_{field}))"
        inputs.append(f'[{field}] "{kind}"{value}')
    macro_arguments = ", ".join(f"ARG_{name}" for name in names)
    text = f'"custom %[n], {", ".join(fields)}"'
    bound = f'[n] "i"(CI_{item.name.upper()}_N), ' + ", ".join(inputs)
    head = f"#define ci_{item.name}({macro_arguments}) \\"
    if item.result == "v":
        return [head, f"  __asm__ volatile({text} : : {bound})"]
    kind = C_TYPES[item.result]
    return [
        head,
        f"  __extension__({{ {kind} ci_y_; \\",
        f'     __asm__ volatile({text} : [y] "=r"(ci_y_) \\',
        f"                      : {bound}); ci_y_; }})",
    ]


def _component_macro(part: Component) -> list[str]:
    lines = [f"#define {part.macro}_N {part.base}"]
    if part.bits == 0:
        call = f"__builtin_custom_inii({part.macro}_N, (A), (B))"
        return [*lines, f"#define {part.macro}(A, B) {call}"]
    mask = (1 << part.bits) - 1
    call = f"__builtin_custom_inii({part.macro}_N + ((n) & {part.macro}_N_MASK), (A), (B))"
    return [
        *lines,
        f"#define {part.macro}_N_MASK {mask:#x}",
        f"#define {part.macro}(n, A, B) \\\n  {call}",
    ]


def header(platforms: Mapping[str, Platform]) -> str:
    """Text of ci.h."""
    lines = [
        "/* SPDX-License-Identifier: Apache-2.0 */",
        "/* GENERATED by scripts/gen_custom.py from nios_sw/custom.toml - edit that file. */",
        "/* Custom instructions for C. CI_PLATFORM is 1 (vendor FPU) or 2 (ours, the default).",
        "   ALT_CI_*: macros as in the vendor's system.h, operands are integers (bit patterns).",
        "   ci_*: the instruction with its types. Without a Nios II, or with CI_SOFTWARE defined,",
        "   ci_* are plain C; CI_HARDWARE tells which. docs/ci.md states results.",
        "   CI_*_CYCLES: cycles of the CPU. */",
        "#ifndef CI_H",
        "#define CI_H",
        "",
        "#ifndef CI_PLATFORM",
        "#define CI_PLATFORM 2",
        "#endif",
        "#if defined(__nios2__) && !defined(CI_SOFTWARE)",
        "#define CI_HARDWARE 1",
        "#else",
        "#define CI_HARDWARE 0",
        "#include <math.h>",
        "#endif",
    ]
    for number, platform in enumerate(platforms.values(), 1):
        lines += ["", f"#if CI_PLATFORM == {number} /* {platform.doc} */", ""]
        for item in platform.instructions.values():
            upper = item.name.upper()
            lines += [f"#define CI_{upper}_N {item.n}", f"#define CI_{upper}_CYCLES {item.cycles}"]
        lines += ["", "#if CI_HARDWARE", ""]
        for part in platform.components.values():
            lines += [f"/* {part.name}: {part.doc} */", *_component_macro(part)]
        lines.append("")
        for item in platform.instructions.values():
            lines.append(f"/* {item.doc} */")
            lines += _inline(item) if item.registers == CPU_REGISTERS else _assembly(item)
        lines += ["", "#else /* software */", ""]
        if any("ci_bounds" in item.software for item in platform.instructions.values()):
            lines += [
                "static float ci_bounds[32][2] __attribute__((unused));",
                "static inline float ci_saturate(float a, float low, float high) {",
                "  if (!(low <= high) || a != a) return NAN;",
                "  return a < low ? low : a > high ? high : a;",
                "}",
            ]
        for item in platform.instructions.values():
            head = f"static inline {C_TYPES[item.result]} ci_{item.name}({_arguments(item)})"
            keep = "return " if item.result != "v" else ""
            ignored = [n for n in argument_names(item) if not re.search(rf"\b{n}\b", item.software)]
            void = "".join(f"(void){name}; " for name in ignored)
            lines += [f"/* {item.doc} */", f"{head} {{ {void}{keep}{item.software}; }}"]
        lines += ["", "#endif", "", f"#endif /* CI_PLATFORM == {number} */"]
    lines += [
        "",
        "#if CI_PLATFORM != 1 && CI_PLATFORM != 2",
        '#error "CI_PLATFORM must be 1 (vendor FPU) or 2 (our custom instructions)"',
        "#endif",
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def flags(platforms: Mapping[str, Platform]) -> str:
    """Text of ci_flags.mk: CI_FLAGS_FPGA1 and CI_FLAGS_FPGA2 for GCC."""
    lines = [
        "# SPDX-License-Identifier: Apache-2.0",
        "# GENERATED by scripts/gen_custom.py from nios_sw/custom.toml - edit that file.",
        "# Options of nios2-elf-gcc that make plain C use the custom instructions of a platform.",
        "# GCC uses sine and cosine only with -funsafe-math-optimizations, minimum and maximum",
        "# only with -ffinite-math-only, the square root in line only with -fno-math-errno.",
    ]
    for number, platform in enumerate(platforms.values(), 1):
        options = [f"{i.gcc}={i.n}" for i in platform.instructions.values() if i.gcc]
        rows = [f"CI_FLAGS_{platform.name.upper()} := -DCI_PLATFORM={number}"]
        for option in options:
            if len(rows[-1]) + len(option) > 96:
                rows[-1] += " \\"
                rows.append("  " + option)
            else:
                rows[-1] += " " + option
        lines += rows
    return "\n".join([*lines, ""])


def document(platforms: Mapping[str, Platform]) -> str:
    """Text of docs/ci.md."""
    lines = [
        "<!-- GENERATED by scripts/gen_custom.py from nios_sw/custom.toml - edit that file. -->",
        "# Custom instructions: reference",
        "",
        "How to use them and add your own: [custom_instructions.md](custom_instructions.md).",
        "Cycles are those of the CPU from start to the edge that takes the result, both included.",
        "Registers `c` and `a`, `b` are those of the CPU unless the assembly says `c0` .. `c31`:",
        "internal registers of the component, constants in C.",
    ]
    for platform in platforms.values():
        lines += ["", f"## {platform.name.upper()}: {platform.doc}", ""]
        lines += table(
            ["component", "n", "type", "C macro", ""],
            [
                [f"`{c.name}`", block(c), c.type, f"`{c.macro}`", c.doc]
                for c in platform.components.values()
            ],
        )
        lines.append("")
        lines += table(
            ["n", "C", "assembly", "cycles", "component", "GCC", "result"],
            [
                [
                    str(i.n),
                    f"`{C_TYPES[i.result]} ci_{i.name}({_arguments(i)})`",
                    f"`{assembly_form(i)}`",
                    str(i.cycles),
                    f"`{i.component}`",
                    f"`{i.gcc}={i.n}`" if i.gcc else "-",
                    i.doc,
                ]
                for i in platform.instructions.values()
            ],
        )
    return "\n".join([*lines, ""])


def assembly_form(item: Instruction) -> str:
    """`custom 244, rC, rA, cB`."""
    fields = []
    for place, field in enumerate("cab"):
        kind = item.registers[place]
        unused = place == 2 and kind == "r" and "b" not in argument_names(item)
        fields.append("r0" if unused else f"{kind}{field.upper()}")
    return f"custom {item.n}, {', '.join(fields)}"


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
    interface = "nios_custom_instruction_slave"
    ports = ports_of(component)
    operands = sum(role in ("dataa", "datab") for role, _, _ in ports.values())
    sources = [path.relative_to(ROOT) for path in sources_of(component.name)]
    properties = {
        "clockCycle": cycles,
        "clockCycleType": TYPES[component.type],
        "operands": operands,
        "opcodeExtensionLocked": "true",
        "opcodeExtensionLockedValue": f"{component.base:#04x}",
    }
    return "\n".join(
        [
            "# SPDX-License-Identifier: Apache-2.0",
            "# GENERATED by scripts/gen_custom.py from nios_sw/custom.toml - edit that file.",
            f"# Platform Designer (Qsys 13.1 and later) component: rtl/custom/{component.name}.sv.",
            "# Add this folder to the IP search path. The numbers are those of ci.h.",
            "package require -exact qsys 13.1",
            "",
            f"set_module_property NAME {component.name}",
            "set_module_property VERSION 1.0",
            f'set_module_property DISPLAY_NAME "Microtick {component.name}"',
            f'set_module_property DESCRIPTION "{component.doc}"',
            'set_module_property GROUP "Custom Instruction Modules"',
            'set_module_property AUTHOR "Microtick"',
            "set_module_property INSTANTIATE_IN_SYSTEM_MODULE true",
            "set_module_property EDITABLE false",
            "set_module_property ANALYZE_HDL false",
            "",
            "# ---- sources, packages first",
            "foreach kind {QUARTUS_SYNTH SIM_VERILOG} {",
            "  add_fileset $kind $kind add_sources",
            f"  set_fileset_property $kind TOP_LEVEL {component.name}",
            "}",
            "",
            "proc add_sources {entity} {",
            "  set root [file join [get_module_property MODULE_DIRECTORY] .. ..]",
            "  foreach path {",
            *(f"    {path}" for path in sources),
            "  } {",
            "    add_fileset_file [file tail $path] SYSTEM_VERILOG PATH [file join $root $path]",
            "  }",
            "}",
            "",
            "# ---- interface: clock and reset are part of it",
            f"add_interface {interface} nios_custom_instruction end",
            *(
                f"set_interface_property {interface} {name} {value}"
                for name, value in properties.items()
            ),
            *(
                f"add_interface_port {interface} {name} {role} {direction} {width}"
                for name, (role, width, direction) in ports.items()
            ),
            "",
        ]
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


def generate(source: Path = SOURCE) -> dict[str, str]:
    """Text of each generated file by its path below the repository. Raises CustomError."""
    platforms = load(source)
    return {
        "rtl/gen/ci_pkg.sv": package(platforms),
        "nios_sw/include/gen/ci.h": header(platforms),
        "nios_sw/include/gen/ci_flags.mk": flags(platforms),
        "docs/ci.md": document(platforms),
        **hardware_scripts(platforms),
    }


def main(arguments: list[str] | None = None) -> int:
    """Command line; exit 0 done or equal, 1 refused source or stale files, 2 usage."""
    parser = argparse.ArgumentParser(
        description="Generate package, C header, flags and page of the custom instructions.",
        epilog="example: python scripts/gen_custom.py --check",
    )
    parser.add_argument("--check", action="store_true", help="write nothing, fail on a deliver")
    parser.add_argument("--root", type=Path, default=ROOT, help="where the generated files stand")
    parser.add_argument("--source", type=Path, default=SOURCE, help="table to read")
    options = parser.parse_args(arguments)
    try:
        files = generate(options.source)
    except CustomError as error:
        print(error, file=sys.stderr)
        return 1
    except OSError as error:
        print(
            f"{options.source}: error: {error.strerror}; name a table with --source",
            file=sys.stderr,
        )
        return 1
    return deliver(files, options.root, options.check, "scripts/gen_custom.py")


if __name__ == "__main__":
    sys.exit(main())
