# SPDX-License-Identifier: Apache-2.0
"""Random programs through the G-code reader: moves that join, or mistakes with their place.

Programs are made of words that mean something, most of them in an order that does, and some of them
are damaged afterwards, so that both ends of the reader are reached.
"""

from __future__ import annotations

import math
import os
import random

import pytest

from sim.motion.gcode import GcodeErrors, Move, parse, stream

SEED = int(os.environ.get("SEED", "1"))
MODAL = (
    *("G17 G18 G19 G20 G21 G40 G49 G54 G55 G59.3 G61 G61.1 G64 G80 G90 G91 G90.1 G91.1".split()),
    *("G93 G94 G98 G99 G43.4 G92.1 G92.2 G92.3 G28 G28.1 G53".split()),
)
HEADS = ("G0", "G1", "G1", "G1", "G2", "G3", "G81", "G82", "G83", "G4", "G92", "G10 L2", "")
LETTERS = "XYZACIJKRFPQLN"
FUNCTIONS = ("SIN", "SQRT", "ATAN", "LN", "EXP", "FIX", "ROUND", "ABS", "ACOS")
OPERATORS = ("+", "-", "*", "/", "**", " MOD ", " EQ ", " OR ", " LT ")
SCRAP = "GMXYZACIJKRFNTPQLOSIN0123456789.+-*/[]=<>%();#\t é\0"


def number(rng: random.Random, depth: int = 0) -> str:
    """A number, a parameter or an expression."""
    kind = rng.random()
    if kind < 0.75 or depth > 2:
        digits = rng.choice([0, 1, 3, 9])
        size = rng.choice([1.0, 5.0, 20.0, 1e6, 1e-6])
        return f"{rng.uniform(-size, size):.{digits}f}"
    if kind < 0.83:
        return f"#{rng.choice(['1', '2', '31', '5220', '5221', '<name>', '#1', '0', '99999'])}"
    if kind < 0.9:
        inner = number(rng, depth + 1)
        name = rng.choice(FUNCTIONS)
        return f"{name}[{inner}]" + (f"/[{number(rng, depth + 1)}]" if name == "ATAN" else "")
    parts = [number(rng, depth + 1) for _ in range(rng.randrange(1, 4))]
    return "[" + rng.choice(OPERATORS).join(parts) + "]"


def block(rng: random.Random) -> str:
    """One line of words in any combination."""
    kind = rng.random()
    if kind < 0.1:
        return f"#{rng.choice(['1', '2', '31', '<name>', '[1+2]'])}={number(rng)}"
    if kind < 0.15:
        return rng.choice(["(comment)", "; rest", "%", "", "N10", "M2", "/G1 X1", "o1 sub"])
    words = rng.sample(MODAL, rng.choice([0, 0, 0, 1, 1, 2]))
    words.append(rng.choice(HEADS))
    words += [
        f"{letter}{number(rng)}" for letter in rng.sample(LETTERS, rng.choice([0, 1, 2, 2, 3, 4]))
    ]
    if rng.random() < 0.5:
        words.append(f"F{rng.choice([100, 6000, 15000])}")
    if rng.random() < 0.1:
        rng.shuffle(words)
    return rng.choice([" ", " ", ""]).join(word for word in words if word)


def sober_block(rng: random.Random) -> str:
    """One line that is most probably right."""

    def at(letters: str, least: int = 1) -> str:
        chosen = rng.sample(letters, rng.randrange(least, len(letters) + 1))
        return " ".join(f"{x}{rng.uniform(-20, 20):.{rng.choice([0, 2, 4])}f}" for x in chosen)

    x, r = rng.uniform(1, 9), rng.uniform(10, 20)
    return rng.choice(
        [
            f"G0 {at('XYZAC')}",
            f"G1 {at('XYZAC')} F{rng.randrange(1, 20000)}",
            f"{at('XYZ')}",
            f"G17 G91 G{rng.choice('23')} X{x:.4f} R{r:.3f} F900\nG90 G1 Z1",
            f"G17 G{rng.choice('23')} I{x:.3f} J{-x:.3f} F900\nG1 Z1",
            f"G64 P{rng.uniform(0, 1):.4f} Q{rng.uniform(0, 0.1):.3f}",
            rng.choice(["G61", "G20", "G21", "G91", "G90", "G54", "G55", "G92.1", "G4 P.1", "G80"]),
            f"G9{rng.choice('89')} G81 {at('XY')} Z{-r:.2f} R{x:.2f} F100\nG80\nG1 Z1",
            f"G10 L2 P1 {at('XYZ')}",
            f"#{rng.randrange(1, 31)}=[{number(rng, 3)}+1]\nG1 Z2 F900",
            f"G1 X[#{rng.randrange(5161, 5164)}+COS[{r:.2f}]]",
        ]
    )


def program(seed: str) -> str:
    """A text of up to 12 blocks; half of them mean something, and one in three is damaged."""
    rng = random.Random(seed)
    one = sober_block if rng.random() < 0.6 else block
    lines = [one(rng) for _ in range(rng.randrange(1, 12))]
    if one is sober_block:
        lines.insert(0, "G1 X1 F600")
    text = "\n".join([*lines, *rng.choice([["M2"], ["M2"], ["M30"], [], ["%"]])])
    if rng.random() < 0.33:
        for _ in range(rng.randrange(1, 4)):
            place = rng.randrange(len(text) + 1)
            text = text[:place] + rng.choice([rng.choice(SCRAP), ""]) + text[place + 1 :]
    return text


def check(text: str) -> str:
    """Reads a program; returns "moves", "nothing" or "mistakes". Asserts what must hold."""
    lines = text.splitlines() or [""]
    try:
        read = parse(text)
    except GcodeErrors as caught:
        assert caught.errors
        for error in caught.errors:
            assert 1 <= error.line <= len(lines)
            source = lines[error.line - 1]
            assert source[error.column - 1 :].expandtabs(1).startswith(error.text)
            assert 1 <= error.column <= len(source) + 1
        return "mistakes"
    assert all(1 <= move.line <= len(lines) for move in read.moves)
    for before, move in zip(read.moves, read.moves[1:], strict=False):
        assert before.end == move.start and before.line <= move.line
    for move in read.moves:
        values = [*move.start, *move.end, move.tolerance if move.tolerance < math.inf else 0.0]
        values += move.centre if move.motion.is_arc else ()
        assert all(math.isfinite(value) for value in values)
        assert move.feed is None or move.feed > 0.0 or move.motion.value == "G0"
    assert [item for item in stream(text.splitlines()) if isinstance(item, Move)] == list(
        read.moves
    )
    return "moves" if read.moves else "nothing"


def campaign(name: str, count: int) -> dict[str, int]:
    found = {"moves": 0, "nothing": 0, "mistakes": 0}
    for n in range(count):
        seed = f"{name} {SEED} {n}"
        text = program(seed)
        try:
            found[check(text)] += 1
        except Exception as error:
            raise AssertionError(f"replay: SEED={SEED}, program({seed!r}):\n{text!r}") from error
    print(f"{count} programs, SEED={SEED}: {found}")
    return found


def test_reader__ten_thousand_random_programs__moves_or_located_mistakes():
    found = campaign("quick", 10_000)
    # A campaign that only meets refusals, or none, would prove nothing.
    assert min(found["moves"], found["mistakes"]) > 1000


@pytest.mark.full
@pytest.mark.parametrize("part", range(100))
def test_reader__a_million_random_programs__moves_or_located_mistakes(part):
    campaign(f"deep {part}", 10_000)
