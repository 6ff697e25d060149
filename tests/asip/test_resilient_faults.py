# SPDX-License-Identifier: Apache-2.0
"""The core with redundancy: no two of three runs the same, and what a third run repairs."""

from __future__ import annotations

import numpy as np
import pytest

from sim.rtl.asip_bus import BLOCK, CSR, FAULT_NAMES, START, STATUS
from tests.asip import core_bench as bench
from tests.asip import resilient_bench

# Data memory is outside of the redundancy: a run that changes it makes the next one differ.
COUNTING = """\
.program "runs counted in data memory, up to most"
.data    runs = 0.0
.input   most
.const   one = 1.0
.output  F, safe = 7.5
        ld    before, runs[zero]
        fadd  next, before, one
        fmin  now, next, most
        st    now, runs[zero]
        mov   F, now
        halt
"""
ENDLESS = 1e9
OUTPUT = BLOCK["outputs"]


@pytest.fixture
def core():
    dut = resilient_bench.core()
    dut.reset()
    dut.load(bench.assembled(COUNTING, "fast"))
    return dut


def tick(core, most: float) -> tuple[str, int, float]:
    """(fault, repaired, output) of a tick."""
    result = core.run(core.input_addresses(["most"]), np.array([[most]], np.float32), [OUTPUT])
    status = int(result.status[0])
    return result.fault, STATUS["repaired"].of(status), float(result.words.view(np.float32)[0, 0])


def test_third_run__as_the_second__counts_and_says_so(core):
    assert tick(core, 1.0) == ("NONE", 1, 1.0)  # what was read differs: 0, 1, 1
    assert tick(core, 1.0) == ("NONE", 0, 1.0)


def test_three_runs__no_two_alike__is_the_fault_disagree(core):
    assert tick(core, 1.0) == ("NONE", 1, 1.0)
    assert tick(core, ENDLESS) == ("DISAGREE", 0, 7.5)
    core.write(CSR["CONTROL"], START)
    core.clock(1000)
    status = core.read(CSR["STATUS"])
    assert FAULT_NAMES[STATUS["cause"].of(status)] == "DISAGREE", "a faulted core started"
    assert core.read(OUTPUT) == int(np.float32(7.5).view(np.uint32)) and core.irq


def test_disagree__cleared_and_loaded__runs_again(core):
    assert tick(core, ENDLESS)[0] == "DISAGREE"
    core.load(core.image)
    assert tick(core, 1.0) == ("NONE", 1, 1.0)
