# SPDX-License-Identifier: Apache-2.0
"""pysoem's own set-up of distributed clocks, and its frames lost and damaged on the wire."""

from __future__ import annotations

import pytest

from sim.bus.dc_run import SHIFT_NS, SYNC0_NS
from tests.bench.needs import needs
from tests.ethercat.masters import report_of

pytestmark = needs("tap")
PHASE_NS = 40  # a slave sends in its own phase
NEAR_NS = 50  # of pulses: as the system times (20 ns), a clock and a step of observation each


@pytest.fixture(scope="module")
def clocks() -> dict:
    return report_of("dc_run", "--cycles", 200)


@pytest.mark.full
def test_dc__pysoem_finds_the_clocks_and_goes_to_op(clocks):
    assert clocks["found"] and clocks["state"] == "OP" and clocks["wrong_counters"] == 0


def test_dc__delays_are_those_of_the_frames(clocks):
    pairs = list(zip(clocks["delays"], clocks["true_delays"], strict=True))
    assert pairs[0] == (0, 0)
    for n, (written, true) in enumerate(pairs):
        assert abs(written - true) <= PHASE_NS * n, (n, written, true)
    near, far = (b - a for a, b in zip(clocks["delays"], clocks["delays"][1:], strict=False))
    assert abs(far - near - 700) <= 2 * PHASE_NS  # cables of 500 and 1200 ns


def test_dc__offsets_make_one_time_of_the_latched_ones(clocks):
    assert clocks["offsets"] == clocks["true_offsets"]
    # The second clock is faster and latches later: never equal. The third is slower and later
    # still, so that it may represent a moment where either of the others does.
    assert clocks["offsets"][1] < 0
    # The models are read one after the other: a clock of time passes for each access.
    assert all(abs(rest) <= 10 for rest in clocks["rests"])


def test_dc__sync0_rises_at_its_time_in_all_slaves(clocks):
    assert clocks["cycles"] == [SYNC0_NS] * 3
    assert [start % SYNC0_NS for start in clocks["starts"]] == [SHIFT_NS] * 3
    assert all(0 <= late <= NEAR_NS for late in clocks["late"])
    for times in clocks["pulses"]:
        apart = [(time + SYNC0_NS // 2) % SYNC0_NS - SYNC0_NS // 2 for time in times]
        assert max(map(abs, apart)) <= NEAR_NS, clocks["pulses"]
        steps = [b - a for a, b in zip(times, times[1:], strict=False)]
        assert all(abs(step - SYNC0_NS) <= NEAR_NS for step in steps)


FRAMES = 5


@pytest.fixture(scope="module")
def disturbed() -> dict:
    return report_of("disturbed_run", "--frames", FRAMES)


@pytest.mark.parametrize("kind", ("lost", "damaged", "lost back"))
def test_frames__disturbed_cost_their_cycles_only_and_op_is_kept(disturbed, kind: str):
    found = disturbed[kind]
    assert (found["wrong"], found["wrong_behind"], found["in_op"]) == (FRAMES, 0, True)
    assert found["counted"]["watchdog"] == found["counted"]["rx"] == [0] * 3
    # Outputs of frames that were lost or damaged never came: the inputs are of those before.
    assert found["inputs"][1] == [1 if kind == "lost back" else FRAMES + 1] * 3
    assert max(found["inputs"][2]) < FRAMES


def test_frames__damaged_are_counted_by_the_first_slave_and_forwarded_by_the_others(disturbed):
    for kind in ("lost", "damaged", "lost back"):
        own = FRAMES * (kind == "damaged")
        assert disturbed[kind]["counted"]["invalid"] == [own, 0, 0]
        assert disturbed[kind]["counted"]["forwarded"] == [0, own, own]


def test_frames__lost_for_longer_than_the_watchdog_are_counted_by_it(disturbed):
    found = disturbed["long"]
    assert found["counted"]["watchdog"] == [1] * 3
    assert found["wrong_behind"] == 0 and max(found["inputs"][2]) < FRAMES
