# SPDX-License-Identifier: Apache-2.0
"""Certificate of a compiled law: error bounds of all results for every input within its limits,
and that no operation leaves its domain there, or where it does.

A state's range is its limits together with what the program writes to it, where that comes to an
end: then the bounds hold in every tick, otherwise in a tick that begins with the state in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.box_search import Floats, Input, Problem, Search, changes
from asip_asm.model.graph import Graph
from asip_asm.model.law import Law, Port

SCHEMA = 1
"""Version of the fields of `as_json`, described in docs/numerics.md."""
DEFAULT_LIMITS = (-1.0, 1.0)
"""Range of an input or state for which the record states none; the proof draws from it too."""
EFFORT = 10_000_000
"""Operations times boxes that a certificate may take."""
TRIAL = 0.1
"""Share of the effort after which affine forms and intervals are compared."""
CLOSING = 8
"""Ticks in which the ranges of the states must come to an end."""
WITNESSES = 256
"""Boxes with a fault of which points are tried."""
Nobody = Callable[[str], None]


@dataclass(frozen=True)
class Fault:
    """Where an operation may leave its domain: a box that holds all such inputs, and one of them;
    point: empty where none was found, so that there may be none.
    """

    reason: str
    operation: str
    box: Mapping[str, tuple[float, float]]
    point: Mapping[str, float]

    def text(self) -> str:
        """One line for a user."""
        if self.point:
            return f"at {_values(self.point)}: {self.reason} ({self.operation})"
        box = ", ".join(f"{n} {low:.9g} .. {high:.9g}" for n, (low, high) in self.box.items())
        return f"{self.reason} ({self.operation}) not excluded in the box {box}"


def _values(point: Mapping[str, float]) -> str:
    shown = list(point.items())[:12]
    return ", ".join(f"{n} = {x:.9g}" for n, x in shown) + (", ..." if len(point) > 12 else "")


@dataclass(frozen=True)
class Bound:
    """Error bound of a result [unit]; low, high: its values. without_doubt: bound for inputs with
    which the two sides of no comparison are as near to each other as their errors.
    """

    name: str
    unit: str
    bound: float
    without_doubt: float
    low: float
    high: float


@dataclass(frozen=True)
class Certificate:
    """What holds for every input in the box. assumed: inputs and states without stated limits;
    open_states: states that may leave their range in the next tick.
    """

    inputs: Sequence[Input]
    bounds: Mapping[str, Bound]
    fault: Fault | None
    boxes: int
    assumed: Sequence[str] = ()
    open_states: Sequence[str] = ()

    @property
    def finite(self) -> bool:
        """Whether every result has a bound, and no operation a fault."""
        return self.fault is None and all(math.isfinite(b.bound) for b in self.bounds.values())

    def covers(self, values: Mapping[str, NDArray]) -> NDArray[np.bool_]:
        """Which inputs (n,), by name, are in the box."""
        size = len(next(iter(values.values())))
        found = np.ones(size, bool)
        for each in self.inputs:
            if each.of:
                last = values[each.state].astype(float) - each.offset
                number = values[each.of].astype(float) - last
            else:
                number = values[each.name].astype(float)
            found &= (number >= each.low) & (number <= each.high)
        return found

    def as_json(self) -> dict[str, Any]:
        """Fields of the certificate's file."""
        return {
            "schema": SCHEMA,
            "holds": self.finite,
            "inputs": [asdict(each) for each in self.inputs],
            "limits_assumed": list(self.assumed),
            "states_for_one_tick": list(self.open_states),
            "results": {
                name: {k: json_number(v) for k, v in asdict(bound).items() if k != "name"}
                for name, bound in self.bounds.items()
            },
            "fault": None if self.fault is None else asdict(self.fault),
            "boxes": self.boxes,
        }


def json_number(value: Any) -> Any:
    """JSON has no infinity."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def inputs_of(law: Law) -> list[Input]:
    """The box of a law's inputs: limits of its ports, parameters at their values."""
    found = []
    for port in law.ports:
        low, high = port.limits or DEFAULT_LIMITS
        if port.kind == "parameter":
            value = float(np.float32(port.initial))
            found.append(Input(port.name, value, value, port.unit))
        elif port.kind == "rate":
            most = float(max(1, int(abs(high / port.scale))))
            found.append(Input(port.name, -most, most, "count", True, port.rate_of))
        elif port.kind in ("input", "state") and port.type == "int":
            ends = sorted(float(np.rint((x - port.offset) / port.scale)) for x in (low, high))
            found.append(Input(port.name, ends[0], ends[1], "count", True))
        elif port.kind in ("input", "state"):
            found.append(Input(port.name, *singles(low, high), port.unit))
        if port.kind == "input" and port.change < math.inf:
            most = singles(-port.change, port.change)[1]
            found.append(Input(f"{port.name}_change", -most, most, port.unit, of=port.name))
    return found


def _with_changes(graph: Graph, inputs: Sequence[Input]) -> list[Input]:
    """The inputs with those changes that the program takes, and the states that hold the last."""
    taken = {each.name: each for each in changes(graph, inputs).values()}
    return [taken.get(each.name, each) for each in inputs if not each.of or each.name in taken]


def singles(low: float, high: float) -> tuple[float, float]:
    """The least and the largest binary32 number between the limits."""
    least, most = np.float32(low), np.float32(high)
    if least < low:
        least = np.nextafter(least, np.float32(np.inf))
    if most > high:
        most = np.nextafter(most, np.float32(-np.inf))
    return float(least), float(most)


def certify(
    graph: Graph, law: Law, effort: int = EFFORT, progress: Nobody = lambda _: None
) -> Certificate:
    """The certificate of a compiled law's graph over the limits of its ports."""
    inputs, open_states = closed(graph, _with_changes(graph, inputs_of(law)))
    search = _search(graph, inputs, effort, progress)
    problem = search.problem
    units = {port.name: port.unit for port in law.ports}
    bounds = {}
    for k, name in enumerate(problem.roots):
        unit = units.get(name, units.get(name.removesuffix("_next"), "1"))
        error, smooth = float(search.bound[k].max()), float(search.smooth[k].max())
        low, high = float(search.least[k].min()), float(search.most[k].max())
        bounds[name] = Bound(name, unit, error, smooth, low, high)
    assumed = [p.name for p in law.ports if _assumed(p)]
    fault = _fault(search) if np.isinf(search.bound).any() else None
    return Certificate(inputs, bounds, fault, search.boxes, assumed, open_states)


def _assumed(port: Port) -> bool:
    return port.kind in ("input", "state", "rate") and port.limits is None


def closed(graph: Graph, inputs: Sequence[Input]) -> tuple[list[Input], list[str]]:
    """The inputs, states widened by what the program writes to them; states whose ranges still grow
    after some ticks: they keep their limits.
    """
    stated = {each.name: each for each in inputs}
    grown, open_ = dict(stated), []
    for tick in range(CLOSING):
        problem = Problem(graph, list(grown.values()))
        _, _, least, most, _ = problem.results(*problem.whole())
        more: dict[str, Input] = {}
        for k, name in enumerate(problem.roots):
            state = grown.get(name.removesuffix("_next")) if name.endswith("_next") else None
            if state is None or state.name in open_:
                continue
            low, high = least[k, 0], most[k, 0]
            if low >= state.low and high <= state.high:
                continue
            room = 0.01 * (high - low) if tick > 1 else 0.0
            ends = (min(low - room, state.low), max(high + room, state.high))
            more[state.name] = replace(state, low=_single(ends[0]), high=_single(ends[1]))
        if not more:
            break
        unbounded = [n for n, each in more.items() if not abs(each.low) + abs(each.high) < 1e30]
        if tick >= CLOSING // 2 or unbounded:
            open_ += unbounded or list(more)
            grown |= {name: stated[name] for name in open_}
        grown |= {name: each for name, each in more.items() if name not in open_}
    else:
        open_ = [name for name in stated if f"{name}_next" in problem.roots]
        grown = stated
    return list(grown.values()), open_


def _single(value: float) -> float:
    """A binary32 number at or beyond the value, seen from 0."""
    near = np.float32(value)
    away = np.float32(math.copysign(math.inf, value))
    return float(near if abs(near) >= abs(value) else np.nextafter(near, away))


def _search(graph: Graph, inputs: Sequence[Input], effort: int, progress: Nobody) -> Search:
    """The better of a search with affine forms and one with intervals, carried to its end."""
    found = []
    for affine in (False, True):
        problem = Problem(graph, inputs)
        if affine:
            problem.use_symbols()
        search = Search(problem, int(TRIAL * effort), progress)
        search.run()
        found.append(search)
    best = min(found, key=lambda search: search.total())
    other = found[1 - found.index(best)]
    best.left = effort - int(2 * TRIAL * effort)
    best.run()
    best.cap(other)
    return best


def _fault(search: Search) -> Fault:
    """What happens where a result has no bound."""
    problem = search.problem
    boxes = np.flatnonzero(np.isinf(search.bound).any(axis=0))
    low, high = search.low[:, boxes], search.high[:, boxes]
    hull = {
        each.name: (float(low[k].min()), float(high[k].max()))
        for k, each in enumerate(problem.inputs)
        if each.low < each.high
    }
    some = slice(0, WITNESSES)
    near_zero = np.clip(0.0, low[:, some], high[:, some])
    middle = np.float32(0.5 * low[:, some] + 0.5 * high[:, some]).astype(float)
    whole = np.array([each.whole for each in problem.inputs])
    middle[whole] = np.rint(middle[whole])
    zero = np.clip(0.0, *problem.whole())
    points = np.concatenate((zero, near_zero, low[:, some], high[:, some], middle), axis=1)
    bound, *_ = problem.results(points, points)
    bad = np.flatnonzero(np.isinf(bound).any(axis=0))
    if bad.size:
        zeros = (points[:, bad] == 0).sum(axis=0)
        point = points[:, bad[np.argmax(zeros)]]
        at = {each.name: float(x) for each, x in zip(problem.inputs, point, strict=True)}
        reason, operation = _reason(problem, point[:, None], point[:, None])
        return Fault(reason, operation, hull, {name: at[name] for name in hull})
    reason, operation = _reason(problem, low[:, :1], high[:, :1])
    return Fault(reason, operation, hull, {})


def _reason(problem: Problem, low: Floats, high: Floats) -> tuple[str, str]:
    """Reason, and the operation, of the first fault that reaches a result in a box."""
    found = problem.enclose(low, high)
    for i, reason, mask in found.faults:
        if mask[0]:
            return reason, f"operation {i}, {problem.graph.nodes[i].op}"
    return "no finite bound", "products of unbounded derivatives"
