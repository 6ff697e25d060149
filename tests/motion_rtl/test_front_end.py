# SPDX-License-Identifier: Apache-2.0
"""Motion front-end: moves against the plan, velocity modes, five axes, faults, drive timing."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from sim.motion.planner.phases import Phase, State
from sim.motion.planner.pulse_records import PulseRecordError, pulse_counted, time_exact
from sim.motion.planner.ramp_time import RampTimePlan, ramp_time_plan
from sim.rtl.gen.motion_regmap import REGMAP
from sim.rtl.motion_rtl import CLOCK_HZ, Edges, MotionError, MotionRtl, extended
from sim.rtl.phase_record import FIRST, LAST, UNITS_PER_PULSE, Record
from tests.bench.seed import SEED

US = CLOCK_HZ // 1_000_000
LIMIT = 40_000_000  # clocks, above every move here
FULL = pytest.mark.full


def timed(length: int, space: int, setup: int, hold: int, interpolators: bool = True) -> MotionRtl:
    """A front-end with these times of the drives, clocks."""
    rtl = MotionRtl(interpolators)
    rtl.set("STEP_TIMING", length=length, space=space)
    rtl.set("DIRECTION_TIMING", setup=setup, hold=hold)
    return rtl


@pytest.fixture
def motion() -> MotionRtl:
    """A front-end with the fastest drive timing."""
    return timed(1, 1, 1, 1)


def quick(v0: str, length: str, tm: str = "0.005") -> RampTimePlan:
    """A move of some 30 ms: 200 units/s, 20 ms of acceleration."""
    return ramp_time_plan(v0, "200", "0.02", tm, length)


def cruise(rate: int, ticks: int, flags: int = FIRST | LAST) -> Record:
    """Ticks of a constant rate [1/16 Hz]."""
    return Record(flags, ticks, rate << 32, 0, 0)


# ---------------------------------------------------------------------- records alone


@pytest.mark.parametrize("tm", ["0", "0.005", "0.01"])
@pytest.mark.parametrize("length", ["8", "3", "0.5"])
@pytest.mark.parametrize("pulses", [10, 1000, 20_000])
def test_time_exact_records__sum_is_the_displacement_within_a_thousandth(tm, length, pulses):
    plan = quick("20", length, tm)
    records = time_exact(plan.phases, pulses)
    total = sum(record.published(i) for record in records for i in range(record.count))
    assert abs(Fraction(total, UNITS_PER_PULSE) - plan.length * pulses) < Fraction(1, 1000)
    assert sum(record.count for record in records) == round(plan.total_time * 1_000_000)


def test_time_exact_records__cruise_of_many_seconds__no_drift():
    state = State(Fraction(0), Fraction(1, 3), Fraction(0))
    phase = Phase(Fraction(1000), Fraction(0), state)
    records = time_exact([phase], 1_000)
    total = sum(record.published(0) * record.count for record in records)
    assert abs(Fraction(total, UNITS_PER_PULSE) - Fraction(1_000_000, 3)) < Fraction(1, 1_000_000)


def test_records__what_the_hardware_cannot_do__is_refused_by_name():
    fast = ramp_time_plan("0", "2000", "0.2", "0.05", "800")
    with pytest.raises(PulseRecordError, match=r"phase \d: rates .* not within 0..50000000 Hz"):
        time_exact(fast.phases, 30_000)
    with pytest.raises(PulseRecordError, match="start speed 0 never makes the first pulse"):
        pulse_counted(quick("0", "8").phases, 10)
    with pytest.raises(PulseRecordError, match="move of no ticks"):
        time_exact([], 10)
    sudden = Phase(
        Fraction(1, 1000), Fraction(10**15), State(Fraction(0), Fraction(0), Fraction(0))
    )
    with pytest.raises(PulseRecordError, match="phase 1: "):
        time_exact([sudden], 10)


# ---------------------------------------------------------------------- time-exact mode


@pytest.mark.quick("0.01-3-2000-20")
@pytest.mark.parametrize("v0", ["0", "20"])
@pytest.mark.parametrize(
    ("tm", "length", "pulses"),
    [
        *(("0.005", "8", 50), ("0.01", "3", 2000), ("0", "2.5", 50)),
        *(pytest.param(*way, marks=FULL) for way in (("0.005", "8", 2000), ("0.01", "3", 50))),
        pytest.param("0", "2.5", 2000, marks=FULL),
    ],
)
def test_time_exact__count_and_duration_exact__pulses_near_the_plan(motion, v0, tm, length, pulses):
    plan = quick(v0, length, tm)
    records = time_exact(plan.phases, pulses)
    motion.run({0: records}, LIMIT)
    assert motion.position(0) == plan.length * pulses
    at = motion.edges().pulses(0)
    assert len(at) == plan.length * pulses
    # The first tick begins on a multiple of a microsecond; pulse n represents n - 1/2.
    begin = _begin(at[0], plan, pulses)
    times = (at - begin) / CLOCK_HZ
    # sample(): correctly rounded positions of the exact plan.
    chosen = np.linspace(0, len(at) - 1, 40).astype(int)
    ideal = plan.sample(times[chosen]).position * pulses
    # Quantum of 1 us at 400 kHz at most: 0.4 pulse and half a clock.
    bound = 0.04 if pulses == 50 else 0.45
    assert np.abs(ideal - (chosen + 0.5)).max() <= bound
    assert motion.status("underrun") == motion.status("overrun") == 0


def _begin(first: int, plan: RampTimePlan, pulses: int) -> int:
    """Clock in which the move began: the tick for which the first pulse is nearest its place."""
    low, high = 0.0, float(plan.total_time)
    for _ in range(60):  # instant of half a pulse in the plan
        middle = (low + high) / 2
        low, high = (middle, high) if plan.at(middle).position * pulses < 0.5 else (low, middle)
    return round((first - low * CLOCK_HZ) / US) * US


def test_time_exact__zero_start_speed__moves_and_ends(motion):
    plan = quick("0", "3")
    motion.run({2: time_exact(plan.phases, 100, negative=True)}, LIMIT)
    assert motion.position(2) == -300


@pytest.mark.full
def test_moves_one_after_another__each_exact_from_the_first_pulse(motion):
    plan = quick("20", "0.7")
    for number in range(1, 4):
        motion.run({0: time_exact(plan.phases, 30)}, LIMIT)
        assert motion.position(0) == 21 * number
    motion.run({0: time_exact(plan.phases, 30, negative=True)}, LIMIT)
    assert motion.position(0) == 42


@pytest.mark.parametrize("rounds", [1, pytest.param(8, marks=pytest.mark.full)])
def test_random_moves__on_five_axes_at_once__all_exact(motion, rounds):
    random = np.random.default_rng(SEED)
    wanted = [0] * 5
    for _ in range(rounds):
        moves = {}
        for axis in range(5):
            count = int(random.integers(1, 900))
            plan = quick(str(random.integers(0, 100)), f"{count}/1000", "0.004")
            negative = bool(random.integers(0, 2))
            moves[axis] = time_exact(plan.phases, 1000, negative)
            wanted[axis] += -count if negative else count
        motion.run(moves, LIMIT)
        assert [motion.position(axis) for axis in range(5)] == wanted, f"replay: SEED={SEED}"


def test_axes_released_together__pulse_in_the_same_clock(motion):
    record = cruise(16 * 50_000, 400)
    motion.clock(37)  # not on a tick
    motion.run({axis: [record] for axis in range(5)}, LIMIT)
    seen = motion.edges()
    assert len(seen.pulses(0)) == 20
    assert all((seen.pulses(axis) == seen.pulses(0)).all() for axis in range(5))


def test_phases_of_one_tick__follow_each_other_without_a_gap(motion):
    """The hardest case for the profile memory: every axis wants a record every microsecond."""
    records = [
        cruise(16 * 4_000_000 * (1 + i % 2), 1, FIRST * (i == 0) | LAST * (i == 7))
        for i in range(8)
    ]
    motion.run({axis: records for axis in range(5)}, LIMIT)
    # 4 and 8 pulses a microsecond in turn
    assert [motion.position(axis) for axis in range(5)] == [48] * 5
    assert motion.status("underrun") == 0


# Half a pulse: after the half at a move's start it makes one pulse in the tick's last clock.
HALF = cruise(8_000_000, 1)


@pytest.mark.parametrize("flags", [FIRST | LAST, LAST, FIRST | LAST | 1, LAST | 1])
def test_pulse_in_the_last_clock_of_a_tick__sent_and_in_its_own_direction(motion, flags):
    before = replace(HALF, flags=FIRST | LAST * (flags & FIRST != 0))
    motion.run({0: [before, cruise(16_000_000, 3, flags)]}, LIMIT)
    assert motion.position(0) == 1 + 3 * (-1 if flags & 1 else 1)
    seen = motion.edges()
    at = seen.pulses(0)
    # From the centre the next pulse comes half a period later.
    assert abs(int(at[1] - at[0]) - (50 if flags & FIRST else 100)) <= flags % 2, at
    assert (seen.direction[np.searchsorted(seen.clock, at)] & 1).tolist() == [0] + 3 * [flags & 1]


def test_pulse_in_the_last_clock_of_a_tick__does_not_count_in_a_phase_of_pulses_behind_it(motion):
    pulses = Record(FIRST | LAST | 2, 3, 16_000_000 << 32, 0, 0)
    motion.run({0: [HALF, pulses]}, LIMIT)
    assert motion.position(0) == 1 + 3


def test_pulse_in_the_last_clock_of_a_move__no_interrupt_before_it(motion):
    motion.run({0: [HALF]}, LIMIT)
    assert motion.position(0) == 1


# ---------------------------------------------------------------------- pulse-counted mode


def pulse_counted_rule(plan: RampTimePlan, pulses: int) -> float:
    """Duration [s] of a move by the paper's rule, simulated in floating point microseconds."""
    phases = plan.phases
    reach = [-((-phase.end.position * pulses) // 1) if phase.duration else None for phase in phases]
    active = [i for i, value in enumerate(reach) if phases[i].displacement]
    index, sent, time, accumulated, entered = 0, 0, 0.0, 0.5, 0.0
    speed = float(plan.v0)
    while True:
        accumulated += speed * pulses * 1e-6
        time += 1e-6
        entered += 1e-6
        if accumulated < 1.0:
            continue
        accumulated -= 1.0
        sent += 1
        while sent >= reach[active[index]]:
            index += 1
            entered = 0.0
            if index == len(active):
                return time
        phase = phases[active[index]]
        start = phase.start
        speed = max(
            float(start.speed)
            + float(start.acceleration) * entered
            + float(phase.jerk) * entered**2 / 2,
            0.0,
        )


@pytest.mark.quick("0.01-3-1000")
@pytest.mark.parametrize(
    ("tm", "length", "pulses"),
    [
        *(("0.005", "8", 100), ("0.01", "3", 1000), ("0.005", "3", 100)),
        *(pytest.param(*way, marks=FULL) for way in (("0.005", "8", 1000), ("0.01", "3", 100))),
        pytest.param("0.005", "3", 1000, marks=FULL),
    ],
)
def test_pulse_counted__count_exact__duration_as_the_rule_gives(motion, tm, length, pulses):
    plan = quick("30", length, tm)
    motion.set("IRQ_ENABLE", idle=1, fault=1)
    begin = motion.now
    motion.run({0: pulse_counted(plan.phases, pulses)}, LIMIT)
    assert motion.position(0) == plan.length * pulses
    at = motion.edges().pulses(0)
    took = (at[-1] - begin) / CLOCK_HZ
    # Up to 2 us a phase change and for the start, of some tens of milliseconds.
    assert took == pytest.approx(pulse_counted_rule(plan, pulses), abs=20e-6)
    assert motion.status("underrun") == 0


@pytest.mark.full
def test_pulse_counted__few_pulses__ends_early__as_published(motion):
    """At low pulse density the scheme is coarse: it is a tick-exact end that it misses."""
    plan = quick("30", "8")
    motion.run({0: pulse_counted(plan.phases, 20)}, LIMIT)
    took = motion.edges().pulses(0)[-1] / CLOCK_HZ
    assert motion.position(0) == 160
    assert took < float(plan.total_time) - 100e-6


def test_pulse_counted__zero_start_speed_forced__never_starts(motion):
    """The trap that the software refuses: rates change after a pulse, so 0 stays 0."""
    (record,) = [Record(FIRST | LAST | 2, 10, 0, 1 << 32, 0)]
    with pytest.raises(MotionError, match="no interrupt"):
        motion.run({0: [record]}, 200_000)
    assert motion.position(0) == 0


# ---------------------------------------------------------------------- faults


def test_records_run_out_inside_a_move__rate_0_underrun_until_abort(motion):
    motion.set("IRQ_ENABLE", fault=1)
    motion.put({1: [cruise(16 * 100_000, 100, FIRST)]})
    motion.wait_for_irq(LIMIT)
    assert motion.status("underrun") == 0b10
    assert motion.position(1) == 10
    motion.put({1: [cruise(16 * 100_000, 100)]})
    motion.clock(50_000)
    assert motion.position(1) == 10, "nothing runs before the fault is cleared"
    motion.set("CONTROL", abort=0b10)
    assert motion.status("underrun") == 0
    motion.run({1: [cruise(16 * 100_000, 100)]}, LIMIT)
    assert motion.position(1) == 20


def test_abort__no_further_pulse_on_that_axis_only(motion):
    motion.put({0: [cruise(16 * 1_000_000, 100)] * 2, 3: [cruise(16 * 1_000_000, 100)]})
    motion.clock(50 * US)
    motion.set("CONTROL", abort=1)
    stopped = motion.position(0)
    assert 30 < stopped < 50
    motion.clock(300 * US)
    assert motion.position(0) == stopped
    assert motion.position(3) == 100
    assert motion.status("running") == 0
    assert motion.read("HEAD") == motion.read("TAIL")


def test_abort__in_every_clock_between_two_pulses__none_comes_after_it(motion):
    wanted = 0
    for clock in range(101):
        motion.put({0: [cruise(16 * 1_000_000, 1000)]})
        motion.clock(400 + clock)
        motion.set("CONTROL", abort=1)
        aborted = motion.now
        motion.clock(250)
        at = motion.edges().pulses(0)
        assert len(at) and at[-1] <= aborted, clock
        wanted += len(at)
        motion.run({0: [cruise(16 * 1_000_000, 2, FIRST | LAST | 1)]}, LIMIT)
        wanted -= 2
        assert motion.position(0) == wanted, clock
        motion.edges()


def test_steps_faster_than_the_drive_allows__overrun(motion):
    motion.set("STEP_TIMING", length=100, space=100)  # 0.5 MHz
    motion.set("IRQ_ENABLE", fault=1)
    motion.put({0: [cruise(16 * 1_000_000, 2000)]})
    motion.wait_for_irq(LIMIT)
    assert motion.status("overrun") == 1


def test_full_ring__refused_before_anything_is_written(motion):
    with pytest.raises(MotionError, match="9 records, room for 8"):
        motion.put({0: [cruise(16, 1)] * 9})


def test_identity_and_reserved_words__read_as_documented(motion):
    assert motion.read("ID").to_bytes(4, "big") == b"MOT1"
    assert motion.read("CONFIG") == REGMAP.registers["CONFIG"].word(
        axes=5, records=8, clocks=100, interpolators=1
    )
    assert motion.read("POSITION", 5) == 0


# ---------------------------------------------------------------------- drive timing


def edges(*changes: tuple[int, int, int]) -> Edges:
    """Lines of axis 0 as (clock, step, direction)."""
    return Edges(*(np.array(column, dtype=np.int64) for column in zip(*changes, strict=True)))


@pytest.mark.parametrize(
    ("turn", "setup", "hold"), [(20, 10, 6), (30, 0, -4), (11, 19, -3), (14, 16, 0)]
)
def test_drive_times__of_known_edges(turn, setup, hold):
    levels = {10: 1, 14: 0, 30: 1, 34: 0}
    step, direction, rows = 0, 0, []
    for clock in sorted({*levels, turn}):
        step = levels.get(clock, step)
        direction |= clock >= turn
        rows.append((clock, step, direction))
    times = edges(*rows).drive_times(0)
    assert times.lengths.tolist() == [4] and times.space.tolist() == [16]
    assert times.setup.tolist() == [setup]
    assert times.hold.tolist() == [hold]  # a turn with a rising edge is inside that pulse
    assert times.kept(4, 16, 10, 6) is (turn == 20)
    assert not times.kept(3, 16, 1, 1) and not times.kept(4, 17, 1, 1)


def test_drive_times__pulse_without_end__is_an_error():
    with pytest.raises(MotionError, match="axis 0: 1 pulses begin, 0 end"):
        edges((10, 1, 0)).drive_times(0)


def test_steps__two_pulses_of_one_axis_at_once__is_an_error():
    known = edges((10, 1, 2), (12, 3, 2), (14, 0, 2), (50, 1, 2), (54, 0, 2))
    clocks, moved = known.steps(2, 20)
    assert clocks.tolist() == [10, 50] and moved.tolist() == [[1, -1], [1, 0]]
    with pytest.raises(MotionError, match="axis 0 has two pulses within 50 clocks of 50"):
        known.steps(2, 50)


@pytest.mark.parametrize("case", range(6))
def test_drive_timing__random_times_and_reversals__kept_on_every_edge(case):
    random = np.random.default_rng([SEED, case])
    length, space, setup, hold = (int(x) for x in random.integers(1, 60, 4))
    motion = timed(length, space, setup, hold)
    rate = int(16e8 / (length + space) * 0.9)
    wanted = 0
    for _ in range(6):
        ticks, negative = int(random.integers(5, 60)), int(random.integers(0, 2))
        pulses = (8 * UNITS_PER_PULSE // 16 + rate * ticks) // UNITS_PER_PULSE
        wanted += -pulses if negative else pulses
        motion.run({0: [cruise(rate, ticks, FIRST | LAST | negative)]}, LIMIT)
    what = f"replay: SEED={SEED}, length {length} space {space} setup {setup} hold {hold}"
    assert motion.position(0) == wanted, what
    times = motion.edges().drive_times(0)
    assert times.kept(length, space, setup, hold), f"{what}: {times}"


@pytest.mark.parametrize("case", range(4))
def test_drive_timing__reversals_without_rest__kept_on_every_edge(case):
    """Moves there and back in one ring: the next one's pulses come while the last ones wait."""
    random = np.random.default_rng([SEED, 100 + case])
    length, space, setup, hold = (int(x) for x in random.integers(1, 60, 4))
    times = (length, space, setup + 60 * (case % 2), hold + 60 * (1 - case % 2))
    motion = timed(*times)
    rate = int(16e8 / (length + space) * 0.9)
    records = [
        cruise(rate, int(random.integers(8, 20)), FIRST | LAST | number % 2) for number in range(8)
    ]
    motion.run({0: records}, LIMIT)
    what = f"replay: SEED={SEED}, length, space, setup, hold {times}"
    wanted = 0
    for record in records:
        pulses = (UNITS_PER_PULSE // 2 + rate * record.count) // UNITS_PER_PULSE
        wanted += -pulses if record.flags & 1 else pulses
    assert motion.position(0) == wanted, what
    seen = motion.edges()
    assert np.count_nonzero(np.diff(seen.direction.astype(int), prepend=0)) == 7, what
    found = seen.drive_times(0)
    assert found.kept(*times), f"{what}: {found}"


def test_position__read_within_2_31_steps__is_extended_beyond_the_register():
    # That the register counts every step modulo 2^32 is proved: tests/formal_motion/drive.py.
    ends = [2**31 - 1, 1, 2**32, 2**33, 2**32 + 1, 0, -(2**31), -(2**31) - 1, -(2**33), 0]
    position = 0
    for end in ends:
        while position != end:
            there = position + max(-(2**31), min(2**31 - 1, end - position))
            position = extended(position, there % 2**32)
            assert position == there
