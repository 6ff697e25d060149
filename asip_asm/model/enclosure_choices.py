# SPDX-License-Identifier: Apache-2.0
"""What comparisons, selections, minima and whole numbers make of the ranges of their arguments."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from asip_asm.model.enclosure import Enclosure, Mask, Partial, Step
from asip_asm.model.ranges import Form, Real, chosen, plus, scaled, times, union

INTEGERS = 2.0**31
Rule = Callable[[Enclosure, int, Sequence[int]], Step]


def compare(strict: bool, equal: bool = False) -> Rule:
    def rule(found: Enclosure, i: int, args: Sequence[int]) -> Step:
        a, b = (found.steps[arg] for arg in args)
        d = plus(a.value, b.value, -1)
        if equal:
            yes, no = (d.low == 0) & (d.high == 0), (d.low > 0) | (d.high < 0)
        else:
            yes = (d.high < 0) if strict else (d.high <= 0)
            no = (d.low >= 0) if strict else (d.low > 0)
        open_ = ~yes & ~no
        error = np.zeros(found.boxes)
        if open_.any():
            error = np.where(open_, found.error(args[0]) + found.error(args[1]), 0.0)
        own = (error > 0).astype(float)
        value = Form(yes.astype(float), (~no).astype(float))
        step = found.plain(args, value, (None, None), own, np.ones(found.boxes))
        step.difference, step.in_doubt, step.jump = d, error, own
        return step

    return rule


def select(zero_is_first: bool | None, strict: bool = False) -> Rule:
    """None: the test is whether the number is not 0."""

    def rule(found: Enclosure, i: int, args: Sequence[int]) -> Step:
        test, a, b = (found.steps[arg] for arg in args)
        t = test.value
        if zero_is_first is None:
            first, second = (t.low > 0) | (t.high < 0), (t.low == 0) & (t.high == 0)
        else:
            first = (t.low > 0) if strict else (t.low >= 0)
            second = (t.high <= 0) if strict else (t.high < 0)
        return _either(found, i, args, first, second)

    return rule


def _either(found: Enclosure, i: int, args: Sequence[int], first: Mask, second: Mask) -> Step:
    """One of two branches: the other one, its faults and its errors, count where either may be
    taken. Where the test is in doubt the program may take another branch than the law; their
    difference is then that at a number within its error of the switching point.
    """
    test, a, b = (found.steps[arg] for arg in args)
    open_ = ~first & ~second
    value = chosen(first, a.value, chosen(second, b.value, union(a.value, b.value)))
    hull = [
        Form(np.where(sure, 1.0, 0.0), np.where(other, 0.0, 1.0))
        for sure, other in ((first, second), (second, first))
    ]
    own = np.zeros(found.boxes)
    if open_.any():
        if test.difference is not None and test.in_doubt is not None:
            number, error = test.difference, test.in_doubt
        else:
            number, error = test.value, found.error(args[0])
        doubt = open_ & (error > 0)
        if doubt.any():
            own = np.where(doubt, _gap(a.value, b.value, number, error), 0.0)
    bad = test.bad | (a.bad & ~second) | (b.bad & ~first)
    partials = tuple(1.0 if m.low.all() else None if not m.high.any() else m for m in hull)
    grid = np.minimum(a.grid, b.grid)
    step = found.plain(args, value, (None, *partials), own, grid, bad)
    step.jump = own
    return step


def _gap(a: Form, b: Form, test: Form, error: Real) -> Real:
    """Largest |a - b| where |test| is at most `error`."""
    gap = plus(a, b, -1)
    found = gap.size
    if gap.g is None or test.g is None:
        return found
    own = np.maximum((test.g**2).sum(axis=0), 1e-300)
    share = (gap.g * test.g).sum(axis=0) / own
    share = np.where(np.isfinite(share), share, 0.0)
    rest = plus(gap, times(Form(share, share), test), -1)
    return np.fmin(found, rest.size + np.abs(share) * error * (1 + 2.0**-40))


def _pick(masks: Sequence[tuple[Mask, Mask]]) -> tuple[Partial, ...]:
    """Derivatives of a piecewise choice: 1 where it surely is the argument, 0 to 1 where it may."""
    return tuple(
        Form(sure.astype(float), may.astype(float)) if not sure.all() else 1.0
        for sure, may in masks
    )


def extreme(sign: int) -> Rule:
    """Largest (sign 1) or smallest of two."""

    def rule(found: Enclosure, i: int, args: Sequence[int]) -> Step:
        a, b = (found.steps[arg] for arg in args)
        d = scaled(plus(a.value, b.value, -1), sign)
        first, second = d.low >= 0, d.high <= 0
        if sign > 0:
            low, high = (np.maximum(*ends) for ends in _ends(a, b))
        else:
            low, high = (np.minimum(*ends) for ends in _ends(a, b))
        value = chosen(first, a.value, chosen(second, b.value, Form(low, high)))
        partials = _pick([(first, ~second | first), (second & ~first, ~first)])
        step = found.plain(args, value, partials, grid=np.minimum(a.grid, b.grid))
        found.choose(i, step)
        return step

    return rule


def _ends(a: Step, b: Step) -> tuple[tuple[Real, Real], tuple[Real, Real]]:
    return (a.value.low, b.value.low), (a.value.high, b.value.high)


def saturate(found: Enclosure, i: int, args: Sequence[int]) -> Step:
    x, low, high = (found.steps[arg] for arg in args)
    v, least, most = x.value, low.value, high.value
    value = Form(*(np.minimum(np.maximum(getattr(v, end), getattr(least, end)), getattr(most, end))
                   for end in ("low", "high")))  # fmt: skip
    inside = (v.low >= least.high) & (v.high <= most.low)
    below, above = v.high <= least.low, v.low >= most.high
    none = np.zeros(found.boxes, bool)
    masks = [(inside, ~below & ~above), (none, v.low < least.high), (none, v.high > most.low)]
    value = chosen(inside, v, value)
    grid = np.minimum(np.minimum(x.grid, low.grid), high.grid)
    step = found.plain(args, value, _pick(masks), grid=grid)
    found.choose(i, step)
    return step


def absolute(found: Enclosure, i: int, args: Sequence[int]) -> Step:
    (x,) = (found.steps[arg] for arg in args)
    v = x.value
    plus_, minus = v.low >= 0, v.high <= 0
    folded = Form(np.zeros(found.boxes), v.size)
    value = chosen(plus_, v, chosen(minus, scaled(v, -1), folded))
    slope = Form(np.where(plus_, 1.0, -1.0), np.where(minus & ~plus_, -1.0, 1.0))
    return found.plain(args, value, (slope,), grid=x.grid)


def sign_of(found: Enclosure, i: int, args: Sequence[int]) -> Step:
    (x,) = (found.steps[arg] for arg in args)
    value = Form(np.sign(x.value.low), np.sign(x.value.high))
    open_ = value.low != value.high
    doubt = open_ & (found.error(args[0]) > 0) if open_.any() else open_
    step = found.plain(args, value, (None,), 2.0 * doubt, np.ones(found.boxes))
    step.jump = step.own
    return step


# ------------------------------------------------------------------ integers
def beyond(value: Form, limit: float, bad: Mask | bool = False) -> tuple[str, Mask, Real]:
    """Fault of an integer that may be larger than the limit."""
    return (
        "integer beyond 32 bits",
        ~(value.size <= limit) & np.logical_not(bad),
        1 - limit / value.size,
    )


def _steps_of(found: Enclosure, number: int, low: Real, high: Real) -> Real:
    """By how much a whole number may differ that a rounding of `number` decides."""
    open_ = low != high
    if not open_.any():
        return np.zeros(found.boxes)
    error = found.error(number)
    return np.where(open_ & (error > 0), np.minimum(np.floor(error) + 1, high - low), 0.0)


def floor(found: Enclosure, i: int) -> Step:
    number = found.structure.floors[i]
    x = found.steps[number]
    low, high = np.floor(x.value.low), np.floor(x.value.high)
    own = np.zeros(found.boxes)
    if i not in found.structure.periodic:
        own = _steps_of(found, number, low, high)
    bad = x.bad | found.fault(i, *beyond(x.value, INTEGERS - 1, x.bad))
    step = found.plain((), Form(low, high), (), own, np.ones(found.boxes), bad)
    step.jump = own
    return step


def to_integer(round_: Callable[[Real], Real]) -> Rule:
    def rule(found: Enclosure, i: int, args: Sequence[int]) -> Step:
        (x,) = (found.steps[arg] for arg in args)
        low, high = round_(x.value.low), round_(x.value.high)
        bad = x.bad | found.fault(i, *beyond(x.value, INTEGERS - 1, x.bad))
        own = _steps_of(found, args[0], low, high)
        step = found.plain(args, Form(low, high), (None,), own, np.ones(found.boxes), bad)
        step.jump = own
        return step

    return rule
