# SPDX-License-Identifier: Apache-2.0
"""Goals of the environments: the set-up and the jobs work in each, or say the cure."""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from sim.report.goals import Goal, depth, exactly
from tests.security.environments import PLAIN, TABLE, Environment, job, set_up

LEAST = 25
CURE = "make goals T='security environments' RUN=full"


def failures(
    table: Sequence[Environment], folder: Path, full: bool
) -> tuple[list[str], list[str], list[str]]:
    """Names of the environments in which the set-up, and in which a job fails; what they said.

    full: the main job, and a set-up that makes the virtual environment, else quick ones.
    Raises RuntimeError if the plain environment fails.
    """
    wrong, wanted = job(folder / "plain", PLAIN, full)
    if wrong:
        raise RuntimeError(f"the job fails in the plain environment: {wrong}")
    set_ups, jobs, said = [], [], []
    for n, what in enumerate(table):
        if found := set_up(folder / f"set-up {n}", what, full):
            set_ups.append(what.name)
            said.append(f"{what.name}, set-up: {found}")
        found, outputs = job(folder / f"job {n}", what, full)
        if not found and not what.cure(full) and outputs != wanted:
            differ = [name for name in wanted if outputs.get(name) != wanted[name]]
            found = f"outputs differ from those of the plain environment: {differ}"
        if found:
            jobs.append(what.name)
            said.append(f"{what.name}, job: {found}")
        for used in (folder / f"set-up {n}", folder / f"job {n}"):
            shutil.rmtree(used, ignore_errors=True)
    return set_ups, jobs, said


def can_confine() -> bool:
    """Whether read-only folders and no network can be had here."""
    command = ["unshare", "-rmn", "true"]
    return bool(shutil.which(command[0])) and subprocess.run(command).returncode == 0


def rows(full: bool) -> Iterator[Goal]:
    """Every environment of the table; the quick form runs shorter jobs in them."""
    table = [what for what in TABLE if not what.confined or can_confine()]
    with tempfile.TemporaryDirectory() as folder:
        set_ups, jobs, _ = failures(table, Path(folder), full)
    yield depth("environments.tried", len(table), LEAST, "environments", CURE)
    yield exactly("environments.set_up_fails", len(set_ups), 0, "environments", json.dumps(set_ups))
    yield exactly("environments.job_fails", len(jobs), 0, "environments", json.dumps(jobs))
