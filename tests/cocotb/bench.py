# SPDX-License-Identifier: Apache-2.0
"""cocotb benches as pytest tests: each `@cocotb.test()` of a bench is one result.

    RUNS = {"fp_mul": Run("fp_mul", unit_tb, only="fp_mul")}
    test_scenario = one_test_each(RUNS)

A run is built and simulated when the first of its tests is requested.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import pytest

from sim.cocotb.runner import Simulation, outcomes
from sim.rtl.build import ROOT
from tests.bench.needs import needs
from tests.bench.seed import SEED

FOLDER = ROOT / "build/cocotb"


@dataclass(frozen=True)
class Run:
    """Tests of a bench whose names match `only`, on `top` with parameters, in a simulator."""

    top: str
    bench: ModuleType
    only: str = ""
    parameters: Mapping[str, int] = field(default_factory=dict)
    sim: str = "verilator"

    def names(self) -> list[str]:
        """Names of the tests, as in the results file."""
        tests = (
            test
            for found in vars(self.bench).values()
            if hasattr(found, "generate_tests")
            for test in found.generate_tests()
        )
        return [test.name for test in tests if re.search(self.only, test.name)]

    def start(
        self, simulation: Simulation, plusargs: Sequence[str] = (), **environment: str
    ) -> Path:
        """Run the tests on a build; returns the file of the results."""
        wanted = "|".join(map(re.escape, self.names()))
        bins = simulation.folder / "bins.txt"
        bins.write_text("", encoding="utf-8")
        environment = {"SEED": str(SEED), "BINS": str(bins), **environment}
        return simulation.run(
            self.bench.__name__, environment, test_filter=f"({wanted})$", plusargs=list(plusargs)
        )


_found: dict[str, dict[str, str] | Exception] = {}


def simulated(name: str, run: Run) -> dict[str, str]:
    """Outcome of every test of a run, simulated once. Raises what the simulation raised."""
    if name not in _found:
        try:
            _found[name] = _simulate(name, run)
        except Exception as error:
            _found[name] = error
    found = _found[name]
    if isinstance(found, Exception):
        raise found
    return found


def _simulate(name: str, run: Run) -> dict[str, str]:
    simulation = Simulation(run.top, folder=FOLDER / name, parameters=run.parameters, sim=run.sim)
    return outcomes(run.start(simulation))


def one_test_each(runs: Mapping[str, Run], quick: Sequence[str] = ("*",)) -> Callable[..., None]:
    """A parametrised pytest function with one case for each test of each run.

    `make test` runs the cases that match a pattern of `quick`.
    """
    cases = []
    for name, run in runs.items():
        marks = [needs("iverilog", "yosys")] if run.sim == "icarus" else []
        cases += [
            pytest.param(name, test, id=f"{name}-{test}", marks=marks) for test in run.names()
        ]

    @pytest.mark.quick(*quick)
    @pytest.mark.parametrize(("run", "test"), cases)
    def test_scenario(run: str, test: str) -> None:
        found = simulated(run, runs[run])
        assert set(found) == set(runs[run].names())
        log = FOLDER / run / "log.txt"
        assert not found[test], f"{found[test]}\nSEED={SEED}; log: {log}"

    return test_scenario
