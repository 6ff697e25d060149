# SPDX-License-Identifier: Apache-2.0
"""Measurements of the shown laws that take minutes, in processes, each stored when it is done: a
run that was stopped continues with the next law. A change of any source measures again.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from asip_asm.pace import Pace
from asip_asm.project import BUILD, ROOT
from sim.core.fpbench.campaign import run
from sim.report import cache

STORE = BUILD / "law_results"
SOURCES = ("asip_asm", "sim")
JOBS = 2


class MeasureError(RuntimeError):
    """A law could not be measured; the message names it."""


@dataclass(frozen=True)
class Task:
    """What to measure of a law: `place` is "module:function" of its name and the numbers."""

    place: str
    law: str
    numbers: tuple[int, ...]
    path: Path
    fingerprint: str


@functools.cache
def fingerprint() -> str:
    """Of the sources, and of the files that they read."""
    files = [file for folder in SOURCES for file in (ROOT / folder).rglob("*")]
    return cache.fingerprint(
        file for file in files if file.suffix in (".py", ".toml", ".urdf", ".s")
    )


def file_name(law: str) -> str:
    """Where the result of a law belongs."""
    return f"{law.replace(' ', '_')}.json"


def work(task: Task) -> dict[str, Any]:
    """Measure, in a process of its own."""
    module, _, function = task.place.partition(":")
    return getattr(import_module(module), function)(task.law, *task.numbers)


def results(place: str, laws: Sequence[str], *numbers: int) -> dict[str, dict[str, Any]]:
    """What `place` finds of each law, stored or measured now. Raises MeasureError."""
    what = "-".join([place.partition(":")[0].rpartition(".")[2], *map(str, numbers)])
    tasks = [
        Task(place, law, numbers, STORE / what / file_name(law), fingerprint()) for law in laws
    ]
    found = {task.law: result for task in tasks if (result := cache.load(task)) is not None}
    missing = [task for task in tasks if task.law not in found]
    pace = Pace(what, len(missing))
    wrong: list[str] = []

    def done(task: Task, result: dict[str, Any]) -> None:
        found[task.law] = result
        pace.at(sum(one.law in found for one in missing))

    run(missing, done, lambda task, text: wrong.append(f"{task.law}: {text}"), JOBS, work=work)
    if wrong:
        raise MeasureError("; ".join(wrong))
    return {law: found[law] for law in laws}
