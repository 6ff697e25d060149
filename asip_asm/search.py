# SPDX-License-Identifier: Apache-2.0
"""Search for a short schedule of one dependence graph on the core's slots, write port and blocking
units.

A serial list scheduler places operations, in a given order, at the first cycle that dependences and
resources allow; its mirror image places them at the last. Alternating both ("double justification",
Valls, Ballestin and Quintanilla, EJOR 165, 2005) shortens a schedule. It begins with critical-path
orders whose paths include guessed waits for the slots and the port; then a population of schedules
is crossed, one giving the order within a window of time, another that around it (after the same
authors' hybrid genetic algorithm, EJOR 185, 2008). Everything is deterministic: a fixed seed, and
effort counted in schedules, not in time.
"""

from __future__ import annotations

import bisect
import functools
import heapq
import itertools
import operator
import random
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from asip_asm.dependence import Graph
from asip_asm.machine import Machine

SEED = 20220711
POPULATION = 60
WINDOWS = (0.2, 0.6)
"""Smallest and largest window of a crossing, as a share of the schedule's length."""
WIDTHS = (0.5, 1.5, 4.0)
"""Standard deviations in cycles of the perturbation of a crossed schedule."""
PERTURBED = 0.4
"""Share of the crossed schedules that are perturbed."""
FRESH, FRESH_UNTIL = 0.3, 0.25
"""Share of the schedules that are new ones with random waits, in that part of the effort."""
FMA_WAITS = (0.0, 4.0, 8.0, 1.0)
AUX_WAITS = (16.0, 24.0, 8.0, 4.0, 0.0)
"""Guesses how long an operation waits for its slot or port, added to path lengths."""
PATIENCE = 800
"""Schedules without gain after which the search ends, for each cycle that could still be won."""
EXCESS_PENALTY = 2
"""Cycles that one register too many is taken to cost."""


@dataclass(frozen=True)
class Value:
    """A register value for the pressure estimate.

    `pool` indexes `Problem.capacity`; `definition` is None for a value that is live at the start;
    `kept` values stay live to the end.
    """

    pool: int
    definition: int | None
    readers: tuple[int, ...]
    kept: bool


Row = tuple[list[tuple[int, int]], int, int, int, bool, bool, int | None, tuple[str, int] | None]
"""Of an operation: edges from those placed before it, number of its lane, slots of the lane, cycles
from its issue to its write, whether it takes the port, whether it takes a pipe or a unit that
blocks, and which."""


@dataclass(frozen=True)
class Problem:
    """A graph with the resources each operation takes.

    `lane[i]` is the slot class of operation i and `lanes` the slots per class; `pipe[i]` fixes a
    slot (None: any of the class); `port[i]`: takes the shared write port at issue + latency;
    `blocked[i]`: the unit that it blocks and for how many cycles (None: pipelined). `capacity`
    holds the registers available to each pool of `values`. `around` is None unless the operations
    are the body of a loop; (i, j, d) there: operation j of a round issues at least d cycles after
    operation i of the round before.
    """

    graph: Graph
    lanes: dict[str, int]
    lane: list[str]
    pipe: list[int | None]
    port: list[bool]
    blocked: list[tuple[str, int] | None]
    values: list[Value] = field(default_factory=list)
    capacity: tuple[int, ...] = ()
    around: list[tuple[int, int, int]] | None = None

    @functools.cached_property
    def rows(self) -> tuple[list[Row], list[Row]]:
        """What `place` reads of each operation, forward and backward. The lists of a problem are
        not changed after its first schedule.
        """
        number = {name: n for n, name in enumerate(self.lanes)}
        graph, found = self.graph, []
        for edges, sign in ((graph.predecessors, 1), (graph.successors, -1)):
            lane = [number[name] for name in self.lane]
            slots = [self.lanes[name] for name in self.lane]
            rank = [sign * cycles for cycles in graph.latency]
            fixed = [
                pipe is not None or block is not None
                for pipe, block in zip(self.pipe, self.blocked, strict=True)
            ]
            given = (edges, lane, slots, rank, self.port, fixed, self.pipe, self.blocked)
            found.append(list(zip(*given, strict=True)))
        return found[0], found[1]

    @functools.cached_property
    def spans(self) -> tuple[list[tuple[int, int, int]], list[tuple[int, int, tuple[int, ...]]]]:
        """What `pressure` reads of each value: pool, and where the value begins and ends, as
        operations; one more operation is the start, the next one the end. Those that have not just
        one end have their readers.
        """
        start = len(self.lane)
        between, among = [], []
        for value in self.values:
            first = start if value.definition is None else value.definition
            if value.kept or len(value.readers) == 1:
                between.append((value.pool, first, start + 1 if value.kept else value.readers[0]))
            else:
                among.append((value.pool, first, value.readers))
        return between, among

    @functools.cached_property
    def loose(self) -> list[tuple[int, int]]:
        """Operations (i, j) of which j, which comes after i, may issue in the cycle of i."""
        successors = enumerate(self.graph.successors)
        return [(i, j) for i, edges in successors for j, distance in edges if distance <= 0]

    @functools.cached_property
    def writes(self) -> list[tuple[int, int]]:
        """Operations that take the write port, and their latency."""
        latency = enumerate(self.graph.latency)
        return [(i, cycles) for i, cycles in latency if self.port[i]]


def build_problem(
    graph: Graph,
    machine: Machine,
    pipe: list[int | None] | None = None,
    values: list[Value] | None = None,
    capacity: tuple[int, ...] = (),
    around: list[tuple[int, int, int]] | None = None,
) -> Problem:
    """Problem of a graph on a machine; lanes are 'fma slots' and 'aux slots', or 'any slots'."""
    names = {
        tuple(i for i, other in enumerate(machine.slots) if other == kind): f"{kind} slots"
        for kind in machine.slots
    }
    units = [machine.unit(op) for op in graph.operations]
    return Problem(
        graph=graph,
        lanes={name: len(slots) for slots, name in names.items()},
        lane=[names[machine.slots_of(op)] for op in graph.operations],
        pipe=pipe or [None] * len(graph.operations),
        port=[machine.writes_port(op) for op in graph.operations],
        blocked=[(unit.name, unit.interval) if unit.interval > 1 else None for unit in units],
        values=values or [],
        capacity=capacity,
        around=around,
    )


@dataclass(frozen=True)
class Progress:
    """State of a search: schedules tried of the effort, cycles of the best one, lower bound in
    cycles.
    """

    tried: int
    effort: int
    cycles: int
    bound: int


def length(problem: Problem, times: Sequence[int]) -> int:
    """First cycle without a pending write."""
    return max(map(operator.add, times, problem.graph.latency), default=-1) + 1


def round_cycles(problem: Problem, times: Sequence[int]) -> int:
    """Cycles from round to round of a loop whose body issues at `times`."""
    found = max(times, default=0) + 1
    for i, j, distance in problem.around or ():
        cycles = times[i] + distance - times[j]
        if cycles > found:
            found = cycles
    writes = [(times[i] + latency) % found for i, latency in problem.writes]
    return found + len(writes) - len(set(writes))


def round_bound(problem: Problem) -> int:
    """Lower bound in cycles from round to round of a loop: issue slots, write port, blocking units,
    the longest chain from the first bundle to the last, and chains that go around.
    """
    graph = problem.graph
    counts = Counter(problem.lane)
    bounds = [-(-count // problem.lanes[name]) for name, count in counts.items()]
    busy = Counter(block for block in problem.blocked if block is not None)
    bounds += [sum(problem.port), *(interval * n for (_, interval), n in busy.items())]
    bounds.append(max(graph.heads(), default=0) + 1)
    ends: dict[int, list[tuple[int, int]]] = {}
    for i, j, distance in problem.around or ():
        ends.setdefault(j, []).append((i, distance))
    for first, lasts in ends.items():
        longest: dict[int, int] = {first: 0}
        for i in range(first, len(graph.operations)):
            if i in longest:
                for j, distance in graph.successors[i]:
                    longest[j] = max(longest.get(j, 0), longest[i] + distance)
        bounds += [longest[i] + distance for i, distance in lasts if i in longest]
    return max(bounds)


def critical_path(problem: Problem) -> int:
    """Length of the longest dependence chain in cycles."""
    return max(problem.graph.tails(), default=0)


def occupancy_bounds(problem: Problem) -> dict[str, int]:
    """Lower bounds in cycles from every lane, from the write port and from units that block.

    For the operations of one resource that have at least head h before and tail q after them:
    h + cycles of the resource + q, the largest over all h and q.
    """
    heads, tails = problem.graph.heads(), problem.graph.tails()
    latency = problem.graph.latency
    count = range(len(problem.lane))
    bounds = {}
    for name, slots in problem.lanes.items():
        members = [(heads[i], tails[i]) for i in count if problem.lane[i] == name]
        bounds[name] = _interval_bound(members, slots, 1)
    writes = [(heads[i] + latency[i], tails[i] - latency[i]) for i in count if problem.port[i]]
    bounds["write port"] = _interval_bound(writes, 1, 1)
    for unit, interval in sorted({block for block in problem.blocked if block is not None}):
        members = [(heads[i], tails[i]) for i in count if problem.blocked[i] == (unit, interval)]
        bounds[unit] = _interval_bound(members, 1, interval)
    return bounds


def _interval_bound(members: list[tuple[int, int]], slots: int, interval: int) -> int:
    """Bound of one resource from (head, tail) of its operations."""
    bound = 0
    for floor in {head for head, _ in members}:
        ends = sorted((tail for head, tail in members if head >= floor), reverse=True)
        for position, tail in enumerate(ends):
            bound = max(bound, floor + (position // slots) * interval + tail)
    return bound


def lower_bound(problem: Problem) -> int:
    """Largest of the critical path and the occupancy bounds, in cycles."""
    return max([critical_path(problem), *occupancy_bounds(problem).values()])


def ordered(graph: Graph, keys: Sequence[float], forward: bool) -> list[int]:
    """Operations by rising key, corrected so that none comes before one it depends on (or,
    backward, after).
    """
    before = graph.predecessors if forward else graph.successors
    after = graph.successors if forward else graph.predecessors
    by_key = sorted(range(len(keys)), key=keys.__getitem__)
    rank = [0] * len(keys)  # whole numbers are compared faster than keys and operations
    for place, i in enumerate(by_key):
        rank[i] = place
    waiting = list(map(len, before))
    ready = [rank[i] for i, count in enumerate(waiting) if count == 0]
    heapq.heapify(ready)
    push, pop = heapq.heappush, heapq.heappop
    result = []
    while ready:
        i = by_key[pop(ready)]
        result.append(i)
        for j, _ in after[i]:
            count = waiting[j] = waiting[j] - 1
            if count == 0:
                push(ready, rank[j])
    return result


def ordered_again(problem: Problem, keys: Sequence[float], forward: bool) -> list[int]:
    """As `ordered`, where the keys are issue cycles of a schedule (or, backward, their negatives).

    Such keys have no operation before one it depends on, except for operations in one cycle.
    """
    if not forward and any(keys[i] == keys[j] for i, j in problem.loose):
        return ordered(problem.graph, keys, forward)
    return sorted(range(len(keys)), key=keys.__getitem__)


def place(
    problem: Problem, order: Sequence[int], forward: bool, least: Sequence[int] = ()
) -> list[int]:
    """Issue cycles of operations that a serial list scheduler places in this order, from 0 on;
    backward the schedule is built from its end and then moved to start at 0. least: cycles of each
    operation from the start, or to the end.
    """
    # Backward the time axis is mirrored: u = -(issue), ends are aligned at the last write.
    rows = problem.rows[0 if forward else 1]
    used: list[dict[int, int]] = [{} for _ in problem.lanes]
    skip: list[dict[int, int]] = [{} for _ in problem.lanes]
    writes: dict[int, int] = {}
    fixed: set[tuple[int, int]] = set()
    busy: dict[str, dict[int, int]] = {
        block[0]: {} for block in problem.blocked if block is not None
    }
    times = [0] * len(order)
    for i in order:
        edges, home, slots, rank, takes_port, takes_more, pipe, block = rows[i]
        u = least[i] if least else 0 if forward else 1 - rank
        for j, distance in edges:
            v = times[j] + distance
            if v > u:
                u = v
        jump = skip[home]
        if u in jump:
            v = jump[u]
            u = _first_free(jump, u) if v in jump else v
        if takes_more:
            while True:
                if takes_port and u + rank in writes:
                    u = _first_free(writes, u + rank) - rank
                elif pipe is not None and (u, pipe) in fixed:
                    u += 1
                elif block is not None and u in busy[block[0]]:
                    u = _first_free(busy[block[0]], u)
                elif u not in jump:
                    break
                if u in jump:
                    u = _first_free(jump, u)
            if takes_port:
                writes[u + rank] = u + rank + 1
            if pipe is not None:
                fixed.add((u, pipe))
            if block is not None:
                unit, interval = block
                taken = range(u - interval + 1, u + interval)
                busy[unit].update(dict.fromkeys(taken, u + interval))
        elif takes_port:
            v = u + rank
            while v in writes:
                u = _first_free(writes, v) - rank
                if u in jump:
                    u = _first_free(jump, u)
                v = u + rank
            writes[v] = v + 1
        times[i] = u
        if slots == 1:
            jump[u] = u + 1
        else:
            table = used[home]
            count = table[u] = table.get(u, 0) + 1
            if count == slots:
                jump[u] = u + 1
    if forward:
        return times
    last = max(times, default=0)
    return [last - u for u in times]


def _first_free(busy: dict[int, int], cycle: int) -> int:
    """First cycle from `cycle` on that is not in `busy`, which maps cycles to later ones."""
    end = busy.get(cycle, cycle)
    after = busy.get(end)
    while after is not None:
        busy[cycle] = after
        cycle, end = end, after
        after = busy.get(end)
    return end


def pressure(problem: Problem, times: Sequence[int]) -> list[int]:
    """Largest number of registers in use at once, by pool."""
    end = max(times, default=0) + 1
    steps = [[0] * (end + 2) for _ in problem.capacity]
    cycles = [*times, 0, end]
    between, among = problem.spans
    for pool, first, last in between:
        step = steps[pool]
        step[cycles[first]] += 1
        step[cycles[last]] -= 1
    for pool, first, readers in among:
        step, begin = steps[pool], cycles[first]
        step[begin] += 1
        step[max(map(cycles.__getitem__, readers), default=begin + 1)] -= 1
    return [max(itertools.accumulate(step)) for step in steps]


def delay_loads(problem: Problem, times: Sequence[int]) -> list[int]:
    """The schedule with every load as late as its readers, a free slot of a bundle and the write
    port allow: its register is taken for fewer cycles, the schedule is as long.
    """
    graph, late = problem.graph, list(times)
    used = Counter(zip(problem.lane, late, strict=True))
    taken = set(late)
    writes = {t + graph.latency[i] for i, t in enumerate(late) if problem.port[i]}
    loads = [i for i, op in enumerate(graph.operations) if op.mnemonic == "ld"]
    for i in sorted(loads, key=lambda i: -late[i]):
        lane, rank = problem.lane[i], graph.latency[i]
        end = min((late[j] - distance for j, distance in graph.successors[i]), default=late[i])
        for cycle in range(end, late[i], -1):
            free = used[lane, cycle] < problem.lanes[lane] and cycle + rank not in writes
            if free and cycle in taken and problem.pipe[i] is None:
                used[lane, late[i]] -= 1
                used[lane, cycle] += 1
                writes.remove(late[i] + rank)
                writes.add(cycle + rank)
                late[i] = cycle
                break
    return late


def search(
    problem: Problem, effort: int, progress: Callable[[Progress], None] | None = None
) -> list[int]:
    """Issue cycle of every operation, from 0 on.

    `effort` bounds the number of schedules tried; the search ends early at the lower bound, and
    near it after `PATIENCE` schedules without gain. Prefers schedules that fit the register
    capacity, then short ones.
    """
    return _Search(problem, effort, progress).run()


Found = tuple[tuple[int, int], list[int]]
"""Cost and issue cycles of a schedule."""


class _Search:
    """State of one search."""

    def __init__(
        self, problem: Problem, effort: int, progress: Callable[[Progress], None] | None
    ) -> None:
        self.problem = problem
        self.effort = effort
        self.progress = progress
        self.rng = random.Random(SEED)
        looped = problem.around is not None
        self.length = round_cycles if looped else length
        self.bound = (round_bound if looped else lower_bound)(problem)
        self.tried = 0
        self.gained = 0
        self.justified: dict[tuple[int, ...], Found | None] = {}
        self.costs: dict[tuple[int, ...], tuple[int, int]] = {}

    def run(self) -> list[int]:
        """Issue cycles of the best schedule found."""
        no_wait = [0.0] * len(self.problem.lane)
        found = [self._start(no_wait, True), self._start(no_wait, False)]
        starts = [
            (self._waits(fma, aux), forward)
            for aux in AUX_WAITS
            for fma in FMA_WAITS
            for forward in (True, False)
        ]
        self.gained = self.tried
        while starts and self._goes_on(min(found)):
            self._tell(min(found))
            best = min(found)[0]
            found.append(self._start(*starts.pop(0)))
            if found[-1][0][0] < best[0]:
                self.gained = self.tried
        return self._evolve(found)

    def _goes_on(self, best: Found) -> bool:
        """Whether another schedule may be worth its time."""
        if not best[1]:
            return False  # a region without operations
        patience = PATIENCE * (best[0][0] - self.bound)
        return self.tried < self.effort and self.tried - self.gained < patience

    def _tell(self, best: Found) -> None:
        if self.progress is not None:
            cycles = self.length(self.problem, best[1])
            self.progress(Progress(self.tried, self.effort, cycles, self.bound))

    def _evolve(self, found: list[Found]) -> list[int]:
        """Cross schedules; one that is no worse than the worst takes its place."""
        population: list[Found] = []
        for one in sorted(found):
            if one not in population:
                population.append(one)
        del population[POPULATION:]
        while self._goes_on(population[0]):
            self._tell(population[0])
            fresh = self.tried < FRESH_UNTIL * self.effort and self.rng.random() < FRESH
            keys = self._guess() if fresh else self._cross(population)
            child = self._improve(self._place(keys, True))
            if child[0] > population[-1][0] or child in population:
                continue
            if child[0][0] < population[0][0][0]:
                self.gained = self.tried
            bisect.insort(population, child, key=lambda one: one[0])
            del population[POPULATION:]
        return population[0][1]

    def _guess(self) -> list[float]:
        """Keys by the longest following path, with random waits."""
        fma, aux = self.rng.choice(FMA_WAITS), self.rng.choice(AUX_WAITS)
        wait = [self.rng.uniform(0.5, 1.5) * cycles for cycles in self._waits(fma, aux)]
        return [-cycles for cycles in self.problem.graph.tails(wait)]

    def _cross(self, population: list[Found]) -> list[float]:
        """Keys of an order: within a window of time that of one schedule, outside another's."""
        rng = self.rng
        inner, outer = (one[1] for one in rng.choices(population, k=2))
        end = max(inner)
        first = rng.uniform(0, end)
        last = first + rng.uniform(*WINDOWS) * end
        before, after = first - 1, last + 1
        keys = [
            a
            if first <= a <= last
            else (b if b <= before else before)
            if a < first
            else (b if b >= after else after)
            for a, b in zip(inner, outer, strict=True)
        ]
        if rng.random() < PERTURBED:
            width = rng.choice(WIDTHS)
            keys = [key + rng.gauss(0.0, width) for key in keys]
        return keys

    def _waits(self, fma: float, aux: float) -> list[float]:
        """Cycles to wait: of multiply-adds, and of operations that use the write port."""
        return [aux if port else fma for port in self.problem.port]

    def _start(self, wait: list[float], forward: bool) -> Found:
        """Schedule by the longest path after (forward) or before (backward), waits included."""
        graph = self.problem.graph
        path = graph.tails(wait) if forward else graph.heads(wait)
        return self._improve(self._place([-cycles for cycles in path], forward))

    def _place(self, keys: Sequence[float], forward: bool) -> list[int]:
        self.tried += 1
        order = ordered(self.problem.graph, keys, forward)
        return place(self.problem, order, forward, self._least(keys, forward))

    def _place_again(self, keys: Sequence[int], forward: bool) -> list[int]:
        """As `_place`, for keys that are those of `ordered_again`; not counted as tried."""
        order = ordered_again(self.problem, keys, forward)
        return place(self.problem, order, forward, self._least(keys, forward))

    def _least(self, keys: Sequence[float], forward: bool) -> list[int]:
        """Of the body of a loop: cycles that operations keep from the start, or from the end, for
        those of the round before, or after, if these are where the keys say.
        """
        problem = self.problem
        if problem.around is None:
            return []
        if forward:
            end = max(keys, default=0) + 1
            found = [0] * len(keys)
            for i, j, distance in problem.around:
                cycle = int(distance - (end - keys[i]))
                if cycle > found[j]:
                    found[j] = cycle
        else:
            found = [1] * len(keys)
            for i, j, distance in problem.around:
                cycle = int(distance + keys[j])  # keys are negative times
                if cycle > found[i]:
                    found[i] = cycle
        return found

    def _improve(self, times: list[int]) -> Found:
        """Justify to the end and back to the start, as long as that is better."""
        best = (self._cost(times), times)
        while self.tried < self.effort:
            self.tried += 2
            found = self._justified(best)
            if found is None:
                break
            best = found
        return best

    def _justified(self, best: Found) -> Found | None:
        """The better of both justified schedules, None if none is better. Schedules come back again
        and again, so what became of each is noted.
        """
        key = tuple(best[1])
        if key not in self.justified:
            late = self._place_again([-t for t in best[1]], False)
            early = self._place_again(late, True)
            # A longer schedule costs more, whatever its registers.
            most = best[0][0]
            near = [times for times in (late, early) if self.length(self.problem, times) <= most]
            found = min(((self._cost(times), times) for times in near), default=best)
            self.justified[key] = found if found[0] < best[0] else None
        return self.justified[key]

    def _cost(self, times: list[int]) -> tuple[int, int]:
        """Cycles, with a penalty for registers that do not exist; then registers in use."""
        key = tuple(times)
        if key not in self.costs:
            peaks = pressure(self.problem, times)
            capacity = self.problem.capacity
            excess = sum(max(0, peak - size) for peak, size in zip(peaks, capacity, strict=True))
            cycles = self.length(self.problem, times)
            self.costs[key] = cycles + EXCESS_PENALTY * excess, sum(peaks)
        return self.costs[key]
