# SPDX-License-Identifier: Apache-2.0
"""Runs shards in worker processes and caches each finished one: a stopped campaign resumes.

A shard's result is in `build/fpbench/shards/<unit>/<shard>.json` (sim/report/cache.py). Its
fingerprint covers the unit's RTL and the bench (`variants.fingerprint`): a changed unit runs again,
an unchanged one does not.
"""

from __future__ import annotations

import functools
import itertools
import socket
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from sim.core.fpbench.native import ROOT, BenchError, Unit
from sim.core.fpbench.plan import Shard
from sim.core.fpbench.variants import bench_unit, fingerprint
from sim.report import cache
from sim.report.cache import Cached
from sim.rtl.processes import processes

STORE = ROOT / "build/fpbench/shards"


@dataclass(frozen=True)
class Task:
    """A shard and where its result belongs."""

    shard: Shard
    unit: str
    fingerprint: str
    path: Path


def task_of(shard: Shard, store: Path = STORE) -> Task:
    """The task of a shard against the RTL as it is now."""
    mark = _fingerprint(shard.unit)
    return Task(shard, shard.unit, mark, store / shard.unit / f"{shard.name}.json")


@functools.cache
def _fingerprint(unit: str) -> str:
    return fingerprint(unit)


@functools.cache
def _unit(name: str, mark: str) -> Unit:
    """The unit with that fingerprint, built once per worker."""
    if fingerprint(name) != mark:
        raise BenchError(f"{name}: its sources changed after the campaign began; start it again")
    return bench_unit(name)


def execute(task: Task) -> dict:
    """Run one shard (in a worker) and return what is stored."""
    shard = task.shard
    unit = _unit(task.unit, task.fingerprint)
    report = unit.run(
        shard.op, shard.kind, shard.start, shard.count, seed=shard.seed, gaps=shard.gaps
    )
    return {
        "unit": task.unit,
        "host": socket.gethostname(),
        "shard": asdict(shard),
        **report.as_json(),
    }


def run(
    tasks: Iterable[Any],
    done: Callable[[Any, dict], None],
    failed: Callable[[Any, str], None],
    jobs: int = 2,
    scheduler: str | None = None,
    work: Callable[[Any], dict] = execute,
) -> None:
    """Run tasks in `jobs` processes of this machine, or on the Dask cluster at `scheduler`.

    `work` makes the result of a task (`Cached`) in a worker: here of a shard, other campaigns have
    their own.

    `done` is called with each result after it is stored, `failed` with the text of what kept a task
    from running (sources that changed meanwhile, a unit that does not build). A task per worker is
    in flight: more could wait after a long one while another worker has nothing to do.

    The processes of this machine are reached through pipes. A Dask cluster has ports that run what
    any client sends: it is used only where the user has set one up.
    """
    waiting = list(tasks)
    if not waiting:
        return
    if scheduler is not None:
        _run_on_cluster(scheduler, waiting, done, failed, work)
        return
    with processes(jobs) as pool:
        _drain(pool.submit, jobs, waiting, done, failed, work)


def _run_on_cluster(
    scheduler: str,
    waiting: list[Cached],
    done: Callable[[Any, dict], None],
    failed: Callable[[Any, str], None],
    work: Callable[[Any], dict],
) -> None:
    try:
        from dask.distributed import Client
    except ImportError:
        raise BenchError(
            "Dask is not installed; pip install 'microtick[cluster]', or leave out the scheduler"
        ) from None
    try:
        with Client(scheduler, timeout="10s") as client, client.get_executor(pure=False) as cluster:
            workers = max(1, len(client.scheduler_info()["workers"]))
            _drain(cluster.submit, workers, waiting, done, failed, work)
    except OSError as error:
        raise BenchError(f"no Dask scheduler at {scheduler}: {error}") from error


def _drain(
    submit: Callable[..., Future],
    workers: int,
    waiting: list[Cached],
    done: Callable[[Any, dict], None],
    failed: Callable[[Any, str], None],
    work: Callable[[Any], dict],
) -> None:
    queue = iter(waiting)
    owner = {submit(work, task): task for task in itertools.islice(queue, workers)}
    while owner:
        for future in wait(owner, return_when=FIRST_COMPLETED).done:
            task = owner.pop(future)
            try:
                result = future.result()
            except BrokenExecutor:
                raise BenchError(
                    "a worker process ended by itself; the machine may have run out of memory: "
                    "take fewer processes (JOBS)"
                ) from None
            except Exception as error:
                failed(task, str(error))
            else:
                cache.save(task, result)
                done(task, result)
            owner |= {submit(work, each): each for each in itertools.islice(queue, 1)}
