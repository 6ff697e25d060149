# SPDX-License-Identifier: Apache-2.0
"""Sequencer, double buffer and statistics, watched through programs whose words are known.

Word i of the trajectory core's run n is 32 n + i (count_runs.s); the tracking core puts out what it
was given (echo.s). So every command shows from which run its words are.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Self

import numpy as np
import pytest

from asip_asm.assemble import assemble
from sim.rtl.asip_bus import BLOCK, CSR
from sim.rtl.dual_rtl import LISTS, MEASURED_SOURCE, REGMAP, DualRtl
from tests.bench.seed import SEED

FOLDER = Path(__file__).parent
PERIOD = 500
LONGEST_WORK = 1000  # clocks, above all work of a period with short runs
LONG = 45  # rounds of a run that is longer than a period, and shorter than two
WORDS = 15
NAN = 0x7FC00000
SAFE = [1000.0, 1001.0, 1002.0, 1003.0, 1004.0]


@functools.cache
def known_program(name: str):
    return assemble(FOLDER / f"{name}.s", configuration="fast")


def numbered(sources: Sequence[int]) -> list[tuple[int, int]]:
    return [(source, place) for place, source in enumerate(sources)]


class Bench:
    """The system with the two programs; words `shown` of the set-point come out as commands."""

    def __init__(self, shown: Sequence[int] = (0, 1, 2, 3, 4), zero_on_hold: int = 0) -> None:
        self.system = DualRtl()
        self.system.trajectory.load(known_program("count_runs"))
        self.system.tracking.load(known_program("echo"))
        self.show(shown)
        self.system.write("ZERO_ON_HOLD", zero_on_hold)
        self.system.write("PERIOD", PERIOD)
        self.set_input("spin", 1)

    def show(self, shown: Sequence[int]) -> None:
        """Choose the sources of echo.s's five words; its spin is measured word 0."""
        first, second = self.system.trajectory, self.system.tracking
        inputs = second.input_addresses(["e0", "e1", "e2", "e3", "e4", "spin"])
        self.system.set_lists(
            {
                "set_points": numbered(first.output_addresses([f"w{i}" for i in range(WORDS)])),
                "inputs": list(zip([*shown, MEASURED_SOURCE], inputs, strict=True)),
                "commands": numbered(second.output_addresses([f"r{i}" for i in range(5)])),
            }
        )

    def set_input(self, name: str, word: int) -> None:
        core = self.system.trajectory
        core.write(core.input_addresses([name])[0], word)

    def start(self) -> Self:
        self.system.set("CONTROL", run=1)
        return self

    def run(self, periods: int, spin: int = 1) -> np.ndarray:
        return self.system.run([[spin, 0, 0, 0, 0]] * periods)

    def counts(self) -> dict[str, int]:
        return {name: self.system.read(name) for name in ("PERIODS", "UNDERRUNS", "OVERRUNS")}


def commands(records: np.ndarray) -> np.ndarray:
    return records["commands"].view(np.float32)


def runs(records: np.ndarray) -> list[int]:
    """From which run of the trajectory core the first command of each period is."""
    return (commands(records)[:, 0] // 32).astype(int).tolist()


# ---------------------------------------------------------------------- latency and words


def test_hand_over__set_point_of_a_period_is_tracked_in_the_next():
    bench = Bench().start()
    records = bench.run(6)
    assert records["updates"].tolist() == [0, 1, 1, 1, 1, 1]  # nothing to track in the first
    assert records["words"].view(np.float32)[:, 0].tolist() == [32.0 * n for n in range(6)]
    assert runs(records[1:]) == [0, 1, 2, 3, 4]
    assert not any(bench.system.read(name) for name in ("UNDERRUNS", "OVERRUNS"))


@pytest.mark.parametrize("first", [0, 5, 10])
def test_hand_over__every_word_reaches_the_input_of_its_list_entry(first):
    shown = [first + i for i in (3, 0, 4, 1, 2)]
    bench = Bench(shown).start()
    records = bench.run(3)
    assert commands(records)[2].tolist() == [32.0 + i for i in shown]


def test_hand_over__measured_words_are_those_of_the_first_clock_and_change_nothing_else():
    bench = Bench([MEASURED_SOURCE + i for i in (1, 2, 3, 4)] + [14]).start()
    rng = np.random.default_rng(SEED)
    measured = rng.integers(-(2**22), 2**22, (8, 5))  # no NaN as binary32
    measured = np.abs(measured)
    measured[:, 0] = 1
    records = bench.system.run(measured)
    seen = records["commands"][1:]
    assert seen[:, :4].tolist() == measured[1:, 1:].tolist(), f"SEED={SEED}"
    assert seen[:, 4].view(np.float32).tolist() == [32.0 * n + 14 for n in range(7)]


@pytest.mark.full
def test_hand_over__no_set_point_and_no_counts_are_torn_wherever_a_period_begins():
    """A period begins at every clock of the work of the one before; words of two never mix."""
    bench = Bench([0, 14, *(MEASURED_SOURCE + i for i in (1, 2, 4))])
    kept = 0
    for period in range(20, 320):
        bench.system.write("CONTROL", 0)
        bench.system.clock(2 * LONGEST_WORK)
        bench.system.set("CONTROL", clear=1)
        bench.system.write("PERIOD", period)
        bench.start()
        measured = [[1, *([1000 * period + n] * 4)] for n in range(8)]
        records = bench.system.run(measured)
        assert not records["torn"].any(), period
        made = records["words"].view(np.float32)[:, 14]
        assert set(np.diff(made[made > 0])) <= {0.0, 32.0}, period
        for record in records[records["updates"] > 0]:
            words, counts = record["commands"][:2].view(np.float32), record["commands"][2:]
            assert words[1] == words[0] + 14, period
            assert len(set(counts.tolist())) == 1 and counts[0] // 1000 == period, period
            kept += 1
    assert kept > 300


def test_period__written_in_the_middle_of_one_takes_effect_with_the_next():
    bench = Bench().start()
    bench.run(2)
    begins = []
    for period in (400, 700, 300, 300):  # from 500, 400, 700, 300 on
        records = bench.run(1)
        begins.append(bench.system.clocks - int(records["used"][0]))
        bench.system.write("PERIOD", period)
    assert np.diff(begins).tolist() == [PERIOD, 400, 700]


def test_hand_over__source_beyond_the_words_reads_zero():
    bench = Bench([15, 31, MEASURED_SOURCE + 5, MEASURED_SOURCE + 31, 1]).start()
    assert commands(bench.run(3))[2].tolist() == [0.0, 0.0, 0.0, 0.0, 33.0]


def test_hand_over__empty_lists_hand_over_nothing():
    bench = Bench()
    bench.system.set_lists({name: [] for name in LISTS})
    bench.start()
    records = bench.run(3)
    assert records["stored"].tolist() == [0, 0, 0]
    assert not records["commands"].any()


def test_lists__too_long_is_refused():
    with pytest.raises(ValueError, match="list inputs has 33 entries, room is 32"):
        DualRtl().set_lists({"set_points": [], "inputs": [(0, 0)] * 33, "commands": []})


# ---------------------------------------------------------------------- late and missing


def test_underrun__last_set_point_is_held_with_zero_rates_then_the_next_one_follows():
    bench = Bench(zero_on_hold=0b00110)  # words 1 and 2 are rates
    bench.start()
    bench.run(3)
    bench.set_input("spin", LONG)
    records = bench.run(5)
    # a run takes the rest of its period and a part of the next one, which holds the set-point
    assert runs(records) == [2, 2, 3, 3, 4]
    assert records["late"].tolist() == [1, 0, 1, 0, 1]
    assert commands(records)[0].tolist() == [64.0, 65.0, 66.0, 67.0, 68.0]
    assert commands(records)[1].tolist() == [64.0, 0.0, 0.0, 67.0, 68.0]
    assert commands(records)[2].tolist() == [96.0, 97.0, 98.0, 99.0, 100.0]
    flags = bench.system.flags()
    assert flags["underrun"] and flags["trajectory_overrun"]
    assert not flags["tracking_overrun"] and not flags["stop"]
    bench.system.clock(10)
    assert bench.system.read("UNDERRUNS") == 3  # the period now under way holds, too
    assert bench.system.read("LEFT_MIN") == 0
    assert bench.system.read("USED_MAX") == PERIOD
    bench.set_input("spin", 1)
    bench.run(1)
    after = runs(bench.run(3))
    assert np.diff(after).tolist() == [1, 1]
    assert not bench.system.flags()["hold"]


def test_late_copying__the_next_period_begins_behind_it_with_the_new_set_point():
    bench = Bench().start()
    end = int(bench.run(3)["set_point_clock"][2])
    bench.system.write("PERIOD", end - 5)
    late = bench.run(1)
    bench.system.queue([(REGMAP.address("PERIOD"), PERIOD)])  # the next one has begun
    records = np.concatenate([late, bench.run(4)])
    assert late["late"].tolist() == [1] and late["updates"].tolist() == [1]
    assert runs(records) == [2, 3, 4, 5, 6]
    assert bench.counts()["UNDERRUNS"] == 0 < bench.counts()["OVERRUNS"]
    flags = bench.system.flags()
    assert flags["trajectory_overrun"] and not flags["tracking_overrun"] and not flags["hold"]


def test_tracking_overrun__commands_stay_and_the_late_run_counts():
    bench = Bench().start()
    bench.run(3)
    late = bench.run(1, spin=LONG)
    after = bench.run(3)
    assert late["late"].tolist() == [1]
    assert late["updates"].tolist() == [0]
    assert runs(late) == [1]
    assert after["late"].tolist() == [0, 0, 0]
    assert runs(after) == [2, 4, 5]
    flags = bench.system.flags()
    assert flags["tracking_overrun"] and not flags["trajectory_overrun"] and not flags["stop"]
    assert bench.counts()["OVERRUNS"] == 1


def test_late__interrupt_only_where_enabled():
    bench = Bench()
    bench.set_input("spin", LONG)
    bench.start()
    bench.run(3)
    assert not bench.system.irq
    bench.system.set("IRQ_ENABLE", late=1)
    assert bench.system.irq
    bench.system.set("IRQ_ENABLE", stop=1)
    assert not bench.system.irq


# ---------------------------------------------------------------------- faults


def test_trajectory_fault__holds_stops_and_tracks_on_until_cleared():
    bench = Bench(zero_on_hold=0b11000)
    bench.system.set("IRQ_ENABLE", stop=1)
    bench.start()
    bench.run(4)
    bench.set_input("poison", NAN)
    assert not bench.system.irq and not bench.system.stop
    faulted = bench.run(1)
    assert runs(faulted) == [3]
    assert faulted["stored"].tolist() == [0]
    bench.set_input("poison", 0)
    assert bench.system.irq and bench.system.stop
    held = bench.run(5)
    assert commands(held).tolist() == [[96.0, 97.0, 98.0, 0.0, 0.0]] * 5
    assert held["updates"].tolist() == [1] * 5
    assert held["stored"].tolist() == [0] * 5
    flags = bench.system.flags()
    assert flags["stop"] and flags["trajectory_fault"] and flags["hold"] and flags["underrun"]
    assert not flags["tracking_fault"] and not flags["trajectory_overrun"]
    assert bench.counts()["UNDERRUNS"] == 5
    bench.system.set("CONTROL", run=1, clear=1)
    again = bench.run(3)
    assert not bench.system.stop
    assert again["updates"].tolist() == [0, 1, 1]
    # the program counts the run that faulted
    assert again["stored"].tolist() == [WORDS] * 3


def test_tracking_fault__safe_commands_and_no_core_starts_until_cleared():
    bench = Bench([MEASURED_SOURCE + 1, 1, 2, 3, 4]).start()
    bench.run(3)
    faulted = bench.system.run([[1, NAN, 0, 0, 0]])
    assert commands(faulted)[0].tolist() == SAFE
    after = bench.run(3)
    assert commands(after).tolist() == [SAFE] * 3
    assert after["updates"].tolist() == [0] * 3
    assert after["stored"].tolist() == [0] * 3
    flags = bench.system.flags()
    assert flags["stop"] and flags["tracking_fault"] and not flags["trajectory_fault"]
    bench.system.set("CONTROL", run=1, clear=1)
    again = bench.run(3)
    assert again["updates"].tolist() == [0, 1, 1]
    assert commands(again)[2].tolist()[1:] != SAFE[1:]


def test_stopped_host__no_period_begins_after_run_is_cleared():
    bench = Bench().start()
    bench.run(2)
    bench.system.write("CONTROL", 0)
    periods = bench.system.read("PERIODS")
    bench.system.clock(3 * PERIOD)
    assert bench.system.read("PERIODS") == periods
    assert not bench.system.flags()["active"]


# ---------------------------------------------------------------------- statistics


def test_statistics__registers_are_what_the_harness_and_the_cores_count():
    bench = Bench().start()
    cycles, used, command = [], [], []
    for spin in (1, 5, 2, 8, 3):
        records = bench.run(1, spin)
        used.append(int(records["used"][0]))
        if records["updates"][0]:
            command.append(int(records["command_clock"][0]))
            cycles.append(bench.system.tracking.read(CSR["CYCLES"]))
        assert bench.system.read("USED_LAST") == used[-1]
    read = bench.system.read
    assert read("TRACKING_MIN") == min(cycles) < read("TRACKING_MAX") == max(cycles)
    assert read("TRACKING_LAST") == cycles[-1]
    assert read("TRAJECTORY_LAST") == bench.system.trajectory.read(CSR["CYCLES"])
    assert read("TRAJECTORY_MIN") == read("TRAJECTORY_MAX") == read("TRAJECTORY_LAST")
    assert read("COMMAND_MAX") == max(command) > read("COMMAND_LAST") == command[-1]
    assert read("USED_MAX") == max(used)
    assert read("LEFT_MIN") == PERIOD - max(used)
    assert 0 < read("COPY_LAST") <= read("COPY_MAX") < max(used)


def test_statistics__periods_are_exactly_as_long_as_set():
    bench = Bench().start()
    begins = []
    for _ in range(3):
        records = bench.run(1)
        begins.append(bench.system.clocks - int(records["used"][0]))
    assert np.diff(begins).tolist() == [PERIOD, PERIOD]


def test_stop__in_the_middle_of_a_period__its_clocks_are_counted_to_the_end():
    bench = Bench().start()
    names = ("COMMAND_LAST", "USED_LAST", "LEFT_MIN")
    used = int(bench.run(3)["used"][2])
    before = [bench.system.read(name) for name in names]
    for clocks in (1, 50, 120):
        bench.system.clock(PERIOD - used - 1 + clocks)
        bench.system.write("CONTROL", 0)
        bench.system.clock(3 * PERIOD)
        assert [bench.system.read(name) for name in names] == before, clocks
        bench.start()
        used = int(bench.run(2)["used"][1])
    bench.set_input("spin", LONG)  # begins in the period that is stopped, and ends after it
    bench.system.clock(PERIOD)
    bench.system.write("CONTROL", 0)
    bench.system.clock(3 * PERIOD)
    assert bench.system.read("USED_LAST") == PERIOD and bench.system.read("LEFT_MIN") == 0
    assert bench.counts()["OVERRUNS"] == 0


def test_clear__in_the_first_clocks_of_a_period__that_one_counts():
    bench = Bench()
    # The first period begins while the cores are cleared.
    bench.system.set("CONTROL", run=1, clear=1)
    assert bench.run(4)["updates"].tolist() == [0, 1, 1, 1]
    assert bench.counts() == {"PERIODS": 4, "UNDERRUNS": 0, "OVERRUNS": 0}


def test_clear__starts_the_statistics_anew():
    bench = Bench().start()
    bench.run(3, spin=2)
    bench.system.set("CONTROL", clear=1)
    bench.system.clock(4 * PERIOD)
    assert bench.counts() == {"PERIODS": 0, "UNDERRUNS": 0, "OVERRUNS": 0}
    assert bench.system.read("TRACKING_MIN") == 0xFFFFFFFF
    assert bench.system.read("USED_MAX") == 0
    flags = bench.system.flags()
    assert not any(flags.values())


# ---------------------------------------------------------------------- host


def test_host__accesses_at_any_time_change_no_word_and_are_answered_right():
    """The host and the sequencer share the cores' buses; neither may take the other's word."""
    bench = Bench().start()
    rng = np.random.default_rng(SEED)
    expected = 0
    for _ in range(60):
        records = bench.run(1)
        made = int(records["words"].view(np.float32)[0, 0]) // 32
        assert made == bench.system.read("PERIODS") - 1, f"SEED={SEED}"
        if expected:
            assert records["words"].view(np.float32)[0].tolist() == [
                32.0 * made + i for i in range(WORDS)
            ], f"SEED={SEED}"
            assert commands(records)[0].tolist() == [32.0 * (made - 1) + i for i in range(5)], (
                f"SEED={SEED}"
            )
        expected += 1
        bench.system.clock(int(rng.integers(0, PERIOD)))
        for core in (bench.system.trajectory, bench.system.tracking):
            for _ in range(int(rng.integers(0, 8))):
                word = int(rng.integers(0, 2**32))
                place = BLOCK["data"] + int(rng.integers(0, 1024))
                core.write(place, word)
                assert core.read(place) == word, f"SEED={SEED}"
                assert core.read(CSR["ID"]) == 0x4D544B31
    assert bench.counts()["UNDERRUNS"] == 0
    assert not bench.system.flags()["stop"]


def test_host__read_of_a_register_at_every_clock_of_a_period_leaves_the_sequencer_its_words():
    bench = Bench()
    system = bench.system
    for core in (system.trajectory, system.tracking):
        core.write(CSR["WATCHDOG"], 0xFFFF)  # as status it would be a fault
    bench.start()
    used = int(bench.run(2)["used"][1])
    for core in (system.trajectory, system.tracking):
        for clock in range(used):
            made = int(bench.run(1)["words"].view(np.float32)[0, 0]) // 32
            system.clock(PERIOD - used - 1 + clock)
            assert core.read(CSR["WATCHDOG"]) == 0xFFFF, clock
            assert runs(bench.run(1)) == [made + 1], clock
    assert not system.stop
    for name in ("TRAJECTORY", "TRACKING"):
        assert system.read(f"{name}_MIN") == system.read(f"{name}_MAX")


def test_host__registers_read_back_and_unknown_words_read_zero():
    system = DualRtl()
    assert system.read("ID") == REGMAP.registers["ID"].reset
    assert system.read("PERIOD") == 12500
    config = REGMAP.registers["CONFIG"].word(words=15, measured=5, commands=5)
    assert system.read("CONFIG") == config
    lengths = REGMAP.registers["LENGTHS"].word(set_points=7, inputs=6, commands=5)
    for name, word in (("PERIOD", 777), ("ZERO_ON_HOLD", 0xDEADBEEF), ("LENGTHS", lengths)):
        system.write(name, word)
        assert system.read(name) == word
    assert system.read_word(0x8000 + 31) == 0
    assert system.read_word(0xC000) == 0
