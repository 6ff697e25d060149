# SPDX-License-Identifier: Apache-2.0
"""Step interpolators: golden step strings, and every node's distance from the ideal in integers."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from sim.rtl.interpolator_rtl import InterpolatorRtl
from tests.bench.seed import SEED

MODES = [False, True]  # elementary, combined
Node = tuple[int, int]


@functools.cache
def rtl() -> InterpolatorRtl:
    return InterpolatorRtl()


def text(steps: np.ndarray) -> str:
    """X, Y: +1; x, y: -1; D: both axes, forward."""
    letters = {(1, 0): "X", (-1, 0): "x", (0, 1): "Y", (0, -1): "y", (1, 1): "D"}
    return "".join(letters[int(x), int(y)] for x, y, _ in steps)


def nodes(steps: np.ndarray, start: Node = (0, 0)) -> np.ndarray:
    """Nodes (x, y) after each step."""
    return np.cumsum(steps[:, :2], axis=0) + np.array(start)


def quadruple(values: np.ndarray) -> np.ndarray:
    """As Python integers, in which squares of squares can't overflow."""
    return values.astype(object)


# ---------------------------------------------------------------------- golden strings


# End, combined, steps of the line.
LINES = [
    ((5, 3), False, "XYXYXXYX"),
    ((5, 3), True, "DXDXD"),
    ((-3, 7), False, "YxYYYxYYxY"),
    ((4, 4), False, "YXYXYXYX"),
    ((0, 0), False, ""),
    ((0, 0), True, ""),
    ((0, -2), True, "yy"),
]
CIRCLE_5 = "YYxYYxxYxxxxyxxyyxyyyyXyyXXyXXXXYXXYYXYY"  # of radius 5, from its point on x


@pytest.mark.parametrize(("end", "combined", "wanted"), LINES)
def test_line__golden_string(end, combined, wanted):
    assert text(rtl().line(*end, combined)) == wanted


def test_circle__golden_string():
    assert text(rtl().arc((5, 0), (5, 0), 25)) == CIRCLE_5


# ---------------------------------------------------------------------- lines


def check_line(u: int, v: int, combined: bool) -> None:
    steps = rtl().line(u, v, combined)
    at = nodes(steps)
    count = max(abs(u), abs(v)) if combined else abs(u) + abs(v)
    assert len(steps) == count, (u, v)
    if not count:
        return
    assert tuple(at[-1]) == (u, v)
    moved = np.abs(steps).sum(axis=1)
    assert np.all(moved >= 1) if combined else np.all(moved == 1)
    number = np.arange(1, count + 1)
    for reached, length in zip(at.T, (u, v), strict=True):
        assert np.all(2 * np.abs(reached * count - number * length) <= count), (u, v)
    across = at[:, 0] * v - at[:, 1] * u  # distance times the line's length
    assert np.all((4 if combined else 2) * across**2 <= u * u + v * v), (u, v)


@pytest.mark.parametrize("combined", MODES)
def test_line__every_end_within_64__each_node_within_half_a_step(combined):
    for u in range(-64, 65):
        for v in range(-64, 65):
            check_line(u, v, combined)


@pytest.mark.parametrize("combined", MODES)
def test_line__long_random__each_node_within_half_a_step(combined):
    random = np.random.default_rng(SEED)
    for _ in range(60):
        check_line(*(int(x) for x in random.integers(-9000, 9001, 2)), combined)


# ---------------------------------------------------------------------- circles and arcs


def check_on_circle(at: np.ndarray, radius_squared: int, combined: bool) -> None:
    """Radial distance at most 0.7071 (elementary) or below 0.5 (combined), in exact integers."""
    squared = quadruple((at**2).sum(axis=1))
    if combined:
        assert all((4 * (squared + radius_squared) - 1) ** 2 < 64 * squared * radius_squared)
    else:
        assert all((2 * (squared + radius_squared) - 1) ** 2 <= 16 * squared * radius_squared)


def full_turn(radius: int, clockwise: bool, combined: bool) -> np.ndarray:
    steps = rtl().arc((radius, 0), (radius, 0), radius**2, clockwise, combined)
    at = nodes(steps, (radius, 0))
    assert tuple(at[-1]) == (radius, 0)
    assert len(at) == 8 * radius or combined
    area = int((at[:, 0] * steps[:, 1] - at[:, 1] * steps[:, 0]).sum())
    assert (area < 0) == clockwise
    check_on_circle(at, radius**2, combined)
    return at


@pytest.mark.parametrize("combined", MODES)
@pytest.mark.parametrize("clockwise", [False, True])
def test_circle__every_radius_to_200__closes_and_stays_on_the_circle(clockwise, combined):
    for radius in range(1, 201):
        full_turn(radius, clockwise, combined)


@pytest.mark.parametrize("combined", MODES)
@pytest.mark.parametrize("clockwise", [False, True])
@pytest.mark.parametrize(
    "radii",
    [(*range(1, 14), 37), pytest.param(range(1, 201), marks=pytest.mark.full)],
    ids=["small", "all"],
)
def test_arc__every_end__is_the_circle_up_to_it(radii, clockwise, combined):
    for radius in radii:
        start, whole = (radius, 0), full_turn(radius, clockwise, combined)
        for number, end in enumerate(whole.tolist(), start=1):
            steps = rtl().arc(start, tuple(end), radius**2, clockwise, combined)
            assert len(steps) == number, (radius, end)
            assert np.array_equal(nodes(steps, start), whole[:number]), (radius, end)


def random_arc(
    random: np.random.Generator, largest: int, turns: int = 2
) -> tuple[Node, Node, int, bool, int]:
    """Begin, end, square of the radius (from 3 steps on), clockwise, whole turns below `turns`."""
    radius = float(random.uniform(3, largest))
    angles = random.uniform(0, 2 * np.pi, 2)
    begin, end = ((round(radius * np.cos(a)), round(radius * np.sin(a))) for a in angles)
    return begin, end, round(radius**2), bool(random.integers(2)), int(random.integers(turns))


def test_arc__random_nodes_and_turns__ends_exactly_and_turns_as_asked():
    random = np.random.default_rng(SEED)
    for case in range(400):
        start, end, squared, clockwise, turns = random_arc(random, 400, turns=3)
        combined = bool(case & 1)
        steps = rtl().arc(start, end, squared, clockwise, combined, turns)
        at = nodes(steps, start)
        what = f"replay: SEED={SEED}, case {case}: {start} {end} {squared} {clockwise} {combined}"
        assert tuple(at[-1]) == end, what
        swept = np.unwrap(np.arctan2(*np.vstack([start, at]).T[::-1]))
        whole = abs(swept[-1] - swept[0]) / (2 * np.pi)
        assert turns - 0.01 <= whole <= turns + 1.01, what
        assert (swept[-1] < swept[0]) == clockwise, what
        near = quadruple((at[:-1] ** 2).sum(axis=1))
        # Ends are rounded nodes: they, and a combined end's neighbours, may be 0.7071 away.
        assert all((2 * (near + squared) - 1) ** 2 <= 16 * near * squared + 64 * squared), what


def near_circle(node: Sequence[int], squared: int, size: Callable[[tuple[int, int]], int]) -> bool:
    """Whether -m <= N < m; m: the greater coordinate (max), or the sum of both (sum)."""
    most = size((abs(node[0]), abs(node[1])))
    return -most <= node[0] ** 2 + node[1] ** 2 - squared < most


@pytest.mark.parametrize("combined", MODES)
def test_arc__every_pair_of_nodes_that_a_command_may_have__in_one_turn(combined):
    """Any nodes between whose neighbours the circle passes, rounded points of it or not.

    Every node is within half a step of the circle along the diagonal; combined ones are along an
    axis if start and end are. So some are more than half a step off.
    """
    farthest: list[float] = []
    for squared in (*range(1, 9), 13, 25, 27):
        reach = range(-8, 9)
        begins = [
            (u, v)
            for u in reach
            for v in reach
            if -(abs(u) + abs(v)) <= u * u + v * v - squared < abs(u) + abs(v)
        ]
        for start in begins:
            for end in begins:
                close = combined and all(near_circle(x, squared, max) for x in (start, end))
                for clockwise in (False, True):
                    what = (start, end, squared, clockwise)
                    at = nodes(rtl().arc(start, end, squared, clockwise, combined), start)
                    assert tuple(at[-1]) == end, what
                    farthest.append(max(abs(math.hypot(*x) - squared**0.5) for x in at.tolist()))
                    bound = max if close else sum
                    assert all(near_circle(x, squared, bound) for x in at.tolist()), what
                    swept = np.unwrap(np.arctan2(*np.vstack([start, at]).T[::-1]))
                    turned = (swept[-1] - swept[0]) * (-1 if clockwise else 1)
                    assert 0 < turned < 2 * np.pi + 1e-6, what
    assert 0.5 < max(farthest) <= math.sqrt(0.5)


def test_planes__same_steps_on_the_plane_s_axes():
    flat = rtl().arc((9, 0), (0, 9), 81)
    assert np.array_equal(rtl().arc((9, 0), (0, 9), 81, plane="zx"), flat[:, [1, 2, 0]])
    assert np.array_equal(rtl().arc((9, 0), (0, 9), 81, plane="yz"), flat[:, [2, 0, 1]])
    line = rtl().line(7, -3)
    assert np.array_equal(rtl().line(7, -3, plane="zx"), line[:, [1, 2, 0]])
    assert np.array_equal(rtl().line(7, -3, plane="yz"), line[:, [2, 0, 1]])


def test_pauses_between_requests__change_no_step():
    assert np.array_equal(rtl().line(40, 17, pause=5), rtl().line(40, 17))
    assert np.array_equal(
        rtl().arc((30, 0), (0, -30), 900, pause=7), rtl().arc((30, 0), (0, -30), 900)
    )
