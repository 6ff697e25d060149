# SPDX-License-Identifier: Apache-2.0
"""Linear assembly of a graph of core operations, with the source expression of every operation as
its comment.

Constants that find no room in bank K after inputs and parameters are states that no operation
writes, or words of data memory, loaded once in a run (`places`). States have room in all banks of
registers, not in bank C alone.
"""

from __future__ import annotations

import numpy as np

from asip_asm.assembly_text import note, quoted
from asip_asm.isa import default_isa
from asip_asm.machine import Machine
from asip_asm.model.graph import INT_KINDS, LEAVES, Graph, Node, binary32
from asip_asm.model.law import Law, Port, before, room_for_states
from asip_asm.model.places import Places
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


def literal(value: float) -> str:
    """Text that the assembler reads as the binary32 number nearest to `value`."""
    single = binary32(value)
    if not np.isfinite(single):
        raise ModelError(f"the constant {value:g} is too large for binary32")
    text = str(single)
    if np.float32(float(text)) != single or (single == 0 and np.signbit(single)):
        return f"0f{single.view(np.uint32):08x}"
    return text


def emit(graph: Graph, law: Law, machine: Machine, places: Places) -> str:
    """Source text of the program. Raises ModelError for a constant beyond binary32."""
    return _Emitter(graph, law, machine, places).text()


class _Emitter:
    def __init__(self, graph: Graph, law: Law, machine: Machine, places: Places) -> None:
        self.graph = graph
        self.law = law
        self.order = graph.used()
        self.uses = graph.uses()
        self.names: dict[int, str] = {}
        self.expressions: dict[int, str] = {}
        self.body: list[str] = []
        self.taken = {port.name for port in law.ports}
        self.rates = {before(port.rate_of) for port in law.of_kind("rate")}
        self.taken |= self.rates
        self.in_data = {value: self._free(f"data_{k}") for k, value in enumerate(places.data)}
        self.held = {
            value: (self._free(f"held_{bank.lower()}{k}"), bank)
            for bank, values in places.registers.items()
            for k, value in enumerate(values)
        }
        self.loaded: dict[float, str] = {}
        self.room = room_for_states(machine)
        self.room["C"] -= len(self.rates)
        self.last_read = self._last_reads()

    def _free(self, name: str) -> str:
        """The name, longer if a signal has it."""
        while name in self.taken:
            name += "_"
        self.taken.add(name)
        return name

    def _last_reads(self) -> dict[str, float]:
        """Position of the last operation that reads the old value of each state."""
        nodes = self.graph.nodes
        reads: list[tuple[float, Node]] = [
            (i, nodes[arg]) for i in self.order for arg in nodes[i].args
        ]
        reads += [(float("inf"), nodes[root]) for root in self.graph.roots()]
        return {str(node.value): i for i, node in reads if node.op in ("state", "int_state")}

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
        rows += [
            f".state    {name} = {literal(value)}, pin {bank}"
            for value, (name, bank) in self.held.items()
        ]
        rows += [f".data     {name} = {literal(value)}" for value, name in self.in_data.items()]
        return ["", *rows]

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
        if value in self.held:
            return self.held[value][0]
        if value in self.in_data:
            if value not in self.loaded:
                self.loaded[value] = self._free(f"c{self.in_data[value]}")
                self._line("ld", [self.loaded[value], self.in_data[value]], literal(value), None)
            return self.loaded[value]
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
        unit = default_isa().operations[self.graph.nodes[i].op].unit
        states = [name for name, root in self.graph.next_states.items() if root == i]
        if len(states) == 1 and self.last_read.get(states[0], -1) <= i:
            pool = "pipes" if unit == "fma" else "C"
            if self.room[pool]:
                self.room[pool] -= 1
                return states[0]
        names = [name for name, root in self.graph.outputs.items() if root == i]
        exports = {port.name for port in self.law.of_kind("export")}
        for name in names:
            if name in exports:
                return name
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
        while moves:  # a state that moves into another one is read before it is written
            sources = set(moves.values())
            state = next((state for state in moves if state not in sources), "")
            if not state:
                state = next(iter(moves))
                held = self._free(f"old_{state}")
                self._line("mov", [held, state], "", None)
                moves = {s: held if source == state else source for s, source in moves.items()}
            self._move(state, moves.pop(state))

    def _move(self, state: str, source: str) -> None:
        """Copy a value to a state: in bank C, or, where that has no room, in the banks of the
        pipes. The difference to zero is the number itself, its sign included.
        """
        if self.room["C"] or state in self.rates:
            self.room["C"] -= state not in self.rates
            self._line("mov", [state, source], "", None)
            return
        self.room["pipes"] -= 1
        self._line("fsub", [state, source, "zero"], "a copy", None)

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
