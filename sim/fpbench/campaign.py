# SPDX-License-Identifier: Apache-2.0
"""Runs shards as Dask tasks and keeps each finished one, so that a stopped campaign resumes.

A shard's result lies in `build/fpbench/shards/<unit>-<fingerprint>/<shard>.json`. The fingerprint
covers the unit's RTL and the bench (`variants.fingerprint`): a changed unit runs again, an
unchanged one does not.
"""

from __future__ import annotations

import functools
import json
import os
import socket
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

from dask.distributed import Client, LocalCluster, as_completed

from asip_asm.files import write_text
from sim.fpbench.native import ROOT, BenchError, Unit
from sim.fpbench.plan import Shard
from sim.fpbench.variants import bench_unit, fingerprint

STORE = ROOT / "build/fpbench/shards"


@dataclass(frozen=True)
class Task:
    """A shard and where its result belongs."""

    shard: Shard
    unit: str
    fingerprint: str
    path: Path

    @property
    def key(self) -> str:
        """Its name among the tasks of a cluster."""
        return f"{self.unit}-{self.fingerprint}-{self.shard.name}"


class Stored(Protocol):
    """What a campaign needs of a task: its name on the cluster, where its result belongs."""

    @property
    def key(self) -> str: ...

    @property
    def path(self) -> Path: ...


def task_of(shard: Shard, store: Path = STORE) -> Task:
    """The task of a shard against the RTL as it is now."""
    mark = _fingerprint(shard.unit)
    return Task(shard, shard.unit, mark, store / f"{shard.unit}-{mark}" / f"{shard.name}.json")


@functools.cache
def _fingerprint(unit: str) -> str:
    return fingerprint(unit)


@functools.cache
def _unit(name: str, mark: str) -> Unit:
    """The unit with that fingerprint, built once per worker."""
    if fingerprint(name) != mark:
        raise BenchError(f"{name}: its sources changed after the campaign began; start it again")
    return bench_unit(name)


def finished(task: Stored) -> dict | None:
    """The stored result, None if there is none that can be read."""
    try:
        return json.loads(task.path.read_text())
    except (FileNotFoundError, json.JSONDecodeError):
        return None


def execute(task: Task) -> dict:
    """Run one shard (in a worker) and return what is stored."""
    shard = task.shard
    unit = _unit(task.unit, task.fingerprint)
    report = unit.run(
        shard.op, shard.kind, shard.start, shard.count, seed=shard.seed, gaps=shard.gaps
    )
    return {
        "unit": task.unit,
        "fingerprint": task.fingerprint,
        "host": socket.gethostname(),
        "shard": asdict(shard),
        **report.as_json(),
    }


def store(task: Stored, result: dict) -> None:
    """Write a result so that a reader never sees half of it."""
    task.path.parent.mkdir(parents=True, exist_ok=True)
    temporary = task.path.with_suffix(f".{os.getpid()}")
    write_text(temporary, json.dumps(result, indent=1) + "\n")
    temporary.replace(task.path)


def run(
    tasks: Iterable[Any],
    done: Callable[[Any, dict], None],
    failed: Callable[[Any, str], None],
    jobs: int = 2,
    scheduler: str | None = None,
    work: Callable[[Any], dict] = execute,
) -> None:
    """Run tasks on a local cluster of `jobs` processes, or on the cluster at `scheduler`.

    `work` makes the result of a task (`Stored`) in a worker: here of a shard, other campaigns have
    their own.

    `done` is called with each result after it is stored, `failed` with the text of what kept a task
    from running (sources that changed meanwhile, a unit that does not build). A task per worker is
    in flight: more could wait behind a long one while another worker has nothing to do.
    """
    waiting = list(tasks)
    if not waiting:
        return
    if scheduler is None:
        cluster = LocalCluster(
            n_workers=jobs, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50
        )
        address: LocalCluster | str = cluster
    else:
        cluster, address = None, scheduler
    try:
        with Client(address, timeout="10s") as client:
            _drain(client, waiting, done, failed, work)
    except OSError as error:
        raise BenchError(f"no Dask scheduler at {scheduler}: {error}") from error
    finally:
        if cluster is not None:
            cluster.close()


def _drain(
    client: Client,
    waiting: list[Stored],
    done: Callable[[Any, dict], None],
    failed: Callable[[Any, str], None],
    work: Callable[[Any], dict],
) -> None:
    queue = iter(waiting)
    workers = max(1, len(client.scheduler_info()["workers"]))
    owner: dict[str, Stored] = {}

    def submit() -> list:
        task = next(queue, None)
        if task is None:
            return []
        owner[task.key] = task
        return [client.submit(work, task, key=task.key, pure=False)]

    futures = as_completed([f for _ in range(workers) for f in submit()])
    for future in futures:
        task = owner.pop(future.key)
        if future.status == "finished":
            result = future.result()
            store(task, result)
            done(task, result)
        else:
            failed(task, str(future.exception()))
        for further in submit():
            futures.add(further)
