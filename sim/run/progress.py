# SPDX-License-Identifier: Apache-2.0
"""Progress of long simulations: bars on a terminal, a line every tenth in a log."""

from __future__ import annotations

from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn


class TickProgress:
    """Named tasks that advance in ticks; a context manager."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._bars = Progress(
            TextColumn("  {task.description:<24}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            console=console,
            disable=not console.is_terminal,
        )
        self._tasks: dict[str, int] = {}

    def __enter__(self) -> TickProgress:
        self._bars.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._bars.stop()

    def add(self, name: str, ticks: int) -> None:
        """A task of so many ticks."""
        self._tasks[name] = self._bars.add_task(name, total=ticks)

    def advance(self, name: str, ticks: int) -> None:
        """So many more ticks of a task are done."""
        task = self._bars.tasks[self._tasks[name]]
        before = task.completed
        self._bars.advance(task.id, ticks)
        tenth = task.total / 10
        if not self._console.is_terminal and task.completed // tenth > before // tenth:
            self._console.print(f"      {name}: {task.completed:.0f} of {task.total:.0f} ticks")
