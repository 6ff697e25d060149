# SPDX-License-Identifier: Apache-2.0
"""The box of a law's inputs, split into smaller ones: those with the largest error bounds first.

Nothing depends on time: the same law is split the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.enclosure import Enclosure
from asip_asm.model.enclosure_rules import add_step
from asip_asm.model.graph import Graph
from asip_asm.model.structure import Structure

CHUNK, FEW = 256, 8
"""Most boxes at once, and boxes that cost as much as one."""
SPLIT = 128
"""Boxes split in a round."""
TRIED = 6
"""Boxes of a round on which every split is tried."""
LEAST_GAIN = 0.005
"""Share by which the bounds must fall in `PATIENCE` rounds and more for the search to go on."""
PATIENCE = 12
USELESS, SKIPPED = 0.995, 6
"""A split that leaves more than this share of a result's bound is not made; the result waits for so
many turns.
"""
FAULT_ROUNDS = 100
"""Rounds after which a search ends that knows an input with a fault."""
MOST_BOXES = 20_000
COARSE = 2.0**-17
"""A rounding above this share of what is rounded gets a symbol: it is a split into two parts."""
MOST_ROUNDINGS = 12
PEELING = 24
"""Rounds after which every second one splits the widest input of the boxes without a bound."""
SLICES, PROMISING = 8, 0.97
"""Where no split helps, one is made of an input of which thin slices have so low a bound."""
NARROW = 1e-6
"""Share of an input's range up to which an operation's domain is looked for."""
MANY_BINADES = 2.0**40
"""Ratio of an interval's ends above which its arithmetic middle takes off one binade of many."""
TINY = 1e-300
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Input:
    """Range of an input, state or parameter; whole: an integer. of: this is the change of that
    input since the last tick, which `state` holds, with `offset` added to it.
    """

    name: str
    low: float
    high: float
    unit: str = "1"
    whole: bool = False
    of: str = ""
    state: str = ""
    offset: float = 0.0


def changes(graph: Graph, inputs: Sequence[Input]) -> dict[int, Input]:
    """Differences of a number and the state that held it in the last tick, by node, where the
    number is an input whose change has a range, with a constant added.
    """
    known = {each.of: each for each in inputs if each.of}
    nodes, found = graph.nodes, {}
    for i in graph.used():
        if nodes[i].op not in ("isub", "fsub"):
            continue
        now, last = nodes[i].args
        state, source, offset = str(nodes[last].value), nodes[now], 0.0
        if nodes[last].op not in ("state", "int_state") or graph.next_states.get(state) != now:
            continue
        added = graph.constant(source.args[1]) if source.op in ("fsub", "fadd") else None
        if added is not None:
            offset = added * (1 if source.op == "fadd" else -1)
            source = nodes[source.args[0]]
        if source.value in known:
            found[i] = replace(known[str(source.value)], state=state, offset=offset)
    return found


@dataclass
class Problem:
    """A graph with the box of its inputs. order: nodes that are needed, arguments first; symbols
    of the affine forms by input or node, none for intervals alone.
    """

    graph: Graph
    inputs: Sequence[Input]
    structure: Structure = field(init=False)
    leaves: dict[int, str] = field(init=False)
    order: list[int] = field(init=False)
    symbols: dict[int | str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.structure = Structure(self.graph)
        self.leaves = {i: each.name for i, each in changes(self.graph, self.inputs).items()}
        self.roots = {
            **{f"{n}_next": i for n, i in self.graph.next_states.items() if self._float(i)},
            **self.graph.outputs,
        }
        self.order = self._needed()
        self.free = [k for k, each in enumerate(self.inputs) if each.low < each.high]
        self.faulty: set[int] = set()

    def _float(self, i: int) -> bool:
        return self.graph.nodes[i].op not in ("int_input", "int_state")

    def arguments(self, i: int) -> tuple[int, ...]:
        if i in self.leaves:
            return ()
        if i in self.graph.functions:
            return self.graph.functions[i][1]
        if i in self.structure.floors:
            return (self.structure.floors[i],)
        return self.graph.nodes[i].args

    def _needed(self) -> list[int]:
        needed = set(self.roots.values())
        for i in range(len(self.graph.nodes) - 1, -1, -1):
            if i in needed:
                needed.update(self.arguments(i))
        for i, fraction in self.structure.fractions.items():
            if i in needed and fraction.number not in needed:
                del self.structure.fractions[i]
        return sorted(needed)

    def concerned(self) -> list[int]:
        """Free inputs that operations which may leave their domain depend on."""
        needed, names = set(self.faulty), set()
        for i in reversed(self.order):
            if i in needed:
                needed.update(self.arguments(i))
                names.add(self.leaves.get(i, str(self.graph.nodes[i].value)))
        return [k for k in self.free if self.inputs[k].name in names]

    def use_symbols(self) -> None:
        """A symbol for every input, and for roundings that split a number into two parts."""
        low, high = self.whole()
        found = self.enclose(low, high)
        names: list[int | str] = [self.inputs[k].name for k in self.free]
        for i in self.order:
            node, step = self.graph.nodes[i], found.steps[i]
            values = [self.graph.constant(arg) for arg in node.args]
            if node.op not in ("fadd", "fsub") or values.count(None) != 1:
                continue
            other = found.steps[node.args[values.index(None)]].value.size[0]
            if step.own[0] >= COARSE * other and len(names) < len(self.free) + MOST_ROUNDINGS:
                names.append(i)
        self.symbols = {name: k for k, name in enumerate(names)}

    def whole(self) -> tuple[Floats, Floats]:
        """The whole box, (inputs, 1)."""
        low = np.array([[each.low] for each in self.inputs])
        return low, np.array([[each.high] for each in self.inputs])

    def enclose(self, low: Floats, high: Floats) -> Enclosure:
        """All steps over boxes (inputs, B)."""
        found = Enclosure(self.graph, self.structure, low.shape[1], self.symbols)
        values = {
            each.name: (low[k], high[k]) for k, each in enumerate(self.inputs)
        }  # fmt: skip
        with np.errstate(all="ignore"):
            for i in self.order:
                add_step(found, i, values, self.leaves)
        return found

    def results(self, low: Floats, high: Floats) -> tuple[Floats, ...]:
        """Bounds (results, B), infinite where an operation may fault, those where no branch is in
        doubt, ends of the values; severity of the faults (1, B).
        """
        parts: list[tuple[Floats, ...]] = []
        for begin in range(0, low.shape[1], CHUNK):
            some = slice(begin, begin + CHUNK)
            found = self.enclose(low[:, some], high[:, some])
            self.faulty.update(i for i, _, _ in found.faults)
            bounds, smooth, least, most = [], [], [], []
            with np.errstate(all="ignore"):
                for root in self.roots.values():
                    step = found.steps[root]
                    both = found.error_and_smooth(root)
                    bounds.append(np.where(step.bad, np.inf, both[0]))
                    smooth.append(np.where(step.bad, np.inf, both[1]))
                    least.append(step.value.low)
                    most.append(step.value.high)
            rows = (np.array(rows) for rows in (bounds, smooth, least, most))
            parts.append((*rows, found.severity[None]))
        return tuple(np.concatenate(each, axis=1) for each in zip(*parts, strict=True))


class Search:
    """Splits the box. Leaves: low, high (inputs, L); bound, smooth, least, most (results, L)."""

    def __init__(self, problem: Problem, effort: int, progress: Callable[[str], None]) -> None:
        self.problem = problem
        self.left = effort
        self.progress = progress
        self.low, self.high = problem.whole()
        self.keep(*self._results(self.low, self.high))
        self.width = self.high - self.low
        self.rounds, self.turn = 0, -1
        self.skipped, self.idle = [0] * len(self.bound), 0

    def keep(self, bound, smooth, least, most, severity) -> None:
        """Results of all leaves."""
        self.bound, self.smooth, self.least, self.most = bound, smooth, least, most
        self.severity = severity

    @property
    def boxes(self) -> int:
        return self.low.shape[1]

    def _results(self, low: Floats, high: Floats) -> tuple[Floats, ...]:
        cost = len(self.problem.order) * (1 + len(self.problem.symbols) // 4)
        self.left -= cost * max(FEW, low.shape[1])
        return self.problem.results(low, high)

    def run(self) -> None:
        """Split until the bounds fall no more."""
        history = [self.total()]
        effort, told = max(1, self.left), 0
        patience = PATIENCE + 2 * len(self.bound)
        while self.left > 0 and self.problem.free and self.boxes < MOST_BOXES:
            if history[-1][0] and len(history) % FAULT_ROUNDS == 0 and self.faults_at_points():
                break
            chosen = self._worst()
            split = self._best_split(chosen)
            if split is None or self.idle >= len(self.bound):
                break
            if self.idle:
                continue
            self._split(chosen, split)
            history.append(self.total())
            tenths = int(10 * (1 - max(0, self.left) / effort))
            if tenths > told:
                told, open_ = tenths, history[-1][0]
                rest = f", {open_} without a bound" if open_ else ""
                self.progress(f"{tenths}0 % of the effort at most, {self.boxes} boxes{rest}")
            if len(history) > patience:
                then, now = history[-1 - patience], history[-1]
                if then[0] == 0 and then[1] - now[1] < LEAST_GAIN:
                    break

    def faults_at_points(self) -> bool:
        """Whether an input itself, not only a box around it, has no bound."""
        boxes = np.flatnonzero(np.isinf(self.bound).any(axis=0))[:CHUNK]
        points = np.clip(0.0, self.low[:, boxes], self.high[:, boxes])
        return bool(np.isinf(self.problem.results(points, points)[0]).any())

    def cap(self, other: Search) -> None:
        """Take over the bounds of another search of the same box where they are smaller."""
        for mine, its in ((self.bound, other.bound), (self.smooth, other.smooth)):
            np.minimum(mine, its.max(axis=1, keepdims=True), out=mine)

    def total(self) -> tuple[int, float]:
        """Boxes without a bound, mean logarithm of the results' bounds."""
        worst = self.bound.max(axis=1)
        finite = np.maximum(worst[np.isfinite(worst)], TINY)
        mean = float(np.log(finite).mean()) if finite.size else 0.0
        return int(np.isinf(self.bound).any(axis=0).sum()), mean

    def _worst(self) -> NDArray[np.int64]:
        """Boxes to split: the widest of those without a bound first, then those next to the largest
        bound of one result. The results take turns.
        """
        lost = np.isinf(self.bound).any(axis=0)
        if lost.any():
            wide = np.maximum(self.width[self.problem.free], TINY)
            size = ((self.high - self.low)[self.problem.free] / wide).mean(axis=0)
            score = np.where(lost, 1 + 4 * size, 0.0)
        else:
            self.turn = (self.turn + 1) % len(self.bound)
            for _ in range(len(self.bound)):
                if self.skipped[self.turn] == 0:
                    break
                self.skipped[self.turn] -= 1
                self.turn = (self.turn + 1) % len(self.bound)
            score = self.bound[self.turn] + TINY
        order = np.argsort(-score, kind="stable")[:SPLIT]
        return order[score[order] >= 0.5 * score[order[0]]]

    def _best_split(self, chosen: NDArray[np.int64]) -> tuple[int, bool] | None:
        """Input to split, and whether by binades: the one that most lowers the bounds of some."""
        self.rounds += 1
        if self.rounds > PEELING and self.rounds % 2 and np.isinf(self.bound[:, chosen]).any():
            # Where several inputs must be small, the best split always takes a slice off one of
            # them: cut the widest in two.
            share = (self.high - self.low)[:, chosen].mean(axis=1) / np.maximum(
                self.width[:, 0], TINY
            )
            widest = max(self.problem.concerned(), key=lambda k: share[k], default=None)
            if widest is not None and share[widest] > NARROW:
                return widest, False
        some = chosen[:: max(1, len(chosen) // TRIED)][:TRIED]
        ways, lows, highs = [], [], []
        for k in self.problem.free:
            for by_binades in (False, True):
                split = self._halves(some, k, by_binades)
                if split is not None:
                    ways.append((k, by_binades))
                    lows.append(split[0])
                    highs.append(split[1])
        if not ways:
            return None
        bound, _, _, _, severity = self._results(np.concatenate(lows, 1), np.concatenate(highs, 1))
        before_, old = self.bound[:, some], np.maximum(self.severity[0, some], TINY)
        best, merit = ways[0], np.inf
        for k, (way, halves) in enumerate(
            zip(ways, np.split(bound, len(ways), axis=1), strict=True)
        ):
            pair = halves.reshape(len(bound), 2, -1)
            found = self._merit(before_, pair)
            share = np.split(severity, len(ways), axis=1)[k].reshape(2, -1) / old
            found += float(np.where(np.isinf(before_).any(axis=0), share, 0.0).mean())
            wide = float(np.mean((self.high - self.low)[way[0], some] / self.width[way[0]]))
            found -= 1e-3 * wide
            if found < merit:
                best, merit = way, found
        self.idle = 0
        if not np.isinf(before_).any() and merit > USELESS:
            slice_, merit = self._best_slice(some)
            if merit < PROMISING:
                return slice_, False
            self.skipped[self.turn] = SKIPPED
            self.idle += 1
        return best

    def _best_slice(self, some: NDArray[np.int64]) -> tuple[int, float]:
        """Input of which thin slices have the least bounds, and what is left: where one split does
        not help several may.
        """
        lows, highs, n = [], [], len(some)
        for k in self.problem.free:
            low, high = self.low[k, some], self.high[k, some]
            low_, high_ = (np.concatenate([a[:, some]] * 3, 1) for a in (self.low, self.high))
            width = (high - low) / SLICES
            starts = np.concatenate((low, 0.5 * (low + high - width), high - width))
            low_[k], high_[k] = starts, np.minimum(starts + np.tile(width, 3), high_[k])
            lows.append(low_)
            highs.append(high_)
        bound, *_ = self._results(np.concatenate(lows, 1), np.concatenate(highs, 1))
        parts = bound[self.turn].reshape(len(self.problem.free), 3, n)
        left = (parts.mean(axis=1) / np.maximum(self.bound[self.turn, some], TINY)).mean(axis=1)
        best = int(np.argmin(left))
        return self.problem.free[best], float(left[best])

    def _merit(self, parent: Floats, pair: Floats) -> float:
        """Lower is better: the mean of the halves' bounds as a share of the box's; of boxes without
        a bound, halves without one.
        """
        if np.isinf(parent).any():
            return 10 * float(np.isinf(pair).any(axis=0).mean())
        before = np.maximum(parent[self.turn], TINY)
        return float((pair[self.turn].mean(axis=0) / before).mean())

    def _halves(
        self, chosen: NDArray[np.int64], k: int, by_binades: bool
    ) -> tuple[Floats, Floats] | None:
        """Both halves of boxes, (inputs, 2 n), or None where one cannot be split so."""
        low, high = self.low[k, chosen], self.high[k, chosen]
        if self.problem.inputs[k].whole:
            if by_binades:
                return None
            middle = np.floor(0.5 * low + 0.5 * high)
            after = middle + 1
        else:
            middle = _by_binades(low, high) if by_binades else _middle(low, high)
            small, large = np.sort(np.abs([low, high]), axis=0)
            if not by_binades and ((low * high > 0) & (large > MANY_BINADES * small)).all():
                return None
            if by_binades and np.array_equal(middle, _middle(low, high)):
                return None
            after = np.nextafter(middle.astype(np.float32), np.float32(np.inf)).astype(float)
        if np.any(low >= high):
            return None
        lows, highs = (np.concatenate([a[:, chosen]] * 2, 1) for a in (self.low, self.high))
        n = len(chosen)
        highs[k, :n], lows[k, n:] = middle, after
        return lows, highs

    def _split(self, chosen: NDArray[np.int64], way: tuple[int, bool]) -> None:
        k, by_binades = way
        chosen = chosen[self.low[k, chosen] < self.high[k, chosen]]
        split = self._halves(chosen, k, by_binades) or self._halves(chosen, k, not by_binades)
        if split is None:
            raise ValueError("a box that cannot be split")
        low, high = split
        new = list(self._results(low, high))
        for n, old in enumerate((self.bound, self.smooth)):
            new[n] = np.minimum(new[n], np.concatenate([old[:, chosen]] * 2, 1))
        kept = np.ones(self.boxes, bool)
        kept[chosen] = False
        old = (self.bound, self.smooth, self.least, self.most, self.severity)

        def joined(old: Floats, new: Floats) -> Floats:
            return np.concatenate((old[:, kept], new), axis=1)

        self.keep(*(joined(a, b) for a, b in zip(old, new, strict=True)))
        self.low, self.high = joined(self.low, low), joined(self.high, high)


def _middle(low: Floats, high: Floats) -> Floats:
    """A binary32 number in the middle, 0 where that is inside."""
    middle = (0.5 * low + 0.5 * high).astype(np.float32).astype(float)
    zero = (low < 0) & (high > 0) & (np.minimum(-low, high) > 0.05 * (high - low))
    return np.where(zero, 0.0, np.where(middle >= high, low, middle))


def _by_binades(low: Floats, high: Floats) -> Floats:
    """The geometric mean; a 0 at an end, or inside, is split off."""
    least = np.float32(2.0**-149)
    size = np.sqrt(np.abs(low)) * np.sqrt(np.abs(high))
    mean = np.where(low > 0, size, -size).astype(np.float32).astype(float)
    mean = np.where(low == 0, 0.0, np.where(high == 0, -float(least), mean))
    mean = np.where((low < 0) & (high > 0), 0.0, mean)
    return np.where(mean >= high, low, np.maximum(mean, low))
