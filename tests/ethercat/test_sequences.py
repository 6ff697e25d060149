# SPDX-License-Identifier: Apache-2.0
"""Random sequences of writes leave no device whose objects do not go together."""

from __future__ import annotations

import pytest

from tests.bench.seed import SEED
from tests.ethercat.sequences import CAMPAIGN, campaign


def check_sequences(count: int) -> None:
    for name, wrong in campaign(SEED, count):
        assert not wrong, f"{name}: {wrong}"


def test_random_writes__leave_consistent_objects():
    check_sequences(600)


@pytest.mark.full
def test_random_writes__many():
    check_sequences(CAMPAIGN)
