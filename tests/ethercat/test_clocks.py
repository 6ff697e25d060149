# SPDX-License-Identifier: Apache-2.0
"""Distributed clocks of three slaves whose clocks are 100 ppm off, and the pulses made of them."""

from __future__ import annotations

import pytest

from sim.ethercat.clocks import measure_delays, read, synchronise, write
from sim.ethercat.gen import esc_regmap
from sim.ethercat.line import Line

PPM = (0.0, 100.0, -100.0)
CABLE_PS = 500_000
NEAR = 20  # ns


# A slave sends in its own phase of 40 ns: a way may be that much longer.
def test_delays__are_those_of_the_cables():
    with Line((0.0,) * 3, cable_ps=CABLE_PS) as line, Line((0.0,) * 3, cable_ps=0) as short:
        long, none = measure_delays(line, 4), measure_delays(short, 4)
    for n, (with_cables, without) in enumerate(zip(long, none, strict=True)):
        assert abs(with_cables - without - 500 * n) <= 40 * n


def test_clocks__come_together():
    with Line(PPM, cable_ps=CABLE_PS) as line:
        found = synchronise(line, 500, counted=50, speed_filter=8)
        fast, slow = (
            int.from_bytes(
                read(line, n, esc_regmap.SPEED_DIFFERENCE).to_bytes(2, "little"),
                "little",
                signed=True,
            )
            for n in (1, 2)
        )
    assert found.worst <= NEAR
    assert fast < -5000 and slow > 5000  # 100 ppm are 6711 * 2^-26


@pytest.mark.full
def test_clocks__ten_thousand_cycles_at_the_default_filter():
    with Line(PPM, cable_ps=CABLE_PS) as line:
        assert synchronise(line, 10_000).worst <= NEAR


def test_sync0__begins_at_its_time_and_every_cycle():
    with Line() as line:
        start = line.time() + 40_000
        write(line, 0, esc_regmap.SYNC0_CYCLE, 5000)
        write(line, 0, esc_regmap.START_TIME, start)
        write(line, 0, esc_regmap.SYNC_ACTIVATION, 3)
        seen, before = [], 0
        while len(seen) < 4:
            line.run(10)
            now = line.sync() & 1
            if now and not before:
                seen.append(line.time() - start)
            before = now
    assert all(0 <= late - 5000 * n <= 40 for n, late in enumerate(seen))
