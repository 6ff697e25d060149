# SPDX-License-Identifier: Apache-2.0
"""Cutter compensation: random contours against rs274, refusals by name, distance by geometry."""

import math
import random

import numpy as np
import pytest

from sim.motion.gcode.interpreter import GcodeErrors, parse
from sim.motion.gcode.oracle import OracleError, differences, ours, rs274
from sim.motion.gcode.tools import Tool
from sim.motion.geometry.curves import curve_of
from tests.bench.needs import needs
from tests.bench.seed import SEED
from tests.gcode.mistakes import ZERO, refused

TOOLS = {1: Tool(diameter=4.0), 2: Tool(diameter=6.0, orientation=2)}


def contour(seed: str) -> str:
    """A random contour of lines and arcs with compensation, some of them with gouging corners."""
    rng = random.Random(seed)
    plane, (a, b), (i, j), h = rng.choice((("G17", "XY", "IJ", "Z"), ("G18", "ZX", "KI", "Y")))
    x, y = 0.0, 0.0
    diameter = rng.choice((1, 2, 4))
    on = rng.choice((f"G41.1 D{diameter}", f"G42.1 D{diameter}", "G41 D2", "G42 D1", "G41.1 D-3"))
    lines = [f"G21 G90 G94 G54 G98 F100\n{plane} G0 {a}0 {b}0\n{on}"]
    for _ in range(rng.randrange(2, 9)):
        kind, extra = rng.random(), ""
        if rng.random() < 0.3:
            extra = rng.choice(
                (f" {h}{rng.uniform(-5, 5):.2f}", " A5 C7", f" F{rng.randint(9, 999)}")
            )
        p, q = x + rng.uniform(-25, 25), y + rng.uniform(-25, 25)
        if len(lines) > 1 and rng.random() < 0.2:
            p, q = round(p), y
        if kind < 0.5:
            lines.append(f"G{rng.choice('1110')} {a}{p:.4f} {b}{q:.4f}{extra}")
        elif kind < 0.75:
            radius = math.hypot(p - x, q - y) / 2 * rng.choice((1.01, 1.2, 2, 5))
            radius *= rng.choice((1, 1, 1, -1))
            lines.append(f"G{rng.choice('23')} {a}{p:.4f} {b}{q:.4f} R{radius:.4f}{extra}")
        elif kind < 0.9:
            u, v, angle = rng.uniform(-8, 8), rng.uniform(-8, 8), rng.uniform(0, 6.28)
            p = x + u + math.hypot(u, v) * math.cos(angle)
            q = y + v + math.hypot(u, v) * math.sin(angle)
            word = f"G{rng.choice('23')} {a}{p:.6f} {b}{q:.6f}"
            lines.append(f"{word} {i}{u:.6f} {j}{v:.6f}{extra}")
        else:
            lines.append(rng.choice(("G4 P.5", "S5", f"G1 {h}2", "G91 G1 X0\nG90", "G20\nG21")))
            continue
        x, y = float(f"{p:.4f}"), float(f"{q:.4f}")
    return "\n".join([*lines, "G40", f"G0 {a}50 {b}50\nG1 X1 Y2 Z3 F77", "M2"]) + "\n"


def verdicts(text: str) -> tuple[bool, bool, list[str]]:
    """Whether rs274 and we accept a text, and how the moves differ."""
    try:
        rs274(text)
    except OracleError:
        theirs = False
    else:
        theirs = True
    try:
        ours(text)
    except GcodeErrors:
        return theirs, False, []
    return theirs, True, differences(text) if theirs else []


@needs("rs274")
@pytest.mark.parametrize("number", [60, pytest.param(5000, marks=pytest.mark.full)])
def test_compensation__random_contours__move_as_in_rs274_or_are_refused_by_both(number):
    accepted = 0
    for case in range(number):
        seed = f"contour {SEED} {case}"
        text = contour(seed)
        theirs, mine, found = verdicts(text)
        assert (theirs, found) == (mine, []), f"seed {seed!r}\n{text}"
        accepted += mine
    assert accepted > number / 2


def distance_to(contour_moves, points: np.ndarray) -> np.ndarray:
    """Least distance of each point (n, 2) to the contour, by dense samples of it."""
    samples = []
    for move in contour_moves:
        curve = curve_of(move)
        places = np.linspace(0.0, curve.length, 4000)
        samples.append(curve.evaluate(places)[0][:, :2] * 1e3)
    every = np.concatenate(samples)
    return np.array([np.min(np.hypot(*(every - point).T)) for point in points])


def test_compensation__closed_contour__the_tool_touches_it_and_never_cuts_it():
    """Geometry alone: every point of the centre's path is one radius from the contour."""
    contour_text = "G1 X30 F100\nG3 X40 Y10 R10\nG1 Y30\nX20\nY20\nX5\nG2 X0 Y15 R5\nG1 Y0\n"
    head, tail = "G0 X-20 Y0\n", "G1 X0\nM2"
    plain = parse(head + "G1 X0 F100\n" + contour_text + tail, start=ZERO).moves[2:-1]
    text = head + "G42.1 D4\nG1 X0 F100\n" + contour_text + "G40\n" + tail
    moves = parse(text, start=ZERO).moves[2:-1]
    for move in moves:
        curve = curve_of(move)
        points = curve.evaluate(np.linspace(0.0, curve.length, 40))[0][:, :2] * 1e3
        assert distance_to(plain, points) == pytest.approx(2.0, abs=0.01)


REFUSED = {
    "G41\nG1 X9": "G41 without a tool",
    "G41 D9\nG1 X9": "there is no tool 9",
    "G41 D2\nG1 X9": "tool 2 is a lathe tool",
    "G41.1\nG1 X9": "G41.1 without D",
    "G19 G41 D1\nG1 X9": "G41 with G19",
    "G43.4\nG41 D1\nG1 X9": "G41 with G43.4",
    "G41 D1\nG42 D1": "cutter compensation is on already",
    "D1 G1 X9": "D does not belong to G1",
    "G41 D1\nG1 Z1": "the entry move of the compensation, 0.0000 mm",
    "G41 D1\nG2 X1 Y1 R1": "the ends of the entry arc are 1.4142 mm apart",
    "G41 D1\nG3 X5 R2.6\nG3 X6 R.6": "the arc of radius 0.6000 mm has no room",
    "G41 D1\nG1 X9\nX9.5\nY9\nG40": "the line of line 4 ends in a concave corner",
    "G41 D1\nG1 X9\nG40\nG2 X20 R9": "the move after G40 is an arc",
    "G41 D1\nG1 X9\n#1=#5420": "the position #5420 is not known during cutter compensation",
    "G41 D1\nG1 X9\no1 repeat [1001]\nG1 Z1\nZ2\no1 endrepeat": "1000 moves and rests follow",
} | {
    f"G41 D1\nG1 X9\n{word}\nG1 X20": f"{word.split()[0]} during cutter compensation"
    for word in (
        *("G18", "G54", "G61", "G99", "G43", "G43.4", "G49", "M6", "M70", "M73", "G28", "G28.1"),
        *("G92 X1", "G92.1", "G10 L2 P1 X1", "G10 L20 P0 X1", "G81 X1 Z-1 R1"),
        "G53 G0 X1",
    )
}  # fmt: skip


@pytest.mark.parametrize("text", REFUSED)
def test_compensation__what_is_not_defined__is_refused_by_name(text):
    assert REFUSED[text] in str(refused(f"F100\n{text}\nM2", start=ZERO, tools=TOOLS))


def test_compensation__tool_change_behind_g40__goes_on_from_where_the_tool_is():
    moves = parse("T1 G41 D1 F9\nG1 X10\nX20\nG40\nM6\nG0 Z1\nM2", start=ZERO, tools=TOOLS).moves
    assert moves[-1].end == pytest.approx((20, 2, 1, 0, 0))


def test_compensation__hole_of_the_size_of_the_tool__is_a_way_down():
    text = "G41.1 D4 F9\nG0 X-2 Y9\nX-2 Y0\nG3 X-2 I2 Z-1\nX-2 I2\nG40\nG0 Z1\nM2"
    moves = parse(text, start=(-2.0, 20.0, 0.0, 0.0, 0.0)).moves
    assert [curve_of(move) is None for move in moves] == [False, False, False, True, False]
