# SPDX-License-Identifier: Apache-2.0
"""Goals of killed jobs: no process is left, no output is damaged, the job runs again.

TERM goes to make alone; INT and HUP come from a terminal, which sends them to all its processes;
KILL goes to the job below make, so that its workers must end by themselves.
"""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from asip_asm.project import ROOT
from sim.report.goals import Goal, depth, exactly
from tests.security.test_signals import DEADLINE, members, obey_signals

SIGNALS = ("SIGTERM", "SIGINT", "SIGHUP", "SIGKILL")
KILLS = 100
CURE = "make goals T='security kills' RUN=full"
QUICK = {"run": (4, ("run", "TICKS=5", "PLATFORMS=fpga3"))}
FULL = {
    "run": (50, ("run", "TICKS=200")),
    "test": (25, ("test", "T=test_image or test_processes")),
    "robots": (25, ("robots", "T=pendulum")),
}
PNG_END = b"IEND\xaeB`\x82"
RERUN_EACH = 10  # kills


@dataclass
class Found:
    """What kills left: names of the kill and what was wrong."""

    kills: int = 0
    left: list[str] = field(default_factory=list)
    damaged: list[str] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)


def damage(file: Path) -> str:
    """What is wrong with an output, "" if it is whole."""
    data = file.read_bytes()
    if file.suffix == ".json":
        try:
            json.loads(data)
        except ValueError as error:
            return str(error)
    if file.suffix == ".html" and not data.rstrip().endswith(b"</html>"):
        return "no end of the page"
    if file.suffix == ".png" and not data.endswith(PNG_END):
        return "no end of the image"
    return "" if data else "empty"


def outputs(folder: Path) -> list[Path]:
    """Files that a job shows; one being written has a name with a dot in front."""
    return [
        each for each in folder.glob("*.*")
        if each.suffix in (".json", ".html", ".png") and not each.name.startswith(".")
    ]  # fmt: skip


def start(words: Sequence[str], output: Path) -> subprocess.Popen[bytes]:
    """Start a target of the Makefile in a session of its own."""
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}
    command = ["make", *words, *([f"OUTPUT={output}"] if words[0] == "run" else [])]
    return subprocess.Popen(
        command, cwd=ROOT, env=environment, start_new_session=True, preexec_fn=obey_signals,
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def children(pid: int) -> list[int]:
    """Processes that a process has started."""
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(each) for each in text.split()]


def send(job: subprocess.Popen[bytes], name: str) -> None:
    """Send a signal as the module's text says; nothing if the job is over."""
    number = getattr(signal, name)
    try:
        if name == "SIGTERM":
            job.terminate()
        elif name == "SIGKILL":
            for child in children(job.pid):
                os.kill(child, number)
        else:
            os.killpg(job.pid, number)
    except (ProcessLookupError, FileNotFoundError):
        pass


def survivors(job: subprocess.Popen[bytes]) -> list[str]:
    """Processes of the session that are there when it should be over; they are ended."""
    end = time.monotonic() + DEADLINE
    while (found := members(job.pid)) and time.monotonic() < end:
        job.poll()
        time.sleep(0.05)
    if found:
        os.killpg(job.pid, signal.SIGKILL)
    job.wait()
    return found


def kill(words: Sequence[str], count: int, rng: random.Random, folder: Path, found: Found) -> None:
    """Start and kill a job at random moments of its length; run it again every ten kills."""
    name = words[0]
    shown = folder if name == "run" else ROOT / "build"
    begun = time.monotonic()
    if start(words, folder).wait() != 0:
        raise RuntimeError(f"make {' '.join(words)} fails before any kill")
    length = time.monotonic() - begun
    for n in range(1, count + 1):
        number = SIGNALS[(n - 1) % len(SIGNALS)]
        moment = rng.random()
        said = f"{name} {n}: {number} at {moment:.3f} of its length"
        job = start(words, folder)
        time.sleep(moment * length)
        send(job, number)
        found.kills += 1
        found.left += [f"{said}: {each}" for each in survivors(job)]
        wrong = {file.name: damage(file) for file in outputs(shown)}
        found.damaged += [f"{said}: {file}: {text}" for file, text in wrong.items() if text]
        if (n % RERUN_EACH == 0 or n == count) and start(words, folder).wait() != 0:
            found.failed.append(said)


def rows(full: bool) -> Iterator[Goal]:
    """Kills of the main job; the full form also of tests and of the robots shown."""
    found, rng = Found(), random.Random(1)
    with tempfile.TemporaryDirectory() as folder:
        for count, words in (FULL if full else QUICK).values():
            kill(words, count, rng, Path(folder), found)
    yield depth("kills.tried", found.kills, KILLS, "kills", CURE)
    yield exactly("kills.processes_left", len(found.left), 0, "processes", json.dumps(found.left))
    yield exactly(
        "kills.outputs_damaged", len(found.damaged), 0, "files", json.dumps(found.damaged)
    )
    yield exactly("kills.reruns_failed", len(found.failed), 0, "runs", json.dumps(found.failed))
