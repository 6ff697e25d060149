# SPDX-License-Identifier: Apache-2.0
"""Goals of killed jobs: no process is left, no output is damaged, the job runs again.

A kill is a signal and whom it goes to. "first" is make alone, or the command where none is in
front of it. "terminal" is the whole group of processes, as Ctrl-C in a terminal reaches it. "job"
is what the first one has started, so that the workers of a job that is killed must end by
themselves. "any" is one process below the first, chosen at random: a shell, a worker, a compiler.
The job may then end by itself.
"""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

from asip_asm.project import ROOT
from sim.report.goals import Goal, depth, exactly
from tests.security.outcomes import resumed
from tests.security.sessions import DEADLINE, marked, marked_environment, obey_signals

KILLS = 100
CURE = "make goals T='security kills' RUN=full"
KINDS = (
    ("SIGTERM", "first"), ("SIGINT", "terminal"), ("SIGHUP", "terminal"), ("SIGKILL", "job"),
    ("SIGTERM", "any"), ("SIGINT", "any"), ("SIGHUP", "any"), ("SIGKILL", "any"),
)  # fmt: skip
RUN = ("make", "run", "TICKS=5", "PLATFORMS=fpga3")
TESTS = "PYTEST_ADDOPTS=tests/asm/test_cli.py tests/security/test_processes.py"
MICROTICK = (sys.executable, "-m", "sim.verbs")
QUICK = {"run": (4, RUN)}
FULL = {
    "run": (40, RUN),
    "test": (40, ("make", "test", "-o", "checks", TESTS)),
    "robots": (20, (*MICROTICK, "robots", "--only", "pendulum")),
}
"""Short forms: the tests are two files, without the checks of sources before them."""
PNG_END = b"IEND\xaeB`\x82"
SHOWN = (".json", ".html", ".png", ".xml")
RERUN_EACH = 10  # kills


@dataclass(frozen=True)
class Kill:
    """One kill of a job, at a moment given as a part of the job's length."""

    job: str
    n: int

    @property
    def kind(self) -> tuple[str, str]:
        """Signal, and whom it goes to."""
        return KINDS[(self.n - 1) % len(KINDS)]

    @property
    def random(self) -> random.Random:
        """The source of what is chosen at random."""
        return random.Random(f"{self.job} {self.n}")

    def __str__(self) -> str:
        name, whom = self.kind
        return f"{self.job} {self.n}: {name} to {whom} at {self.random.random():.3f} of its length"


def damage(file: Path) -> str:
    """What is wrong with an output, "" if it is whole."""
    data = file.read_bytes()
    if file.suffix == ".json":
        try:
            json.loads(data)
        except ValueError as error:
            return str(error)
    if file.suffix == ".xml":
        try:
            ElementTree.fromstring(data)
        except ElementTree.ParseError as error:
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
        if each.suffix in SHOWN and not each.name.startswith(".")
    ]  # fmt: skip


def start(words: Sequence[str], output: Path, mark: str) -> subprocess.Popen[bytes]:
    """Start a command in a session of its own; the main job writes to `output`."""
    command = [*words, *([f"OUTPUT={output}"] if "run" in words else [])]
    return subprocess.Popen(
        command, cwd=ROOT, env=marked_environment(mark), start_new_session=True,
        preexec_fn=obey_signals,
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def children(pid: int) -> list[int]:
    """Processes that a process has started."""
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(each) for each in text.split()]


def send(
    job: subprocess.Popen[bytes], kind: tuple[str, str], mark: str, rng: random.Random
) -> None:
    """Send a signal as the module's text says; nothing if the job is over."""
    number, whom = getattr(signal, kind[0]), kind[1]
    try:
        if whom == "first":
            job.send_signal(number)
        elif whom == "terminal":
            os.killpg(job.pid, number)
        elif whom == "job":
            for child in children(job.pid):
                os.kill(child, number)
        else:
            below = sorted(set(marked(mark)) - {job.pid})
            if below:
                os.kill(rng.choice(below), number)
    except (ProcessLookupError, FileNotFoundError):
        pass


def survivors(job: subprocess.Popen[bytes], mark: str, patience: float) -> list[str]:
    """Processes of the job that are there when it should be over; they are ended.

    patience: how long the job may go on before that, in s.
    """
    try:
        job.wait(patience)
    except subprocess.TimeoutExpired:
        pass  # it is found below
    end = time.monotonic() + DEADLINE
    while (found := marked(mark)) and time.monotonic() < end:
        time.sleep(0.05)
    for pid in found:
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    job.wait()
    return list(found.values())


def kill(
    what: Kill, words: Sequence[str], length_known: Callable[[], float], folder: Path
) -> dict[str, list[str]]:
    """Start a job and kill it: what was left and damaged, and whether it ran again where tried."""
    length = length_known()
    rng, mark = what.random, f"{os.getpid()} {what}"
    moment = rng.random()
    job = start(words, folder, mark)
    time.sleep(moment * length)
    send(job, what.kind, mark, rng)
    left = survivors(job, mark, DEADLINE + 5 * length)
    shown = folder if what.job == "run" else ROOT / "build"
    wrong = {file.name: damage(file) for file in outputs(shown)}
    damaged = [f"{name}: {text}" for name, text in wrong.items() if text]
    again = what.n % RERUN_EACH == 0 and start(words, folder, mark).wait() != 0
    return {"left": left, "damaged": damaged, "failed": ["it does not run again"] if again else []}


def length_of(words: Sequence[str], folder: Path) -> float:
    """How long a job takes when nothing kills it, in s."""
    begun = time.monotonic()
    if start(words, folder, "unharmed").wait() != 0:
        raise RuntimeError(f"{' '.join(words)} fails before any kill")
    return time.monotonic() - begun


def rows(full: bool) -> Iterator[Goal]:
    """Kills of the main job; the full form also of tests and of a robot shown. It resumes."""
    found: dict[str, list[str]] = {"left": [], "damaged": [], "failed": []}
    tried = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for job, (count, words) in (FULL if full else QUICK).items():
            length = cache(partial(length_of, words, folder))
            for n in range(1, count + 1):
                what = Kill(job, n)
                measure = partial(kill, what, words, length, folder)
                outcome = resumed("kills", str(what), measure) if full else measure()
                tried += 1
                for key, texts in outcome.items():
                    found[key] += [f"{what}: {text}" for text in texts]
    yield depth("kills.tried", tried, KILLS, "kills", CURE)
    for name, key, unit in (
        ("kills.processes_left", "left", "processes"),
        ("kills.outputs_damaged", "damaged", "files"),
        ("kills.reruns_failed", "failed", "runs"),
    ):
        yield exactly(name, len(found[key]), 0, unit, json.dumps(found[key]))
