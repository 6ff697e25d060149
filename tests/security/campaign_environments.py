# SPDX-License-Identifier: Apache-2.0
"""Goals of the environments: the set-up and the jobs work in each, or say the cure."""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from sim.report.goals import Goal, depth, exactly
from tests.security.environments import PLAIN, TABLE, Environment, job, set_up
from tests.security.outcomes import resumed

LEAST = 25
CURE = "make goals T='security environments' RUN=full"


def outcome(what: Environment, folder: Path, full: bool) -> dict:
    """What is wrong with the set-up and with the jobs, and digests of what the jobs wrote."""
    used = [Path(tempfile.mkdtemp(dir=folder)) for _ in range(2)]
    wrong = set_up(used[0], what, full)
    failed, outputs = job(used[1], what, full)
    for each in used:
        shutil.rmtree(each, ignore_errors=True)
    return {"name": what.name, "set_up": wrong, "job": failed, "outputs": outputs}


def failures(
    table: Sequence[Environment], folder: Path, full: bool
) -> tuple[list[str], list[str], list[str]]:
    """Names of the environments in which the set-up, and in which a job fails; what they printed.

    full: the main job and a test command, and a set-up that makes the virtual environment, else
    quick ones. A full campaign resumes. Raises RuntimeError if the plain environment fails.
    """
    order = [PLAIN, *(each for each in table if each is not PLAIN)]
    found = []
    for what in order:
        measure = partial(outcome, what, folder, full)
        found.append(resumed("environments", what.name, measure) if full else measure())
        if what is PLAIN and found[0]["job"]:
            raise RuntimeError(f"the job fails in the plain environment: {found[0]['job']}")
    set_ups, jobs, said = [], [], []
    wanted = found[0]["outputs"]
    for what, seen in zip(order, found, strict=True):
        wrong, outputs = seen["job"], seen["outputs"]
        if not wrong and not what.cure(full) and outputs != wanted:
            differ = [name for name in wanted if outputs.get(name) != wanted[name]]
            wrong = f"outputs differ from those of the plain environment: {differ}"
        for part, text, names in (("set-up", seen["set_up"], set_ups), ("job", wrong, jobs)):
            if text:
                names.append(what.name)
                said.append(f"{what.name}, {part}: {text}")
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
