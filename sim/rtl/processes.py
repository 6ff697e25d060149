# SPDX-License-Identifier: Apache-2.0
"""Worker processes of campaigns, reached through pipes and never through a port; other programs."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any


def end_with_parent() -> None:
    """This worker ends when the process that made it has ended, by whatever signal.

    A worker that waits for its next task would otherwise wait for ever: the pipe stays open in it.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        raise RuntimeError("end_with_parent is called in a worker, never in the main process")

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, name="end with parent", daemon=True).start()


def _begin() -> None:
    """A worker leaves Ctrl-C to the main process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()


def kill_workers(pool: ProcessPoolExecutor) -> None:
    """End the workers in the middle of their tasks; `shutdown` of the pool returns afterwards.

    Before Python 3.11.5 the writer of the pool's queue would wait forever for a reader if a task
    does not fit into the pipe, so the reading end is closed here (CPython issue 94777).
    """
    for process in list((pool._processes or {}).values()):
        process.kill()
    if sys.version_info < (3, 11, 5) and (queue := getattr(pool, "_call_queue", None)) is not None:
        queue._reader.close()


@contextmanager
def processes(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that share nothing with this one: a copy of it could not run its Verilated models,
    whose threads are not copied.

    A job that is stopped ends them without waiting for their tasks.
    """
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), _begin)
    try:
        yield pool
    except BaseException:
        kill_workers(pool)
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


class _Held:
    """Signals that Python handles wait from now until `release`.

    A program that is being started can then not be lost: a handler that raises in the middle of it
    would leave nobody who knows the program's number.
    """

    def __init__(self) -> None:
        self.came: list[int] = []
        self.handlers: dict[int, Any] = {}
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                if callable(handler := signal.getsignal(number)):
                    self.handlers[number] = handler
                    signal.signal(number, lambda number, frame: self.came.append(number))

    def release(self) -> None:
        """The handlers are those of before, and get what has come meanwhile."""
        for number, handler in self.handlers.items():
            signal.signal(number, handler)
        for number in self.came:
            signal.raise_signal(number)


def run_group(
    command: Sequence[str | Path],
    timeout: float | None = None,
    input: str | None = None,
    **options: Any,
) -> subprocess.CompletedProcess[str]:
    """Run a program and take what it prints. Raises subprocess.TimeoutExpired.

    If it is not over after `timeout` s, or this process is to stop meanwhile, it ends with
    every process that it has started. input: text that it reads. options: further ones of Popen.
    """
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    if input is not None:
        streams["stdin"] = subprocess.PIPE
    held = _Held()
    try:
        job = subprocess.Popen(command, start_new_session=True, **(streams | options))
    except BaseException:
        held.release()
        raise
    with job:
        try:
            held.release()
            said, errors = job.communicate(input, timeout)
        except BaseException:
            os.killpg(job.pid, signal.SIGKILL)  # Its number is not given away before the wait.
            raise
    return subprocess.CompletedProcess(command, job.returncode, said, errors)
