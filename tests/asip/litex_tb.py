# SPDX-License-Identifier: Apache-2.0
"""cocotb side of the LiteX system: the words that its CPU reports, started by test_litex.py.

Environment: WORDS, a JSON list of the words to expect.
"""

from __future__ import annotations

import json
import os

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, First, Timer, ValueChange

from sim.cocotb.clocked import word

PERIOD_NS = 10
LIMIT_NS = 2_000_000  # between two words


@cocotb.test()
async def the_cpu_runs_ticks__outputs_of_the_model(dut) -> None:
    dut.rst.value = 1
    Clock(dut.clk, PERIOD_NS, unit="ns").start()
    await ClockCycles(dut.clk, 5)
    dut.rst.value = 0
    found, wanted = [], json.loads(os.environ["WORDS"])
    while len(found) < len(wanted):
        await First(ValueChange(dut.count), Timer(LIMIT_NS, unit="ns"))
        assert word(dut.count) == len(found) + 1, f"the CPU reported {len(found)} words"
        found.append(word(dut.result))
    assert found == wanted
