# SPDX-License-Identifier: Apache-2.0
"""Servo link and the front-end: the traffic on the processor's bus, clock by clock; registers."""

from __future__ import annotations

import numpy as np
import pytest

from asip_asm.gen.asip_regmap import REGMAP as ASIP
from sim.rtl.gen.drive_regmap import REGMAP as DRIVE
from tests.bench.seed import SEED
from tests.servo.clocked import Accesses, Clocked
from tests.servo.test_decoder import lines

AXES, WORDS, VALUES = 5, 21, 15
LINK_IN = (
    *("enable", "trigger", "orders", "sample", "order"),
    *("readdata", "waitrequest", "irq"),
)
LINK_OUT = (
    *("word", "value_valid", "axis", "phase", "value", "done"),
    *("address", "read", "write", "writedata", "busy", "late", "fault"),
)
START = ASIP.address("CONTROL")
MAGIC = np.float32(1.5 * 2**23)  # a program adds it to a value, and takes it off a sample


def run_link(
    samples: np.ndarray,
    values: np.ndarray,
    triggers: tuple[int, ...],
    fault: bool = False,
    hold: np.ndarray | int = 0,
) -> dict[str, np.ndarray]:
    """The link at a processor whose runs take 100 clocks; hold: clocks in which its bus waits."""
    link = Clocked("servo_link", LINK_IN, LINK_OUT)
    clocks = 800
    trigger = np.isin(np.arange(clocks), triggers)
    answers = {name: np.zeros(clocks, dtype=np.int64) for name in ("sample", "readdata", "irq")}
    outputs = (values.astype(np.float32) + MAGIC).view(np.int32).astype(np.int64)
    base = ASIP.blocks["outputs"].base
    while True:
        found = link.run(clocks, enable=1, trigger=trigger, waitrequest=hold, **answers)
        address = found["address"]
        status = ASIP.registers["STATUS"].word(fault=int(fault))
        read = np.where(address == ASIP.address("STATUS"), status, 0)
        inside = (address >= base) & (address < base + VALUES)
        read[inside] = outputs[address[inside] - base]
        starts = (address == START) & (found["write"] == 1) & np.equal(hold, 0)
        irq = np.zeros(clocks, dtype=np.int64)
        for start in np.flatnonzero(starts):
            irq[start + 100 : start + 300] = 1
        fresh = {
            "sample": samples[np.minimum(found["word"], WORDS - 1)],
            "readdata": read,
            "irq": irq,
        }
        if all((fresh[name] == answers[name]).all() for name in fresh):
            return found
        answers = fresh


@pytest.mark.parametrize("waits", [False, True])
def test_trigger__samples_a_run_and_values(waits):
    random = np.random.default_rng([SEED, waits])
    samples = random.integers(-(2**22), 2**22, WORDS)
    values = random.integers(0, 1251, VALUES)
    busy = waits & (random.random(800) < 0.4)
    found = run_link(samples, values, (10,), hold=busy)
    writes = (found["write"] == 1) & ~busy
    base = ASIP.blocks["constants"].base
    assert found["address"][writes].tolist() == [*range(base, base + WORDS), START]
    words = found["writedata"][writes][:WORDS].astype(np.uint32).view(np.float32)
    np.testing.assert_array_equal(words - MAGIC, samples.astype(np.float32))
    assert found["writedata"][writes][-1] == ASIP.registers["CONTROL"].word(start=1, clear=1)
    given = found["value_valid"] == 1
    np.testing.assert_array_equal(found["value"][given], values)
    assert found["axis"][given].tolist() == [n // 3 for n in range(VALUES)]
    assert found["phase"][given].tolist() == [n % 3 for n in range(VALUES)]
    (done,) = np.flatnonzero(found["done"])
    assert done == np.flatnonzero(given)[-1] + 1 and not found["busy"][done + 1 :].any()
    if not waits:  # trigger, inputs, start; run; status, outputs
        assert np.flatnonzero(writes)[0] == 11 and done == 11 + WORDS + 101 + 1 + VALUES


def test_orders__follow_the_samples_as_they_are():
    link = Clocked("servo_link", LINK_IN, LINK_OUT)
    inputs = {"enable": 1, "orders": 1, "trigger": np.arange(60) == 5}
    word = link.run(60, **inputs)["word"]
    found = link.run(60, **inputs, order=0x40490000 + word)
    writes = np.flatnonzero(found["write"])
    base = ASIP.blocks["constants"].base
    assert found["address"][writes].tolist() == [*range(base, base + 26), START]
    assert found["writedata"][writes][21:26].tolist() == [0x40490000 + n for n in range(21, 26)]


def test_fault_of_a_run__no_value_comes():
    found = run_link(np.zeros(WORDS, dtype=np.int64), np.zeros(VALUES), (10,), fault=True)
    assert found["fault"].sum() == 1 and not found["value_valid"].any() and not found["done"].any()
    assert not found["busy"][np.flatnonzero(found["fault"])[0] + 1 :].any()


def test_trigger_while_busy__is_late_and_starts_nothing():
    found = run_link(np.zeros(WORDS, dtype=np.int64), np.zeros(VALUES), (10, 60))
    assert np.flatnonzero(found["late"]).tolist() == [60] and found["done"].sum() == 1


def front_end() -> Clocked:
    inputs = (
        *("address", "read", "write", "writedata"),
        *("core_readdata", "core_waitrequest", "core_irq"),
        *("a", "b", "z", "bit_a", "bit_b", "bus", "fault", "order", "stop"),
    )
    outputs = (
        *("readdata", "waitrequest", "core_address", "core_read", "core_write"),
        *("core_writedata", "mclk", "high", "low", "position", "release", "chopper"),
    )
    return Clocked("drive_front_end", inputs, outputs, {"Axes": 2})


def test_front_end__compare_values_of_a_host_reach_the_gates_of_its_axis():
    clocks = 6000
    host = Accesses(DRIVE, clocks)
    host.write(10, "PWM", half_period=300, minimum=40)
    host.write(11, "DEAD_TIME", clocks=20)
    host.write(12, "MODE", axis1=2)  # runs
    for phase, value in enumerate((150, 20, 290)):
        host.write(13 + phase, "COMPARE", axis=1, phase=phase, value=value, commit=int(phase == 2))
    host.read(3000, "STATUS", "PWM")
    found = front_end().run(clocks, **host.columns)
    high = found["high"][3600:4800] >> np.arange(6)[:, None] & 1  # two periods
    # Bounded: 20 is below 40, 290 above 300 - 40; the dead time goes off the middle one.
    assert high.sum(axis=1).tolist() == [0, 0, 0, 2 * (300 - 20), 0, 1200]
    pwm = DRIVE.registers["PWM"].word(half_period=300, minimum=40)
    assert host.words(found) == [0, pwm]


def test_front_end__positions_currents_and_the_samples_of_the_link():
    clocks = 9000
    steps = (np.arange(clocks) > 300) & (np.arange(clocks) % 10 == 0) & (np.arange(clocks) < 2000)
    true = np.cumsum(steps)
    host = Accesses(DRIVE, clocks)
    host.write(10, "LINK", enable=1)
    host.read(8000, "POSITION", index=1)
    host.read(8010, "CURRENT_A")
    host.read(8020, "EDGE_TIME", index=1)
    found = front_end().run(
        clocks,
        **host.columns,
        **{name: 2 * line for name, line in lines(true).items()},  # of axis 1
        bit_a=1,  # axis 0, all bits 1
        bus=-123,
    )
    full = 2**17
    position, current, edge_time = host.words(found)
    assert (position, current) == (true[-1], full)
    assert abs(edge_time - np.flatnonzero(steps)[-1]) < 10
    # The run never ends: one set of words, at the end of the first window, and then late.
    writes = np.flatnonzero(found["core_write"])
    words = found["core_writedata"][writes][:9].astype(np.uint32).view(np.float32) - MAGIC
    assert words[[0, 1, 2, 5, 6, 8]].tolist() == [0, full, -full, -full, -full, -123]
    assert 0 < words[4] < true[-1]
    host = Accesses(DRIVE, clocks)
    host.write(10, "LINK", enable=1)
    host.read(8000, "STATUS")
    (status,) = host.words(front_end().run(clocks, **host.columns))
    fields = DRIVE.registers["STATUS"].fields
    assert fields["late"].of(status) and fields["trip"].of(status) == 3  # both axes


def test_front_end__trip_clears_by_axis():
    clocks = 3000
    host = Accesses(DRIVE, clocks)
    host.write(10, "MODE", axis0=1, axis1=1)
    host.write(1500, "CONTROL", clear=2)
    fault = np.where(np.arange(clocks) == 900, 3, 0)
    found = front_end().run(clocks, **host.columns, fault=fault)
    assert found["low"][899] == 0o77 and not found["low"][902:1500].any()
    assert found["low"][2000] == 0o70


def test_front_end__overcurrent_trips_its_axis():
    clocks = 6000
    host = Accesses(DRIVE, clocks)
    host.write(10, "MODE", axis0=1, axis1=1)
    host.write(2000, "CURRENT_LIMIT", size=200)
    bits = (np.arange(clocks) // 6) % 2  # of no current
    jump = np.where(np.arange(clocks) > 4000, 2, 0)
    found = front_end().run(clocks, **host.columns, bit_a=3 * bits | jump, bit_b=3 * bits)
    assert (found["low"][3000:4000] == 0o77).all()
    assert found["low"][-1] == 0o07, "axis 1 alone, whose bits are all 1"


def test_front_end__orders_of_one_clock_and_the_machines_position():
    clocks = 5000
    host = Accesses(DRIVE, clocks)
    host.write(10, "LINK", enable=1, orders=1)
    host.write(11, "ORIGIN", value=1000)
    first, second = 0x3F800000, 0xC0000000
    late = np.where(np.arange(clocks) > 1400, 0x7FFFFFFF, (second << 32) | first)
    found = front_end().run(clocks, **host.columns, order=late)
    writes = np.flatnonzero(found["core_write"])[:11]  # after the first window, 1152 clocks
    assert writes[0] < 1400 and found["core_writedata"][writes][9:11].tolist() == [
        first,
        second - 2**32 if found["core_writedata"].min() < 0 else second,
    ]
    assert found["position"][-1] == 1000


GUARDS = {
    "undervoltage": (dict(bus=10000), dict(bus=(11200, 9000)), 3),
    "overvoltage": (dict(bus=0), dict(bus=(12000, 12001)), 3),
    "stop": (dict(bus=0), dict(stop=(0, 1)), 3),
    "encoder": (dict(encoder=1), dict(a=(0, 2), b=(0, 2)), 2),
}


@pytest.mark.parametrize("cause", GUARDS)
def test_front_end__guards_take_gates_and_close_brakes(cause):
    guard, inputs, axes = GUARDS[cause]
    clocks = 3000
    host = Accesses(DRIVE, clocks)
    host.write(10, "MODE", axis0=2, axis1=2)
    host.write(11, "LINK", orders=1)
    host.write(12, "BRAKE", release=3)
    host.write(13, "GUARD", **guard)
    host.write(14, "BUS_LIMIT", most=12000)
    host.read(2500, "STATUS")
    when = np.arange(clocks) > 1000
    given = {name: np.where(when, pair[1], pair[0]) for name, pair in inputs.items()}
    found = front_end().run(clocks, **host.columns, **({"bus": 11200} | given))
    on = found["high"] | found["low"]
    assert found["release"][900] == 3 and on[900] == 0o77
    assert found["release"][-1] == 3 - axes
    assert on[-1] == sum(7 << 3 * n for n in range(2) if not axes >> n & 1)
    fields = DRIVE.registers["STATUS"].fields
    (status,) = host.words(found)
    assert fields["trip"].of(status) & 3 == axes
    flag = "illegal" if cause == "encoder" else cause
    assert fields[flag].of(status) & axes


@pytest.mark.parametrize("level", [12001, 20000, 32767])
def test_front_end__overvoltage_of_one_clock_takes_the_gates_after_three_edges(level):
    """Row n of the outputs follows edge n, which sees row n of the inputs."""
    clocks, at = 2000, 1500
    host = Accesses(DRIVE, clocks)
    host.write(10, "MODE", axis0=1, axis1=1)
    host.write(11, "BUS_LIMIT", most=12000)
    host.read(1900, "STATUS", "BUS_LIMIT")
    clear = Accesses(DRIVE, clocks)
    clear.write(10, "MODE", axis0=1, axis1=1)
    bus = np.where(np.arange(clocks) == at, level, 12000)
    found = front_end().run(clocks, **host.columns, bus=bus)
    low = found["low"]
    assert (low[1000:at] == 0o77).all() and not low[at + 3 :].any()
    status, limit = host.words(found)
    fields = DRIVE.registers["STATUS"].fields
    assert fields["overvoltage"].of(status) and fields["trip"].of(status) == 3 and limit == 12000
    never = front_end().run(clocks, **clear.columns, bus=bus)
    assert (never["low"][1000:] == 0o77).all(), "a limit of 0 never trips"


def test_front_end__chopper_is_on_above_one_voltage_until_it_is_below_the_other():
    """A random tour of the bus voltage, then a limit of 0; a trip changes nothing."""
    clocks = 4000
    draw = np.random.default_rng([SEED, 39])
    bus = 11200 + np.cumsum(draw.integers(-150, 151, clocks))
    bus = 11000 + np.abs((bus - 11000) % 3000 - 1500)  # within 11000 and 12500
    host = Accesses(DRIVE, clocks)
    host.write(10, "BUS_LIMIT", most=12300)
    host.write(11, "CHOPPER", on=12000, off=11500)
    host.read(3000, "CHOPPER")
    host.write(3500, "CHOPPER", on=0, off=11500)
    found = front_end().run(clocks, **host.columns, bus=bus)
    on, expected = False, []
    for clock, volts in enumerate(bus.tolist()):
        on = 11 < clock <= 3500 and (volts > 12000 or (on and volts >= 11500))
        expected.append(on)
    assert sum(np.diff(expected[:3500]) != 0) > 10 and max(bus) > 12300
    # The registers hold what was written after the edge of the write.
    assert found["chopper"][1:].astype(bool).tolist() == expected[:-1]
    assert host.words(found) == [11500 << 16 | 12000]
