# SPDX-License-Identifier: Apache-2.0
"""Reads a `casadi.Function` into a graph of real operations.

A function of scalar instructions (SX; MX is expanded) is a list: CasADi numbers work registers, an
instruction reads some and writes one. Every scalar instruction of CasADi 3.8 is in `UNARY`,
`BINARY` or `read_function`, or refused by name with its place.
"""

from __future__ import annotations

import os
import resource
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

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
LOAD_SECONDS = 5  # of processor time for a file
LOAD_BYTES = 1 << 29  # beyond what the process has
NAMES = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}


def load_function(source: ca.Function | Path | str) -> ca.Function:
    """Function of a file that `Function.save` wrote, or the function itself, in scalar
    instructions. Raises ModelError.
    """
    if not isinstance(source, ca.Function):
        path = Path(source)
        if not path.is_file():
            raise ModelError(f"{path}: no such file; write one with casadi.Function.save")
        if fault := _fault_of(path):
            raise ModelError(
                f"{path}: not a file of casadi.Function.save with this version: {fault}"
            )
        source = ca.Function.load(str(path))
    if source.is_null():
        raise ModelError("the function is empty: save one that has been made")
    if source.is_a("SXFunction"):
        return source
    try:
        return source.expand()
    except Exception as error:
        line = str(error).strip().splitlines()[-1]
        raise ModelError(
            f"{source.name()}: does not expand into scalar operations: {line}; "
            "solvers, interpolants and external calls have none"
        ) from None


def _fault_of(path: Path) -> str:
    """Why CasADi cannot load the file, empty if it can. Tried in a process of its own: a damaged
    file can make it compute without end, take all memory or crash.
    """
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        _try_to_load(path, writer)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        text = pipe.read().decode(errors="replace")
    status = os.waitpid(child, 0)[1]
    return text or ("damaged" if status else "")


def _try_to_load(path: Path, writer: int) -> None:
    """Load the file under limits and write what goes wrong; never returns."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + LOAD_BYTES
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
        resource.setrlimit(resource.RLIMIT_CPU, (LOAD_SECONDS, LOAD_SECONDS + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        function = ca.Function.load(str(path))
        argument_names(function)
        result_names(function)
    except BaseException as error:  # CasADi raises many kinds for a damaged file
        line = str(error).strip().splitlines()[:1]
        os.write(writer, (line[0][:200] if line else "damaged").encode())
    finally:
        os._exit(0)


def argument_names(function: ca.Function) -> dict[tuple[int, int], str]:
    """Name 'argument' or 'argument[k]' of every entry (argument, nonzero k) that goes in."""
    return _names(function.n_in(), function.name_in, function.nnz_in)


def result_names(function: ca.Function) -> dict[tuple[int, int], str]:
    """The same for what comes out."""
    return _names(function.n_out(), function.name_out, function.nnz_out)


def _names(
    count: int, name: Callable[[int], str], size: Callable[[int], int]
) -> dict[tuple[int, int], str]:
    return {
        (i, k): name(i) if size(i) == 1 else f"{name(i)}[{k}]"
        for i in range(count)
        for k in range(size(i))
    }


def read_function(
    function: ca.Function, graph: Graph, arguments: Mapping[tuple[int, int], int]
) -> dict[tuple[int, int], int]:
    """Append the function's operations to the graph; nodes of its results by (result, nonzero).

    `arguments`: nodes of its arguments. Raises ModelError.
    """
    work: dict[int, int] = {}
    results: dict[tuple[int, int], int] = {}
    for i in range(function.n_instructions()):
        try:
            _instruction(function, i, graph, arguments, work, results)
        except (KeyError, IndexError):
            raise ModelError(
                f"{function.name()}, instruction {i} of {function.n_instructions()} reads what "
                "nothing wrote: the file is damaged; save the function again"
            ) from None
    for key in result_names(function):  # structural zeros are not written
        if key not in results:
            results[key] = graph.const(0.0)
    return results


def _instruction(
    function: ca.Function,
    i: int,
    graph: Graph,
    arguments: Mapping[tuple[int, int], int],
    work: dict[int, int],
    results: dict[tuple[int, int], int],
) -> None:
    """One instruction of `read_function`: its node goes into `work` or `results`."""
    op = function.instruction_id(i)
    inputs, outputs = function.instruction_input(i), function.instruction_output(i)
    if op == ca.OP_OUTPUT:
        results[outputs[0], outputs[1]] = work[inputs[0]]
    elif op == ca.OP_INPUT:
        work[outputs[0]] = arguments[inputs[0], inputs[1]]
    elif op == ca.OP_CONST:
        work[outputs[0]] = _constant(function, i, graph)
    else:
        args = [work[k] for k in inputs]
        work[outputs[0]] = _operation(function, i, op, graph, args)


def _constant(function: ca.Function, i: int, graph: Graph) -> int:
    value = function.instruction_constant(i)
    if abs(value) > 3.4028235677973366e38 or value != value:
        raise ModelError(
            f"{function.name()}, instruction {i}: the constant {value} is no binary32 number; "
            "replace infinity by a large bound"
        )
    return graph.const(value)


def _operation(function: ca.Function, i: int, op: int, graph: Graph, args: list[int]) -> int:
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
        f"{function.name()}, instruction {i} of {function.n_instructions()}: {name} is not "
        f"compiled: {REFUSED.get(op, 'it is no scalar operation; expand() the function')}"
    )


def reference(function: ca.Function) -> Any:
    """The function in double precision: maps arrays (nonzeros, N) to arrays, N points at once."""
    return lambda arguments, points: [
        result.full() for result in function.map(points).call([ca.DM(a) for a in arguments])
    ]
