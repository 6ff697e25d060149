# SPDX-License-Identifier: Apache-2.0
"""Values and errors of a compiled program over boxes of its inputs, many boxes at once.

Let r_i be the own error of operation i. With all own errors times t of 0..1 the program has values
y(t): exact at 0, as computed at 1. `Form` of a node encloses y(t) for every t and every input of
the box, so each own error and each derivative has a range over all of them, and by the mean value
theorem the error of a result is at most sum_i sup |d result / d y_i| sup |r_i|. There is no
remainder. An operation that has no derivative (a comparison, a selection, a whole number, a root
next to 0) takes the error of its arguments into its own error, and passes none on. R. E. Moore,
R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, 2009, chapter 6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from asip_asm.model.graph import Graph, binary32
from asip_asm.model.ranges import (
    Form,
    Real,
    chosen,
    constant,
    plus,
    polar,
    scaled,
    times,
    union,
    widened,
    within,
)
from asip_asm.model.structure import Structure

Mask = NDArray[np.bool_]
Factor = Form | float
Partial = Factor | None
LARGEST = float(np.finfo(np.float32).max)
MANTISSA = 2.0**24
SMALLEST = 2.0**-149


@dataclass(frozen=True)
class Wave:
    """sign * the sine, or cosine, of an angle: the node `angle` of the graph."""

    angle: int
    cosine: bool
    node: int
    sign: int = 1


@dataclass
class Weight:
    """Derivative of a result by a node, while it is summed. waves: its terms that are a number
    times the sine or the cosine of an angle, by the angle: of both together the size is known.
    """

    boxes: int
    plain: Partial = None
    waves: dict[int, dict[bool, tuple[Factor, Wave]]] = field(default_factory=dict)

    def add(self, weight: Factor, partial: Factor, wave: Wave | None) -> None:
        """A term weight * partial."""
        if wave is None:
            term = _product(weight, partial)
            self.plain = term if self.plain is None else _sum(self.plain, term, self.boxes)
            return
        pair = self.waves.setdefault(wave.angle, {})
        number = _product(weight, float(wave.sign))
        if wave.cosine in pair:
            number = _sum(pair[wave.cosine][0], number, self.boxes)
        pair[wave.cosine] = number, wave

    def total(self, steps: Mapping[int, Step]) -> Factor:
        total = self.plain
        for pair in self.waves.values():
            terms = [_product(number, steps[wave.node].value) for number, wave in pair.values()]
            term = terms[0]
            if len(terms) == 2:
                sizes = [_size(number) for number, _ in pair.values()]
                owns = (steps[wave.node].own for _, wave in pair.values())
                more = sum(owns, np.zeros(self.boxes))
                both = _sum(terms[0], terms[1], self.boxes)
                both = constant(both, self.boxes) if isinstance(both, float) else both
                term = polar(both, sizes[0], sizes[1], more)
            total = term if total is None else _sum(total, term, self.boxes)
        return 0.0 if total is None else total


def _size(number: Factor) -> Real | float:
    return abs(number) if isinstance(number, float) else number.size


@dataclass
class Step:
    """What is known of a node. partials: derivatives by its arguments, None: no influence. own:
    largest own error. grid: the computed value is a multiple of this power of two. bad: boxes in
    which the node, or one that it takes, may leave its domain. difference: of a comparison, the
    number whose sign decides, in_doubt: its error. waves: of a product, the sine or
    cosine that is the derivative. jump: the part of `own` that is there where program and law may
    take different branches. choice: the value is that of an argument.
    """

    value: Form
    args: tuple[int, ...]
    partials: tuple[Partial, ...]
    own: Real
    grid: Real
    bad: Mask
    difference: Form | None = None
    in_doubt: Real | None = None
    waves: tuple[Wave | None, ...] = ()
    jump: Real | None = None
    choice: bool = False


@dataclass
class Enclosure:
    """Steps of all nodes of a graph over boxes. faults: nodes that may leave their domain, why,
    and in which boxes; severity: how much of their ranges is outside of it, summed.
    """

    graph: Graph
    structure: Structure
    boxes: int
    symbols: Mapping[int | str, int]
    steps: dict[int, Step] = field(default_factory=dict)
    faults: list[tuple[int, str, Mask]] = field(default_factory=list)
    errors: dict[int, tuple[Real, Real]] = field(default_factory=dict)
    severity: Real = field(init=False)

    def __post_init__(self) -> None:
        self.severity = np.zeros(self.boxes)

    def error(self, root: int) -> Real:
        """Largest |as computed - exact| of a node in each box."""
        return self.error_and_smooth(root)[0]

    def error_and_smooth(self, root: int) -> tuple[Real, Real]:
        """The error, and that for inputs for which no branch is in doubt."""
        if root not in self.errors:
            value = self.steps[root].value
            width = np.where(
                np.isfinite(value.size), (value.high - value.low) * (1 + 2.0**-50), np.inf
            )
            error, smooth = self._either(root)
            self.errors[root] = np.fmin(error, width), np.fmin(smooth, width)
        return self.errors[root]

    def _either(self, root: int) -> tuple[Real, Real]:
        """A minimum, maximum or saturation has at most the largest error of its arguments."""
        step = self.steps[root]
        if not step.choice:
            return self._error(root)
        parts = [
            [np.where(_size(partial) == 0, 0.0, each) for each in self.error_and_smooth(arg)]
            for arg, partial in zip(step.args, step.partials, strict=True)
            if partial is not None
        ]
        errors, smooth = zip(*parts, strict=True)
        return np.maximum.reduce(errors), np.maximum.reduce(smooth)

    def choose(self, root: int, step: Step) -> None:
        """Add a step whose value is that of an argument; where it is not known which, the error of
        the choice becomes its own: what else the arguments do keeps its correlations.
        """
        self.steps[root] = step
        step.choice = True
        masks = [p.low != p.high if isinstance(p, Form) else np.zeros(self.boxes, bool)
                 for p in step.partials]  # fmt: skip
        open_ = np.logical_or.reduce(masks)
        if open_.any():
            error, smooth = self.error_and_smooth(root)
            none = self.number(0.0)
            step.own, step.jump = (np.where(open_, each, 0.0) for each in (error, error - smooth))
            step.partials = tuple(
                chosen(open_, none, p if isinstance(p, Form) else self.number(p or 0.0))
                for p in step.partials
            )

    def _error(self, root: int) -> tuple[Real, Real]:
        jumps = np.zeros(self.boxes)
        total = np.zeros(self.boxes)
        weights: dict[int, Weight] = {root: Weight(self.boxes, 1.0)}
        for i in range(root, -1, -1):
            found = weights.pop(i, None)
            if found is None:
                continue
            weight, step = found.total(self.steps), self.steps[i]
            size = abs(weight) if isinstance(weight, float) else weight.size
            if step.jump is not None:
                jumps += np.where((step.jump == 0) | (size == 0), 0.0, size * step.jump)
            own = step.own if step.jump is None else step.own - step.jump
            total += np.where((own == 0) | (size == 0), 0.0, size * own)
            for k, (arg, partial) in enumerate(zip(step.args, step.partials, strict=True)):
                if partial is None or self.steps[arg].args == () and not self.steps[arg].own.any():
                    continue
                waved = step.waves[k] if step.waves else None
                weights.setdefault(arg, Weight(self.boxes)).add(weight, partial, waved)
        whole, smooth = (
            np.where(np.isnan(each), np.inf, each * (1 + 2.0**-30))
            for each in (total + jumps, total)
        )
        return whole, smooth

    def fault(self, i: int, reason: str, mask: Mask, outside: Real) -> Mask:
        """Note boxes in which the node may leave its domain, by which share of its range."""
        if mask.any():
            self.faults.append((i, reason, mask))
            self.severity += np.where(mask, np.nan_to_num(np.clip(outside, 0, 1), nan=1.0), 0.0)
        return mask

    def bad(self, args: Sequence[int]) -> Mask:
        """Boxes in which an argument is no number."""
        found = np.zeros(self.boxes, bool)
        for arg in args:
            found |= self.steps[arg].bad
        return found

    def number(self, value: float) -> Form:
        return constant(value, self.boxes)

    # ------------------------------------------------------------------ roundings
    def rounded(
        self, i: int, args: Sequence[int], value: Form, partials: Sequence[Partial],
        own: Real, exact_grid: Real, bad: Mask | None = None,
    ) -> Step:  # fmt: skip
        """Step of a value that the core rounds, with `own` besides; to a multiple of exact_grid no
        rounding is needed where so many digits suffice.
        """
        bad = self.bad(args) if bad is None else bad | self.bad(args)
        size = value.size + own
        exact = size <= MANTISSA * np.where(exact_grid >= SMALLEST, exact_grid, 0.0)
        own = np.where(exact, own, own + half_ulp(size))
        before, value = value, widened(value, own, self.symbols.get(i))
        least, most = (np.float32(end).astype(float) for end in (before.low, before.high))
        up, down = (
            (before.low >= 0) & (2 * own > before.low),
            (before.high <= 0) & (2 * own > -before.high),
        )
        if up.any() or down.any():
            # Rounding is monotonic, and changes no sign: y(t) is max(f + t r, least) there, or min.
            low = np.where(up, np.minimum(least, before.low), value.low)
            value = within(value, low, np.where(down, np.maximum(most, before.high), value.high))
            partials = [self._or_none(up | down, partial) for partial in partials]
        over = ~bad & ~(value.size <= LARGEST)
        bad = bad | self.fault(i, "overflow", over, 1 - LARGEST / value.size)
        grid = np.where(exact & (own == 0), np.maximum(exact_grid, ulp(value)), ulp(value))
        return Step(value, tuple(args), tuple(partials), own, grid, bad)

    def plain(
        self, args: Sequence[int], value: Form, partials: Sequence[Partial],
        own: Real | None = None, grid: Real | None = None, bad: Mask | None = None,
    ) -> Step:  # fmt: skip
        """Step of a value that the core does not round."""
        bad = self.bad(args) if bad is None else bad
        own = np.zeros(self.boxes) if own is None else own
        grid = ulp(value) if grid is None else grid
        return Step(value, tuple(args), tuple(partials), own, grid, bad)

    def _or_none(self, mask: Mask, partial: Partial) -> Partial:
        """The derivative, or 0, in the boxes of the mask."""
        if partial is None:
            return None
        form = self.number(partial) if isinstance(partial, float) else partial
        return chosen(mask, union(form, self.number(0.0)), form)

    def constant_step(self, value: float) -> Step:
        """A constant: its distance from binary32 is its own error."""
        single = float(binary32(value))
        lost = np.full(self.boxes, abs(single - value))
        ends = [np.full(self.boxes, end(single, value)) for end in (min, max)]
        return Step(
            Form(*ends), (), (), lost, np.full(self.boxes, lowest_bit(single)),
            np.zeros(self.boxes, bool),
        )  # fmt: skip


def half_ulp(size: Real) -> Real:
    """Largest error of a rounding to nearest of numbers up to this size."""
    mantissa, exponent = np.frexp(size)
    exponent = exponent - (mantissa == 0.5)  # a power of two itself is not rounded
    found = np.ldexp(1.0, np.maximum(exponent - 25, -150))
    return np.where(np.isfinite(size), found, np.inf)


def ulp(value: Form) -> Real:
    """Spacing of binary32 at the least size of the value: all its numbers are multiples of it."""
    least = np.where(
        (value.low <= 0) & (value.high >= 0), 0.0, np.minimum(np.abs(value.low), np.abs(value.high))
    )
    _, exponent = np.frexp(least)
    found = np.ldexp(1.0, np.maximum(exponent - 24, -149))
    return np.where((least > 0) & np.isfinite(least), found, SMALLEST)


def lowest_bit(value: float) -> float:
    """Largest power of two that the binary32 number is a multiple of; large for 0."""
    if value == 0:
        return 2.0**100
    numerator, denominator = abs(value).as_integer_ratio()
    return (numerator & -numerator) / denominator


def _product(a: Factor, b: Factor) -> Factor:
    if isinstance(a, float):
        return a * b if isinstance(b, float) else scaled(b, a)
    return scaled(a, b) if isinstance(b, float) else times(a, b)


def _sum(a: Factor, b: Factor, boxes: int) -> Factor:
    if isinstance(a, float) and isinstance(b, float):
        return a + b
    first = constant(a, boxes) if isinstance(a, float) else a
    return plus(first, constant(b, boxes) if isinstance(b, float) else b)
