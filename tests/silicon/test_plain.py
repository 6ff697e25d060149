# SPDX-License-Identifier: Apache-2.0
"""The plain Verilog of the cores: other tools parse it, and it does what the RTL does."""

from __future__ import annotations

import subprocess

import pytest

from scripts.plain_verilog import CORES
from sim.harness.asip_rtl import AsipRtl
from tests.bench.needs import needs
from tests.silicon import lockstep, ticks
from tests.silicon.netlist import make_plain
from tests.silicon.test_netlist import IN_EVERY_RUN, planted

pytestmark = needs("yosys")
QUICK = ("biss_port", "mii_to_rgmii")
BLACK_BOXES = "-i"  # Icarus ignores modules that it does not have, such as the PLL of a board


@needs("iverilog")
@pytest.mark.parametrize(
    "top", [pytest.param(top, marks=() if top in QUICK else pytest.mark.full) for top in CORES]
)
def test_plain_verilog__of_a_core__is_parsed_by_icarus_as_2001(top: str) -> None:
    plain = make_plain(top)
    command = ["iverilog", "-g2001", "-Wall", BLACK_BOXES, "-t", "null", "-s", plain.module]
    done = subprocess.run([*command, plain.verilog], capture_output=True, text=True)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


def test_plain_verilog__of_a_unit__gives_every_output_in_every_clock() -> None:
    outcome = lockstep.run(IN_EVERY_RUN, clocks=50_000, make=make_plain)
    assert outcome.first is None
    assert len(outcome.still) < outcome.bits / 2, "the inputs reach the outputs"


def test_plain_verilog__with_a_planted_fault__differs_within_few_clocks() -> None:
    bits = ".round_i  (normal_e2_q[6])", ".round_i  (normal_e2_q[5])"
    faulty = planted(101, "fpu/fp_i2f.sv", "rounding of ties", *bits)
    outcome = lockstep.run(IN_EVERY_RUN, 50_000, [faulty], make_plain)
    assert outcome.first is not None


@pytest.mark.full
@pytest.mark.parametrize("configuration", ["small", "fast"])
@pytest.mark.parametrize("program", ticks.PROGRAMS)
def test_plain_verilog__of_the_asip__gives_bits_and_cycles_of_whole_ticks(
    program: str, configuration: str
) -> None:
    cores = ticks.AsipPlain(configuration), AsipRtl(configuration)
    image = ticks.program(program, configuration)
    assert ticks.compared(image, ticks.inputs(10_000), *cores)[0] is None
