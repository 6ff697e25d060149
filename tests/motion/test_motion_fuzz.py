# SPDX-License-Identifier: Apache-2.0
"""Mutated programs and command lines end in an exit status, soon and in bounded memory."""

import os

import pytest

from tests.fuzz.engine import run_campaign
from tests.fuzz.motion import CAMPAIGNS

SEED = int(os.environ.get("SEED", "1"))
NORMAL = {"gcode": 200, "motion": 60, "lookahead": 60, "planner": 60, "oracle": 20}


def check(campaign, cases: int) -> None:
    result = run_campaign(campaign, cases, SEED)
    again = f"python -m tests.fuzz {campaign.name} --seed {SEED} --replay"
    assert not result.failures, [f"{again} {f.case}: {f.kind} {f.text}" for f in result.failures]
    assert len(result.statuses) > 1  # good and bad ones are among them


@pytest.mark.quick("gcode")
@pytest.mark.parametrize("campaign", CAMPAIGNS, ids=lambda campaign: campaign.name)
def test_fuzz__some_mutated_inputs__no_traceback_no_hang(campaign):
    check(campaign, NORMAL[campaign.name])


@pytest.mark.full
@pytest.mark.parametrize("campaign", CAMPAIGNS, ids=lambda campaign: campaign.name)
def test_fuzz__all_mutated_inputs__no_traceback_no_hang(campaign):
    check(campaign, campaign.cases)
