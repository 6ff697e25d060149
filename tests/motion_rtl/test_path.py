# SPDX-License-Identifier: Apache-2.0
"""Lines and arcs through the front-end's registers: steps on the drive lines, queue, speed, faults.

The nodes that the axes pass are rebuilt from the step and direction lines and compared with exact
integers: golden step strings, distance from the ideal, ends.
"""

from __future__ import annotations

import numpy as np
import pytest

from sim.motion.planner.pulse_records import time_exact
from sim.motion.planner.ramp_time import ramp_time_plan
from sim.rtl.gen.motion_regmap import REGMAP
from sim.rtl.motion_rtl import CLOCK_HZ, MotionError, MotionRtl
from sim.rtl.phase_record import FIRST, LAST, Record
from tests.bench.seed import SEED
from tests.motion_rtl.test_front_end import timed
from tests.motion_rtl.test_interpolators import CIRCLE_5, LINES, check_on_circle, random_arc, text

PERIOD = 40  # clocks from step to step
LIMIT = 6_000_000
ALL = 0b11111


def front_end(source: int = ALL, period: int = PERIOD, interpolators: bool = True) -> MotionRtl:
    """A front-end with the fastest drive timing, the interrupt at rest or fault enabled."""
    rtl = timed(1, 1, 1, 1, interpolators)
    rtl.set("IRQ_ENABLE", idle=1, fault=1)
    rtl.write("SOURCE", source)
    rtl.set("PATH_FEED", period=period)
    return rtl


def positions(rtl: MotionRtl) -> list[int]:
    return [rtl.position(axis) for axis in range(rtl.AXES)]


def steps(rtl: MotionRtl) -> tuple[np.ndarray, np.ndarray]:
    """Clocks of the steps since the last call and (n, 5) arrays of -1, 0, 1."""
    return rtl.edges().steps(rtl.AXES, PERIOD // 2)


# ---------------------------------------------------------------------- what is drawn


@pytest.mark.parametrize(("end", "combined", "wanted"), LINES)
def test_line__golden_string_on_the_step_lines(end, combined, wanted):
    rtl = front_end()
    rtl.line(*end, combined=combined)
    rtl.wait_for_irq(LIMIT)
    clocks, moved = steps(rtl)
    assert text(moved[:, :3]) == wanted
    assert positions(rtl) == [*end, 0, 0, 0]
    assert np.all(np.abs(np.diff(clocks) - PERIOD) <= 2)


def test_circle__golden_string_on_the_step_lines():
    rtl = front_end()
    rtl.arc((5, 0), (5, 0), 25)
    rtl.wait_for_irq(LIMIT)
    assert text(steps(rtl)[1][:, :3]) == CIRCLE_5
    assert positions(rtl) == [0] * 5


@pytest.mark.parametrize("combined", [False, True])
@pytest.mark.parametrize("plane", ["xy", "zx", "yz"])
def test_arc__random_nodes_in_every_plane__on_the_circle_and_at_its_end(plane, combined):
    random = np.random.default_rng([SEED, ord(plane[0]), combined])
    axes = ["xyz".index(letter) for letter in plane]
    rtl = front_end(sum(1 << axis for axis in axes))
    at = [0] * 5
    for _ in range(6):
        begin, end, squared, clockwise, turns = random_arc(random, 90)
        rtl.arc(begin, end, squared, clockwise, combined, turns, plane)
        rtl.wait_for_irq(LIMIT)
        what = f"replay: SEED={SEED}: {begin} {end} {squared} {clockwise} {turns}"
        assert rtl.path_faults() == set(), what
        _, moved = steps(rtl)
        nodes = np.cumsum(moved[:, axes], axis=0) + np.array(begin)
        assert tuple(nodes[-1]) == end, what
        # Ends are rounded nodes: combined ones' neighbours may be as far as elementary ones.
        check_on_circle(nodes[:-1], squared, False)
        for axis, first, last in zip(axes, begin, end, strict=True):
            at[axis] += last - first
        assert positions(rtl) == at, what


def test_line_in_all_axes__each_within_half_a_step_at_every_step():
    random = np.random.default_rng(SEED)
    rtl = front_end()
    at = np.zeros(5, dtype=np.int64)
    for _ in range(5):
        lengths = random.integers(-150, 151, 5)
        lengths[int(random.integers(5))] = 0
        rtl.line_in_all_axes([int(x) for x in lengths])
        rtl.wait_for_irq(LIMIT)
        _, moved = steps(rtl)
        longest = int(np.abs(lengths).max())
        assert len(moved) == longest, f"replay: SEED={SEED}, {lengths}"
        nodes = np.cumsum(moved, axis=0)
        number = np.arange(1, longest + 1)[:, None]
        assert np.all(2 * np.abs(nodes * longest - number * lengths) <= longest), lengths
        at += lengths
        assert positions(rtl) == at.tolist()


def test_corners__greatest_coordinates__taken():
    rtl = front_end(period=4)
    rtl.line(2**23 - 1, 0, start=False)
    rtl.line(-100, 2**23 - 1, combined=True)
    rtl.clock(4_000)
    assert rtl.path("busy") and rtl.path_faults() == set()
    assert 900 < rtl.position(1) <= 1000
    rtl.set("CONTROL", path=1)
    assert rtl.read("PATH_STATUS") == 0


# ---------------------------------------------------------------------- queue and speed


def test_commands_queued__follow_without_a_gap():
    rtl = front_end()
    rtl.line(30, 11)
    jobs = [
        lambda: rtl.arc((20, 0), (0, 20), 400),
        lambda: rtl.line_in_all_axes([-9, 3, 25, 0, -25]),
        lambda: rtl.arc((0, 15), (0, 15), 225, clockwise=True, combined=True),
        lambda: rtl.line(-4, 8, plane="yz"),
    ]
    for job in jobs:
        for _ in range(LIMIT):
            if not rtl.path("pending"):
                break
        job()
    rtl.wait_for_irq(LIMIT)
    assert rtl.path_faults() == set()
    clocks, _ = steps(rtl)
    # A drive's change of direction takes 2 clocks, a step of an arc one more than one of a line.
    assert np.all(np.abs(np.diff(clocks) - PERIOD) <= 4), np.diff(clocks)
    assert positions(rtl) == [30 - 20 - 9, 11 + 20 + 3 - 4, 25 + 8, 0, -25]


def run_commands(count: int, seed: int) -> None:
    """So many random commands, queued: lines and arcs in every plane, lines in all five axes.

    Raises AssertionError for a fault and for a wrong end.
    """
    random = np.random.default_rng([seed, count])
    rtl = front_end()
    wanted = np.zeros(5, dtype=np.int64)
    for _ in range(count):
        while rtl.path("pending"):
            pass
        plane, combined = str(random.choice(["xy", "zx", "yz"])), bool(random.integers(2))
        moved = ["xyz".index(letter) for letter in plane]
        kind = random.integers(3)
        if kind == 0:
            wanted[moved] += (end := random.integers(-99, 100, 2))
            rtl.line(*end.tolist(), plane, combined)
        elif kind == 1:
            begin, end, squared, clockwise, turns = random_arc(random, 90)
            wanted[moved] += np.subtract(end, begin)
            rtl.arc(begin, end, squared, clockwise, combined, turns, plane)
        else:
            wanted += (lengths := random.integers(-99, 100, 5))
            rtl.line_in_all_axes(lengths.tolist())
    rtl.wait_for_irq(LIMIT)
    assert rtl.path_faults() == set(), f"replay: SEED={seed}"
    assert positions(rtl) == wanted.tolist(), f"replay: SEED={seed}"


def test_random_commands_queued__no_fault__exact_ends():
    run_commands(60, SEED)


LEAST = 4  # clocks, of PATH_FEED


def letters(rtl: MotionRtl) -> tuple[np.ndarray, str]:
    """Clocks of the pulses of x, y, z since the last call, and their letters, small ones back."""
    found = rtl.edges().moves(3)
    text_ = "".join("XYZ"[axis] if sign > 0 else "xyz"[axis] for _, axis, sign in found)
    return np.array([clock for clock, _, _ in found]), text_


def test_least_period__commands_of_one_step__each_in_its_clock():
    rtl = front_end(period=LEAST)
    rtl.line(1, 0, start=False)
    planes = np.random.default_rng(SEED).integers(0, 3, 200).tolist()
    for number, plane in enumerate(planes):
        rtl.set("PATH_COMMAND", kind=0, plane=plane)
        # The first one takes two clocks more to begin; from then on one takes a period.
        rtl.clock(LEAST - 1 if number else LEAST + 1)
    rtl.wait_for_irq(LIMIT)
    assert rtl.path_faults() == set(), f"replay: SEED={SEED}"
    clocks, text_ = letters(rtl)
    assert text_ == "".join("XZY"[plane] for plane in planes), f"replay: SEED={SEED}"
    assert np.all(np.diff(clocks) == LEAST), f"replay: SEED={SEED}, {np.diff(clocks)}"


def test_least_period__commands_of_two_steps__none_lost_or_exchanged():
    ends = {(2, 0): "XX", (0, 2): "YY", (1, 1): "YX", (-1, 1): "Yx", (0, -2): "yy", (-2, 0): "xx"}
    rtl = front_end(period=LEAST)
    random = np.random.default_rng(SEED)
    wanted = ""
    for end in [list(ends)[i] for i in random.integers(0, len(ends), 100)]:
        rtl.line(*end)
        rtl.clock(2 * LEAST - 3)  # three words written
        wanted += ends[end]
    rtl.wait_for_irq(LIMIT)
    assert rtl.path_faults() == set(), f"replay: SEED={SEED}"
    clocks, text_ = letters(rtl)
    assert text_ == wanted, f"replay: SEED={SEED}"
    # A drive's change of direction takes a clock.
    assert np.all(np.abs(np.diff(clocks) - LEAST) <= 1), f"replay: SEED={SEED}"


@pytest.mark.parametrize("short", ["all", "arc"])
def test_least_period__command_that_takes_longer_to_begin__its_steps_are_made_up_for(short):
    rtl = front_end(period=LEAST)
    shorts = {
        "all": lambda: rtl.line_in_all_axes([0, 0, 1, 0, 0]),
        "arc": lambda: rtl.arc((1, 0), (0, 1), 1),
    }
    rtl.line(120, 0)
    for job in (shorts[short], lambda: rtl.line(0, 20)):
        while rtl.path("pending"):
            pass
        job()
    rtl.wait_for_irq(LIMIT)
    clocks, text_ = letters(rtl)
    assert text_ == "X" * 120 + {"all": "Z", "arc": "Yx"}[short] + "Y" * 20
    assert clocks[-1] - clocks[0] == LEAST * (len(clocks) - 1)


def test_period__every_step_in_its_clock__and_changed_under_way():
    for period in (4, 7, 1000):
        rtl = front_end(period=period)
        rtl.line(20, 0)
        rtl.wait_for_irq(LIMIT)
        assert np.all(np.diff(rtl.edges().pulses(0)) == period)
    rtl = front_end(period=1000)
    rtl.line(100, 0)
    rtl.clock(10_500)
    rtl.set("PATH_FEED", period=50)
    rtl.clock(500)
    rtl.set("PATH_FEED", period=200)
    rtl.wait_for_irq(LIMIT)
    gaps = np.diff(rtl.edges().pulses(0)).tolist()
    slow, fast = gaps.index(50), gaps.index(200)
    assert gaps[: slow - 1] == [1000] * (slow - 1) and slow > 5
    assert 50 < gaps[slow - 1] < 1000, "the shorter period counts from the write"
    assert gaps[slow:fast] == [50] * (fast - slow) and fast - slow > 5
    assert gaps[fast:] == [200] * (99 - fast)


def test_feed_back_from_a_profile_to_a_period__goes_on_at_once():
    rtl = front_end(source=0b00011)
    rtl.set("PATH_FEED", axis=4)
    rtl.line(30, 0)
    rtl.clock(1000)
    rtl.set("PATH_FEED", period=PERIOD)
    rtl.clock(35 * PERIOD)
    assert rtl.position(0) == 30


@pytest.mark.full
def test_feed_from_a_profile__steps_in_the_pulses_clocks():
    """An S-curve along a line: the steps of the line are the profile's, a few clocks later."""
    plan = ramp_time_plan("20", "200", "0.02", "0.005", "3")
    records = time_exact(plan.phases, 100)
    plain = timed(1, 1, 1, 1)
    plain.run({4: records}, LIMIT)
    wanted = plain.edges().pulses(4)
    rtl = front_end(source=0b10111)
    rtl.set("PATH_FEED", axis=4)
    rtl.line_in_all_axes([300, -150, 0, 0, 7])
    rtl.clock(100)
    assert rtl.path("busy") and positions(rtl) == [0] * 5, "it waits for the profile"
    rtl.put({4: records})
    rtl.wait_for_irq(LIMIT)
    assert positions(rtl) == [300, -150, 0, 0, 7]
    got = rtl.edges().pulses(0)
    assert len(got) == len(wanted) == 300
    assert np.all(np.diff(got) == np.diff(wanted))
    assert (got[-1] - got[0]) / CLOCK_HZ == pytest.approx(float(plan.total_time), rel=0.1)


def test_axes_of_both_kinds__profile_and_arc_at_once__both_exact():
    rtl = front_end(source=0b00011)
    record = Record(FIRST | LAST, 400, 16 * 500_000 << 32, 0, 0)
    rtl.arc((30, 0), (0, -30), 900, clockwise=True)
    rtl.run({3: [record], 0: [record]}, LIMIT)
    assert positions(rtl) == [-30, -30, 0, 200, 0], "axis 0 has its steps from the arc alone"
    assert rtl.status("overrun") == rtl.status("underrun") == 0
    rtl.write("SOURCE", 0)
    rtl.run({0: [record]}, LIMIT)
    assert positions(rtl) == [170, -30, 0, 200, 0]


# ---------------------------------------------------------------------- faults


FAULTS = {
    "kind": (lambda rtl: (rtl.line(3, 3, start=False), rtl.set("PATH_COMMAND", kind=3)), "kind"),
    "plane": (lambda rtl: (rtl.line(3, 3, start=False), rtl.set("PATH_COMMAND", plane=3)), "kind"),
    "unwritten": (lambda rtl: rtl.write("PATH_COMMAND", 0), "range"),
    "range above": (lambda rtl: rtl.line(1 << 23, 1), "range"),
    "range least": (lambda rtl: rtl.line(1, -(1 << 23)), "range"),
    "radius 0": (lambda rtl: rtl.arc((0, 0), (0, 0), 0), "circle"),
    "end at the centre": (lambda rtl: rtl.arc((2, 0), (0, 0), 4), "circle"),
    "start off": (lambda rtl: rtl.arc((7, 0), (0, 5), 25), "circle"),
    "end off": (lambda rtl: rtl.arc((5, 0), (0, 7), 25), "circle"),
    "axis": (lambda rtl: rtl.line(3, 3, plane="yz"), "axis"),
    "axis of all": (lambda rtl: rtl.line_in_all_axes([1, 1, 0, 0, 1]), "axis"),
    "feed": (lambda rtl: rtl.set("PATH_FEED", period=3), "feed"),
    "feed axis": (lambda rtl: rtl.set("PATH_FEED", axis=5), "feed"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_bad_parameters__a_fault_bit_and_no_motion__until_it_is_cleared(name):
    bad, fault = FAULTS[name]
    rtl = front_end(source=0b00011)
    bad(rtl)
    rtl.clock(20_000)
    assert rtl.path_faults() == {fault}
    assert rtl.path("busy") == rtl.path("pending") == 0
    rtl.line(3, 4)
    rtl.clock(5_000)
    assert positions(rtl) == [0] * 5 and len(rtl.edges().clock) == 0, "nothing before the clear"
    assert rtl.path_faults() == {fault}
    rtl.set("IRQ_ENABLE", fault=1)
    assert rtl.wait_for_irq(10) == 0, "a fault interrupts"
    rtl.set("IRQ_ENABLE", idle=1, fault=1)
    rtl.set("CONTROL", path=1)
    assert rtl.path_faults() == set()
    rtl.line(3, 4)
    rtl.wait_for_irq(LIMIT)
    assert positions(rtl) == [3, 4, 0, 0, 0]
    assert REGMAP.registers["PATH_FEED"].word(period=PERIOD) == rtl.read("PATH_FEED")


def test_nodes_near_a_circle__taken_if_the_ideal_arc_passes_between_their_neighbours():
    random = np.random.default_rng(SEED)
    rtl = front_end(period=1000)
    seen = set()
    for case in range(300):
        radius = int(random.integers(1, 30)) if case % 2 else float(random.uniform(1, 4000))
        squared = round(radius**2)
        nodes, good = [], []
        for _ in range(2):
            angle = random.uniform(0, 2 * np.pi)
            off = random.integers(-1, 2, 2) if random.random() < 0.5 else (0, 0)
            u = round(radius * np.cos(angle)) + int(off[0])
            v = round(radius * np.sin(angle)) + int(off[1])
            nodes.append((u, v))
            norm, size = u * u + v * v - squared, abs(u) + abs(v)
            good.append(-size <= norm < size)
        rtl.arc(*nodes, squared)
        rtl.clock(100)
        what = f"replay: SEED={SEED}, {nodes} {squared}"
        assert rtl.path_faults() == (set() if all(good) else {"circle"}), what
        assert rtl.path("busy") == all(good), what
        rtl.set("CONTROL", path=1, abort=ALL)
        seen.add(tuple(good))
    assert len(seen) == 4, seen


def test_write_while_a_command_waits__refused__the_running_one_ends():
    for word in ("PATH_WORD", "PATH_COMMAND"):
        rtl = front_end()
        rtl.line(20, 10)
        rtl.clock(10)
        rtl.line(5, 5)
        rtl.clock(10)
        assert rtl.path("pending") == 1
        rtl.write(word, 1)
        rtl.clock(2)
        assert rtl.path_faults() == {"order"}
        assert rtl.path("pending") == 0 and rtl.path("busy") == 1
        rtl.clock(PERIOD * 40)
        assert positions(rtl) == [20, 10, 0, 0, 0]


def test_source_changed_in_motion__refused():
    rtl = front_end(source=0b00011)
    rtl.line(20, 0)
    rtl.clock(100)
    rtl.write("SOURCE", 0)
    assert (rtl.path_faults(), rtl.read("SOURCE")) == ({"order"}, 0b00011)
    rtl.clock(PERIOD * 30)
    assert rtl.position(0) == 20
    rtl.set("CONTROL", path=1)
    rtl.put({2: [Record(FIRST | LAST, 100, 16 * 100_000 << 32, 0, 0)]})
    rtl.clock(300)
    rtl.write("SOURCE", 0b00100)
    assert (rtl.path_faults(), rtl.read("SOURCE")) == ({"order"}, 0b00011)
    rtl.set("CONTROL", path=1)
    rtl.write("SOURCE", 0b00001)  # axis 2 keeps its bit: it may move
    assert (rtl.path_faults(), rtl.read("SOURCE")) == (set(), 0b00001)


JOBS = {
    "line": lambda rtl: rtl.line(400, 300),
    "arc": lambda rtl: rtl.arc((100, 0), (0, 100), 10000),
    "all": lambda rtl: rtl.line_in_all_axes([400, 300, 200, -100, 50]),
}


@pytest.mark.parametrize("job", JOBS)
def test_abort__no_further_step__the_next_command_is_exact(job):
    rtl = front_end()
    JOBS[job](rtl)
    rtl.clock(30 * PERIOD)
    JOBS[job](rtl)  # waits
    rtl.set("CONTROL", abort=0b00010)
    rtl.clock(2)
    stopped = positions(rtl)
    assert stopped != [0] * 5 and rtl.read("PATH_STATUS") == 0
    rtl.clock(30 * PERIOD)
    assert positions(rtl) == stopped
    rtl.line(7, -3)
    rtl.wait_for_irq(LIMIT)
    rtl.arc((5, 0), (0, 5), 25)
    rtl.wait_for_irq(LIMIT)
    assert [a - b for a, b in zip(positions(rtl), stopped, strict=True)] == [2, 2, 0, 0, 0]


def test_steps_faster_than_the_drive_allows__path_stops():
    rtl = front_end()
    rtl.set("STEP_TIMING", length=100, space=100)
    rtl.set("IRQ_ENABLE", fault=1)
    rtl.line(1000, 0)
    rtl.wait_for_irq(LIMIT)
    rtl.clock(2)
    assert rtl.path_faults() == {"overrun"} and rtl.status("overrun") == 1
    assert rtl.path("busy") == 0
    rtl.set("CONTROL", path=1)
    rtl.clock(1)
    assert rtl.path_faults() == {"overrun"}, "the axis still has its own"
    rtl.set("CONTROL", path=1, abort=ALL)
    assert rtl.read("PATH_STATUS") == rtl.status("overrun") == 0


def test_profile_faster_than_steps_can_be__path_stops_and_says_so():
    """An arc steps every other clock and begins some clocks late: at 50 MHz pulses pile up."""
    rtl = front_end(source=0b01111)
    rtl.set("PATH_FEED", axis=4)
    nodes = [(50, 0), (0, 50), (-50, 0), (0, -50)]
    rtl.arc(nodes[0], nodes[1], 2500)
    rtl.clock(100)
    rtl.put({4: [Record(FIRST | LAST, 60, 16 * 50_000_000 << 32, 0, 0)]})
    quarters = 1
    while quarters < 20 and not rtl.path_faults():
        if not rtl.path("pending"):
            rtl.arc(nodes[quarters % 4], nodes[(quarters + 1) % 4], 2500)
            quarters += 1
    assert rtl.path_faults() == {"overrun"} and rtl.status("overrun") == 0
    assert rtl.path("busy") == 0
    rtl.wait_for_irq(LIMIT)
    rtl.set("CONTROL", path=1)
    assert rtl.read("PATH_STATUS") == 0
    rtl.wait_for_irq(LIMIT)
    rtl.set("PATH_FEED", period=PERIOD)
    before = positions(rtl)
    rtl.line(7, 0)
    rtl.wait_for_irq(LIMIT)
    assert positions(rtl) == [before[0] + 7, *before[1:]] and rtl.path_faults() == set()


def test_without_interpolators__registers_read_0_and_profiles_run():
    rtl = front_end(interpolators=False)
    assert rtl.read("CONFIG") == REGMAP.registers["CONFIG"].word(axes=5, records=8, clocks=100)
    rtl.line(5, 5)
    rtl.clock(1000)
    for name in ("SOURCE", "PATH_FEED", "PATH_STATUS"):
        assert rtl.read(name) == 0
    assert len(rtl.edges().clock) == 0
    rtl.run({0: [Record(FIRST | LAST, 100, 16 * 500_000 << 32, 0, 0)]}, LIMIT)
    assert positions(rtl) == [50, 0, 0, 0, 0]


def test_no_command__no_interrupt_missing():
    rtl = front_end()
    assert rtl.wait_for_irq(10) == 0
    rtl.line(1, 0)
    with pytest.raises(MotionError, match="no interrupt"):
        rtl.wait_for_irq(PERIOD // 2)
