# SPDX-License-Identifier: Apache-2.0
"""Campaigns: thirty cases of each always, all of them in the full set."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from tests.bench.commands import output
from tests.bench.seed import SEED
from tests.fuzz.campaigns import CAMPAIGNS

ROOT = Path(__file__).parents[2]
SHORT = 30


def campaign(name: str, report: Path, *options: str) -> None:
    """Run a campaign in a process of its own; its report is in the failure."""
    command = ("-m", "tests.fuzz", name, "--seed", SEED, "--output", report, *options)
    output(sys.executable, *command, cwd=ROOT)
    goals = json.loads(report.read_text(encoding="utf-8"))["goals"]
    assert len(goals) == 4 and all(goal["met"] for goal in goals)


@pytest.mark.quick(
    "assembly", "image", "asip-run", "run-robot", "gcode", "motion", "interface-file"
)
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_campaign__short__no_traceback_no_hang(name: str, tmp_path: Path) -> None:
    campaign(name, tmp_path / "fuzz.json", "--cases", str(SHORT))


@pytest.mark.full
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_campaign__full__no_traceback_no_hang(name: str, tmp_path: Path) -> None:
    campaign(name, tmp_path / "fuzz.json")
