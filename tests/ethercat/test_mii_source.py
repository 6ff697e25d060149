# SPDX-License-Identifier: Apache-2.0
"""The slave controller between the MII source and sink of cocotbext-eth: scenarios of
mii_source_tb.py.

Replay of one scenario: `SEED=n SCENARIO=name pytest tests/ethercat/test_mii_source.py`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from sim.rtl.build import ROOT
from tests.bus.axil import run_scenarios

HERE = Path(__file__).parent
TOP = "mii_slave"


@pytest.mark.full
def test_mii_source__every_scenario() -> None:
    bench, folder = HERE / "mii_source_tb.py", ROOT / "build/mii_source"
    run_scenarios(TOP, (), bench, folder, optimisation="-O1")
