# SPDX-License-Identifier: Apache-2.0
"""Random programs through the G-code reader: moves that join, or mistakes with their place.

Programs are made of words that mean something, most of them in an order that does, and some of them
are damaged afterwards, so that both ends of the reader are reached. Those with O words have
branches, loops and subroutines in each other; undamaged they must move as in rs274.
"""

from __future__ import annotations

import itertools
import math
import random
import re
from collections.abc import Callable

import pytest

from sim.motion.gcode import execution
from sim.motion.gcode.interpreter import GcodeErrors, parse, stream
from sim.motion.gcode.oracle import differences
from sim.motion.geometry.moves import Dwell, Move
from tests.bench.needs import needs
from tests.bench.seed import SEED

MOST = 3000  # moves of a text that are looked at
MODAL = (
    *("G17 G18 G19 G20 G21 G40 G49 G54 G55 G59.3 G61 G61.1 G64 G80 G90 G91 G90.1 G91.1".split()),
    *("G93 G94 G98 G99 G43.4 G92.1 G92.2 G92.3 G28 G28.1 G53 G7 G8 G43".split()),
    *("M0 M1 M6 M60 M70 M71 M72 M73 T0".split()),
)
HEADS = (
    "G0",
    "G1",
    "G1",
    "G1",
    "G2",
    "G3",
    "G81",
    "G82",
    "G83",
    "G73",
    "G89",
    "G74",
    "G84",
    "G4",
    "G92",
    "G10 L2",
    "G38.2",
    "S9 M3 G33",
    "",
)
LETTERS = "XYZACIJKRFPQLNH@^"
FUNCTIONS = ("SIN", "SQRT", "ATAN", "LN", "EXP", "FIX", "ROUND", "ABS", "ACOS")
OPERATORS = ("+", "-", "*", "/", "**", " MOD ", " EQ ", " OR ", " LT ")
SCRAP = "GMXYZACIJKRFNTPQLOSIN0123456789.+-*/[]=<>%();#@^\t é\0"


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
            f"G0 @{r:.3f} ^{10 * x:.3f}\nG1 ^{r:.2f}\n@{x:.2f}",
            f"M70\nG91 G7\nG1 X{x:.3f}\nM72\n{rng.choice(['M0', 'M1', 'X1'])}",
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
    return damaged(rng, text) if rng.random() < 0.33 else text


def damaged(rng: random.Random, text: str) -> str:
    """The text with up to three characters changed or lost."""
    for _ in range(rng.randrange(1, 4)):
        place = rng.randrange(len(text) + 1)
        text = text[:place] + rng.choice([rng.choice(SCRAP), ""]) + text[place + 1 :]
    return text


class FlowProgram:
    """A text with O words that ends: loops count, calls go to later subroutines or count down.

    None has both do and break: in rs274 a break that was passed over ends the next do.
    """

    def __init__(self, seed: str) -> None:
        self.rng = random.Random(seed)
        self.has_do = self.rng.random() < 0.5
        self.label = 100
        self.subs = [f"{n}" if self.rng.random() < 0.7 else f"<part {n}>" for n in range(1, 4)]
        subs = [self.subroutine(n) for n in range(3)]
        main = [
            "#31=1 #32=2 #33=3",
            "G21 G90 G0 X1 Y2 F100",
            *self.body(0, 2),
            *self.body(0, 2),
            "M2",
        ]
        behind = self.rng.randrange(4)  # how many subroutines come after the end
        parts = [*subs[: 3 - behind], main, *subs[3 - behind :]]
        self.text = "\n".join(line for part in parts for line in part) + "\n"

    def value(self) -> str:
        rng = self.rng
        parameter = f"#{rng.choice([1, 2, 3, 31, 32, 33])}"
        return rng.choice([parameter, str(rng.randrange(5)), f"[{parameter}+{rng.randrange(3)}]"])

    def condition(self) -> str:
        return f"[{self.value()} {self.rng.choice(['GT', 'LT', 'EQ', 'ne', 'GE'])} {self.value()}]"

    def subroutine(self, number: int) -> list[str]:
        name = self.subs[number]
        lines = [f"o{name} sub", *self.body(number + 1, 1)]
        if self.rng.random() < 0.5:
            again = [f"o9{number} if [#30 GT 0]", self.call(number, "[#30-1]"), f"o9{number} endif"]
            lines += again
        result = f" [{self.value()}]" if self.rng.random() < 0.3 else ""
        return [*lines, f"O{name.upper()} endsub{result}"]

    def call(self, number: int, last: str) -> str:
        values = [f"[{self.value()}]" for _ in range(29)] + [last]
        return f"o{self.subs[number]} call " + " ".join(values)

    def body(self, first_sub: int, depth: int) -> list[str]:
        lines: list[str] = []
        for _ in range(self.rng.randrange(1, 4)):
            lines += self.item(first_sub, depth)
        return lines

    def item(self, first_sub: int, depth: int) -> list[str]:
        rng = self.rng
        kinds = ["move", "move", "set", "if", "while", "do", "repeat", "call", "return"]
        kind = rng.choice(kinds if depth > 0 else kinds[:3])
        self.label += 1
        o, count = f"o{self.label}", f"#{self.label}"
        if kind == "call" and first_sub < 3:
            return [self.call(rng.randrange(first_sub, 3), f"[{rng.randrange(3)}]")]
        if kind == "return" and first_sub > 0:
            return [f"{o} if {self.condition()}", f"{o} return [{self.value()}]", f"{o} endif"]
        if kind in ("call", "return", "move"):
            return [rng.choice([f"G1 X{self.value()} Y{self.value()}", f"G0 X[{self.value()}/4]"])]
        if kind == "set":
            return [f"#{rng.choice([1, 2, 31, 32])}={self.value()}"]
        inner = self.body(first_sub, depth - 1)
        if kind == "if":
            lines = [f"{o} if {self.condition()}", *inner]
            for _ in range(rng.randrange(3)):
                lines += [f"{o} elseif {self.condition()}", *self.body(first_sub, depth - 1)]
            if rng.random() < 0.5:
                lines += [f"{o} else", *self.body(first_sub, depth - 1)]
            return [*lines, f"{o} endif"]
        if kind == "repeat":
            return [f"{o} repeat [{rng.randrange(3)}]", *inner, f"{o} endrepeat"]
        kind = "do" if kind == "do" and self.has_do else "while"
        if rng.random() < 0.4 and not self.has_do:
            self.label += 1
            at = rng.randrange(len(inner) + 1)
            inner[at:at] = [
                f"o{self.label} if {self.condition()}",
                f"{o} {rng.choice(['break', 'continue'])}",
                f"o{self.label} endif",
                "X3",
            ]
        ends = [f"{count}=[{count}+1]", *inner]
        if kind == "while":
            return [f"{count}=0", f"{o} while [{count} LT 2]", *ends, f"{o} endwhile"]
        return [f"{count}=0", f"{o} do", *ends, f"{o} while [{count} LT 2]"]


def flow_program(seed: str) -> str:
    """A text with O words, one in two damaged."""
    text = FlowProgram(seed).text
    rng = random.Random(f"damage {seed}")
    return damaged(rng, text) if rng.random() < 0.5 else text


def check(text: str) -> str:
    """Reads a program; returns "moves", "nothing" or "mistakes". Asserts what must hold."""
    lines = text.splitlines() or [""]
    # O words let lines run again, a damaged loop for ever.
    jumps = re.search(r"^\s*(N\s*[\d.]+\s*)?O", text, re.MULTILINE | re.IGNORECASE) is not None
    items: list[Move | Dwell] = []
    try:
        items += itertools.islice(stream(lines), MOST + 1)
    except GcodeErrors as caught:
        assert caught.errors
        for error in caught.errors:
            assert 1 <= error.line <= len(lines)
            source = lines[error.line - 1]
            assert source[error.column - 1 :].expandtabs(1).startswith(error.text)
            assert 1 <= error.column <= len(source) + 1
        return "mistakes"
    moves = [item for item in items if isinstance(item, Move)]
    assert all(1 <= move.line <= len(lines) for move in moves)
    for before, move in itertools.pairwise(moves):
        assert before.end == move.start and (jumps or before.line <= move.line)
    for move in moves:
        values = [*move.start, *move.end, move.tolerance if move.tolerance < math.inf else 0.0]
        values += move.centre if move.motion.is_arc else ()
        assert all(math.isfinite(value) for value in values)
        assert move.feed is None or move.feed > 0.0 or move.motion.value == "G0"
    # Of a text with more items, what comes after those may be refused.
    assert jumps or len(items) > MOST or parse(text).moves == tuple(moves)
    return "moves" if moves else "nothing"


def campaign(name: str, count: int, make: Callable[[str], str] = program) -> dict[str, int]:
    found = {"moves": 0, "nothing": 0, "mistakes": 0}
    for n in range(count):
        seed = f"{name} {SEED} {n}"
        text = make(seed)
        try:
            found[check(text)] += 1
        except Exception as error:
            call = f"{make.__name__}({seed!r})"
            raise AssertionError(f"replay: SEED={SEED}, {call}:\n{text!r}") from error
    print(f"{count} programs, SEED={SEED}: {found}")
    return found


def test_reader__random_programs__moves_or_located_mistakes():
    found = campaign("quick", 2500)
    # A campaign that only meets refusals, or none, would prove nothing.
    assert min(found["moves"], found["mistakes"]) > 250


def test_reader__random_o_words__moves_or_located_mistakes(monkeypatch):
    monkeypatch.setattr(execution, "MAX_AGAIN", 15_000)
    found = campaign("flow", 600, flow_program)
    assert min(found["moves"], found["mistakes"]) > 100


@needs("rs274")
def test_reader__random_o_words__move_as_in_rs274():
    moved = 0
    for n in range(40):
        seed = f"equal {SEED} {n}"
        text = FlowProgram(seed).text
        assert differences(text) == [], f"replay: SEED={SEED}, FlowProgram({seed!r}).text:\n{text}"
        moved += len(parse(text).moves)
    assert moved > 300


@pytest.mark.full
@pytest.mark.parametrize("part", range(20))
def test_reader__many_random_o_words__moves_or_located_mistakes(part, monkeypatch):
    monkeypatch.setattr(execution, "MAX_AGAIN", 15_000)
    campaign(f"deep flow {part}", 5000, flow_program)


@pytest.mark.full
@pytest.mark.parametrize("part", range(100))
def test_reader__a_million_random_programs__moves_or_located_mistakes(part):
    campaign(f"deep {part}", 10_000)
