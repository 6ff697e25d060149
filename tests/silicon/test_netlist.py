# SPDX-License-Identifier: Apache-2.0
"""Netlists of ECP5 cells against the RTL that they were made from."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from scripts.silicon import AT_WORK, BLOCKS, PROVED, TICKS, UNITS, netlist_run
from sim.rtl.build import BuildError
from sim.rtl.motion_rtl import MotionRtl
from tests.bench.faults import Fault, copy
from tests.bench.needs import needs
from tests.silicon import beside, lockstep, ticks
from tests.silicon.netlist import BUILD, make_netlist, prove_equivalent
from tests.silicon.work import WORK

pytestmark = needs("yosys")
IN_EVERY_RUN = "fp_i2f"


@pytest.mark.parametrize(
    "top",
    [
        pytest.param(top, marks=() if top == IN_EVERY_RUN else pytest.mark.full)
        for top in (*UNITS, *BLOCKS)
    ],
)
def test_netlist__of_a_module__gives_every_output_in_every_clock(top: str) -> None:
    outcome = lockstep.run(top, clocks=50_000)
    assert outcome.first is None
    assert len(outcome.still) < outcome.bits / 2, "the inputs reach the outputs"


@pytest.mark.full
@pytest.mark.parametrize(
    "top",
    [pytest.param(top, marks=() if top == IN_EVERY_RUN else pytest.mark.full) for top in PROVED],
)
def test_netlist__of_a_unit__is_proved_equal_by_induction(top: str) -> None:
    proved, points = prove_equivalent(top)
    assert points > 50 and proved == points


def planted(number: int, file: str, breaks: str, right: str, wrong: str) -> Path:
    """RTL with a fault, in a folder of its own."""
    fault = Fault(number=number, file=file, breaks=breaks, right=right, wrong=wrong, found=())
    folder = BUILD / f"planted-{number}"  # Yosys does not see the folders of pytest
    shutil.rmtree(folder, ignore_errors=True)
    return copy(folder / "rtl", [fault])


@pytest.fixture(scope="module")
def faulty() -> Path:
    """RTL with the round bit of a conversion taken from one place too low."""
    bits = ".round_i  (normal_e2_q[6])", ".round_i  (normal_e2_q[5])"
    return planted(1, "fpu/fp_i2f.sv", "rounding of ties", *bits)


@pytest.mark.full
def test_netlist__with_a_planted_fault__differs_within_few_clocks(faulty: Path) -> None:
    outcome = lockstep.run(IN_EVERY_RUN, clocks=50_000, netlist_folders=[faulty])
    assert outcome.first is not None


@pytest.mark.full
def test_netlist__with_a_planted_fault__is_not_proved(faulty: Path) -> None:
    proved, points = prove_equivalent(IN_EVERY_RUN, [faulty])
    assert proved < points


# Outputs without which a module has not done its work.
MOVES = {
    "ethercat_slave": {"mii_tx_en_o", "mii_txd_o", "sync_o", "irq_o"},
    "drive_front_end": {"high_o", "low_o"},
    "motion_front_end": {"step_o", "direction_o", "irq_o"},
    "n2_core": {"dtcm_we_o", "avm_writedata_o", "ci_multi_start_o", "trace_value_o"},
}


@pytest.mark.full
@pytest.mark.parametrize("name", AT_WORK)
def test_netlist__at_work__gives_every_output_in_every_clock(name: str) -> None:
    outcome = beside.run(name, 2)
    assert outcome.first is None
    still = {bit.partition("[")[0] for bit in outcome.still}
    assert not still & MOVES[WORK[name].top]


FAULTS = {
    "ethercat_slave": (
        "ethercat/ecat_datagrams.sv",
        "a read and write counts as two",
        "both_last_q ? increment + 2'd2 : increment + 2'd1",
        "increment + 2'd1",
    ),
    "drive_front_end": (
        "drive/pwm_phase.sv",
        "dead time one clock short",
        "ready  = wait_q[DeadBits-1:1] == '0",
        "ready  = wait_q[DeadBits-1:1] == '0 || wait_q == DeadBits'(2)",
    ),
    "motion_front_end": (
        "motion/arc_interpolator.sv",
        "a step of both axes counts as one on the way to the end",
        "((move_p_q && move_q_q) ? 2 : 1)",
        "1",
    ),
    "n2_core_fpga1": (
        "nios/n2_core.sv",
        "a branch taken again and again is predicted as not taken: cycles alone differ",
        "counter_e_q == 2'b11 ? 2'b11 : counter_e_q + 2'b01",
        "counter_e_q + 2'b01",
    ),
    "n2_core_fpga2": (
        "nios/n2_core.sv",
        "a reader of a loaded value as its second operand waits a clock too few",
        "(late_m_q && b_in_m && !b_in_e)",
        "1'b0",
    ),
}


@pytest.mark.full
@pytest.mark.parametrize("name", FAULTS)
def test_netlist__at_work_with_a_planted_fault__differs(name: str) -> None:
    number = 2 + list(FAULTS).index(name)
    outcome = beside.run(name, 2, [planted(number, *FAULTS[name])])
    assert outcome.first is not None


@pytest.mark.full
def test_netlist__beside_an_instance_of_other_parameters__ends_the_build() -> None:
    wanted = "motion_front_end: Interpolators is not its netlist's"
    with beside.bound(WORK["motion_front_end"]), pytest.raises(BuildError, match=wanted):
        MotionRtl(interpolators=False)


def test_netlist__of_a_unit__is_made_of_cells_alone() -> None:
    netlist = make_netlist(IN_EVERY_RUN)
    assert set(netlist.cells) <= {"LUT4", "PFUMX", "L6MUX21", "CCU2C", "TRELLIS_FF"}
    assert netlist.cells["TRELLIS_FF"] > 50


@pytest.mark.full
@pytest.mark.parametrize("configuration", ["small", "fast"])
@pytest.mark.parametrize("program", ticks.PROGRAMS)
def test_netlist__of_the_core__gives_bits_and_cycles_of_whole_ticks(program, configuration) -> None:
    assert netlist_run(program, configuration, TICKS) == (TICKS, None)
