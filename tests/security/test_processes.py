# SPDX-License-Identifier: Apache-2.0
"""Workers of campaigns: no port, an orderly end, and no survivor of a job that was killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from sim.core.fpbench import campaign
from sim.core.fpbench.native import BenchError
from sim.rtl import processes
from tests.security.test_signals import members, obey_signals

DEADLINE = 30.0  # s, against a hang
LISTENS = "0A"  # state in the kernel's table
JOB = """
import time
from sim.rtl.processes import processes
if __name__ == "__main__":
    with processes(2) as pool:
        print(*pool.map(abs, [-1, -2]), flush=True)
        pool.submit(time.sleep, 600)
        time.sleep(600)
"""


@dataclass(frozen=True)
class Work:
    """A task of a campaign."""

    path: Path
    n: int


def listening(pid: int) -> list[str]:
    """Addresses of the TCP sockets at which a process listens."""
    held = set()
    for entry in Path(f"/proc/{pid}/fd").iterdir():
        try:
            held.add(os.readlink(entry))
        except OSError:
            pass  # the list's own descriptor
    found = []
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            words = line.split()
            if words[3] == LISTENS and f"socket:[{words[9]}]" in held:
                found.append(words[1])
    return found


def ports(work: Work) -> dict:
    """Listening sockets of the worker and of the process that made it."""
    if work.n < 0:
        os._exit(1)
    if work.n == 0:
        raise ValueError("nothing to do")
    return {"n": work.n, "ports": [listening(os.getpid()), listening(os.getppid())]}


def test_campaign_on_this_machine__opens_no_port(tmp_path):
    work = [Work(tmp_path / f"{n}.json", n) for n in range(5)]
    seen, failed = [], []
    campaign.run(work, lambda w, r: seen.append(r), lambda w, e: failed.append(e), 2, work=ports)
    assert sorted(each["n"] for each in seen) == [1, 2, 3, 4] and failed == ["nothing to do"]
    assert [each["ports"] for each in seen] == [[[], []]] * 4
    assert sorted(os.listdir(tmp_path)) == ["1.json", "2.json", "3.json", "4.json"]


def test_campaign__whose_worker_ends__says_so(tmp_path):
    with pytest.raises(BenchError, match="a worker process ended by itself.*fewer processes"):
        campaign.run([Work(tmp_path / "x.json", -1)], print, print, 1, work=ports)


@pytest.mark.parametrize("name", ["SIGKILL", "SIGTERM", "SIGINT"])
def test_killed_job__leaves_no_worker(name, tmp_path):
    script = tmp_path / "job.py"
    script.write_text(JOB)
    job = subprocess.Popen(
        [sys.executable, script], cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE, start_new_session=True, text=True, stderr=subprocess.DEVNULL,
        preexec_fn=obey_signals,
    )  # fmt: skip
    try:
        assert job.stdout is not None and job.stdout.readline() == "1 2\n"
        assert len(members(job.pid)) >= 3
        job.send_signal(getattr(signal, name))
        end = time.monotonic() + DEADLINE
        while members(job.pid) and time.monotonic() < end:
            time.sleep(0.05)
        assert members(job.pid) == []
    finally:
        if members(job.pid):
            os.killpg(job.pid, signal.SIGKILL)
        job.wait()


def test_end_with_parent__in_the_main_process_is_a_mistake():
    with pytest.raises(RuntimeError, match="called in a worker"):
        processes.end_with_parent()
