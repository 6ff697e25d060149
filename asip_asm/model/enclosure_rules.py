# SPDX-License-Identifier: Apache-2.0
"""What each core operation makes of the ranges of its arguments: `add_step`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from asip_asm.model.bound import SINE_ULP
from asip_asm.model.enclosure import (
    MANTISSA,
    SMALLEST,
    Enclosure,
    Mask,
    Partial,
    Step,
    Wave,
    half_ulp,
)
from asip_asm.model.enclosure_choices import (
    INTEGERS,
    Rule,
    absolute,
    beyond,
    compare,
    extreme,
    floor,
    saturate,
    select,
    sign_of,
    to_integer,
)
from asip_asm.model.functions import MARKED, TURN, Function
from asip_asm.model.ranges import (
    LIBRARY,
    Form,
    Real,
    chosen,
    inverse,
    plus,
    root,
    scaled,
    sine_and_cosine,
    times,
    widened,
    within,
)
from asip_asm.model.structure import SUMS

LARGEST_ANGLE = 256.0
SMALL_ANGLE = 2.0**-12
"""Up to here the sine unit's result is its argument (docs/units.md)."""
NEAR_ZERO = 4.0
"""A root's argument within so many of its own errors of 0 has no useful derivative."""
Values = Mapping[str, tuple[Real, Real]]


def add_step(found: Enclosure, i: int, values: Values, leaves: Mapping[int, str]) -> None:
    """Step of node i of the graph; those of its arguments are there.

    values: range of the inputs, states and parameters by name; leaves: differences of integers that
    have a range of their own.
    """
    graph, node = found.graph, found.graph.nodes[i]
    if i in leaves or not node.args and node.op not in ("const", "int_const"):
        low, high = values[leaves.get(i, str(node.value))]
        whole = node.op in ("int_input", "int_state", "isub")
        value = _leaf(found, low, high, leaves.get(i, str(node.value)))
        if node.op == "fsub":  # a number less its value of the last tick
            step = found.rounded(i, (), value, (), *_rest(found))
            grid = found.steps[node.args[0]].grid
            exact = value.size <= MANTISSA * grid
            step.own, step.grid = np.where(exact, 0.0, step.own), np.where(exact, grid, step.grid)
        else:
            step = found.plain((), value, (), grid=np.ones(found.boxes) if whole else None)
    elif node.op == "const":
        step = found.constant_step(node.number)
    elif node.op == "int_const":
        step = found.plain((), found.number(node.number), (), grid=np.ones(found.boxes))
    elif i in graph.functions:
        name, args = graph.functions[i]
        step = _function(found, i, args, MARKED[name], name)
    elif i in found.structure.floors:
        step = floor(found, i)
    else:
        step = RULES[node.op](found, i, node.args)
    fraction = found.structure.fractions.get(i)
    if fraction is not None:
        error = 2 * found.error(fraction.number) + half_ulp(step.value.size)
        low, high = -fraction.offset - error, 1 - fraction.offset + error
        ends = (low, high) if fraction.sign > 0 else (-high, -low)
        step.value = within(step.value, *ends)
    found.steps[i] = step


def _leaf(found: Enclosure, low: Real, high: Real, name: str) -> Form:
    symbol = found.symbols.get(name)
    if symbol is None:
        return Form(low, high)
    c, half = 0.5 * low + 0.5 * high, 0.5 * (high - low)
    g = np.zeros((len(found.symbols), found.boxes))
    g[symbol] = half
    return Form(low, high, c, g, 2.0**-50 * (np.abs(c) + half))


# ------------------------------------------------------------------ sums and products
def _power_of_two(x: Form) -> Mask:
    mantissa, _ = np.frexp(x.low)
    return (x.low == x.high) & (np.abs(mantissa) == 0.5)


def _exact_factor(step: Step, factor: Form) -> Mask:
    """Whether the factor is a power of two that takes no digit from the value."""
    return _power_of_two(factor) & (
        (factor.size >= 1) | (step.grid * factor.size >= SMALLEST) | (step.value.size == 0)
    )


def _multiply(sign: int, addend: int = 0) -> Rule:
    def rule(found: Enclosure, i: int, args: Sequence[int]) -> Step:
        steps = [found.steps[arg] for arg in args]
        x, y = steps[0].value, steps[1].value
        value = scaled(times(x, y), sign)
        grid = steps[0].grid * steps[1].grid
        partials: list[Partial] = [scaled(y, sign), scaled(x, sign)]
        if addend:
            value = plus(value, steps[2].value, addend)
            grid = np.minimum(grid, steps[2].grid)
            partials.append(float(addend))
            value = _polar(found, i, value)
        own = np.zeros(found.boxes)
        step = found.rounded(i, args, value, partials, own, grid)
        waves = [_wave(found, args[1], sign), _wave(found, args[0], sign)]
        step.waves = (*waves, None) if addend else tuple(waves)
        if not addend:
            exact = _exact_factor(steps[0], y) | _exact_factor(steps[1], x)
            if exact.any():
                step.own = np.where(exact, 0.0, step.own)
                step.value = chosen(exact, value, step.value)
        return step

    return rule


def _wave(found: Enclosure, i: int, sign: int) -> Wave | None:
    """What the derivative by the other factor is, where it is the sine or cosine of an angle."""
    wave = found.structure.waves.get(i)
    return Wave(*wave, i, sign) if wave else None


def _polar(found: Enclosure, i: int, value: Form) -> Form:
    """A sum in which both the sine and the cosine of an angle are factors."""
    joint = found.structure.joint_sums.get(i)
    if joint is None:
        return value
    size = {arg: step.value.size for arg, step in found.steps.items() if arg in joint.nodes}
    most = sum((size[a] * (size[b] if b is not None else 1.0) for a, b in joint.others),
               np.zeros(found.boxes))  # fmt: skip
    most = most + sum(found.steps[inner].own for inner in joint.inner)
    for x, y, one, other in joint.pairs:
        more = found.steps[one].own + found.steps[other].own
        most = most + np.sqrt(size[x] ** 2 + size[y] ** 2) * (1 + more)
    most = most * (1 + 2.0**-40)
    return within(value, -most, most)


def _add(sign: int) -> Rule:
    def rule(found: Enclosure, i: int, args: Sequence[int]) -> Step:
        a, b = (found.steps[arg] for arg in args)
        if args[0] == args[1] and sign < 0:
            return found.plain(args, found.number(0.0), (1.0, -1.0))
        value = _polar(found, i, plus(a.value, b.value, sign))
        grid = np.minimum(a.grid, b.grid)
        return found.rounded(i, args, value, (1.0, float(sign)), np.zeros(found.boxes), grid)

    return rule


def _add_integers(sign: int) -> Rule:
    def rule(found: Enclosure, i: int, args: Sequence[int]) -> Step:
        a, b = (found.steps[arg] for arg in args)
        value = plus(a.value, b.value, sign)
        over = found.fault(i, *beyond(value, INTEGERS + 1))
        step = found.plain(args, value, (1.0, float(sign)), grid=np.minimum(a.grid, b.grid))
        step.bad = step.bad | over
        return step

    return rule


def _divide(found: Enclosure, i: int, args: Sequence[int]) -> Step:
    a, b = (found.steps[arg] for arg in args)
    low, high = b.value.low, b.value.high
    zero = (low <= 0) & (high >= 0) & ~b.bad
    bad = found.fault(i, "division by zero", zero, np.minimum(-low, high) / (high - low))
    reciprocal = inverse(b.value)
    one = bool((a.value.low == 1).all() and (a.value.high == 1).all())
    value = reciprocal if one else times(a.value, reciprocal)
    slope = scaled(times(value, reciprocal), -1)
    return found.rounded(i, args, value, (reciprocal, slope), *_rest(found), bad)


def _rest(found: Enclosure) -> tuple[Real, Real]:
    """No own error yet, no grid."""
    return np.zeros(found.boxes), np.zeros(found.boxes)


def _root(found: Enclosure, i: int, args: Sequence[int]) -> Step:
    """Next to 0 the root of an argument with error e is off by up to sqrt(e)."""
    (x,) = (found.steps[arg] for arg in args)
    low, high = x.value.low, x.value.high
    bad = found.fault(i, "root of a negative number", (low < 0) & ~x.bad, -low / (high - low))
    value = root(x.value)
    slope = scaled(inverse(value), 0.5)
    low = np.maximum(x.value.low, 0)
    near = low <= 1e-4 * x.value.high
    own, partial = np.zeros(found.boxes), slope
    if near.any():
        error = found.error(args[0])
        near &= (low <= NEAR_ZERO * error) | (low == 0)
        jump = np.where(low > error, error / np.sqrt(np.maximum(low, 1e-300)), np.sqrt(error))
        own = np.where(near, jump * (1 + 2.0**-40), 0.0)
        partial = chosen(near, found.number(0.0), slope)
    return found.rounded(i, args, value, (partial,), own, np.zeros(found.boxes), bad)


# ------------------------------------------------------------------ sines and functions
def _sine(cosine: bool) -> Rule:
    def rule(found: Enclosure, i: int, args: Sequence[int]) -> Step:
        (x,) = (found.steps[arg] for arg in args)
        far = ~(x.value.size <= LARGEST_ANGLE) & ~x.bad
        bad = found.fault(i, "sine beyond 256 rad", far, 1 - LARGEST_ANGLE / x.value.size)
        s, c = sine_and_cosine(x.value)
        value, slope = (c, scaled(s, -1)) if cosine else (s, c)
        own = 2 * SINE_ULP * half_ulp(value.size)
        if not cosine:  # The sine of a small angle is the angle itself, as the unit gives it.
            cube = np.minimum(x.value.size, SMALL_ANGLE) ** 3 / 6 * (1 + 2.0**-40)
            own = np.where(x.value.size <= SMALL_ANGLE, cube, own)
        # The result of a unit whose error is below an ulp is never above 1.
        step = found.plain(
            args, within(widened(value, own), -np.ones(found.boxes), np.ones(found.boxes)),
            (slope,), own, bad=bad | x.bad,
        )  # fmt: skip
        return step

    return rule


def _function(found: Enclosure, i: int, args: Sequence[int], function: Function, name: str) -> Step:
    if name.endswith("_turns"):
        return _turns(found, i, args, function, name.startswith("cos"))
    (x,) = (found.steps[arg] for arg in args)
    low, high = function.domain
    outside = ((x.value.low < low) | (x.value.high > high)) & ~x.bad
    far = np.maximum(low - x.value.low, x.value.high - high) / (x.value.high - x.value.low)
    bad = found.fault(i, f"{name} outside of {low:g} to {high:g}", outside, far)
    ends = [np.clip(end, low, high) for end in (x.value.low, x.value.high)]
    a, b = (function.exact(end) for end in ends)
    margin = LIBRARY * np.maximum(np.abs(a), np.abs(b))
    value = Form(np.minimum(a, b) - margin, np.maximum(a, b) + margin)
    points = [function.partials(point)[0] for point in (*ends, np.clip(0.0, *ends))]
    least, most = np.minimum.reduce(points), np.maximum.reduce(points)
    wider = LIBRARY * np.maximum(np.abs(least), np.abs(most))
    slope = Form(least - wider, most + wider)
    own = function.ulp * 2.0**-23 * value.size + function.absolute
    # Next to 0 the absolute part would be as large as the number itself.
    square = x.value.size**2 * (1 + 2.0**-40)
    own = np.where(x.value.size <= function.unchanged, np.minimum(own, square), own)
    return found.plain(args, widened(value, own), (slope,), own, bad=bad | x.bad)


def _turns(found: Enclosure, i: int, args: Sequence[int], function: Function, cosine: bool) -> Step:
    steps = [found.steps[arg] for arg in args]
    turns = times(steps[0].value, steps[1].value)
    if len(args) == 3:
        turns = plus(turns, steps[2].value)
    angle = scaled(turns, TURN)
    limit = function.domain[1]
    far = ~(turns.size <= limit) & ~found.bad(args)
    bad = found.fault(i, "sine beyond 256 rad", far, 1 - limit / turns.size)
    s, c = sine_and_cosine(angle)
    value, slope = (c, scaled(s, -1)) if cosine else (s, c)
    steep = scaled(slope, TURN)
    partials = [times(steep, steps[1].value), times(steep, steps[0].value), steep]
    exact = _power_of_two(steps[1].value) if len(args) == 2 else np.zeros(found.boxes, bool)
    lost = np.where(exact, 0.0, 2.0**-24 * (1 + 1e-6) * angle.size)
    own = function.ulp * 2.0**-23 * value.size + function.absolute + lost
    # The polynomial's value itself is one of the core, a little above 1 at most.
    return found.plain(
        args, widened(value, own), tuple(partials[: len(args)]), own, bad=bad | found.bad(args)
    )


def _to_float(found: Enclosure, i: int, args: Sequence[int]) -> Step:
    (x,) = (found.steps[arg] for arg in args)
    return found.rounded(i, args, x.value, (1.0,), np.zeros(found.boxes), x.grid)


def _negate(found: Enclosure, i: int, args: Sequence[int]) -> Step:
    (x,) = (found.steps[arg] for arg in args)
    return found.plain(args, scaled(x.value, -1), (-1.0,), grid=x.grid)


RULES: dict[str, Rule] = {
    "fmul": _multiply(1),
    "fnmul": _multiply(-1),
    **{op: _multiply(*signs) for op, signs in SUMS.items()},
    "fadd": _add(1),
    "fsub": _add(-1),
    "iadd": _add_integers(1),
    "isub": _add_integers(-1),
    "fdiv": _divide,
    "fsqrt": _root,
    "fsin": _sine(False),
    "fcos": _sine(True),
    "fneg": _negate,
    "fabs": absolute,
    "fsgn": sign_of,
    "fmin": extreme(-1),
    "fmax": extreme(1),
    "fsat": saturate,
    "feq": compare(False, equal=True),
    "flt": compare(True),
    "fle": compare(False),
    "sel": select(None),
    "selge": select(True),
    "selgt": select(True, strict=True),
    "i2f": _to_float,
    "f2i": to_integer(np.rint),
    "f2it": to_integer(np.trunc),
}
