# SPDX-License-Identifier: Apache-2.0
"""Shards of injections as tasks of the campaign runner (sim/core/fpbench/campaign.py)."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.project import BUILD
from sim.report.cache import fingerprint
from tests.upsets.model import EFFECTS, LATER, PROGRAM, Model, NetlistModel
from tests.upsets.plan import KINDS, SHARD, Kind, block_of, draw, line_of

STORE = BUILD / "upsets/shards"
NETLIST = "netlist"
CORES: dict[str, tuple[type[Model], bool]] = {
    "plain": (Model, False),
    "resilient": (Model, True),
    NETLIST: (NetlistModel, True),
}
"""Name of a core -> kind of its model, whether it has the parameter Resilience."""
SHARDS = {
    "quick": {"plain": 10, "resilient": 10},
    "full": {"plain": 44, "resilient": 44, NETLIST: 8},
}
"""Shards of each core; a netlist's are of flip-flops alone: its memories are those of the RTL."""
IDLE = 1300
"""Clocks between ticks in which the sweep comes to its end (a period of 100 us has 12 500)."""
SWEPT, SWEPT_OF_SHARD = ("program memory in use", "bank K in use"), 100
WRONG = ("wrong once", "wrong later")


@dataclass(frozen=True)
class Task:
    """A shard of one kind of place, of one core."""

    core: str
    kind: str
    shard: int
    fingerprint: str

    @property
    def key(self) -> str:
        """Its name among the tasks of a cluster."""
        return f"{self.core}-{self.kind}-{self.shard}-{self.fingerprint}"

    @property
    def path(self) -> Path:
        """Where its result belongs."""
        words = self.kind.replace(",", "").replace(" ", "_")
        return STORE / self.core / f"{words}-{self.shard}.json"


@functools.cache
def model_of(core: str) -> Model:
    """The core's model, made once per process."""
    kind, resilient = CORES[core]
    return kind(resilient)


def fingerprint_of(core: str) -> str:
    """Changes with everything that a result depends on: RTL, harness, program, plan."""
    here = Path(__file__)
    files = (PROGRAM, here.with_name("plan.py"), here.with_name("model.py"))
    return fingerprint(files, model_of(core).build)


def tasks_of(core: str, depth: str) -> Iterator[Task]:
    """Every shard of a core, dealt to the kinds by their shares."""
    current = fingerprint_of(core)
    shards = SHARDS[depth][core]
    parts = {kind: max(1, round(kind.share * shards)) for kind in KINDS}
    for kind, part in ({KINDS[0]: shards} if core == NETLIST else parts).items():
        for shard in range(part):
            yield Task(core, kind.name, shard, current)


def cost() -> dict[str, int]:
    """Clocks of the core in a tick: {core: cycles}."""
    return {core: model_of(core).cycles for core in ("plain", "resilient")}


def memory_ticks(shards: int) -> dict[str, int]:
    """Flipped bits of program memory and bank K, on the resilient core with `IDLE` clocks between
    ticks, time for its sweep: how many were found, and most ticks after that of the upset.

    {"injections", "found", "ticks"}: a bit of the program stays as a stuck one does, until the host
    loads again.
    """
    model = Model(True, IDLE)
    found, n, ticks = 0, 0, 0
    for kind in (each for each in KINDS if each.name in SWEPT):
        for shard in range(shards):
            outcomes = model.inject(draw(model, kind, shard)[:SWEPT_OF_SHARD])
            reported = outcomes["effect"] == EFFECTS.index("fault reported")
            harmless = outcomes["effect"] == EFFECTS.index("masked")  # an input, written again
            n += len(outcomes)
            found += int(np.sum(reported | harmless))
            ticks = max(ticks, int(outcomes["ticks"].max()))
    return {"injections": n, "found": found, "ticks": ticks}


def execute(task: Task) -> dict:
    """Inject one shard (in a worker): counts by block and effect, each case that is not masked."""
    model = model_of(task.core)
    if fingerprint_of(task.core) != task.fingerprint:
        raise RuntimeError("the core changed after the campaign began; start it again")
    kind: Kind = next(kind for kind in KINDS if kind.name == task.kind)
    upsets = draw(model, kind, task.shard)
    outcomes = model.inject(upsets)
    counts: dict[str, dict[str, int]] = {}
    for upset, outcome in zip(upsets, outcomes, strict=True):
        block = kind.name if kind.memory else block_of(model.sites[upset["site"]].place)
        row = counts.setdefault(block, dict.fromkeys(EFFECTS, 0))
        row[EFFECTS[outcome["effect"]]] += 1
    wrong = np.isin(outcomes["effect"], [EFFECTS.index(effect) for effect in WRONG])
    bad = wrong | (outcomes["effect"] >= EFFECTS.index("run lost"))
    return {
        "core": task.core,
        "kind": task.kind,
        "later": LATER,
        "injections": SHARD,
        "unsafe": int(outcomes["unsafe"].sum()),
        "counts": counts,
        "causes": {
            str(cause): int(np.sum(outcomes["cause"] == cause))
            for cause in np.unique(outcomes["cause"])
            if cause
        },
        "cases": [
            {
                "replay": line_of(model.sites, upsets[i]),
                "effect": EFFECTS[outcomes["effect"][i]],
                "error": float(outcomes["worst"][i]),
            }
            for i in np.flatnonzero(bad)
        ],
    }
