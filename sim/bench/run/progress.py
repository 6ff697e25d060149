# SPDX-License-Identifier: Apache-2.0
"""Progress of long simulations: bars on a terminal, a line every tenth in a log."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn


def duration(seconds: float) -> str:
    """A duration as people say it."""
    if seconds < 100.0:
        return f"{max(seconds, 1.0):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000.0 else f"{seconds / 3600:.1f} h"


class TickProgress:
    """Named tasks that advance in ticks; a context manager.

    work: ticks and seconds per tick of every task to come, from which the time left of all is
    told. Without it each task reports its own on a terminal.
    """

    def __init__(
        self, console: Console, work: Mapping[str, tuple[int, float]] | None = None
    ) -> None:
        self._console = console
        self._bars = Progress(
            TextColumn("  {task.description:<24}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            TextColumn("{task.fields[left]}"),
            console=console,
            disable=not console.is_terminal,
        )
        self._tasks: dict[str, int] = {}
        self._cost = {name: seconds for name, (_, seconds) in (work or {}).items()}
        self._total = sum(ticks * seconds for ticks, seconds in (work or {}).values())
        self._done = 0.0
        self._begin = time.monotonic()

    def __enter__(self) -> TickProgress:
        self._bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bars.stop()

    def add(self, name: str, ticks: int) -> Callable[[int], None]:
        """A task of so many ticks; gives its `advance`."""
        self._tasks[name] = self._bars.add_task(name, total=ticks, left="")
        return partial(self.advance, name)

    def advance(self, name: str, ticks: int) -> None:
        """So many more ticks of a task are done."""
        self._done += ticks * self._cost.get(name, 0.0)
        left = self._left()
        task = self._bars.tasks[self._tasks[name]]
        before = task.completed
        self._bars.update(task.id, advance=ticks, left=left)
        total = task.total or 0.0
        tenth = total / 10
        if not self._console.is_terminal and task.completed // tenth > before // tenth:
            self._console.print(f"      {name}: {task.completed:.0f} of {total:.0f} ticks{left}")

    def _left(self) -> str:
        """Time left of all tasks, once it is known."""
        if not self._done > 0.0:
            return ""
        passed = time.monotonic() - self._begin
        return f"; {duration(passed * max(self._total / self._done - 1.0, 0.0))} left in all"
