# SPDX-License-Identifier: Apache-2.0
"""Touch probe of CiA 402; values from the text of the standard and from the line of a motion."""

from __future__ import annotations

import random
import struct

import pytest

from tests.ethercat.drives import Drives
from tests.ethercat.host import AbortedError
from tests.ethercat.host_link import HostWords

ON, CONTINUOUS, INDEX, OBJECT, RISING, FALLING = 0x01, 0x02, 0x04, 0x08, 0x10, 0x20
STORED_RISING, STORED_FALLING = 0x02, 0x04
WAY = 100  # increments in a control cycle


class Probed(Drives):
    """The first axis is moved by the test, `WAY` in a control cycle."""

    def __init__(self) -> None:
        super().__init__()
        self.held.add(0)

    def go(self, inputs: int | None = None, ages: tuple[int, int] = (0, 0), way: int = WAY) -> int:
        """A control cycle; the position that it has."""
        if inputs is not None:
            self.feedback.digital_inputs = inputs
            self.feedback.edge_age[:] = ages
        self.feedback.axis[0].position += way
        self.step()
        return self.feedback.axis[0].position

    def pulse(self, place: int) -> None:
        axis = self.feedback.axis[0]
        axis.index_count, axis.index_position = (axis.index_count + 1) % 64, place

    def probe(self, function: int, n: int = 0) -> None:
        self.put(0x60B8, 0, function << 8 * n)

    def flags(self, n: int = 0) -> int:
        return int(self.get(0x60B9)) >> 8 * n & 0xFF

    def value(self, n: int, edge: int) -> tuple[int, int]:
        """Position and counter of a rising (0) or falling (1) edge."""
        at = 2 * n + edge
        return int(self.get(0x60BA + at)), int(self.get(0x60D5 + at))


@pytest.mark.parametrize("n", [0, 1])
def test_probe__one_edge_then_none_until_it_is_turned_on_again(n):
    drives = Probed()
    bit = 1 << n
    drives.probe(ON | RISING | FALLING, n)
    drives.go(inputs=0)
    assert drives.flags(n) == ON and drives.flags(1 - n) == 0
    up = drives.go(inputs=bit)
    assert drives.flags(n) == ON | STORED_RISING
    down = drives.go(inputs=0)
    assert drives.flags(n) == ON | STORED_RISING | STORED_FALLING
    for _ in range(4):
        drives.go(inputs=bit)
        drives.go(inputs=0)
    assert drives.value(n, 0) == (up, 1) and drives.value(n, 1) == (down, 1)
    assert drives.value(1 - n, 0) == drives.value(1 - n, 1) == (0, 0)
    drives.probe(0, n)
    drives.go()
    assert drives.flags(n) == 0 and drives.value(n, 0) == (up, 1)
    drives.probe(ON | RISING, n)
    drives.go()
    assert drives.flags(n) == ON and drives.value(n, 0) == (up, 0)
    again = drives.go(inputs=bit)
    assert drives.value(n, 0) == (again, 1) and drives.value(n, 1) == (down, 0)


def test_probe__an_edge_turned_off_and_on_is_taken_once_more():
    drives = Probed()
    drives.probe(ON | RISING)
    drives.go(inputs=0)
    drives.go(inputs=1)
    drives.go(inputs=0)
    drives.probe(ON)
    drives.go()
    assert drives.flags() == ON
    drives.probe(ON | RISING)
    place = drives.go(inputs=1)
    assert drives.flags() == ON | STORED_RISING and drives.value(0, 0) == (place, 2)


def test_probe__continuous_takes_every_edge():
    drives = Probed()
    drives.probe(ON | CONTINUOUS | RISING | FALLING)
    drives.go(inputs=0)
    rng, level, last, counts = random.Random(4), 0, [0, 0], [0, 0]
    for _ in range(200):
        before, level = level, rng.randrange(2)
        place = drives.go(inputs=level)
        if level != before:
            edge = 1 - level
            last[edge], counts[edge] = place, counts[edge] + 1
        assert [drives.value(0, 0), drives.value(0, 1)] == list(zip(last, counts, strict=True))


@pytest.mark.parametrize("way", [WAY, -WAY, 12_345])
@pytest.mark.parametrize("age", [0, 1, 16_384, 32_768, 65_535])
def test_probe__place_between_two_ticks_by_the_age_of_the_edge(way, age):
    drives = Probed()
    drives.probe(ON | FALLING, 1)
    drives.go(inputs=2, way=way)
    drives.go(way=way)
    here = drives.go(inputs=0, ages=(0xFFFF - age, age), way=way)
    assert abs(drives.value(1, 1)[0] - (here - way * age / 65536)) <= 0.5


def test_probe__an_old_edge_is_not_taken():
    drives = Probed()
    drives.go(inputs=1)
    drives.probe(ON | RISING)
    for _ in range(3):
        drives.go()
    assert drives.flags() == ON and drives.value(0, 0) == (0, 0)


@pytest.mark.parametrize("n", [0, 1])
def test_probe__of_the_index_has_its_place(n):
    drives = Probed()
    drives.pulse(11)
    drives.probe(ON | INDEX | RISING, n)
    drives.go(inputs=0)
    drives.go(inputs=3)  # no source
    assert drives.flags(n) == ON
    drives.pulse(777)
    drives.go()
    assert drives.flags(n) == ON | STORED_RISING and drives.value(n, 0) == (777, 1)
    drives.pulse(888)
    drives.go()
    assert drives.value(n, 0) == (777, 1)
    drives.probe(ON | INDEX | CONTINUOUS | RISING, n)
    drives.pulse(999)
    drives.go()
    assert drives.value(n, 0) == (999, 2)
    drives.go()
    assert drives.value(n, 0) == (999, 2)


@pytest.mark.parametrize("n", [0, 1])
@pytest.mark.parametrize("source", [1, 2])
def test_probe__of_60d0_takes_either_input_and_its_age(n, source):
    drives = Probed()
    drives.put(0x60D0, n + 1, source)
    drives.probe(ON | OBJECT | RISING | FALLING, n)
    bit, other = 1 << source - 1, 4 >> source
    drives.go(inputs=0)
    drives.go(inputs=other)  # no source
    assert drives.flags(n) == ON
    ages = (0x4000, 0xC000)
    up = drives.go(inputs=bit | other, ages=ages)
    assert drives.value(n, 0) == (up - WAY * ages[source - 1] // 65536, 1)
    down = drives.go(inputs=0)
    assert drives.value(n, 1) == (down, 1)
    assert drives.flags(n) == ON | STORED_RISING | STORED_FALLING
    assert drives.flags(1 - n) == 0


@pytest.mark.parametrize("n", [0, 1])
def test_probe__of_60d0_takes_the_index_and_a_new_source_restarts_it(n):
    drives = Probed()
    assert [drives.get(0x60D0, 1), drives.get(0x60D0, 2)] == [1, 2]
    drives.put(0x60D0, n + 1, 3)
    drives.probe(ON | OBJECT | CONTINUOUS | RISING, n)
    drives.go(inputs=0)
    drives.go(inputs=3)
    assert drives.flags(n) == ON
    drives.pulse(777)
    drives.go()
    assert drives.value(n, 0) == (777, 1)
    drives.put(0x60D0, n + 1, 1)
    drives.go(inputs=0)
    assert drives.flags(n) == ON and drives.value(n, 0) == (777, 0)
    place = drives.go(inputs=1)
    assert drives.value(n, 0) == (place, 1)


@pytest.mark.parametrize("n", [0, 1])
def test_probe__index_by_60d0_and_falling_edges_are_refused_in_either_order(n):
    drives = Probed()
    drives.put(0x60D0, n + 1, 3)
    for function in (ON | OBJECT | FALLING, ON | OBJECT | RISING | FALLING):
        with pytest.raises(AbortedError) as caught:
            drives.probe(function, n)
        assert caught.value.code == 0x06090030 and drives.get(0x60B8) == 0
    drives.put(0x60D0, n + 1, 2)
    drives.probe(ON | OBJECT | FALLING, n)
    with pytest.raises(AbortedError) as caught:
        drives.put(0x60D0, n + 1, 3)
    assert caught.value.code == 0x06090030 and drives.get(0x60D0, n + 1) == 2
    for value in (0, -1, 4):  # 06090030 of a limit too
        with pytest.raises(AbortedError):
            drives.put(0x60D0, n + 1, value)


def test_probe__positions_are_those_of_the_master():
    """After homing they are as 6064."""
    drives = Probed()
    drives.put(0x607C, 0, 5_000)
    drives.enable(mode=6)
    drives.step(control=0x1F)
    drives.probe(ON | RISING)
    drives.go(inputs=0)
    drives.go(inputs=1)
    assert drives.value(0, 0)[0] == drives.inputs()[0x6064, 0] == 5_000 + 2 * WAY


@pytest.mark.parametrize("n", [0, 1])
@pytest.mark.parametrize("function", [ON | 0x0C, ON | INDEX | FALLING, ON | 0x40])
def test_probe__what_is_not_there_is_refused_and_by_process_data_stays_off(function, n):
    drives = Probed()
    with pytest.raises(AbortedError) as caught:
        drives.probe(function, n)
    assert caught.value.code == 0x06090030 and drives.get(0x60B8) == 0
    drives = Mapped()
    drives.function = (function | RISING) << 8 * n
    drives.go(inputs=0)
    drives.pulse(5)
    drives.go(inputs=3)
    assert drives.get(0x60B8) == drives.function
    assert drives.get(0x60B9) == 0 and drives.value(n, 0) == (0, 0)
    drives.function = (ON | RISING) << 8 * n
    drives.go(inputs=0)
    place = drives.go(inputs=3)
    assert drives.value(n, 0) == (place, 1)


class Mapped(Probed):
    """60B8 alone is in the process data."""

    function = 0

    def process_managers(self, outputs: int = 0) -> None:
        self.put(0x1C12, 0, 0)
        self.put(0x1600, 0, 0)
        self.put(0x1600, 1, 0x60B80010)
        self.put(0x1600, 0, 1)
        self.put(0x1C12, 1, 0x1600)
        self.put(0x1C12, 0, 1)
        super().process_managers(outputs=2)

    def outputs(self, values=None) -> None:
        self.write(0x1200, struct.pack("<H", self.function))


def test_ages_of_edges__by_the_words_of_a_control_tick():
    drives = Probed()
    words = HostWords(drives)
    words.inputs[-1] = 0x1234_ABCD
    words.tick()
    assert list(drives.feedback.edge_age) == [0xABCD, 0x1234]
