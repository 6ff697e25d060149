# SPDX-License-Identifier: Apache-2.0
"""The plain Verilog of the cores: other tools parse it, and it does what the RTL does."""

from __future__ import annotations

import pytest

from scripts.plain_goals import AT_WORK, in_four_states, parsed
from scripts.plain_verilog import CORES
from tests.bench.needs import needs
from tests.silicon import beside, lockstep
from tests.silicon.netlist import make_plain
from tests.silicon.test_netlist import IN_EVERY_RUN, planted
from tests.silicon.ticks import PROGRAMS
from tests.silicon.work import PLAIN_WORK

pytestmark = needs("yosys")
SMALL = ("biss_port", "mii_to_rgmii")  # of quick models


@needs("iverilog")
@pytest.mark.parametrize(
    "top", [pytest.param(top, marks=() if top in SMALL else pytest.mark.full) for top in CORES]
)
def test_plain_verilog__of_a_core__is_parsed_by_icarus_as_2001(top: str) -> None:
    assert parsed(top)


@pytest.mark.parametrize("module", [IN_EVERY_RUN, pytest.param(SMALL[0], marks=pytest.mark.full)])
def test_plain_verilog__of_a_module__gives_every_output_in_every_clock(module: str) -> None:
    outcome = lockstep.run(module, clocks=50_000, make=make_plain)
    assert outcome.first is None
    assert len(outcome.still) < outcome.bits / 2, "the inputs reach the outputs"


def test_plain_verilog__with_a_planted_fault__differs_within_few_clocks() -> None:
    bits = ".round_i  (normal_e2_q[6])", ".round_i  (normal_e2_q[5])"
    faulty = planted(101, "fpu/fp_i2f.sv", "rounding of ties", *bits)
    outcome = lockstep.run(IN_EVERY_RUN, 50_000, [faulty], make_plain)
    assert outcome.first is not None


def test_work__is_there_for_every_core() -> None:
    assert {work.top for work in PLAIN_WORK.values()} == set(CORES)
    assert set(AT_WORK) == set(PLAIN_WORK)


@pytest.mark.full
@pytest.mark.parametrize("name", PLAIN_WORK)
def test_plain_verilog__at_work__gives_every_output_in_every_clock(name: str) -> None:
    outcome = beside.run(name, 2, plain=True)
    assert outcome.first is None
    assert len(outcome.still) < outcome.bits, "the work moves outputs"


@pytest.mark.full
def test_plain_verilog__at_work_with_a_planted_fault__differs() -> None:
    lines = "missed_q <= (missed_q && !clear)", "missed_q <= missed_q"
    faulty = planted(
        102, "drive/absolute_registers.sv", "a dropped request is never cleared", *lines
    )
    assert beside.run("biss_port", 1, [faulty], plain=True).first is not None


@needs("iverilog")
def test_law__in_icarus__has_no_x_and_the_words_of_the_model() -> None:
    in_four_states(PROGRAMS[1], 2)
