# SPDX-License-Identifier: Apache-2.0
"""Refuse SystemVerilog outside the subset that every tool of the project reads in the same way.

The subset is what Verilator 5, slang, Yosys `read_verilog -sv` and, by published reports, Quartus
II 13.1 accept. Most rules work on text without comments, strings and attributes. Exit 1 if any rule
is broken.
"""

from __future__ import annotations

import functools
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pyslang.syntax import (
    CompilationUnitSyntax,
    GenerateBlockSyntax,
    SyntaxKind,
    SyntaxTree,
)
from rich.console import Console

from asip_asm.command import command, script_parser

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Rule:
    """One construct to refuse: `pattern` finds it, `cure` says what to write instead."""

    name: str
    pattern: str
    message: str
    cure: str


@dataclass(frozen=True)
class Finding:
    """A broken rule; `line` counts from 1."""

    path: Path
    line: int
    rule: str
    text: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.rule}: {self.text}"


RULES = (
    Rule("import", r"\bimport\b", "import of a package", "name it in place: pkg::item"),
    Rule("assignment-pattern", r"'\{", "assignment pattern '{..}", "concatenate, or assign fields"),
    Rule("return", r"\breturn\b", "return", "assign to the function's name"),
    Rule(
        "unique-priority",
        r"\b(unique0?|priority)\s+(case[xz]?|if)\b",
        "unique or priority",
        "plain case with a default",
    ),
    Rule(
        "loop", r"\b(foreach|break|continue|do)\b", "foreach, break, continue or do", "for (int ..)"
    ),
    Rule("inside", r"\binside\b", "inside", "casez or comparisons"),
    Rule("wildcard-equality", r"[=!]=\?", "==? or !=?", "casez or a mask"),
    Rule("interface", r"\b(interface|modport)\b", "interface or modport", "plain ports"),
    Rule(
        "parameter-kind",
        r"\b(parameter|localparam)\s+(string|type|real|shortreal|realtime)\b",
        "string, type or real parameter",
        "an integer or a vector; a package type",
    ),
    Rule("real", r"\b(real|shortreal|realtime)\b", "real number", "an integer computed beforehand"),
    Rule("string", r"\bstring\b", "string variable", "a vector of characters"),
    Rule("streaming", r"\{\s*(<<|>>)", "streaming operator", "a for loop over the bits"),
    Rule(
        "concurrent-assertion",
        r"\b((assert|assume|cover)\s+property|property|sequence|restrict)\b",
        "concurrent assertion",
        "immediate assert in a clocked block behind `ifndef SYNTHESIS",
    ),
    Rule("assert-else", r"\bassert\b[^;]*\belse\b", "assert .. else", "if (!condition) $error"),
    Rule(
        "bits-of-package-type",
        r"\$bits\s*\(\s*\w+::",
        "$bits of a package type",
        "a width constant next to the type",
    ),
    Rule(
        "cast-of-product",
        r"\w'\s*\((?!\s*\()[^()]*\*",
        "product inside a size cast, where the standard keeps its factors' width",
        "assign the product to a vector of its full width",
    ),
    Rule(
        "operator-before-cast",
        r"(?:[=(,?:<>&|^+*/%{[-]\s*[-~!]|[=(,?:{[]\s*[&|^])\s*\w+'\s*\(",
        "unary operator before a size cast, which Yosys takes for part of the size",
        "parentheses around the cast: -(8'(..))",
    ),
    Rule("cast-of-bits", r"'\s*\(\s*\$bits", "size cast of $bits", "a localparam of that width"),
    Rule(
        "enum-method",
        r"\w\.(next|prev|first|last|num|name)\b(?!_)",
        "enumeration method",
        "a case or arithmetic on the value",
    ),
    Rule(
        "initialiser",
        r"(?m)^\s*(automatic\s+)?(logic|bit|reg|byte|int|integer)\b[^;=({]*=(?!=)",
        "variable declared with a value",
        "declare, then assign (a local), or reset (a register)",
    ),
    Rule(
        "automatic-local",
        r"(?<!function )(?<!task )\bautomatic\b",
        "automatic local",
        "a plain local of the named block or a function",
    ),
    Rule(
        "unpacked-struct", r"\b(struct|union)\b(?!\s+packed)", "unpacked struct or union", "packed"
    ),
    Rule(
        "packed-2d-constant",
        r"\b(localparam|parameter)\b(\s+\w+)*\s*\[[^\]]*\]\s*\[[^\]]*\]\s*\w+\s*=",
        "constant with two packed dimensions",
        "a flat constant and a slice",
    ),
    Rule(
        "constant-array",
        r"\b(localparam|parameter)\b[^;=]*\]\s*=",
        "constant array",
        "a case function or a flat constant and a slice",
    ),
    Rule(
        "array-size-form",
        r"(?m)^\s*(logic|reg|bit|wire)\b(\s*\[[^\]]*\])*\s+\w+\s*\[[^\]:]+\]\s*[;,]",
        "unpacked dimension given as a size",
        "a range, [0:N-1]",
    ),
    Rule(
        "genvar",
        r"\bfor\s*\(\s*genvar\b",
        "genvar declared in a for, which Quartus refuses",
        "genvar i; before the region",
    ),
    Rule(
        "read-memory-file", r"\$readmem[bh]\b", "$readmemh", "values in a case function, or a host"
    ),
    Rule(
        "constant-case",
        r"\bcase[xz]?\s*\(\s*\d*'[bdh]\w+\s*\)",
        "case of a constant, which Quartus decides wrongly",
        "if .. else if",
    ),
    Rule(
        "double-semicolon",
        r";\s*;",
        "empty item, which Quartus refuses",
        "one semicolon",
    ),
    Rule(
        "enum-kind", r"\benum\b(?!\s+logic\s*\[)", "enumeration without a width", "enum logic [1:0]"
    ),
    Rule(
        "state-constant",
        r"\blocalparam\s+logic\s*\[[^\]]*\]\s*St[A-Z]\w*\s*=",
        "state as a constant, which waves show as a number",
        "typedef enum logic [1:0] {..} state_e",
    ),
    Rule(
        "enum-value",
        r"\benum\b[^{;]*\{[^}]*?=\s*\d+\s*(?=[,}])",
        "value of an enumeration without a width, which Quartus refuses",
        "2'd1",
    ),
    Rule(
        "declaration",
        r"\b(let|timeunit|timeprecision|class|program|clocking|always_latch)\b",
        "let, timeunit, class, program, clocking or latch",
        "a function; none; a register",
    ),
)
GENERATE = Rule(
    "generate-region",
    "",
    "generate loop or condition outside of a region, which Quartus refuses",
    "generate .. endgenerate around it",
)
UNNAMED = Rule(
    "unnamed-generate",
    "",
    "generate block without a name, which Quartus refuses in a loop",
    "begin : gen_name",
)
PORT_DIRECTION = Rule(
    "port-direction",
    "",
    "port without a direction of its own, which Quartus refuses",
    "input logic or output logic for each",
)
ENUM_ARRAY = Rule(
    "enum-array", "", "packed array of an enumeration", "a vector, or one variable for each"
)
UNCLOCKED_READ = Rule(
    "unclocked-read",
    "",
    "array read outside of a clocked process: in Quartus registers, no memory",
    "register the read; or ram_lut; or a row of UNCLOCKED",
)
# Arrays that are meant to be registers: few words, or all of them are read in one clock.
UNCLOCKED = {
    "asip_lockstep": ("safe",),
    "debug_capture": ("own",),
    "debug_scope": ("levels",),
    "drive_front_end": ("samples_q",),
    "ecat_fmmus": ("column_q",),
    "ecat_ports": ("back_data_q",),
    "ecat_unit": ("data_q",),
    "quadrature_decoder": ("lasted_q",),
}
MEMORY_ATTRIBUTE = Rule(
    "memory-attribute",
    r"\(\*[^*]*\b(ramstyle|ram_style|no_rw_check)\b",
    "memory attribute outside rtl/memory",
    "an instance of ram_block, ram_lut or ram_two_ports",
)
UNPACKED_PORT = Rule("unpacked-port", "", "unpacked array port", "a packed vector, [N-1:0][31:0]")
DEFAULT_ARGUMENT = Rule("default-argument", "", "default value of an argument", "pass every one")
RESULT_FIELD = Rule(
    "result-field", "", "field of a function's result assigned", "a local variable, then f = local"
)
# What an array in rtl/memory has: read in a clocked process, or outside.
CLOCKED, ASYNCHRONOUS = '(* ramstyle = "no_rw_check", no_rw_check *)', '(* ramstyle = "MLAB" *)'
BARE_MEMORY = Rule(
    "bare-memory", "", "memory of rtl/memory without its attribute", f"{CLOCKED} or {ASYNCHRONOUS}"
)
SIMULATION_ONLY = Rule(
    "simulation-only",
    r"(\bassert\b|\$(error|fatal|warning|info|display|finish)\b)",
    "assertion or message in synthesis",
    "put it behind `ifndef SYNTHESIS",
)
ALL_RULES = (
    *RULES,
    *(GENERATE, UNNAMED, PORT_DIRECTION, ENUM_ARRAY, UNCLOCKED_READ, MEMORY_ATTRIBUTE),
    *(UNPACKED_PORT, DEFAULT_ARGUMENT, RESULT_FIELD, BARE_MEMORY, SIMULATION_ONLY),
)


def bare(text: str) -> str:
    """Text with comments, attributes and the inside of strings blanked, line breaks unchanged."""

    def blank(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match[0])

    pattern = r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*.*?\*/|\(\*\s*\w.*?\*\)'
    return re.sub(pattern, blank, text, flags=re.S)


def _synthesised(text: str) -> str:
    """Text with everything between `ifndef SYNTHESIS and its `else or `endif blanked."""
    lines, conditions = [], []
    for line in text.split("\n"):
        word = re.match(r"\s*`(ifdef|ifndef|else|elsif|endif)\b\s*(\w*)", line)
        if word and word[1] in ("ifdef", "ifndef"):
            conditions.append((word[1], word[2]) == ("ifndef", "SYNTHESIS"))
        elif word and word[1] == "endif" and conditions:
            conditions.pop()
        elif word and conditions:
            conditions[-1] = False
        lines.append("" if any(conditions) else line)
    return "\n".join(lines)


def _parenthesised(text: str, start: int) -> tuple[int, int]:
    """Positions inside the parentheses that open at text[start]; the end is the closing one."""
    depth = 0
    for at in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[at], 0)
        if depth == 0:
            return start + 1, at
    return start + 1, len(text)


def _pieces(text: str, begin: int, end: int) -> Iterator[tuple[int, str]]:
    """Parts of text[begin:end] between commas outside brackets, with their positions."""
    depth, start = 0, begin
    for at in range(begin, end):
        depth += {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}.get(text[at], 0)
        if text[at] == "," and depth == 0:
            yield start, text[start:at]
            start = at + 1
    yield start, text[start:end]


def _generates_outside(text: str) -> Iterator[int]:
    """Positions of generate constructs that are members of a module, not of a region."""
    kinds = SyntaxKind.LoopGenerate, SyntaxKind.IfGenerate, SyntaxKind.CaseGenerate
    root = SyntaxTree.fromText(text).root
    # slang returns a single module as the root.
    modules = root.members if isinstance(root, CompilationUnitSyntax) else [root]
    for module in modules:
        for member in getattr(module, "members", ()):
            if member.kind in kinds:
                yield member.sourceRange.start.offset


def _unnamed(text: str) -> Iterator[int]:
    """Positions of the blocks of generate loops and conditions that have no name."""
    pattern = r"\bbegin\b(?!\s*:)"
    kinds = SyntaxKind.LoopGenerate, SyntaxKind.IfGenerate
    found: list[int] = []

    def visit(node: object) -> None:
        if isinstance(node, GenerateBlockSyntax):
            start = node.sourceRange.start.offset
            if node.parent.kind in kinds or node.parent.kind == SyntaxKind.ElseClause:
                if re.match(pattern, text[start:]):
                    found.append(start)

    SyntaxTree.fromText(text).root.visit(visit)
    yield from found


def _enumerations(text: str) -> set[str]:
    """Names of the types that a text declares as enumerations."""
    return set(re.findall(r"\benum\b[^{;]*\{[^}]*\}\s*(\w+)\s*;", text))


@functools.cache
def _package_enumerations() -> frozenset[str]:
    """The same of the project's packages."""
    files = (ROOT / "rtl").rglob("*_pkg.sv")
    return frozenset(name for path in files for name in _enumerations(bare(path.read_text())))


def _enum_arrays(text: str) -> Iterator[int]:
    """Positions of declarations with packed dimensions on an enumeration."""
    names = "|".join(sorted(_enumerations(text) | _package_enumerations()))
    for match in re.finditer(rf"\b(?:\w+::)?(?:{names})\s*\[[^\]]*\]\s*\w+", text):
        yield match.start()


ARRAY = re.compile(r"(?m)^\s*logic\b(?:\s+signed)?(?:\s*\[[^\]]*\])*\s*(\w+)\s*\[[^\]]*:[^\]]*\]")


def _unclocked_reads(source: str, stem: str) -> Iterator[int]:
    """Positions of reads of an array outside of clocked processes, where it should be a memory."""
    item = r"\b(always_ff|always_comb|always\s*@|assign|initial|function|logic)\b"
    starts = [(match.start(), match[1]) for match in re.finditer(item, source)]
    for declared in ARRAY.finditer(source):
        name = declared[1]
        if name in UNCLOCKED.get(stem, ()):
            continue
        for use in re.finditer(rf"\b{name}\s*\[", source):
            kind = next((word for at, word in reversed(starts) if at < use.start()), "logic")
            if kind in ("always_comb", "assign", "function"):
                yield use.start()


def _port_lists(text: str) -> Iterator[tuple[str, str, int, int]]:
    """(keyword, name, begin, end) of every module, function and task port list."""
    head = r"\b(module|function|task)\b[^;(#]*?(\w+)\s*(?=[(#;])"
    for match in re.finditer(head, text):
        at = match.end()
        if text[at] == "#":
            at = _parenthesised(text, text.index("(", at))[1] + 1
            at += len(text[at:]) - len(text[at:].lstrip())
        if text[at : at + 1] == "(":
            yield match[1], match[2], *_parenthesised(text, at)


def check(text: str, path: Path = Path("<text>")) -> list[Finding]:
    """Findings in a source text, in order of lines."""
    source = bare(text)
    found: list[tuple[int, Rule]] = []
    for rule in RULES:
        found += [(match.start(), rule) for match in re.finditer(rule.pattern, source)]
    found += [(at, GENERATE) for at in _generates_outside(text)]
    found += [(at, UNNAMED) for at in _unnamed(text)]
    found += [(at, ENUM_ARRAY) for at in _enum_arrays(source)]
    unclocked = list(_unclocked_reads(source, path.stem))
    if path.parent.parts[-2:] != ("rtl", "memory"):
        attributes = re.finditer(MEMORY_ATTRIBUTE.pattern, text)
        found += [(match.start(), MEMORY_ATTRIBUTE) for match in attributes]
        found += [(at, UNCLOCKED_READ) for at in unclocked]
    else:
        wanted = re.escape(ASYNCHRONOUS if unclocked else CLOCKED)
        for declared in ARRAY.finditer(source):
            if not re.search(rf"{wanted}\s*(?:`endif)?\s*logic[^;]*$", text[: declared.start(1)]):
                found.append((declared.start(), BARE_MEMORY))
    kept = _synthesised(source)
    for match in re.finditer(SIMULATION_ONLY.pattern, kept):
        line = kept.count("\n", 0, match.start())
        found.append((sum(len(row) + 1 for row in source.split("\n")[:line]), SIMULATION_ONLY))
    for keyword, name, begin, end in _port_lists(source):
        for at, piece in _pieces(source, begin, end):
            if piece.split("=")[0].rstrip().endswith("]"):
                found.append((at + len(piece) - len(piece.lstrip()), UNPACKED_PORT))
            directed = re.match(r"\s*(input|output|inout)\b", piece)
            if keyword == "module" and piece.strip() and not directed:
                found.append((at + len(piece) - len(piece.lstrip()), PORT_DIRECTION))
            if keyword != "module" and "=" in piece:
                found.append((at + len(piece) - len(piece.lstrip()), DEFAULT_ARGUMENT))
        if keyword == "function":
            stop = source.find("endfunction", end)
            fields = re.compile(rf"\b{name}\.\w+[^;]*?<?=(?!=)")
            found += [(m.start(), RESULT_FIELD) for m in fields.finditer(source, end, stop)]
    findings = []
    for at, rule in found:
        # A pattern may begin in the blanks before the construct.
        at += len(source[at:]) - len(source[at:].lstrip())
        line = source.count("\n", 0, at) + 1
        findings.append(Finding(path, line, rule.name, f"{rule.message}; write: {rule.cure}"))
    return sorted(set(findings), key=lambda finding: (finding.line, finding.rule))


@command("scripts/rtl_subset.py")
def main(argv: list[str] | None = None) -> int:
    """Command line; exit 0 clean, 1 findings."""
    parser = script_parser(__doc__, "python scripts/rtl_subset.py rtl/asip/asip.sv")
    parser.add_argument("files", nargs="*", type=Path, help="default: every .sv below rtl/")
    parser.add_argument("--rules", action="store_true", help="list the rules and their cures")
    options = parser.parse_args(argv)
    console = Console(soft_wrap=True, highlight=False, markup=False)
    if options.rules:
        for rule in ALL_RULES:
            console.print(f"{rule.name}: {rule.message}; write: {rule.cure}")
        return 0
    files = options.files or sorted((ROOT / "rtl").rglob("*.sv"))
    findings = [found for path in files for found in check(path.read_text(), path)]
    for finding in findings:
        console.print(str(finding))
    console.print(f"rtl_subset: {len(files)} files, {len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
