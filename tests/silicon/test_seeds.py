# SPDX-License-Identifier: Apache-2.0
"""Seeds of place and route as tasks of the campaign runner, with a substitute for its cluster."""

from __future__ import annotations

import json

import pytest

from scripts import synth_unit
from scripts.synth_unit import Placement, SynthesisError
from sim.core.fpbench import campaign
from sim.report import cache


@pytest.fixture
def runs(monkeypatch):
    """Seeds that were run, in order; 13 has no route. Tasks run here, results are stored."""
    made: list[int] = []

    def run_tool(tool, arguments, log):
        seed = int(arguments[list(arguments).index("--seed") + 1])
        made.append(seed)
        if seed == 13:
            raise SynthesisError("no route")
        report = arguments[list(arguments).index("--report") + 1]
        with open(report, "w") as file:
            json.dump({"seed": seed}, file)

    def run(tasks, done, failed, jobs, scheduler=None, work=None):
        for task in tasks:
            try:
                result = work(task)
            except SynthesisError as error:
                failed(task, str(error))
            else:
                cache.save(task, result)
                done(task, result)

    monkeypatch.setattr(synth_unit, "_run", run_tool)
    monkeypatch.setattr(campaign, "run", run)
    return made


def placements(folder, *seeds, netlist="text"):
    (folder / "netlist.json").write_text(netlist)
    return [
        Placement(folder / "netlist.json", ("--seed", str(n)), folder / f"seed{n}.json")
        for n in seeds
    ]


def test_seeds__of_a_campaign_that_stopped__are_not_run_again(runs, tmp_path):
    assert [r["seed"] for r in synth_unit._place_and_route(placements(tmp_path, 1, 2), 1)] == [1, 2]
    reports = synth_unit._place_and_route(placements(tmp_path, 1, 2, 3), 2)
    assert [r["seed"] for r in reports] == [1, 2, 3]
    assert runs == [1, 2, 3]


def test_seeds__of_another_netlist__are_run_again(runs, tmp_path):
    synth_unit._place_and_route(placements(tmp_path, 1), 1)
    synth_unit._place_and_route(placements(tmp_path, 1, netlist="other"), 1)
    assert runs == [1, 1]


def test_seeds__one_that_fails__is_an_error_and_the_others_stay(runs, tmp_path):
    with pytest.raises(SynthesisError, match="no route"):
        synth_unit._place_and_route(placements(tmp_path, 1, 13), 1)
    synth_unit._place_and_route(placements(tmp_path, 1), 1)
    assert runs == [1, 13]
