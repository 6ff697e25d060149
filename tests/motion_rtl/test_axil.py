# SPDX-License-Identifier: Apache-2.0
"""AXI4-Lite port `motion_axil` of the motion front-end: the cocotb scenarios of axil_tb.py.

Replay of one scenario: `SEED=n SCENARIO=name pytest tests/motion_rtl/test_axil.py`.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from sim.rtl.build import ROOT
from tests.bus.axil import run_scenarios


@pytest.mark.full
def test_axil__every_scenario() -> None:
    run_scenarios(
        "motion_axil",
        (),
        Path(__file__).with_name("axil_tb.py"),
        ROOT / "build/axil/motion",
    )
