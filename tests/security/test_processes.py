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
from tests.security.campaign_kills import survivors
from tests.security.sessions import marked, marked_environment, marked_soon, members, obey_signals

DEADLINE = 30.0  # s, against a hang
LISTENS = "0A"  # state in the kernel's table
JOB = """
import time
from sim.rtl.processes import processes
if __name__ == "__main__":
    with processes(2) as pool:
        print(*pool.map(abs, [-1, -2]), flush=True)
        for _ in range(2):
            pool.submit(time.sleep, 600)
        for _ in range(4):  # more than the pipe to the workers takes
            pool.submit(len, bytes(1 << 20))
        time.sleep(600)
"""


@dataclass(frozen=True)
class Work:
    """A task of a campaign."""

    path: Path
    n: int
    fingerprint: str = ""


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


def nothing_marked(mark: str) -> bool:
    """Whether every process with the mark is gone, after a while."""
    end = time.monotonic() + DEADLINE
    while marked(mark) and time.monotonic() < end:
        time.sleep(0.02)
    return marked(mark) == {}


GRANDCHILD = "sleep 600 & echo $!; wait"


@pytest.mark.parametrize("stopped", [subprocess.TimeoutExpired, KeyboardInterrupt])
def test_program__that_is_not_over__ends_with_all_that_it_started(stopped, monkeypatch):
    mark = f"{stopped.__name__} of {os.getpid()}"
    if stopped is KeyboardInterrupt:
        monkeypatch.setattr(subprocess.Popen, "communicate", interrupt)
    with pytest.raises(stopped):
        processes.run_group(["sh", "-c", GRANDCHILD], 0.5, env=marked_environment(mark))
    assert nothing_marked(mark)


def test_signal_while_a_program_starts__ends_it_and_all_that_it_started(monkeypatch):
    """Its number is known although the signal comes before it can be."""
    mark = f"start of {os.getpid()}"

    class Slow(subprocess.Popen):
        def __init__(self, *words, **options):
            super().__init__(*words, **options)
            assert self.stdout is not None and self.stdout.readline()
            signal.raise_signal(signal.SIGINT)
            marked_soon(mark, "sleep 600")

    monkeypatch.setattr(subprocess, "Popen", Slow)
    handler = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        processes.run_group(["sh", "-c", GRANDCHILD], 20.0, env=marked_environment(mark))
    assert nothing_marked(mark) and signal.getsignal(signal.SIGINT) is handler


def interrupt(job: subprocess.Popen[str], *_: object) -> None:
    """As Ctrl-C once the program runs."""
    assert job.stdout is not None and job.stdout.readline()
    raise KeyboardInterrupt


TEST = """
from sim.rtl.processes import run_group

def test_that_takes_long(tmp_path):
    run_group(["sh", "-c", "echo > started; sleep 600 & wait"], cwd={folder!r})
"""


@pytest.mark.quick("SIGTERM-0", "SIGHUP-0")
@pytest.mark.parametrize(("name", "workers"), [("SIGTERM", 0), ("SIGHUP", 0), ("SIGTERM", 1)])
def test_stopped_tests__end_the_programs_that_they_run(name, workers, tmp_path):
    (tmp_path / "test_long.py").write_text(TEST.format(folder=str(tmp_path)))
    mark = f"{name} {workers} of {os.getpid()}"
    words = [sys.executable, "-m", "pytest", "-q", "-p", "tests.conftest", f"--rootdir={tmp_path}"]
    job = subprocess.Popen(
        [*words, "-n", str(workers), tmp_path], cwd=ROOT, env=marked_environment(mark),
        start_new_session=True, preexec_fn=obey_signals, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    end = time.monotonic() + DEADLINE
    while not (tmp_path / "started").exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert "sleep 600" in [text.strip() for text in marked_soon(mark, "sleep 600").values()]
    job.send_signal(getattr(signal, name))
    assert job.wait(DEADLINE) != 0
    assert survivors(job, mark, DEADLINE) == []


def test_program__gets_its_input__and_its_texts_come_back():
    done = processes.run_group(["sh", "-c", "cat; echo no >&2; exit 3"], input="yes")
    assert (done.returncode, done.stdout, done.stderr) == (3, "yes", "no\n")


def test_end_with_parent__in_the_main_process_is_a_mistake():
    with pytest.raises(RuntimeError, match="called in a worker"):
        processes.end_with_parent()
