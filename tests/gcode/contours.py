# SPDX-License-Identifier: Apache-2.0
"""Random contours of lathe cycles: lines, arcs, corners and pockets in all quadrants."""

from __future__ import annotations

import random

CYCLES = ("G70", "G71", "G71", "G71.1", "G71.2", "G72", "G72", "G72.1", "G72.2")
KINDS = ("flat", "slope", "fall", "step", "arc", "arc")


def lathe_program(seed: int) -> str:
    """A program with a contour and a cycle; not every one can be cut."""
    rng = random.Random(seed)
    cycle = rng.choice(CYCLES)
    facing = cycle.startswith("G72") or (cycle == "G70" and rng.random() < 0.4)
    along, across = ("X", "Z") if facing else ("Z", "X")
    sign, side = rng.choice((1, -1)), rng.choice((1, -1))
    lines, begin = _contour(rng, along, across, sign, side)
    distance = rng.choice(
        ("", f" D{rng.uniform(0.02, 0.5):.3f}", f" D{rng.uniform(-0.2, 0.1):.3f}")
    )
    start = begin - sign * rng.uniform(0, 4)
    words = f"{along}{start:.3f} {across}{side * rng.uniform(15, 40):.3f}{distance}"
    if cycle == "G70":
        words += rng.choice(("", " P2", " P3 E0.1"))
    else:
        words += rng.choice(("", " I2", f" I{rng.uniform(0.3, 3):.3f}"))
        words += rng.choice(("", " R0.3", " R0"))
    text = "\n".join(lines)
    return (
        f"G21 G90 G18 G94 G54 F100\nO100 sub\n{text}\nO100 endsub\n"
        f"G0 X41 Z41 Y2\n{cycle} Q100 {words}\nG0 X33\nM2\n"
    )


def _contour(
    rng: random.Random, along: str, across: str, sign: int, side: int
) -> tuple[list[str], float]:
    """Its lines, and the coordinate where it begins."""
    begin, height = round(rng.uniform(-3, 3), 3), rng.uniform(2, 8)
    place, last = begin, ""
    lines = [f"G0 {along}{place:.3f} {across}{side * height:.3f}"]
    count = rng.randint(3, 10)
    for number in range(count):
        kind = rng.choice([kind for kind in KINDS if kind != last or kind == "arc"])
        last = kind
        step = 0.0 if kind == "step" else rng.uniform(0.8, 5)
        rise = 0.0 if kind == "flat" else rng.uniform(0.3, 3)
        if kind == "fall" or (kind == "arc" and rng.random() < 0.5):
            rise = -rise
        place, height = round(place + sign * step, 3), round(height + rise, 3)
        words = (f"{along}{place:.3f} " if step else "") + f"{across}{side * height:.3f}"
        if kind == "arc":
            way = (step**2 + rise**2) ** 0.5
            # Of a smaller radius it would go back.
            radius = way / 2 * max(1.0, rng.choice((way / step, 2.0, 5.0))) + 0.001
            lines.append(f"G{rng.choice((2, 3))} {words} R{radius:.3f}")
            continue
        corner = rng.random() < 0.2 and number < count - 1
        lines.append(f"G1 {words}" + corner * f" {rng.choice('AC')}{rng.uniform(0.05, 0.4):.3f}")
    return lines, begin
