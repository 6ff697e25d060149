# SPDX-License-Identifier: Apache-2.0
"""The plausibility record: what may be committed, by limits and slew; against exact arithmetic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import pytest

from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image
from sim.rtl.asip_bus import BLOCK, CSR, FAULT_NAMES, START, STATUS
from tests.asip import core_bench as bench
from tests.asip import resilient_bench
from tests.asip.core_bench import HALT, op

INF = math.inf
ON = REGMAP.blocks["plausible_on"].word(judged=1)
RECORDS = REGMAP.blocks["plausible_on"].words
EACH, ONCE = 26, 13  # clocks that a run ends later per output with a record, and if there is one


def bits(value: float) -> int:
    return int(np.float32(value).view(np.uint32))


def number(word: int) -> float:
    return float(np.uint32(word).view(np.float32))


def moves(outputs: Sequence[int]) -> Image:
    """Program that writes each of these outputs from k of its number; the last one last."""
    bundles = [op("mov", f"o{i}", f"k{i}") for i in outputs[:-1]]
    last = outputs[-1]
    bundles.append((op("mov", f"o{last}", f"k{last}"), HALT))
    constants = {f"k{i}": 0 for i in outputs}
    return bench.image("fast", bundles, constants, outputs=max(outputs) + 1)


class Tb:
    """A core just reset with a program of moves, and what the host does."""

    def __init__(self, outputs: Sequence[int] = (0,)) -> None:
        self.core, self.outputs = resilient_bench.core(), outputs
        self.core.reset()
        self.core.load(moves(outputs))

    def record(self, output: int, least: float, most: float, slew: float, on: int = ON) -> None:
        words = {"least": bits(least), "most": bits(most), "slew": bits(slew), "on": on}
        for name, word in words.items():
            self.core.write(BLOCK[f"plausible_{name}"] + output, word)

    def tick(self, *values: float | int) -> str:
        """One tick with these outputs, floats or words; returns the fault."""
        words = [bits(v) if isinstance(v, float) else v for v in values]
        places = [BLOCK["constants"] + i for i in self.outputs]
        read = [BLOCK["outputs"] + i for i in self.outputs]
        done = self.core.run(places, np.array([words], dtype=np.uint32), read)
        self.shown, self.cycles = done.words[0].tolist(), int(done.cycles[0])
        self.info = self.core.read(CSR["FAULT_INFO"])
        if done.fault == "NONE":
            assert self.shown == words
        else:
            assert self.shown == [bench.safe_word(i) for i in self.outputs]
            self.core.clear()
        return done.fault


def implausible(word: int, before: int | None, least: float, most: float, slew: float) -> bool:
    """The contract of asip_plausible in exact arithmetic: all words are finite numbers."""
    if not least <= number(word) <= most:
        return True
    if before is None or math.isinf(slew):
        return False
    largest = max(word & 0x7FFFFFFF, before & 0x7FFFFFFF)
    unit = Fraction(2) ** (max(largest >> 23, 1) - 150)  # its last place
    whole = [math.trunc(Fraction(number(each)) / unit) for each in (word, before)]
    return abs(whole[0] - whole[1]) > math.floor(Fraction(slew) / unit)


@pytest.mark.full
def test_record__from_reset__judges_nothing():
    tb = Tb()
    assert [tb.tick(v) for v in (1.0, -3e38, 3e38, 0.0)] == 4 * ["NONE"]


def test_limits__at_them_and_a_step_beyond__the_fault_and_the_safe_value():
    tb = Tb()
    for least, most in ((-2.5, 7.0), (3.0, 4.0), (-9.0, -8.0), (0.0, 0.0), (-INF, 1.0), (1.0, INF)):
        tb.record(0, least, most, INF)
        for limit, beyond in ((least, -INF), (most, INF)):
            if math.isinf(limit):
                assert tb.tick(math.copysign(3e38, limit)) == "NONE"
                continue
            assert tb.tick(float(np.float32(limit))) == "NONE"
            assert tb.tick(float(np.nextafter(np.float32(limit), np.float32(beyond)))) == (
                "IMPLAUSIBLE"
            )
            assert tb.info == 0


def test_limit_zero__minus_zero__is_zero():
    tb = Tb()
    for least, most in ((0.0, 1.0), (-1.0, -0.0), (-0.0, 0.0), (0.0, -0.0)):
        tb.record(0, least, most, 0.0)
        assert [tb.tick(0.0), tb.tick(-0.0), tb.tick(0.0)] == 3 * ["NONE"]


def test_slew__move_from_the_last_commit__counts_behind_the_first_run():
    tb = Tb()
    tb.record(0, -100.0, 100.0, 2.0)
    steps = [(50.0, "NONE"), (52.0, "NONE"), (50.0, "NONE"), (47.5, "IMPLAUSIBLE")]
    steps += [(-80.0, "NONE"), (-78.5, "NONE"), (-76.0, "IMPLAUSIBLE")]
    steps += [(1.0, "NONE"), (-1.0, "NONE"), (1.5, "IMPLAUSIBLE")]
    assert [(value, tb.tick(value)) for value, _ in steps] == steps
    tb.tick(5.0)
    tb = Tb()  # a reset
    tb.record(0, -100.0, 100.0, 2.0)
    assert tb.tick(90.0) == "NONE", "a move from before the reset"
    assert tb.tick(93.0) == "IMPLAUSIBLE"


def test_slew__staged_anew__counts_from_the_word_before():
    tb = Tb()
    assert tb.tick(10.0) == "NONE"  # not checked, but known
    tb.record(0, -INF, INF, 1.0)
    assert tb.tick(11.0) == "NONE"
    tb.record(0, -INF, INF, 0.25)
    assert tb.tick(12.0) == "IMPLAUSIBLE"
    assert tb.tick(12.0) == "NONE"
    tb.record(0, -INF, INF, 0.25, on=0)
    assert tb.tick(-30.0) == "NONE"


def test_record__staged_in_a_run__waits_for_its_end():
    tb = Tb()
    tb.core.write(BLOCK["constants"], bits(5.0))
    tb.core.write(CSR["CONTROL"], START)
    tb.record(0, 0.0, 1.0, INF)
    assert FAULT_NAMES[STATUS["cause"].of(tb.core.read(CSR["STATUS"]))] == "NONE"
    assert tb.core.read(BLOCK["outputs"]) == bits(5.0)
    assert tb.tick(5.0) == "IMPLAUSIBLE"


@pytest.mark.parametrize("word", [0x7FC00000, 0x7F800000, 0xFF800000])
def test_no_number__is_the_fault_not_finite__and_never_committed(word):
    tb = Tb()
    tb.record(0, -INF, INF, INF)
    assert tb.tick(3.0) == "NONE"
    assert tb.tick(word) == "NOT_FINITE"
    assert tb.tick(4.0) == "NONE"


def test_outputs__each_by_its_own_record__the_first_bad_one_is_named():
    outputs = [0, 3, 7, 8, 31]
    tb = Tb(outputs)
    for output in range(RECORDS):
        tb.record(output, -1.0, float(output), 0.5)
    good = [0.0, 3.0, 7.0, 1e9, -1e9]
    assert tb.tick(*good) == "NONE"
    assert tb.tick(*good[:3], -1e9, 1e9) == "NONE", "outputs without a record"
    for place, output in enumerate(outputs[:3]):
        tb.tick(*good)
        assert tb.tick(*good[:place], *[8.0] * (5 - place)) == "IMPLAUSIBLE"
        assert tb.info == output


def test_outputs__written_by_some_runs_only__move_from_the_tick_before_if_it_wrote_them():
    tb = Tb()
    first = [op("mov", "o0", "k0"), op("mov", "o1", "k1")]
    bundles = [(each, HALT) for each in first]
    tb.core.load(bench.image("fast", bundles, {"k0": 0, "k1": 0}, outputs=2, output_mask=0))
    for output in (0, 1):
        tb.record(output, -INF, INF, 1.0)
    found = []
    steps = ((0, 10.0), (1, 50.0), (0, 11.0), (0, 12.0), (1, 90.0), (0, 30.0), (0, 31.0), (0, 33.0))
    for entry, value in steps:
        tb.core.write(CSR["ENTRY"], entry)
        place = [BLOCK["constants"] + entry]
        found.append(tb.core.run(place, np.array([[bits(value)]], np.uint32), []).fault)
    assert found == [*7 * ["NONE"], "IMPLAUSIBLE"]


def test_cycles__without_a_record__are_those_of_the_core_that_has_none():
    tb = Tb(range(8))
    tb.tick(*8 * [1.0])
    plain = tb.cycles
    tb.record(0, -INF, INF, INF, on=0)
    tb.tick(*8 * [1.0])
    assert tb.cycles == plain
    for output in range(8):
        tb.record(output, -INF, INF, INF)
        tb.tick(*8 * [1.0])
        assert tb.cycles == plain + 2 * (EACH * (output + 1) + ONCE)


def test_watchdog__run_that_ends_just_in_time__is_judged_to_its_end():
    tb = Tb(range(8))
    shortest = 0
    for shortest in range(1, 200):
        tb.core.write(CSR["WATCHDOG"], shortest)
        if tb.tick(*8 * [1.0]) == "NONE":
            break
    for output in range(8):
        tb.record(output, -INF, INF, INF)
    assert tb.tick(*8 * [1.0]) == "NONE", f"WATCHDOG {shortest}: the verdicts come too late"
    tb.record(7, -INF, 0.5, INF)
    assert tb.tick(*8 * [1.0]) == "IMPLAUSIBLE"
    tb.core.write(CSR["WATCHDOG"], shortest - 1)
    assert tb.tick(*8 * [1.0]) == "WATCHDOG"


def test_moves__random_words_and_slews__verdicts_of_exact_arithmetic():
    rng = np.random.default_rng(91)
    tb = Tb()
    before, verdicts = None, [0, 0]
    for n in range(1500):
        scale = 0x7F if n % 3 else int(rng.integers(0, 255))
        near = before is not None and rng.random() < 0.7
        if near:
            word = (before + int(rng.integers(-4, 5)) * 2 ** int(rng.integers(0, 24))) & 0xFFFFFFFF
        else:
            word = int(rng.integers(0, 2**32)) & 0x807FFFFF | scale << 23
        if word >> 23 & 0xFF == 0xFF:
            continue
        move = abs(Fraction(number(word)) - Fraction(number(before if before is not None else 0)))
        slew = float(np.float32(min(float(move), 3e38)))
        slew = float(np.nextafter(np.float32(slew), np.float32(rng.choice([0.0, slew, 3e38]))))
        slew *= float(rng.choice([1.0, 1.0, 1.0, 0.5, 2.0]))
        slew = min(slew, 3e38)
        slew = float(np.float32(slew))
        tb.record(0, -INF, INF, slew)
        want = implausible(word, before, -INF, INF, slew)
        assert (tb.tick(word) == "IMPLAUSIBLE") == want, (
            f"{n} (seed 91): {word:08x} after {before if before is None else hex(before)}, {slew!r}"
        )
        verdicts[want] += 1
        before = None if want else word
    assert min(verdicts) > 200, verdicts
