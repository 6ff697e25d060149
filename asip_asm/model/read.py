# SPDX-License-Identifier: Apache-2.0
"""Reads a `casadi.Function` into a graph of real operations.

A function of scalar instructions (SX; MX is expanded) is a list: CasADi numbers work registers, an
instruction reads some and writes one. Every scalar instruction of CasADi 3.8 is in `UNARY`,
`BINARY` or `read_function`, or refused by name with its place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import casadi as ca

from asip_asm.model.graph import Graph


class ModelError(ValueError):
    """A law cannot be compiled; the text says what, where and the cure."""


def _named(names: str, **others: str) -> dict[int, str]:
    """Our operations by CasADi's numbers: `names` are those that both call the same."""
    ours = dict.fromkeys(names.split()) | others
    return {getattr(ca, f"OP_{(theirs or name).upper()}"): name for name, theirs in ours.items()}


UNARY = _named(
    "neg exp log sqrt sin cos tan asin acos atan not floor ceil sign erf "
    "sinh cosh tanh asinh acosh atanh log1p expm1",
    abs="fabs",
)
BINARY = _named(
    "add sub mul div pow lt le eq and or fmod remainder copysign atan2 hypot",
    min="fmin",
    max="fmax",
) | {ca.OP_CONSTPOW: "pow"}
REFUSED: dict[int, str] = {
    ca.OP_ERFINV: "the inverse error function has no program; approximate it in the law",
    ca.OP_PRINTME: "a core cannot print; remove printme()",
    ca.OP_LIFT: "lift() is for optimisation problems; remove it",
    ca.OP_PARAMETER: "a free symbol; make it an argument of the function",
    ca.OP_CALL: "a call that does not expand into scalars; use SX or expand() the callee",
}
NAMES = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}


@dataclass(frozen=True)
class Entry:
    """An argument or a result. places: the element, counted column by column, of each nonzero."""

    name: str
    rows: int
    columns: int
    places: tuple[int, ...]

    @property
    def elements(self) -> int:
        """Elements of the full shape, structural zeros included."""
        return self.rows * self.columns


Instruction = tuple[int, tuple[int, ...], tuple[int, ...], float]
"""CasADi's number of an operation, the places that it reads and writes, a constant's value."""


@dataclass(frozen=True)
class Scalars:
    """A function in scalar instructions, as data."""

    name: str
    arguments: tuple[Entry, ...]
    results: tuple[Entry, ...]
    instructions: tuple[Instruction, ...]


def scalars(function: ca.Function) -> Scalars:
    """The function in scalar instructions. Raises ModelError if it does not expand into them."""
    if function.is_null():
        raise ModelError("the function is empty: save one that has been made")
    if not function.is_a("SXFunction"):
        try:
            function = function.expand()
        except Exception as error:
            line = str(error).strip().splitlines()[-1]
            raise ModelError(
                f"{function.name()}: does not expand into scalar operations: {line}; "
                "solvers, interpolants and external calls have none"
            ) from None
    return Scalars(
        function.name(),
        _entries(function.n_in(), function.name_in, function.sparsity_in),
        _entries(function.n_out(), function.name_out, function.sparsity_out),
        tuple(
            (
                op := function.instruction_id(i),
                tuple(function.instruction_input(i)),
                tuple(function.instruction_output(i)),
                function.instruction_constant(i) if op == ca.OP_CONST else 0.0,
            )
            for i in range(function.n_instructions())
        ),
    )


def _entries(
    count: int, name: Callable[[int], str], pattern: Callable[[int], ca.Sparsity]
) -> tuple[Entry, ...]:
    return tuple(Entry(name(i), *pattern(i).shape, tuple(pattern(i).find())) for i in range(count))


def read_function(
    function: Scalars, graph: Graph, arguments: Sequence[Sequence[int]]
) -> list[list[int]]:
    """Append the function's operations to the graph; nodes of its results, a list of each with
    all elements column by column. `arguments`: nodes of its arguments in the same form.

    Raises ModelError.
    """
    work: dict[int, int] = {}
    results = [[-1] * result.elements for result in function.results]
    for i, (op, inputs, outputs, constant) in enumerate(function.instructions):
        try:
            if op == ca.OP_OUTPUT:
                result, nonzero = outputs
                results[result][function.results[result].places[nonzero]] = work[inputs[0]]
            elif op == ca.OP_INPUT:
                argument, nonzero = inputs
                place = function.arguments[argument].places[nonzero]
                work[outputs[0]] = arguments[argument][place]
            elif op == ca.OP_CONST:
                work[outputs[0]] = _constant(function, i, constant, graph)
            else:
                args = [work[k] for k in inputs]
                work[outputs[0]] = _operation(function, i, op, graph, args)
        except (KeyError, IndexError, ValueError) as error:
            if isinstance(error, ModelError):
                raise
            raise ModelError(
                f"{function.name}, instruction {i} of {len(function.instructions)} reads what "
                "nothing wrote: the file is damaged; save the function again"
            ) from None
    zero = graph.const(0.0)  # structural zeros are not written
    return [[zero if node < 0 else node for node in result] for result in results]


def _constant(function: Scalars, i: int, value: float, graph: Graph) -> int:
    if abs(value) > 3.4028235677973366e38 or value != value:
        raise ModelError(
            f"{function.name}, instruction {i}: the constant {value} is no binary32 number; "
            "replace infinity by a large bound"
        )
    return graph.const(value)


def _operation(function: Scalars, i: int, op: int, graph: Graph, args: list[int]) -> int:
    a, b = args[0], args[-1]
    more: dict[int, Callable[[], int]] = {
        ca.OP_ASSIGN: lambda: a,
        ca.OP_SQ: lambda: graph.add("mul", a, a),
        ca.OP_TWICE: lambda: graph.add("add", a, a),
        ca.OP_INV: lambda: graph.add("div", graph.const(1.0), a),
        ca.OP_NE: lambda: graph.add("not", graph.add("eq", a, b)),
        ca.OP_IF_ELSE_ZERO: lambda: graph.add("select", a, b, graph.const(0.0)),
    }
    if op in UNARY:
        return graph.add(UNARY[op], a)
    if op in BINARY:
        return graph.add(BINARY[op], a, b)
    if op in more:
        return more[op]()
    name = NAMES.get(op, f"opcode {op}")
    raise ModelError(
        f"{function.name}, instruction {i} of {len(function.instructions)}: {name} is not "
        f"compiled: {REFUSED.get(op, 'it is no scalar operation; expand() the function')}"
    )
