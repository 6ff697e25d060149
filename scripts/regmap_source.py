# SPDX-License-Identifier: Apache-2.0
"""Register maps in SystemRDL 2.0, read by systemrdl-compiler into `asip_asm.regmap.RegisterMap`.

A map is an addrmap of blocks: one regfile, `csr`, of registers of 32 bits; memories; other maps.
The compiler checks the language, overlaps and widths; what our hardware needs is checked here
in addition: blocks are aligned powers of two and rows of registers are at multiples of their
length, because it decodes an address by its upper bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from systemrdl import RDLCompileError, RDLCompiler
from systemrdl.messages import MessagePrinter, Severity
from systemrdl.node import AddressableNode, AddrmapNode, MemNode, Node, RegfileNode, RegNode
from systemrdl.source_ref import DetailedFileSourceRef, SourceRefBase
from systemrdl.udp import UDPDefinition

from asip_asm.regmap import (
    DATA_WIDTH,
    NUMBER,
    REGISTER_BLOCK,
    BitField,
    Block,
    Code,
    RegisterMap,
    RegisterRecord,
    by_name,
)

WORD_BYTES = DATA_WIDTH // 8
FAULTS = "fault_cause"  # the enumeration whose members are faults


class RegisterMapError(ValueError):
    """The register map is wrong; one line per finding, with file and line."""


class _Messages(MessagePrinter):
    """Keeps the compiler's findings."""

    def __init__(self) -> None:
        self.findings: list[str] = []

    def print_message(
        self, severity: Severity, text: str, src_ref: SourceRefBase | None = None
    ) -> None:
        place = f"{_place(src_ref)}: " if isinstance(src_ref, DetailedFileSourceRef) else ""
        self.findings.append(f"{place}{severity.name.lower()}: {text}")


def compile_map(
    path: Path, name: str, properties: Sequence[type[UDPDefinition]] = ()
) -> AddrmapNode:
    """Addrmap `name` of the file, elaborated. Raises RegisterMapError.

    `properties` are those that a tool adds to the language.
    """
    messages = _Messages()
    compiler = RDLCompiler(message_printer=messages)
    for definition in properties:
        compiler.register_udp(definition, soft=False)
    try:
        compiler.compile_file(str(path))
        return compiler.elaborate(name).top
    except RDLCompileError as error:
        raise RegisterMapError("\n".join(messages.findings or [str(error)])) from error


def read_map(path: Path, name: str) -> RegisterMap:
    """Register map of addrmap `name` of the file. Raises RegisterMapError."""
    top = compile_map(path, name)
    findings: list[str] = []
    blocks, registers = {}, {}
    enumerations: dict[str, dict[str, Code]] = {}
    children = top.children(unroll=False)
    for node in (child for child in children if isinstance(child, AddressableNode)):
        blocks[node.inst_name] = _block(node, findings)
        if isinstance(node, RegfileNode):
            for register in node.registers():
                registers[register.inst_name] = _register(register, findings)
                enumerations |= _enumerations(register, findings)
    if REGISTER_BLOCK not in blocks or not registers:
        findings.append(_finding(top, f"no regfile '{REGISTER_BLOCK}'; it contains the registers"))
    if findings:
        raise RegisterMapError("\n".join(findings))
    return RegisterMap(
        address_width=(top.size // WORD_BYTES - 1).bit_length(),
        blocks=blocks,
        registers=registers,
        faults=enumerations.pop(FAULTS, {}),
        enumerations=enumerations,
        title=top.get_property("name"),
        note=text_of(top),
    )


def _finding(node: Node, text: str) -> str:
    source = node.inst.inst_src_ref or node.inst.def_src_ref
    place = f"{_place(source)}: " if isinstance(source, DetailedFileSourceRef) else ""
    return f"{place}error: {node.inst_name}: {text}"


def _place(source: DetailedFileSourceRef) -> str:
    return f"{Path(source.path).name}:{source.line}"


def text_of(node: Node) -> str:
    """What the map says of a node."""
    return node.get_property("desc", default="") or ""


def fields_of(node: RegNode) -> dict[str, BitField]:
    """Fields of a register."""
    return by_name(*(BitField(f.inst_name, f.low, f.width, text_of(f)) for f in node.fields()))


def reset_of(node: RegNode) -> int | None:
    """Reset value of a register; None where no field states one."""
    resets = [(field.low, field.get_property("reset")) for field in node.fields()]
    stated = [value << low for low, value in resets if isinstance(value, int)]
    return sum(stated) if stated else None


def _block(node: AddressableNode, findings: list[str]) -> Block:
    words = node.size // WORD_BYTES
    base = node.raw_address_offset // WORD_BYTES
    fields, access = {}, "rw"
    if isinstance(node, RegfileNode):
        words = 1 << (words - 1).bit_length()  # what its registers need
    elif isinstance(node, MemNode):
        access = node.get_property("sw").name
        fields = {k: f for reg in node.registers() for k, f in fields_of(reg).items()}
    if words & (words - 1):
        findings.append(_finding(node, f"{words} words are not a power of two"))
    elif base % words:
        findings.append(_finding(node, f"base {base:#06x} is not a multiple of its {words} words"))
    return Block(node.inst_name, base, words, access, fields, text_of(node))


def _register(node: RegNode, findings: list[str]) -> RegisterRecord:
    if node.get_property("regwidth") != DATA_WIDTH:
        findings.append(_finding(node, f"registers have {DATA_WIDTH} bits"))
    for field in node.fields():
        if field.inst_name == NUMBER and field.low:
            findings.append(_finding(node, f"'{NUMBER}' is all of a register, from bit 0"))
    room = 1 << (node.n_elements - 1).bit_length()
    if node.raw_address_offset // WORD_BYTES % room:
        findings.append(_finding(node, f"so many registers begin at a multiple of {room} words"))
    return RegisterRecord(
        name=node.inst_name,
        offset=node.raw_address_offset // WORD_BYTES,
        access="r" * node.has_sw_readable + "w" * node.has_sw_writable,
        reset=reset_of(node),
        fields=fields_of(node),
        count=node.n_elements,
        doc=text_of(node),
    )


def _enumerations(node: RegNode, findings: list[str]) -> dict[str, dict[str, Code]]:
    """The enumerations that the register's fields show, by name."""
    found: dict[str, dict[str, Code]] = {}
    for field in node.fields():
        encode = field.get_property("encode")
        for member in encode or ():
            code = Code(member.name, member.value, member.rdl_desc or "")
            found.setdefault(type(member).type_name, {})[member.name] = code
            if not member.rdl_desc:
                findings.append(_finding(field, f"{member.name} has no desc"))
    return found
