# SPDX-License-Identifier: Apache-2.0
"""Goals of the plain Verilog: Icarus parses it, it equals the RTL, and no X leaves the core."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from asip_asm.isa import default_isa
from asip_asm.project import ROOT
from scripts.plain_verilog import CORES, FOLDER, write_plain
from scripts.silicon import outcome_of
from sim.cocotb.runner import Simulation, outcomes
from sim.report.goals import Goal, exactly, not_measured
from sim.rtl.sources import sources_of
from tests.silicon import beside, four_states_tb
from tests.silicon.netlist import NetlistError
from tests.silicon.ticks import PROGRAMS
from tests.silicon.work import PLAIN_WORK

TICKS, ICARUS_TICKS = 10_000, 100
SCENARIOS = (1, "run of its tests")
BOARD = (100, "turns of an encoder, with a program and steps over the serial port")
# How much each core does next to its plain Verilog, by the names of PLAIN_WORK.
AT_WORK = {
    "asip": (TICKS, "ticks of each tracking program"),
    "asip_small": (TICKS, "ticks of each tracking program"),
    "asip_de3": (1000, "ticks of each tracking program"),
    "asip_ecp5": BOARD,
    "asip_ulx3s": BOARD,
    "asip_colorlight_i9": BOARD,
    "asip_ecpix5": BOARD,
    "asip_versa_ecp5": BOARD,
    "asip_lockstep": (1000, "ticks of each tracking program"),
    "asip_axil": SCENARIOS,
    "motion_axil": SCENARIOS,
    "n2_core": (1000, "ticks of the tracking law in C"),
    "n2_system": (1000, "ticks of the tracking law in C"),
    "dual_asip": SCENARIOS,
    "debug_asip": SCENARIOS,
    "drive_front_end": (10, "control periods"),
    "ethercat_slave": (300, "chains of datagrams"),
    "mii_to_rgmii": SCENARIOS,
    "ethercat_nios": (200, "control ticks with a frame each"),
    "drive_chain": (10, "control periods"),
    "biss_port": SCENARIOS,
    "ssi_port": SCENARIOS,
    "endat_port": SCENARIOS,
    "absolute_position": SCENARIOS,
    "sincos_position": SCENARIOS,
    "hall_decoder": SCENARIOS,
}
# What an outcome depends on besides the RTL of its top: the comparison and the table of works.
# Other tests or programs give other work, but RTL and plain Verilog that were equal stay equal.
COMPARATOR = (
    *(
        ROOT / f"tests/silicon/{name}.py"
        for name in ("beside", "lockstep", "netlist", "ticks", "work")
    ),
    Path(write_plain.__code__.co_filename),
)
PARSED = "tops whose plain Verilog-2001 Icarus parses"
EQUAL = "tops whose plain Verilog equals the RTL in every clock of their work"
FOUR_STATES = "ticks of both programs in Icarus without an X and with the words of the model"
CURE = 'make goals T="hardware plain" RUN=full'


def parsed(top: str) -> bool:
    """Whether Icarus parses the plain Verilog of a top without a message. Raises PlainError."""
    file = FOLDER / f"{top}.v"
    write_plain(top, file)
    # -i: modules that are not there, such as the PLL of a board, are ignored.
    command = ["iverilog", "-g2001", "-Wall", "-i", "-t", "null", "-s", top, str(file)]
    done = subprocess.run(command, capture_output=True, text=True)
    return done.returncode == 0 and not done.stdout + done.stderr


def in_four_states(program: str, count: int) -> None:
    """So many ticks of a program in Icarus, on the plain Verilog of the core.

    Raises AssertionError where a word differs from the model's or is X.
    """
    shape = default_isa().configurations["fast"]
    parameters = {"FmaPipes": shape.fma_pipes, "Slots": len(shape.slots)}
    simulation = Simulation("asip", parameters=parameters, sim="icarus")
    environment = {"PROGRAM": program, "TICKS": str(count)}
    found = outcomes(simulation.run(four_states_tb.__name__, environment))
    assert found and not any(found.values()), found


def differing(top: str) -> list[str]:
    """What is wrong at the works of a top, empty if its plain Verilog equals the RTL."""
    wrong = []
    for name, work in PLAIN_WORK.items():
        if work.top != top:
            continue
        count = AT_WORK[name][0]
        try:
            key = f"{name}-plain-{count}"
            compare = partial(beside.run, name, count, plain=True)
            outcome = outcome_of(key, compare, (*sources_of(top), *COMPARATOR))
        except NetlistError as error:
            wrong.append(f"{name}: {str(error).splitlines()[0]}")
            continue
        if outcome.first is not None:
            wrong.append(f"{name} differs at clock {outcome.first}")
        elif len(outcome.still) == outcome.bits:
            wrong.append(f"{name}: no output changed")
    return wrong


def rows(full: bool) -> Iterator[Goal]:
    """The goals, with `full` only: the models of all tops take an hour to build."""
    if shutil.which("iverilog") is None or not full:
        cure = CURE if shutil.which("iverilog") else f"install iverilog, then {CURE}"
        for name in (PARSED, EQUAL):
            yield not_measured(name, f"{len(CORES)}", "tops", cure)
        yield not_measured(FOUR_STATES, f"{ICARUS_TICKS}", "ticks", cure)
        return
    yield exactly(PARSED, sum(map(parsed, CORES)), len(CORES), "tops")
    wrong = {top: differing(top) for top in CORES}
    note = "; ".join(text for found in wrong.values() for text in found)
    equal = sum(not found for found in wrong.values())
    yield exactly(EQUAL, equal, len(CORES), "tops", note or f"{TICKS} ticks of the ASIP")
    for program in PROGRAMS:
        in_four_states(program, ICARUS_TICKS)
    yield exactly(FOUR_STATES, ICARUS_TICKS, ICARUS_TICKS, "ticks")
