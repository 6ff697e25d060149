# SPDX-License-Identifier: Apache-2.0
"""The whole device in RTL, its program on the Nios II core, with pysoem as it comes from PyPI."""

from __future__ import annotations

import pytest

from sim.bus.coe.dictionary import load
from tests.ethercat.masters import report_of

pytestmark = pytest.mark.full


@pytest.fixture(scope="module")
def report() -> dict:
    return report_of("device_run", "--step", 5, timeout=3000)


def test_pysoem__finds_maps_and_brings_it_to_op(report):
    device = load()
    head = device.device
    assert report["name"] == head["name"]
    assert report["identity"] == [head["vendor"], head["product"], head["revision"]]
    assert report["mapped_bytes"] == device.bytes("rx") + device.bytes("tx")
    assert (report["expected_counter"], report["wrong_counters"]) == (3, 0)
    assert report["console"] == ""


def test_pysoem__reads_and_browses_the_dictionary(report):
    assert report["dictionary"]["objects"] == len(load().objects)
    assert report["dictionary"]["entries_read"] > 50
    assert report["dictionary"]["different"] == []
    assert report["segments"]


def test_pysoem__enables_and_moves_the_axes(report):
    assert report["drive"] == {"enabled": [True] * 5, "actual_position": 20_000}


def test_control_pass__fits_its_cycle(report):
    for row in report["passes"]:
        assert row["powered"] and row["longest"] < 10_000, row  # 100 us at 100 MHz
