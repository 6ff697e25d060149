# SPDX-License-Identifier: Apache-2.0
"""The set-up and the jobs in environments that go wrong elsewhere."""

from __future__ import annotations

import subprocess

import pytest

from tests.security.campaign_environments import LEAST, can_confine, failures
from tests.security.environments import TABLE, verdict

QUICK = (
    "PIP_CONFIG_FILE",
    "PIP_INDEX_URL bogus",
    "PYTHONPATH with a foreign numpy",
    "LC_ALL=POSIX",
)


@pytest.mark.full
def test_quick_environments__work_or_say_the_cure(tmp_path):
    table = [what for what in TABLE if what.name in QUICK]
    assert len(table) == len(QUICK)
    assert failures(table, tmp_path, False)[2] == []


@pytest.mark.full
def test_every_environment__works_or_says_the_cure(tmp_path):
    assert can_confine(), "unshare (Debian: util-linux) and user namespaces are needed"
    assert len({what.name for what in TABLE}) == len(TABLE) >= LEAST
    assert failures(TABLE, tmp_path, False)[2] == []


@pytest.mark.parametrize(
    ("status", "said", "cure", "fine"),
    [
        (0, "done", "", True),
        (2, "error: x", "", False),
        (0, "help: do y", "do y", False),
        (2, "help: do y", "do y", True),
        (2, "error: x", "do y", False),
        (2, "Traceback (most recent call last)\nhelp: do y", "do y", False),
    ],
)
def test_verdict__asks_for_the_end_that_is_due(status, said, cure, fine):
    done = subprocess.CompletedProcess([], status, said)
    assert (verdict(done, cure) == "") == fine
