# SPDX-License-Identifier: Apache-2.0
"""C of a compiled law: one function for a tick, with the operations of the core's program in their
order, for a PC and for the Nios II systems. Loops of the program are loops of the C (`c_loops`).

The text needs a C11 compiler and its library, on FPGA2 also `gen/ci.h`. Every operation rounds once
to binary32; NAME_FUSED chooses how a multiply-add does: 1, once, as on the core; 0, product and sum
each, as machines without the instruction (the default on Nios II). With 1 the bits are those of the
core, except sine and cosine, which are the C library's; on FPGA2 they are the core's unit.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np

from asip_asm.c_image import comment, identifier
from asip_asm.model.c_helpers import C_WORDS, FORMS, FUSED, HELPERS, PRELUDE, TESTS
from asip_asm.model.c_loops import LoopBody, kept_blocks
from asip_asm.model.compiler import Compiled
from asip_asm.model.emit import INT_OPERANDS, literal
from asip_asm.model.graph import INT_KINDS, LEAVES, Graph, Node, Rewriter, binary32
from asip_asm.model.law import Law, Port, before
from asip_asm.model.read import ModelError


def to_c_code(compiled: Compiled, header_name: str) -> tuple[str, str]:
    """Header and source text; `header_name` is the file that the source includes."""
    if not header_name.isprintable() or {*'"\\'} & {*header_name}:
        raise ModelError(f"{header_name!r} cannot be included by C; name the output otherwise")
    prefix = identifier(compiled.law.title) or "law"
    made = _Source if compiled.plan is None else _Looped
    return _header(compiled, prefix), made(compiled, prefix, header_name).text()


class _Unfuse(Rewriter):
    def visit(self, index: int, node: Node, args: Sequence[int]) -> int:
        if node.op not in FUSED:
            return super().visit(index, node, args)
        product = self.new.add("fmul", args[0], args[1])
        if node.op == "fmadd":
            return self.new.add("fadd", product, args[2])
        if node.op == "fmsub":
            return self.new.add("fsub", product, args[2])
        if node.op == "fnmsub":
            return self.new.add("fsub", args[2], product)
        return self.new.add("fsub", self.new.add("fnmul", args[0], args[1]), args[2])


def unfused(graph: Graph) -> Graph:
    """The core operations with each multiply-add as a product and a sum: what NAME_FUSED 0 does."""
    return _Unfuse(graph).run()


def members(ports: Iterable[str]) -> dict[str, str]:
    """Name in C of each signal: ASCII, no word of C or C++, each different."""
    found: dict[str, str] = {}
    for name in ports:
        plain = re.sub(r"\W", "_", name, flags=re.ASCII)
        while plain in C_WORDS or plain in found.values():
            plain += "_"
        found[name] = plain
    return found


def struct_members(law: Law) -> dict[str, list[tuple[str, str]]]:
    """Words of the structures `inputs`, `states`, `outputs` in order: (signal, type in C).

    The last counts of rates follow the states, and the exports follow the outputs.
    """
    kinds = {"float": "float", "int": "int32_t"}
    rates = [(before(port.rate_of), "int32_t") for port in law.of_kind("rate")]
    return {
        "inputs": [(p.name, kinds[p.type]) for p in law.of_kind("input")],
        "states": [*((p.name, "float") for p in law.of_kind("state")), *rates],
        "outputs": [(p.name, "float") for p in (*law.of_kind("output"), *law.of_kind("export"))],
    }


def words_of(compiled: Compiled) -> dict[str, list[tuple[str, str]]]:
    """The words of `struct_members`, and among the states each word of the blocks of data memory
    that a program of loops keeps from tick to tick.
    """
    groups = struct_members(compiled.law)
    if compiled.plan is not None:
        groups["states"] += [
            (f"{block}_{k}", "float")
            for block, words in kept_blocks(compiled.plan).items()
            for k in range(words)
        ]
    return groups


def parameter_macros(law: Law, prefix: str) -> dict[str, str]:
    """Macro of each parameter, each different and none of the file's own."""
    taken = {f"{prefix}_fused".upper(), f"{prefix}_tick_h".upper()}
    found: dict[str, str] = {}
    for port in law.of_kind("parameter"):
        macro = re.sub(r"\W", "_", f"{prefix}_{port.name}", flags=re.ASCII).upper()
        while macro in taken:
            macro += "_"
        taken.add(macro)
        found[port.name] = macro
    return found


def c_literal(value: float) -> str:
    """The binary32 number nearest to `value`; the sign in parentheses. Raises ModelError."""
    literal(value)  # refuses what is no number
    single = binary32(value)
    text = f"{np.abs(single)!s}f"
    return f"(-{text})" if np.signbit(single) else text


# ---------------------------------------------------------------------- header
def _header(compiled: Compiled, prefix: str) -> str:
    law = compiled.law
    guard = f"{prefix}_tick_h".upper()
    lines = [
        f"/* {comment(law.doc or law.title)}",
        " * Written by microtick: one tick in binary32, the operations of the core's program. */",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        "#include <stdint.h>",
        "",
    ]
    lines += _parameters(law, prefix)
    lines += ["#ifdef __cplusplus", 'extern "C" {', "#endif", ""]
    titles = {
        "inputs": "Inputs of a tick.",
        "states": "What is kept from tick to tick.",
        "outputs": "Outputs of a tick.",
    }
    for group, words in struct_members(law).items():
        lines += [f"/* {titles[group]} */", f"struct {prefix}_{group} {{"]
        names = members(name for name, _ in words)
        rows = [_member(law, name, kind, names[name]) for name, kind in words]
        if group == "states" and compiled.plan is not None:
            blocks = kept_blocks(compiled.plan).items()
            rows += [f"  float {block}[{count}];" for block, count in blocks]
        lines += rows or ["  int32_t none;"]
        lines += ["};", ""]
    lines += [
        "/* States before the first tick, outputs after a fault. */",
        f"extern const struct {prefix}_states {prefix}_initial;",
        f"extern const struct {prefix}_outputs {prefix}_safe;",
        "",
        f"/* One tick, {law.rate:g} a second. Returns 0; or 1 if an output is infinite or no",
        " * number: then the outputs are the safe ones and the states stay. */",
        f"int {prefix}_tick(const struct {prefix}_inputs *in, struct {prefix}_states *state,",
        f"    struct {prefix}_outputs *out);",
        "",
        "#ifdef __cplusplus",
        "}",
        "#endif",
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def _parameters(law: Law, prefix: str) -> list[str]:
    lines = []
    macros = parameter_macros(law, prefix)
    for port in law.of_kind("parameter"):
        macro = macros[port.name]
        lines += [
            f"/* {_describe(port)}; -D{macro}=value replaces it. */",
            f"#ifndef {macro}",
            f"#define {macro} {c_literal(port.initial)}",
            "#endif",
            "",
        ]
    return lines


def _member(law: Law, name: str, kind: str, c_name: str) -> str:
    port = next((p for p in law.ports if p.name == name), None)
    if port is None:
        note = "count of the last tick; at first the present count"
    else:
        note = _describe(port)
    return f"{f'  {kind} {c_name};':<30} /* {note} */"


def _describe(port: Port) -> str:
    text = f"{port.meaning} [{port.unit}]".strip()
    if port.limits is not None:
        text += f", {port.limits[0]:g} .. {port.limits[1]:g}"
    if port.type == "int":
        text += f"; value = {port.scale:.9g}*count + {port.offset:g}"
    return comment(text)


# ---------------------------------------------------------------------- source
class _Source:
    def __init__(self, compiled: Compiled, prefix: str, header_name: str) -> None:
        self.graph, self.law = compiled.graph, compiled.law
        self.prefix, self.header_name = prefix, header_name
        law = self.law
        self.groups = struct_members(law)
        self.names: dict[int, str] = {}
        self.used: set[str] = set()
        inputs = members(name for name, _ in self.groups["inputs"])
        states = members(name for name, _ in self.groups["states"])
        self.sources = {name: f"in->{c}" for name, c in inputs.items()}
        self.sources |= {name: f"was.{c}" for name, c in states.items()}
        self.sources |= parameter_macros(law, prefix)

    def text(self) -> str:
        """The whole source."""
        tables, body = self._tables(), self._body()
        ends = self._ends()
        p = self.prefix
        fused = f"{p}_fused".upper()
        head = [
            f"/* {comment(self.law.doc or self.law.title)}",
            " * Written by microtick. Compile it with -ffp-contract=off. */",
            f'#include "{self.header_name}"',
            "",
            PRELUDE,
            "/* Multiply-adds: 1, rounded once as on the core; 0, product and sum rounded. */",
            f"#ifndef {fused}",
            "#ifdef __nios2__",
            f"#define {fused} 0",
            "#else",
            f"#define {fused} 1",
            "#endif",
            "#endif",
            "",
            *self._fused(fused),
            *(text for name, text in HELPERS.items() if name in self.used),
            *tables,
            self._constant("states", "initial"),
            self._constant("outputs", "safe"),
            f"int {p}_tick(const struct {p}_inputs *in, struct {p}_states *state,",
            f"    struct {p}_outputs *out) {{",
            *self._arguments(body + ends),
        ]
        return "\n".join([*head, *body, *ends, "  return 0;", "}", ""])

    def _tables(self) -> list[str]:
        return []

    def _body(self) -> list[str]:
        return [line for i in self.graph.used() for line in self._operation(i)]

    def _arguments(self, lines: list[str]) -> list[str]:
        """States before the tick; words for a compiler that warns of what a law does not use."""
        text = "\n".join(lines)
        found = []
        if "was." in text:
            found.append(f"  const struct {self.prefix}_states was = *state;")
        elif "state->" not in text:
            found.append("  (void)state;")
        if "in->" not in text:
            found.append("  (void)in;")
        return found

    def _fused(self, macro: str) -> list[str]:
        ops = [op for op in FUSED if op in self.used]
        if not ops:
            return []
        lines = []
        for kind, guard in enumerate((f"#if {macro}", "#else")):
            lines.append(guard)
            for op in ops:
                form = FUSED[op][kind].format("(a)", "(b)", "(c)")
                lines.append(f"#define {op}_(a, b, c) ({form})")
        return [*lines, "#endif", ""]

    def _constant(self, group: str, what: str) -> str:
        rows = []
        names = members(name for name, _ in self.groups[group])
        for port in self.law.ports:
            value = port.initial if what == "initial" else port.safe
            if port.name in names and value:
                rows.append(f"    .{names[port.name]} = {c_literal(value)},")
        p = self.prefix
        if not rows:
            rows = [f"    .{next(iter(names.values()), self._first(group))} = 0,"]
        return "\n".join([f"const struct {p}_{group} {p}_{what} = {{", *rows, "};", ""])

    def _first(self, group: str) -> str:
        """First member of a structure without signals."""
        return "none"

    def _is_int(self, i: int) -> bool:
        node = self.graph.nodes[i]
        if node.op in ("sel", "selge", "selgt"):
            return self._is_int(node.args[1])
        return node.op in INT_KINDS

    def _operand(self, node: Node, position: int, whole: bool) -> str:
        """Argument of an operation, its bits where it is read as the other type."""
        chosen = node.op.startswith("sel") and position > 0
        return self._value(node.args[position], whole if chosen else node.op in INT_OPERANDS)

    def _operation(self, i: int) -> list[str]:
        node = self.graph.nodes[i]
        if node.op in LEAVES:
            self.names[i] = self._leaf(node)
            return []
        whole = self._is_int(i)
        args = [self._operand(node, k, whole) for k in range(len(node.args))]
        form = FORMS.get(node.op)
        if node.op == "sel" and self.graph.nodes[node.args[0]].op in TESTS:
            form = "{0} != 0.0f ? {1} : {2}"
        if form is None:
            self.used.add(node.op)
            form = f"{node.op}_({', '.join(f'{{{k}}}' for k in range(len(args)))})"
        self.names[i] = f"t{i}"
        return [f"  const {'int32_t' if whole else 'float'} t{i} = {form.format(*args)};"]

    def _leaf(self, node: Node) -> str:
        if node.op == "const":
            return c_literal(node.number)
        if node.op == "int_const":
            value = (int(node.number) + (1 << 31)) % (1 << 32) - (1 << 31)
            return "INT32_MIN" if value == -(1 << 31) else f"({value})" if value < 0 else f"{value}"
        return self.sources[str(node.value)]

    def _value(self, i: int, integer: bool) -> str:
        """A value as an integer or a float: its bits where it is the other of them."""
        if self._is_int(i) == integer:
            return self.names[i]
        helper = "bits" if integer else "number"
        self.used.add(helper)
        return f"{helper}_({self.names[i]})"

    def _ends(self) -> list[str]:
        names = members(name for name, _ in self.groups["outputs"])
        values = self._outputs()
        checks = [f"fabsf({values[p.name]}) <= FLT_MAX" for p in self.law.of_kind("output")]
        lines = []
        if checks:
            tests = " &&\n        ".join(checks)
            lines += ["", f"  if (!({tests})) {{", f"    *out = {self.prefix}_safe;"]
            lines += ["    return 1;", "  }"]
        lines += [f"  out->{names[n]} = {value};" for n, value in values.items()]
        return [*lines, *self._states()]

    def _outputs(self) -> dict[str, str]:
        """Expressions of the outputs."""
        return {n: self._value(i, False) for n, i in self.graph.outputs.items()}

    def _states(self) -> list[str]:
        """Lines that write the states."""
        lines = []
        kept = members(name for name, _ in self.groups["states"])
        kinds = dict(self.groups["states"])
        for name, root in self.graph.next_states.items():
            lines.append(f"  state->{kept[name]} = {self._value(root, kinds[name] != 'float')};")
        return lines


class _Looped(_Source):
    """Of a program of loops and streams: its memory is a copy of the states until the tick ends."""

    def __init__(self, compiled: Compiled, prefix: str, header_name: str) -> None:
        super().__init__(compiled, prefix, header_name)
        assert compiled.plan is not None
        self.loops = LoopBody(compiled.plan, self.sources)
        self.used = self.loops.used

    def _tables(self) -> list[str]:
        return self.loops.tables()

    def _body(self) -> list[str]:
        return [*self.loops.declarations(), *self.loops.body]

    def _arguments(self, lines: list[str]) -> list[str]:
        if not self.loops.kept:
            return super()._arguments(lines)
        copy = f"  struct {self.prefix}_states next = *state;"
        return [*super()._arguments([*lines, "state->"]), copy]

    def _first(self, group: str) -> str:
        blocks = self.loops.kept if group == "states" else {}
        return next((f"{block}[0]" for block in blocks), super()._first(group))

    def _outputs(self) -> dict[str, str]:
        return {port.name: self.loops.output(port.name) for port in self.law.of_kind("output")}

    def _states(self) -> list[str]:
        return ["  *state = next;"] if self.loops.kept else []
