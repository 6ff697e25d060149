# SPDX-License-Identifier: Apache-2.0
"""The engine sees what it must see: tracebacks, wrong exit statuses, hangs, memory; and replays."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from random import Random

import pytest

from tests.fuzz import engine
from tests.fuzz.engine import Campaign
from tests.fuzz.mutate import mutated_arguments, mutated_json, mutated_text


def good(rng: Random) -> int:
    return rng.randrange(3)


def raises(rng: Random) -> int:
    raise ValueError("planted")


def shows(rng: Random) -> int:
    print("Traceback (most recent call last):", file=sys.stderr)
    return 1


def leaves(rng: Random) -> int:
    sys.exit(2)


def computes(rng: Random) -> int:
    while True:
        pass


def waits(rng: Random) -> int:
    time.sleep(100)
    return 0


def eats(rng: Random) -> int:
    return len(bytes(2 << 30))


def dies(rng: Random) -> int:
    os._exit(7)


@pytest.mark.quick("good-None")
@pytest.mark.parametrize(
    ("tool", "kind"),
    [
        (good, None),
        (leaves, None),
        (raises, "traceback"),
        (shows, "traceback"),
        (computes, "time"),
        (waits, "hang"),
        (eats, "memory"),
        (dies, "crash"),
        (lambda rng: 139, "status"),
        (lambda rng: "done", "status"),
    ],
)
def test_tool__with_a_planted_fault__is_reported_for_every_case(tool, kind, monkeypatch) -> None:
    monkeypatch.setattr(engine, "CPU_SECONDS", 0.3)
    monkeypatch.setattr(engine, "WALL_SECONDS", 2)
    cases = 2 if kind in ("time", "hang") else 5
    result = engine.run_campaign(Campaign("planted", 5, tool), cases, seed=1)
    assert result.cases == cases
    expected = [] if kind is None else [(case, kind) for case in range(cases)]
    assert [(failure.case, failure.kind) for failure in result.failures] == expected


def test_tool__that_always_hangs__ends_the_campaign(monkeypatch) -> None:
    monkeypatch.setattr(engine, "WALL_SECONDS", 0.2)
    result = engine.run_campaign(Campaign("planted", 500, waits), 500, seed=1)
    assert result.cases == result.count("hang") == engine.HANGS


def test_case__replayed__is_the_same_and_leaves_its_files(tmp_path: Path) -> None:
    def tool(rng: Random) -> int:
        Path("drawn").write_text(mutated_text(rng, "fadd a, b, c\nhalt\n", ["x"]))
        return 3

    campaign = Campaign("planted", 5, tool)
    assert engine.replay(campaign, 1, 4, tmp_path / "a") == 3
    engine.replay(campaign, 1, 4, tmp_path / "b")
    engine.replay(campaign, 1, 3, tmp_path / "c")
    drawn = [(tmp_path / name / "drawn").read_text() for name in "abc"]
    assert drawn[0] == drawn[1] != drawn[2]


def test_mutations__change_most_inputs_and_leave_the_original() -> None:
    text, data, arguments = "a = 1\nb = 2\n", {"a": [1, {"b": "x"}]}, ["-o", "x"]
    changed = [0, 0, 0]
    for seed in range(200):
        changed[0] += mutated_text(Random(seed), text, ["w"]) != text
        changed[1] += mutated_json(Random(seed), data) != data
        changed[2] += mutated_arguments(Random(seed), arguments, ["-h"]) != arguments
    assert data == {"a": [1, {"b": "x"}]} and arguments == ["-o", "x"]
    assert min(changed) > 100
