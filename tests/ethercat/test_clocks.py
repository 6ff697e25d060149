# SPDX-License-Identifier: Apache-2.0
"""Distributed clocks of three slaves whose clocks are 100 ppm off, and the pulses made of them."""

from __future__ import annotations

import numpy as np
import pytest

from sim.bus.clocks import measure_delays, read, synchronise, write
from sim.bus.gen import esc_regmap
from sim.bus.line import Line

PPM = (0.0, 100.0, -100.0)
CABLE_PS = 500_000
NEAR = 20  # ns


# A slave sends in its own phase of 40 ns: a way may be that much longer.
def test_delays__are_those_of_the_cables():
    with Line((0.0,) * 3, cable_ps=CABLE_PS) as line, Line((0.0,) * 3, cable_ps=0) as short:
        long, none = measure_delays(line, 4), measure_delays(short, 4)
    for n, (with_cables, without) in enumerate(zip(long, none, strict=True)):
        assert abs(with_cables - without - 500 * n) <= 40 * n


@pytest.mark.full
def test_clocks__come_together():
    with Line(PPM, cable_ps=CABLE_PS) as line:
        found = synchronise(line, 500, counted=50, speed_filter=8)
        speeds = [read(line, n, esc_regmap.SPEED_DIFFERENCE) for n in (1, 2)]
    fast, slow = np.array(speeds, np.uint16).view(np.int16)
    assert found.worst <= NEAR
    assert fast < -5000 and slow > 5000  # 100 ppm are 6711 * 2^-26


@pytest.mark.full
def test_clocks__ten_thousand_cycles_at_the_default_filter():
    with Line(PPM, cable_ps=CABLE_PS) as line:
        assert synchronise(line, 10_000).worst <= NEAR


CYCLE = 5000  # ns
SEEN = 9 * CYCLE - CYCLE // 2


def pulses(shift: int, late: int = 0) -> list[list[int]]:
    """Beginnings of SYNC0 and SYNC1 after START_TIME, ns, until 9 SYNC0 in the future came.

    late: the unit is switched on so long after START_TIME.
    """
    with Line() as line:
        write(line, 0, esc_regmap.SYNC0_CYCLE, CYCLE)
        write(line, 0, esc_regmap.SYNC1_CYCLE, shift)
        line.write(esc_regmap.PULSE_LENGTH, 20)
        start = line.time() + 40_000 - late
        write(line, 0, esc_regmap.START_TIME, start)
        write(line, 0, esc_regmap.SYNC_ACTIVATION, 7)
        seen, before = ([], []), 0
        while line.time() < start + late + SEEN:
            line.run(10)
            now = line.sync()
            for n in range(2):
                if now & ~before & 1 << n:
                    seen[n].append(line.time() - start)
            before = now
    return [*seen]


def test_sync0__begins_at_its_time_and_every_cycle():
    seen = pulses(1000)[0]
    assert len(seen) == 9
    assert all(0 <= late - CYCLE * n <= 40 for n, late in enumerate(seen))


@pytest.mark.parametrize("shift", (0, 1000, CYCLE - 10, CYCLE, 7000, 2 * CYCLE, 4 * CYCLE))
def test_sync1__begins_behind_every_sync0_that_it_does_not_wait_for(shift: int):
    """SYNC1_CYCLE of n cycles of SYNC0 and more: after every (n + 1)-th (as SOEM counts too)."""
    period = (shift // CYCLE + 1) * CYCLE
    seen = pulses(shift)[1]
    assert len(seen) == len(range(shift, SEEN, period))
    assert all(0 <= late - shift - period * n <= 60 for n, late in enumerate(seen))


def test_sync1__keeps_its_phase_behind_a_start_that_has_passed():
    shift, late = 2 * CYCLE, 200_000
    period = 3 * CYCLE
    seen = [time for time in pulses(shift, late)[1] if time > late]
    assert len(seen) >= 3
    assert all(0 <= (time - shift) % period <= 60 for time in seen)


@pytest.mark.parametrize("ahead", (-20_000, 20_000))
def test_difference__has_the_sign_of_the_published_text(ahead: int):
    """`behind` of 092C: the local time is behind that which came."""
    with Line() as line:
        write(line, 0, esc_regmap.DIFFERENCE_FILTER, 0)
        write(line, 0, esc_regmap.SYSTEM_TIME, line.time() - ahead)
        line.run(2000)
        found = read(line, 0, esc_regmap.TIME_DIFFERENCE)
    fields = esc_regmap.TIME_DIFFERENCE.fields
    assert fields["behind"].of(found) == (ahead < 0)
    assert abs(fields["size"].of(found) - abs(ahead)) < 5_000
