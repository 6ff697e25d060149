# SPDX-License-Identifier: Apache-2.0
"""Netlists of ECP5 cells against the RTL that they were made from."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from scripts.silicon import AT_WORK, BLOCKS, PROVED, TICKS, UNITS, netlist_run
from tests.bench.faults import Fault, copy
from tests.bench.needs import needs
from tests.silicon import beside, lockstep, ticks
from tests.silicon.netlist import BUILD, make_netlist, prove_equivalent

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


def test_netlist__with_a_planted_fault__differs_within_few_clocks(faulty: Path) -> None:
    outcome = lockstep.run(IN_EVERY_RUN, clocks=50_000, netlist_folders=[faulty])
    assert outcome.first is not None


def test_netlist__with_a_planted_fault__is_not_proved(faulty: Path) -> None:
    proved, points = prove_equivalent(IN_EVERY_RUN, [faulty])
    assert proved < points


@pytest.mark.full
@pytest.mark.parametrize("top", AT_WORK)
def test_netlist__at_work__gives_every_output_in_every_clock(top: str) -> None:
    outcome = beside.run(top, 2)
    assert outcome.first is None
    still = {name.partition("[")[0] for name in outcome.still}
    assert not still & {"mii_tx_en_o", "mii_txd_o", "sync_o", "irq_o", "high_o", "low_o"}


@pytest.mark.full
@pytest.mark.parametrize(
    ("top", "fault"),
    [
        (
            "ethercat_slave",
            (
                "ethercat/ecat_datagrams.sv",
                "a read and write counts as two",
                "both_last_q ? increment + 2'd2 : increment + 2'd1",
                "increment + 2'd1",
            ),
        ),
        (
            "drive_front_end",
            (
                "drive/pwm_phase.sv",
                "dead time one clock short",
                "ready  = wait_q[DeadBits-1:1] == '0",
                "ready  = wait_q[DeadBits-1:1] == '0 || wait_q == DeadBits'(2)",
            ),
        ),
    ],
)
def test_netlist__at_work_with_a_planted_fault__differs(top: str, fault: tuple[str, ...]) -> None:
    outcome = beside.run(top, 2, [planted(2, *fault)])
    assert outcome.first is not None


def test_netlist__of_a_unit__is_made_of_cells_alone() -> None:
    netlist = make_netlist(IN_EVERY_RUN)
    assert set(netlist.cells) <= {"LUT4", "PFUMX", "L6MUX21", "CCU2C", "TRELLIS_FF"}
    assert netlist.cells["TRELLIS_FF"] > 50


@pytest.mark.full
@pytest.mark.parametrize("configuration", ["small", "fast"])
@pytest.mark.parametrize("program", ticks.PROGRAMS)
def test_netlist__of_the_core__gives_bits_and_cycles_of_whole_ticks(program, configuration) -> None:
    assert netlist_run(program, configuration, TICKS) == (TICKS, None)
