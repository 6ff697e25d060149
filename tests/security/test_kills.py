# SPDX-License-Identifier: Apache-2.0
"""What the campaign of kills observes; the campaign itself in make test-full."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tests.security import campaign_kills
from tests.security.campaign_kills import PNG_END, children, damage, outputs, send, survivors


@pytest.mark.parametrize(
    ("name", "whole", "cut"),
    [
        ("a.json", b'{"a": 1}\n', b'{"a": '),
        ("a.html", b"<html></html>\n", b"<html>"),
        ("a.png", b"x" + PNG_END, b"x"),
        ("b.json", b"[]", b""),
    ],
)
def test_damage__is_seen(name, whole, cut, tmp_path):
    file = tmp_path / name
    file.write_bytes(whole)
    assert damage(file) == "" and outputs(tmp_path) == [file]
    file.write_bytes(cut)
    assert damage(file)


def test_survivor__is_seen_and_ended(monkeypatch):
    monkeypatch.setattr(campaign_kills, "DEADLINE", 0.3)
    script = (
        "import subprocess, sys; subprocess.Popen(['sleep', '600']); print(flush=True); input()"
    )
    job = subprocess.Popen(
        [sys.executable, "-c", script], start_new_session=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    with job:
        assert job.stdout is not None and job.stdout.readline() == b"\n"
        assert len(children(job.pid)) == 1
        send(job, "SIGTERM")
        assert any("sleep 600" in each for each in survivors(job))
        assert survivors(job) == []


@pytest.mark.full
def test_kills_of_the_main_job__leave_nothing():
    assert [goal for goal in campaign_kills.rows(False) if goal.met is False] == []
