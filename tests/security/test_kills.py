# SPDX-License-Identifier: Apache-2.0
"""What the campaign of kills observes; the campaign itself in make test-full."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time

import pytest

from tests.security import campaign_kills
from tests.security.campaign_kills import PNG_END, children, damage, outputs, send, survivors
from tests.security.sessions import MARK, marked, marked_environment, marked_soon


@pytest.mark.parametrize(
    ("name", "whole", "cut"),
    [
        ("a.json", b'{"a": 1}\n', b'{"a": '),
        ("a.html", b"<html></html>\n", b"<html>"),
        ("a.png", b"x" + PNG_END, b"x"),
        ("a.xml", b"<a><b/></a>", b"<a><b/>"),
        ("b.json", b"[]", b""),
    ],
)
def test_damage__is_seen(name, whole, cut, tmp_path):
    file = tmp_path / name
    file.write_bytes(whole)
    assert damage(file) == "" and outputs(tmp_path) == [file]
    file.write_bytes(cut)
    assert damage(file)


def test_survivor__is_seen_in_any_session_and_ended(monkeypatch):
    monkeypatch.setattr(campaign_kills, "DEADLINE", 0.3)
    script = (
        "import subprocess, sys; subprocess.Popen(['sleep', '600'], start_new_session=True); "
        "print(flush=True); input()"
    )
    mark = f"survivor of {os.getpid()}"
    job = subprocess.Popen(
        [sys.executable, "-c", script], env=marked_environment(mark), start_new_session=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    with job:
        assert job.stdout is not None and job.stdout.readline() == b"\n"
        (child,) = children(job.pid)
        assert set(marked_soon(mark, "sleep 600")) == {job.pid, child}
        send(job, ("SIGTERM", "first"), mark, random.Random(1))
        assert [text.strip() for text in survivors(job, mark, 10.0)] == ["sleep 600"]
        assert survivors(job, mark, 10.0) == []


@pytest.mark.parametrize(
    ("kind", "dead"),
    [
        (("SIGKILL", "first"), [True, False]),
        (("SIGTERM", "terminal"), [True, True]),
        (("SIGTERM", "job"), [False, True]),
        (("SIGTERM", "any"), [False, True]),
    ],
)
def test_signal__goes_to_whom_its_kind_names(kind, dead):
    script = (
        "import subprocess, sys; subprocess.Popen(['sleep', '600']); print(flush=True); input()"
    )
    mark = f"{kind} of {os.getpid()}"
    job = subprocess.Popen(
        [sys.executable, "-c", script], env=marked_environment(mark), start_new_session=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    )  # fmt: skip
    with job:
        assert job.stdout is not None and job.stdout.readline() == b"\n"
        (child,) = children(job.pid)
        assert set(marked_soon(mark, "sleep 600")) == {job.pid, child}
        send(job, kind, mark, random.Random(1))
        gone = [job.pid, child] if all(dead) else [job.pid] if dead[0] else [child]
        end = time.monotonic() + campaign_kills.DEADLINE
        while set(gone) & set(marked(mark)) and time.monotonic() < end:
            time.sleep(0.02)
        assert set(marked(mark)) == {job.pid, child} - set(gone)
        for pid in marked(mark):
            os.kill(pid, signal.SIGKILL)


@pytest.mark.full
def test_kills_of_the_main_job__leave_nothing():
    assert [goal for goal in campaign_kills.rows(False) if goal.met is False] == []


def test_variables_of_make__do_not_reach_the_job(monkeypatch):
    monkeypatch.setenv("MAKEFLAGS", "w -- RUN=full T=security\\ kills")
    for name, value in (("RUN", "full"), ("T", "security kills"), ("OTHER", "1")):
        monkeypatch.setenv(name, value)
    found = marked_environment("m")
    assert not {"RUN", "T", "MAKEFLAGS"} & set(found)
    assert (found["OTHER"], found[MARK]) == ("1", "m")
