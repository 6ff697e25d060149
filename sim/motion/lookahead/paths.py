# SPDX-License-Identifier: Apache-2.0
"""Paths on which look-ahead is measured: times with G64 P against those with G61.

Twenty paths: letters, rasters, zigzags, stars, chords of even and of mixed length, polygons, lines
with arcs, moves of tool and table, random ones. Rounding a corner must never cost time.
"""

from __future__ import annotations

import math
import random
import re
from collections.abc import Iterator, Sequence

from asip_asm.project import ROOT
from sim.motion.gcode.interpreter import parse
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings

FEED = 2400  # mm/min
# Of each wave of a surface: two wave numbers [rad/mm], phase, height [mm].
WAVES = ((0.02, 0.12), (0.02, 0.12), (0.0, 6.28), (1.5, 1.5))
TOLERANCES = (0.001, 0.005, 0.01, 0.02, 0.05, 0.2, 1.0)  # P of every path [mm]


def _lines(points: Sequence[tuple[float, ...]], feed: float = FEED) -> str:
    """A program along points of x, y and, if they have them, a and c; it begins at the first."""
    words = ["".join(f"{n}{v:.6f} " for n, v in zip("XYAC", p, strict=False)) for p in points]
    return "\n".join([f"G0 {words[0]}", "G4 P0", f"G1 F{feed:g} {words[1]}", *words[2:]])


def raster(count: int, length: float, step: float) -> str:
    """Lines of a length with steps between them."""
    points = [(0.0, 0.0)]
    for k in range(count):
        x = length if k % 2 == 0 else 0.0
        points += [(x, k * step), (x, (k + 1) * step)]
    return _lines(points)


def chords(radius: float, lengths: tuple[float, ...]) -> str:
    """A circle in chords of these lengths in turn."""
    angle, points = 0.0, [(radius, 0.0)]
    while angle < 2 * math.pi:
        angle = min(2 * math.pi, angle + lengths[(len(points) - 1) % len(lengths)] / radius)
        points.append((radius * math.cos(angle), radius * math.sin(angle)))
    return _lines(points)


def zigzag(count: int, length: float, degrees: float) -> str:
    """Lines of a length with turns by an angle to both sides."""
    points, angle = [(0.0, 0.0)], 0.0
    for k in range(count):
        x, y = points[-1]
        points.append((x + length * math.cos(angle), y + length * math.sin(angle)))
        angle += math.radians(degrees) * (1 if k % 2 == 0 else -1)
    return _lines(points)


def star(points: int, step: int, radius: float) -> str:
    """Chords from every point of a circle to the one `step` points on."""
    angles = [2 * math.pi * k * step / points for k in range(points + 1)]
    return _lines([(radius * math.cos(a), radius * math.sin(a)) for a in angles])


def walk(seed: int, count: int, least: float, most: float, five: bool = False) -> str:
    """Random lines, of log-uniform length [mm], with or without turns of the table."""
    rng = random.Random(f"walk {seed}")
    place = [0.0] * 4
    points: list[tuple[float, ...]] = [(0.0,) * 4]
    for _ in range(count):
        length, angle = math.exp(rng.uniform(math.log(least), math.log(most))), rng.uniform(0, 6.28)
        place = [
            0.9 * place[0] + length * math.cos(angle),
            0.9 * place[1] + length * math.sin(angle),
        ]
        turn = [rng.uniform(-5, 5), rng.uniform(-20, 20)] if five else [0.0, 0.0]
        points.append((*place, *turn))
        place += [0.0, 0.0]
    return _lines(points)


def slots(count: int) -> str:
    """Lines with arcs between them, and corners into the next one."""
    text = [f"G0 X0 Y0\nG4 P0\nG1 F{FEED}"]
    for k in range(count):
        y = 12 * k
        text.append(f"X20 Y{y}\nG3 X20 Y{y + 6} I0 J3\nG1 X0\nX0 Y{y + 12}")
    return "\n".join(text)


def cam_part(count: int, seed: int = 1) -> Iterator[str]:
    """Lines of a program of at least `count` moves, as CAM writes a surface: G64 P0.01, rows in

    chords of 0.1 to 0.4 mm, rounded to 0.1 um, with a rapid way back. Every second row also
    tilts and turns the table.
    """
    rng = random.Random(f"part {seed}")
    waves = [tuple(rng.uniform(low, high) for low, high in WAVES) for _ in range(6)]

    def height(x: float, y: float) -> float:
        return 600 + sum(h * math.sin(a * x + b * y + c) for a, b, c, h in waves)

    yield "G21 G90 G17 G54 G64 P0.01\nG0 Z620\n"
    made = row = 0
    while made < count:
        x, y = -60.0, -60 + 0.15 * row % 120
        yield f"G0 X{x:.4f} Y{y:.4f} A0 C0\nG1 Z{height(x, y):.4f} F6000\n"
        made += 3
        while (x := x + rng.uniform(0.1, 0.4)) < 60:
            table = f" A{2 * math.sin(x / 15):.4f} C{0.3 * (x + 60):.4f}" if row % 2 else ""
            yield f"X{x:.4f} Z{height(x, y):.4f}{table}\n"
            made += 1
        yield "G0 Z620\n"
        row += 1
    yield "M2\n"


def letters() -> str:
    """A-G-H of the paper, without its path control."""
    text = (ROOT / "sim/paths/agh.ngc").read_text(encoding="utf-8")
    return re.sub(r"G6[14](\.1)?(?!\d)", "", text).replace("M2", "").replace("%", "")


PATHS = {
    "A-G-H": letters,
    "raster, 12 lines of 20 mm, 2 mm apart": lambda: raster(12, 20, 2),
    "raster, 40 lines of 5 mm, 0.5 mm apart": lambda: raster(40, 5, 0.5),
    "raster, 30 lines of 8 mm, 0.1 mm apart": lambda: raster(30, 8, 0.1),
    "two corners 1 mm apart": lambda: raster(1, 10, 1) + "\nX0",
    "circle, chords of 1 and 0.02 mm": lambda: chords(10, (1.0, 0.02)),
    "circle, chords of 0.1 mm": lambda: chords(10, (0.1,)),
    "circle, chords of 0.3, 2 and 0.05 mm": lambda: chords(10, (0.3, 2.0, 0.05)),
    "zigzag of 3 mm by 30 degrees": lambda: zigzag(20, 3, 30),
    "zigzag of 1 mm by 90 degrees": lambda: zigzag(40, 1, 90),
    "zigzag of 0.2 mm by 60 degrees": lambda: zigzag(60, 0.2, 60),
    "zigzag of 0.05 mm by 150 degrees": lambda: zigzag(60, 0.05, 150),
    "star of 7 points": lambda: star(7, 3, 15),
    "star of 40 points": lambda: star(40, 19, 15),
    "hexagon": lambda: star(6, 1, 10),
    "slots of lines and arcs": lambda: slots(6),
    "random lines of 1 to 20 mm": lambda: walk(1, 40, 1, 20),
    "random lines of 0.01 to 5 mm": lambda: walk(2, 80, 0.01, 5),
    "random lines of 0.05 to 0.5 mm": lambda: walk(3, 80, 0.05, 0.5),
    "random lines of 1 to 20 mm with the table": lambda: walk(4, 40, 1, 20, True),
}

CHORDS = tuple(name for name in PATHS if name.startswith("circle"))


def approach_time() -> float:
    """Time of the rapid move before the circles in chords [s]."""
    program = parse("G21 G90 G0 X10\nM2")
    return float(Lookahead(program.moves, LookaheadSettings()).duration())


def path_time(name: str, control: str, settings: LookaheadSettings | None = None) -> float:
    """Time of a path [s] with G61, or G64 and words."""
    program = parse(f"G21 G90 {control}\n{PATHS[name]()}\nM2")
    return float(Lookahead(program.moves, settings or LookaheadSettings()).duration())


def losses() -> Iterator[tuple[str, float, float]]:
    """Path, P, and the time of G64 P more than that of G61 [s], of every path and tolerance."""
    settings = LookaheadSettings()
    for name in PATHS:
        stops = path_time(name, "G61", settings)
        for tolerance in TOLERANCES:
            yield name, tolerance, path_time(name, f"G64 P{tolerance:g}", settings) - stops
