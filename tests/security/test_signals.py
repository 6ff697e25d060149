# SPDX-License-Identifier: Apache-2.0
"""A signal to make leaves no process of the job."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import time

import pytest

from asip_asm.project import ROOT
from tests.security.sessions import DEADLINE, members, obey_signals


@pytest.mark.quick("SIGTERM")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT", "SIGHUP"])
def test_make_run__ends_with_its_workers(name, tmp_path):
    """TERM goes to make alone. INT and HUP come from a terminal, which sends them to all its
    processes: make itself waits for its children then, and passes nothing on.
    """
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}
    job = subprocess.Popen(
        ["make", "run", f"OUTPUT={tmp_path}"], cwd=ROOT, env=environment, start_new_session=True,
        preexec_fn=obey_signals,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    end = time.monotonic() + DEADLINE
    while not any("sim.bench.run" in text for text in members(job.pid)) and time.monotonic() < end:
        time.sleep(0.1)
    time.sleep(2.0)
    assert job.poll() is None, "the job has ended by itself"
    if name == "SIGTERM":
        job.terminate()
    else:
        os.killpg(job.pid, getattr(signal, name))
    assert job.wait(DEADLINE) != 0
    end = time.monotonic() + DEADLINE
    while members(job.pid) and time.monotonic() < end:
        time.sleep(0.1)
    left = members(job.pid)
    if left:
        os.killpg(job.pid, signal.SIGKILL)
    assert left == []


def test_recipes__of_jobs_replace_their_shell():
    lines = (ROOT / "Makefile").read_text().splitlines()
    jobs = [
        line for line in lines if re.match(r"\t@?(exec )?\$\(PY\) -m (sim|tests|scripts)", line)
    ]
    assert len(jobs) > 1
    assert [line for line in jobs if "exec " not in line] == []
