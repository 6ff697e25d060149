# SPDX-License-Identifier: Apache-2.0
"""All campaigns. A module of campaigns adds its list here."""

from __future__ import annotations

from tests.fuzz import asip, main_job, nios
from tests.fuzz.engine import Campaign

CAMPAIGNS: dict[str, Campaign] = {
    campaign.name: campaign for campaign in (*asip.CAMPAIGNS, *nios.CAMPAIGNS, *main_job.CAMPAIGNS)
}
