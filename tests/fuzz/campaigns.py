# SPDX-License-Identifier: Apache-2.0
"""All campaigns. A module of campaigns adds its list here."""

from __future__ import annotations

from tests.fuzz import asip, casadi_files, debugger, main_job, model, motion, nios, urdf
from tests.fuzz.engine import Campaign

MODULES = (asip, debugger, nios, main_job, motion, model, casadi_files, urdf)
CAMPAIGNS: dict[str, Campaign] = {
    campaign.name: campaign for module in MODULES for campaign in module.CAMPAIGNS
}
