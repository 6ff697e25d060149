# SPDX-License-Identifier: Apache-2.0
"""Worker processes of the main job: tasks that report their ticks, and an orderly end.

A task is a function with `progress` as its last argument, which takes ticks done. Whatever ends
the job (an error, Ctrl-C, SIGTERM) ends the workers with it.
"""

from __future__ import annotations

import multiprocessing
import signal
import time
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing.queues import Queue
from queue import Empty
from typing import Any

from sim.bench.run.progress import TickProgress
from sim.rtl.processes import end_with_parent, kill_workers

PROCESSES = 2

_reports: Queue


class WorkerLost(RuntimeError):
    """A worker process ended by itself; most often the machine had no memory left."""


def _begin(reports: Queue) -> None:
    """A worker leaves Ctrl-C to the main process and ends at once on request."""
    global _reports
    _reports = reports
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with_parent()


def _work(name: str, function: Callable, arguments: tuple) -> tuple[Any, float]:
    begin = time.perf_counter()
    result = function(*arguments, lambda ticks: _reports.put((name, ticks)))
    return result, time.perf_counter() - begin


class Workers:
    """Two processes; a context manager. seconds: what finished tasks took, by name."""

    def __init__(self, bars: TickProgress) -> None:
        self._bars = bars
        self._reports: Queue[tuple[str, int]] = multiprocessing.Queue()
        begin = partial(_begin, self._reports)
        self._pool = ProcessPoolExecutor(PROCESSES, initializer=begin)
        self._names: dict[Future, str] = {}
        self.seconds: dict[str, float] = {}

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None:
            kill_workers(self._pool)
        self._pool.shutdown(wait=True, cancel_futures=True)

    def submit(self, name: str, ticks: int, function: Callable, *arguments: Any) -> Future:
        """Start a task of so many ticks when a process is free; tasks start in this order."""
        self._bars.add(name, ticks)
        future = self._pool.submit(_work, name, function, arguments)
        self._names[future] = name
        return future

    def result(self, future: Future) -> Any:
        """Result of a task, while the progress of all is shown. Raises what any task raises."""
        while not future.done():
            self._show(timeout=0.2)
            for failed in wait(self._names, timeout=0, return_when=FIRST_EXCEPTION).done:
                self._checked(failed)
        while not self._reports.empty():
            self._show(timeout=0.0)
        value, self.seconds[self._names[future]] = self._checked(future)
        return value

    @staticmethod
    def _checked(future: Future) -> Any:
        try:
            return future.result()
        except BrokenProcessPool:
            raise WorkerLost(
                "a worker process ended by itself; the machine may have run out of memory: take "
                "fewer ticks (--ticks) or fewer platforms (--platforms)"
            ) from None

    def _show(self, timeout: float) -> None:
        try:
            self._bars.advance(*self._reports.get(timeout=timeout or None, block=timeout > 0.0))
        except Empty:
            return
