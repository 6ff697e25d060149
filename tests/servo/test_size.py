# SPDX-License-Identifier: Apache-2.0
"""Area and clock of one axis on ECP5: decoder, two current filters, three half bridges."""

from __future__ import annotations

import pytest

from scripts.motion_size import area, speed
from tests.bench.needs import needs

MOST_LUTS, LEAST_MHZ = 700, 125


@needs("yosys")
def test_axis__within_its_size():
    found = area("drive_axis", {})
    assert 0 < found["luts"] <= MOST_LUTS and found["multipliers"] == 0


@needs("yosys")
@pytest.mark.full
def test_axis__reaches_its_clock():
    assert speed("drive_axis", {}, "drive_axis", (1, 2, 3))["mhz_median"] >= LEAST_MHZ
