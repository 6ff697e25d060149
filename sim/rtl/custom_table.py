# SPDX-License-Identifier: Apache-2.0
"""The table of custom instructions, nios_sw/custom.toml, validated, as dataclasses."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from asip_asm.machine import FP_PKG_FILE, fp_latencies
from asip_asm.project import ROOT

SOURCE = ROOT / "nios_sw/custom.toml"
PLATFORMS = ("fpga1", "fpga2")
FPGA_OF = {name: number for number, name in enumerate(PLATFORMS, 1)}  # number in C and RTL
# Type -> clockCycleType of the vendor's interface.
TYPES = {"combinational": "COMBINATORIAL", "multicycle": "MULTICYCLE", "variable": "VARIABLE"}
COMPONENT_KEYS = {"type", "select", "macro", "doc"}
INSTRUCTION_KEYS = {"component", "n", "cycles", "operands", "software", "doc"}
OPTIONAL_KEYS = {"gcc", "registers"}
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


NAME, MACRO = re.compile(r"[a-z][a-z0-9_]*"), re.compile(r"[A-Z][A-Z0-9_]*")
DOC = re.compile(r'(?!.*(?:/\*|\*/))[^"\\$\[\]{}`]+')


@dataclass(frozen=True)
class Instruction:
    """One function of a component; `unit` names the latency constant that `cycles` is one above."""

    name: str
    component: str
    n: int
    cycles: int
    unit: str | None
    operands: str
    software: str
    doc: str
    registers: str = CPU_REGISTERS
    gcc: str | None = None

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
        self.texts(header, record)

    def texts(self, header: str, record: Mapping) -> None:
        """Refuse names and texts that C, SystemVerilog, Tcl or Markdown would obey."""
        for what, text, form, cure in (
            ("name", header.rpartition(".")[2], NAME, "a small letter, then a-z, 0-9, _"),
            ("macro", record.get("macro", "X"), MACRO, "a capital letter, then A-Z, 0-9, _"),
            ("doc", record["doc"], DOC, 'one line without " \\ $ [ ] { } `, /* and */'),
        ):
            if not isinstance(text, str) or not text.isprintable() or not form.fullmatch(text):
                raise self.fail(header, f"{what} = {text!r}: {cure}")

    def cycles(self, header: str, value: object) -> tuple[int, str | None]:
        if isinstance(value, str):
            if value not in self.latencies:
                known = ", ".join(sorted(self.latencies))
                raise self.fail(
                    header, f"cycles: {FP_PKG_FILE.name} has no `{value}`; one of {known}"
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
        return Instruction(name, **dict(record) | {"cycles": cycles, "unit": unit})

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
            made = self.component(header, key, entry, instructions)
            for n in made.numbers:
                other = owner.setdefault(n, key)
                if other != key:
                    raise self.fail(header, f"numbers {block(made)} overlap `{other}` at n = {n}")
            for before in components.values():
                if before.macro == made.macro:
                    what = f"macro {made.macro} is already that of `{before.name}`"
                    raise self.fail(header, what)
            components[key] = made
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


def load(path: Path = SOURCE) -> dict[str, Platform]:
    """Platforms by name. Raises CustomError."""
    try:
        reader = _Reader(path, fp_latencies())
    except OSError as error:
        cause = error.strerror or error
        raise CustomError(f"{path}: error: {cause}; name a table with --source") from None
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
