# SPDX-License-Identifier: Apache-2.0
"""Homing of CiA 402 by switches and index. Where a method leads to is written here from the text
of the standard: an edge of a switch and the side of it, seen along the axis, not the way there.
"""

from __future__ import annotations

import numpy as np
import pytest

from sim.bus.machine import Machine
from sim.bus.switches import COUNTS, HOME, NEGATIVE, POSITIVE, Switches
from sim.robot.parameters import Robot
from tests.ethercat.drives import CSP, CSV, ENABLE, HOMING, TICK, Drives
from tests.ethercat.host import DEVICE, AbortedError
from tests.ethercat.host_link import HostWords

FAST, SLOW, ACCELERATION, OFFSET = 4_000_000, 200_000, 400_000_000, 1234
LOW, HIGH, LEFT, RIGHT, PITCH = -200_000, 200_000, 40_000, 90_000, 7_000
FAR = 10**9
START = ENABLE | 0x10
REACHED, ATTAINED, FAILED = 0x0400, 0x1000, 0x2000
STEP = SLOW * TICK
# Method: the edge, and on which side of it the next index is (CiA 402-2, figures of the methods).
EDGES = {
    1: (LOW, 1), 2: (HIGH, -1), 3: (LEFT, -1), 4: (LEFT, 1), 5: (RIGHT, 1), 6: (RIGHT, -1),
    7: (LEFT, -1), 8: (LEFT, 1), 9: (RIGHT, -1), 10: (RIGHT, 1),
    11: (RIGHT, 1), 12: (RIGHT, -1), 13: (LEFT, 1), 14: (LEFT, -1),
}  # fmt: skip
ONE_SIDED = {3: (LEFT, FAR), 4: (LEFT, FAR), 5: (-FAR, RIGHT), 6: (-FAR, RIGHT)}
WITHOUT_INDEX = 16


class Homed(Drives):
    """The first axis has switches and an index, and is always where its set-point is."""

    def __init__(self, switches: Switches, position: int) -> None:
        self.switches = switches
        super().__init__(HOMING)
        for index, subindex, value in (
            (0x6099, 1, FAST), (0x6099, 2, SLOW), (0x609A, 0, ACCELERATION),
            (0x607C, 0, OFFSET), (0x6065, 0, 0xFFFFFFFF),
        ):  # fmt: skip
            self.put(index, subindex, value)
        self.feedback.axis[0].position = position
        self.cycle()
        self.enable()

    def cycle(self, count: int = 1) -> None:
        for _ in range(count):
            axis = self.feedback.axis[0]
            self.switches.move(axis.position)
            axis.switches = self.switches.word(axis.position)
            axis.index_count, axis.index_position = self.switches.count, self.switches.index
            super().cycle()

    def home(self, method: int, cycles: int = 20_000) -> np.ndarray:
        """Set-points of a homing until it reports its end."""
        self.put(0x6098, 0, method)
        rows = [self.follow(2, control=START)]
        assert not self.statusword() & (ATTAINED | REACHED | FAILED)
        while len(rows) < cycles // 10:
            rows.append(self.follow(10))
            if self.statusword() & REACHED:
                return np.vstack(rows)
            assert not self.statusword() & ATTAINED
        raise AssertionError(f"method {method} does not end: {rows[-1][-1]}")

    def home_position(self) -> int:
        """Raw."""
        return self.feedback.axis[0].position - self.inputs()[0x6064, 0] + OFFSET


def axis(method: int, position: int) -> Homed:
    home = ONE_SIDED.get(method % WITHOUT_INDEX, (LEFT, RIGHT))
    return Homed(Switches(LOW, HIGH, home, PITCH), position)


def beside(edge: int, side: int) -> int:
    """The first index on that side of an edge."""
    return (edge // PITCH + 1) * PITCH if side > 0 else (edge - 1) // PITCH * PITCH


def check_ramps(rows: np.ndarray) -> None:
    assert np.abs(rows[:, 1]).max() <= FAST * (1 + 1e-6)
    assert np.abs(np.diff(rows[:, 1])).max() <= ACCELERATION * TICK * (1 + 1e-5)
    assert np.abs(np.diff(rows[:, 0])).max() <= FAST * TICK * 1.001


@pytest.mark.parametrize("start", [-150_000, LEFT + 20_000, 150_000, LOW - 500, HIGH + 500])
@pytest.mark.parametrize("method", EDGES)
def test_homing__with_index_ends_at_the_index_beside_its_edge(method, start):
    drives = axis(method, start)
    rows = drives.home(method)
    assert drives.statusword() & (ATTAINED | REACHED | FAILED) == ATTAINED | REACHED
    assert drives.home_position() == beside(*EDGES[method])
    check_ramps(rows)
    assert rows[-1, 1] == 0 and abs(rows[-1, 0] - drives.home_position()) < 100


@pytest.mark.parametrize("start", [-150_000, LEFT + 20_000, 150_000])
@pytest.mark.parametrize("method", EDGES)
def test_homing__without_index_ends_at_the_edge(method, start):
    drives = axis(method, start)
    check_ramps(drives.home(method + WITHOUT_INDEX))
    edge, side = EDGES[method]
    # The first control cycle that sees the switch change, on the side that is asked for.
    assert 0 <= side * (drives.home_position() - edge) <= STEP + 1


@pytest.mark.parametrize(("method", "side"), [(33, -1), (34, 1)])
@pytest.mark.parametrize("start", [3_000, -3_000])
def test_homing__to_the_next_index_in_a_direction(method, side, start):
    drives = axis(method, start)
    rows = drives.home(method)
    assert drives.home_position() == beside(start, side)
    assert np.abs(rows[:, 1]).max() == SLOW


@pytest.mark.parametrize("method", [7, 9, 10, 11, 12, 14])
def test_homing__a_switch_shorter_than_the_braking_gives_its_edge_or_an_error(method):
    """It is passed in the search. Its edges count on the way back; 10 and 14 have none."""
    start = -150_000 if method <= 10 else 150_000
    drives = Homed(Switches(LOW, HIGH, (LEFT, LEFT + 2_000), PITCH), start)
    drives.put(0x609A, 0, 100_000_000)  # 80 000 increments to rest
    drives.home(method + WITHOUT_INDEX, cycles=60_000)
    assert bool(drives.statusword() & FAILED) == (method in (10, 14))
    if method not in (10, 14):
        edge = LEFT if EDGES[method][0] == LEFT else LEFT + 2_000
        assert abs(drives.home_position() - edge) <= STEP + 1


@pytest.mark.parametrize(
    ("method", "switches"),
    [
        (1, Switches(LOW, HIGH, (LEFT, RIGHT), 0)),  # no index up to the positive limit
        (3, Switches(LOW, HIGH, (FAR, FAR), PITCH)),  # a switch at one end turns nothing round
        (7, Switches(LOW, HIGH, (FAR, FAR), PITCH)),  # both limits, no home switch
        (11, Switches(LOW, HIGH, (FAR, FAR), PITCH)),
        (33, Switches(LOW, HIGH, (LEFT, RIGHT), 0)),
        (34, Switches(LOW, HIGH, (LEFT, RIGHT), 0)),
    ],
)
def test_homing__error_at_a_limit_switch_that_it_should_not_meet(method, switches):
    drives = Homed(switches, 10_000)
    before = drives.inputs()[0x6064, 0]
    rows = drives.home(method, cycles=30_000)
    assert drives.statusword() & (ATTAINED | REACHED | FAILED) == FAILED | REACHED
    assert drives.state() == "OPERATION ENABLED" and rows[-1, 1] == 0
    moved = drives.feedback.axis[0].position - 10_000
    assert drives.inputs()[0x6064, 0] - before == moved  # home is where it was
    brake = FAST**2 / 2 / ACCELERATION + 2 * FAST * TICK
    assert LOW - brake <= rows[:, 0].min() and rows[:, 0].max() <= HIGH + brake
    if method == 3:
        assert rows[:, 0].min() >= 10_000
    # It stays an error until the next homing begins.
    drives.follow(10, control=ENABLE)
    assert drives.statusword() & FAILED
    drives.put(0x6098, 0, 37)
    drives.follow(4, control=START)
    assert drives.statusword() & (ATTAINED | REACHED | FAILED) == ATTAINED | REACHED


def test_homing__status_while_it_moves_to_an_error():
    """Bits 13 and 10: error, then error at rest (CiA 402-2)."""
    drives = Homed(Switches(LOW, HIGH, (FAR, FAR), PITCH), 0)
    drives.put(0x6098, 0, 3)
    drives.set(control=START)
    seen = []
    for _ in range(3000):
        drives.step()
        word = drives.statusword() & (ATTAINED | REACHED | FAILED)
        if not seen or seen[-1] != word:
            seen.append(word)
    assert seen == [0, FAILED, FAILED | REACHED]


def test_homing__is_not_over_when_it_rests_for_a_cycle_to_turn_round():
    drives = axis(23, LEFT - 500)
    for index, subindex, value in ((0x6099, 1, 100_000), (0x6099, 2, 50_000), (0x609A, 0, 10**6)):
        drives.put(index, subindex, value)
    drives.put(0x6098, 0, 23)
    drives.set(control=START)
    speeds = []
    while not drives.statusword() & ATTAINED:
        drives.step()
        speeds.append(drives.set_point()[1])
        assert bool(drives.statusword() & REACHED) == bool(drives.statusword() & ATTAINED)
        assert len(speeds) < 5000
    assert 0.0 in speeds[:-1] and min(speeds) < 0 < max(speeds)


def test_homing__begun_in_motion_takes_an_index_in_its_own_direction():
    drives = axis(34, 3_000)
    drives.put(0x609A, 0, 100_000_000)
    drives.put(0x6098, 0, 34)
    drives.follow(100, mode=CSV, velocity=-3_000_000, control=ENABLE)
    drives.step(mode=HOMING)
    turn = drives.follow(2000, control=START)[:, 0].min()
    drives.follow(10, control=ENABLE)
    assert drives.statusword() & ATTAINED
    assert drives.home_position() == beside(round(turn), 1)


@pytest.mark.parametrize("how", ["bit 4", "halt", "mode"])
def test_homing__interrupted_stops_and_begins_anew(how):
    drives = axis(8, -150_000)
    drives.put(0x6098, 0, 8)
    drives.follow(300, control=START)
    assert drives.set_point()[1] == FAST
    values = {
        "bit 4": {"control": ENABLE},
        "halt": {"control": START | 0x100},
        "mode": {"mode": CSP},
    }
    drives.follow(2000, position=drives.inputs()[0x6064, 0], **values[how])
    assert drives.set_point()[1] == 0 and not drives.statusword() & FAILED
    if how == "bit 4":
        assert drives.statusword() & (ATTAINED | REACHED) == REACHED
    drives.follow(50, control=START, mode=HOMING)
    if how != "bit 4":
        assert drives.set_point()[1] == 0  # it needs an edge
    drives.follow(20, control=ENABLE)
    drives.home(8)
    assert drives.home_position() == beside(LEFT, 1)


def test_homing__speeds_are_within_the_limits_of_the_axis():
    drives = axis(17, 0)
    drives.put(0x607F, 0, 1_000_000)
    drives.put(0x6080, 0, 30)  # 50 000 increments/s
    rows = drives.home(17, cycles=60_000)
    assert np.abs(rows[:, 1]).max() == 50_000


def test_digital_inputs__bits_0_to_2_of_each_axis_are_its_switches():
    drives = Drives()
    for n in range(5):
        drives.feedback.axis[n].switches = n + 1
    drives.feedback.digital_inputs = 0x81
    drives.step()
    assert [drives.get(0x60FD + 0x800 * n) for n in range(5)] == [0x810001 + n for n in range(5)]


def test_supported_methods__are_those_that_6098_takes():
    drives = Drives()
    listed = {int(drives.get(0x60E3, n + 1)) for n in range(int(drives.get(0x60E3, 0)))}
    for method in range(-3, 41):
        try:
            drives.put(0x6098, 0, method)
            taken = True
        except AbortedError as error:
            assert error.code == 0x06090030
            taken = False
        assert taken == (method in listed), method
    assert listed == {*EDGES, *(m + WITHOUT_INDEX for m in EDGES), 33, 34, 35, 37}


def test_switches__words_of_the_machine_reach_the_axes():
    """Switches of two axes and their index, through the words of a control tick."""
    pose, place = (0.03, -0.02, 0.6, 0.1, -0.2), 3_000_000  # x in increments
    machine = Machine(
        Robot.load(None), DEVICE, pose,
        {0: Switches(place + 100, FAR, (0, FAR), 1000), 4: Switches(-FAR, -FAR, (0, 1), 500)},
    )  # fmt: skip
    drives = Drives()
    words = HostWords(drives)
    machine.switches[0].move(place - 1500)
    machine.switches[0].count = COUNTS - 1
    words.inputs[:] = machine.measured()
    words.tick()
    found = drives.feedback.axis[0]
    assert found.switches == NEGATIVE | HOME and drives.feedback.axis[4].switches == POSITIVE
    passed = found.position // 1000 - (place - 1500) // 1000
    assert passed in (1, 2) and abs(found.position - place) <= 200
    assert found.index_count == (COUNTS - 1 + passed) % COUNTS
    assert found.index_position == found.position // 1000 * 1000
    assert drives.feedback.axis[1].switches == 0 == drives.feedback.axis[1].index_count


def test_index_of_the_simulated_encoder__each_crossing_once():
    switches = Switches(-FAR, FAR, (FAR, FAR), 100)
    seen = []
    for position in (50, 99, 100, 101, 150, 99, 50, 350, -1, 0, 5):
        switches.move(position)
        seen.append((switches.count, switches.index))
    assert seen == [
        (0, 0), (0, 0), (1, 100), (1, 100), (1, 100), (2, 100), (2, 100), (5, 300), (9, 0),
        (10, 0), (10, 0),
    ]  # fmt: skip
