# SPDX-License-Identifier: Apache-2.0
"""Linear assembly of a graph of core operations, with the source expression of every operation as
its comment.

Constants that find no room in bank K beside inputs and parameters, those read least, are words of
data memory, loaded once in a run.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from asip_asm.assembly_text import note, quoted
from asip_asm.isa import default_isa
from asip_asm.model.graph import INT_KINDS, LEAVES, Graph, Node
from asip_asm.model.law import Law, Port, before
from asip_asm.model.read import ModelError

INFIX = {
    "fmadd": "{0}*{1} + {2}",
    "fnmsub": "{2} - {0}*{1}",
    "fmsub": "{0}*{1} - {2}",
    "fnmadd": "-{0}*{1} - {2}",
    "fmul": "{0}*{1}",
    "fnmul": "-{0}*{1}",
    "fadd": "{0} + {1}",
    "fsub": "{0} - {1}",
    "fneg": "-{0}",
    "fdiv": "{0}/{1}",
    "flt": "{0} < {1}",
    "fle": "{0} <= {1}",
    "feq": "{0} == {1}",
    "sel": "{0} ? {1} : {2}",
    "selge": "{0} >= 0 ? {1} : {2}",
    "selgt": "{0} > 0 ? {1} : {2}",
    "iadd": "{0} + {1}",
    "isub": "{0} - {1}",
    "i2f": "float({0})",
    "f2i": "int({0})",
    "f2it": "trunc({0})",
    "fabs": "|{0}|",
}
INT_OPERANDS = frozenset({"iadd", "isub", "i2f"})
ANY_OPERANDS = {"sel": (1, 2), "selge": (1, 2), "selgt": (1, 2), "mov": (0,)}
COMMENT = 60
"""Characters of an expression in a comment."""


def binary32(value: float) -> np.float32:
    """The constant as the core holds it."""
    with np.errstate(over="ignore"):
        return np.float32(value)


def literal(value: float) -> str:
    """Text that the assembler reads as the binary32 number nearest to `value`."""
    single = binary32(value)
    if not np.isfinite(single):
        raise ModelError(f"the constant {value:g} is too large for binary32")
    text = str(single)
    if np.float32(float(text)) != single or (single == 0 and np.signbit(single)):
        return f"0f{single.view(np.uint32):08x}"
    return text


def emit(graph: Graph, law: Law, constants: int | None = None) -> str:
    """Source text of the program, with at most so many constants in bank K (None: all that fit).

    Raises ModelError where a limit of the core is met.
    """
    return _Emitter(graph, law, constants).text()


class _Emitter:
    def __init__(self, graph: Graph, law: Law, constants: int | None) -> None:
        self.graph = graph
        self.law = law
        self.constants = constants
        self.order = graph.used()
        self.uses = graph.uses()
        self.names: dict[int, str] = {}
        self.expressions: dict[int, str] = {}
        self.body: list[str] = []
        self.taken = {port.name for port in law.ports}
        self.in_data = self._choose_data()
        self.last_read = self._last_reads()

    def _last_reads(self) -> dict[str, float]:
        """Position of the last operation that reads the old value of each state."""
        nodes = self.graph.nodes
        reads: list[tuple[float, Node]] = [
            (i, nodes[arg]) for i in self.order for arg in nodes[i].args
        ]
        reads += [(float("inf"), nodes[root]) for root in self.graph.roots()]
        return {str(node.value): i for i, node in reads if node.op in ("state", "int_state")}

    # ------------------------------------------------------------------ constants
    def _choose_data(self) -> list[float]:
        """Constants that go to data memory."""
        isa = default_isa()
        words = sum(p.kind in ("input", "parameter") for p in self.law.ports)
        reads: Counter[float] = Counter()
        for i in self.order:
            node = self.graph.nodes[i]
            if node.op == "int_const" and node.value != 0:
                words += 1
            if node.op == "const" and binary32(node.number) != 0:
                reads[float(binary32(node.number))] += self.uses[i]
        room = isa.banks["K"].size - words
        if room < 0:
            raise ModelError(
                f"{self.law.title}: {words} inputs, parameters and integers, bank K holds "
                f"{isa.banks['K'].size} words; take fewer inputs"
            )
        if self.constants is not None:
            room = min(room, self.constants)
        ranked = [value for value, _ in reads.most_common()]
        if len(ranked) - room > isa.data_words:
            raise ModelError(
                f"{self.law.title}: {len(ranked)} constants, {max(room, 0)} places are left for "
                f"them in bank K and {isa.data_words} in data memory; divide the law into several "
                "functions, or compute constants from others"
            )
        return ranked[room:]

    # ------------------------------------------------------------------ text
    def text(self) -> str:
        """The whole source."""
        law = self.law
        for i in self.order:
            self._operation(i)
        self._ends()
        head = [
            f"; {note(law.doc or law.title)}: written by asip-model, schedule it with asip-as.",
            "",
            f".program  {quoted(law.title)}",
        ]
        return "\n".join([*head, *self._declarations(), "", *self.body, "        halt", ""])

    def _declarations(self) -> list[str]:
        rows: list[str] = []
        for port in self.law.of_kind("input"):
            kind = " : int" if port.type == "int" else ""
            rows.append(_row(f".input    {port.name}{kind}", port))
        for port in self.law.of_kind("parameter"):
            rows.append(_row(f".param    {port.name} = {literal(port.initial)}", port))
        for port in self.law.of_kind("state"):
            rows.append(_row(f".state    {port.name} = {literal(port.initial)}", port))
        for port in self.law.of_kind("rate"):
            name = before(port.rate_of)
            rows.append(f".state    {name} : int = 0    ; {port.rate_of} of the last tick")
        for port in self.law.of_kind("output"):
            rows.append(_row(f".output   {port.name}, safe = {literal(port.safe)}", port))
        exports = [port.name for port in self.law.of_kind("export")]
        rows += [f".export   {name}" for name in exports]
        rows += [f".data     {self._data_name(v)} = {literal(v)}" for v in self.in_data]
        return ["", *rows]

    def _data_name(self, value: float) -> str:
        return f"data_{self.in_data.index(value)}"

    # ------------------------------------------------------------------ operations
    def _operation(self, i: int) -> None:
        node = self.graph.nodes[i]
        if node.op in LEAVES:
            self.names[i] = self.expressions[i] = self._leaf(node)
            return
        name = self._direct(i) or self._temporary(node)
        args = [self.expressions[arg] for arg in node.args]
        places = ", ".join(f"{{{k}}}" for k in range(len(args)))
        form = INFIX.get(node.op, f"{node.op.removeprefix('f')}({places})")
        short = [a if _plain(a) else f"({a})" for a in args]
        expression = form.format(*(short if node.op in INFIX else args))
        if i in self.graph.functions:
            function, given = self.graph.functions[i]
            expression = f"{function}({', '.join(self.expressions[arg] for arg in given)})"
        if len(expression) > COMMENT:
            names = [self.names[arg] for arg in node.args]
            expression = form.format(*names)
        operands = [self._operand(node, a) for a in node.args]
        self._line(node.op, [name, *operands], expression, node)
        self.names[i] = name
        self.expressions[i] = expression if len(expression) <= COMMENT // 2 else name

    def _operand(self, node: Node, arg: int) -> str:
        """Name of an operand; the bits of a declared float get another name to be read as int."""
        source = self.graph.nodes[arg]
        declared = source.op in ("input", "state", "param")
        if node.op not in INT_OPERANDS or not declared:
            return self.names[arg]
        name = f"bits_{self.names[arg]}"
        if name not in self.taken:
            self.taken.add(name)
            self._line("mov", [name, self.names[arg]], "", None)
        return name

    def _leaf(self, node: Node) -> str:
        if node.op != "const":
            return str(node.value)
        value = float(binary32(node.number))
        if value in self.in_data:
            name = f"c{self._data_name(value)}"
            if name not in self.taken:
                self.taken.add(name)
                self._line("ld", [name, self._data_name(value)], literal(value), None)
            return name
        text = literal(node.number)
        return f"({text})" if text.startswith("-") else text

    def _temporary(self, node: Node) -> str:
        first = self.names[node.args[0]] if node.args else ""
        names = {"fsin": f"sin_{first}", "fcos": f"cos_{first}", "i2f": f"float_{first}"}
        name = names.get(node.op, f"t{len(self.body)}")
        while name in self.taken or not name.isidentifier():
            name = f"t{len(self.taken)}_{len(self.body)}"
        self.taken.add(name)
        return name

    def _direct(self, i: int) -> str | None:
        """Name of the output, export or state that the operation can write itself: a state whose
        old value nothing reads any more.
        """
        states = [name for name, root in self.graph.next_states.items() if root == i]
        if len(states) == 1 and self.last_read.get(states[0], -1) <= i:
            return states[0]
        names = [name for name, root in self.graph.outputs.items() if root == i]
        exports = {port.name for port in self.law.of_kind("export")}
        for name in names:
            if name in exports:
                return name
        unit = default_isa().operations[self.graph.nodes[i].op].unit
        if len(names) == 1 and self.uses[i] == 1 and unit != "fma":
            return names[0]
        return None

    def _ends(self) -> None:
        """Outputs and states that no operation wrote directly."""
        for name, root in self.graph.outputs.items():
            if self.names[root] != name:
                self._line("mov", [name, self.names[root]], "", None)
        moves = {s: self.names[root] for s, root in self.graph.next_states.items()}
        moves = {state: source for state, source in moves.items() if state != source}
        held = {}
        for state in moves:  # a state that moves into another one must be read before it is written
            if state in moves.values():
                held[state] = f"old_{state}"
                self._line("mov", [held[state], state], "", None)
        for state, source in moves.items():
            self._line("mov", [state, held.get(source, source)], "", None)

    def _line(self, op: str, operands: list[str], expression: str, node: Node | None) -> None:
        text = f"        {op:<8}{', '.join(operands)}"
        notes = [expression] if expression else []
        if node is not None and self._mixes(node):
            notes.append("-Wno-type: bits of the number")
        self.body.append(f"{text:<52}; {' '.join(notes)}".rstrip("; ").rstrip())

    def _mixes(self, node: Node) -> bool:
        """Whether the operation reads a float as an integer, or the reverse."""
        free = ANY_OPERANDS.get(node.op, ())
        for position, arg in enumerate(node.args):
            source = self.graph.nodes[arg]
            integer = source.op in INT_KINDS
            if position not in free and integer != (node.op in INT_OPERANDS):
                return True
        return False


def _plain(text: str) -> bool:
    return all(c.isalnum() or c in "_.()|" for c in text)


def _row(text: str, port: Port) -> str:
    notes = note(f"{port.meaning} [{port.unit}]".strip())
    return f"{text:<42}; {notes}" if port.meaning or port.unit != "1" else text
