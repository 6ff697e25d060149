# SPDX-License-Identifier: Apache-2.0
"""cocotb side of the tracking law in four states: plain Verilog in Icarus, which knows X.

No register has a value at power-up. From the end of the reset on, no control output may be X, and
no word that is written or read. Words are those of the instruction-set model, whose sines are the
hardware's, at most 1 ulp off. Environment: PROGRAM, TICKS.
"""

from __future__ import annotations

import os

import cocotb

from sim.cocotb.asip import Asip
from sim.cocotb.clocked import word
from sim.core.iss.core import Iss
from sim.core.iss.path import preset
from sim.robot.parameters import Robot
from sim.robot.records import COUNTS, SET_POINTS
from tests.asip.core_bench import rtl_sincos
from tests.asip.tracking_path import reversing_path
from tests.bench.seed import SEED
from tests.silicon.ticks import PROGRAMS, ROOT

CONTROL = ("waitrequest_o", "irq_o", "trace_issue_o", "trace_write_o")
LANES = 3  # of a bundle; the third one also writes outputs


class Watch:
    """Counts clocks and written words; raises AssertionError at the first X in one of them."""

    def __init__(self, core: Asip) -> None:
        self.core, self.clocks, self.words = core, 0, 0
        cocotb.start_soon(self._watch())

    async def _watch(self) -> None:
        dut = self.core.dut
        while True:
            await self.core.next()
            await self.core.settle()
            self.clocks += 1
            for name in CONTROL:
                word(getattr(dut, name))
            write = word(dut.trace_write_o)
            lanes = write & 3 | (write >> 2 & 1 | write >> 3) << 2
            data, index = str(dut.trace_data_o.value), str(dut.trace_index_o.value)
            for lane in range(LANES):
                if lanes >> lane & 1:
                    self.words += 1
                    at = LANES - 1 - lane
                    bits = data[32 * at :][:32] + index[6 * at :][:6]
                    assert set(bits) <= {"0", "1"}, f"clock {self.clocks}, lane {lane}: {bits}"


@cocotb.test()
async def law__in_four_states__has_the_words_of_the_model_and_no_x(dut):
    robot, count = Robot.load(), int(os.environ["TICKS"])
    path, counts = reversing_path(robot, max(count, 600))
    core = Asip(dut, seed=SEED)
    await core.reset()
    watch = Watch(core)
    image = await core.load(ROOT / f"asip_asm/programs/{os.environ['PROGRAM']}.s")
    begun = preset(image.to_json(), robot, counts[0].tolist())
    await core.preset(begun)
    model = Iss(image.to_json(), sincos=rtl_sincos)
    model.set_state(begun)
    for tick in range(count):
        inputs = dict(zip(SET_POINTS, path.words()[tick].tolist(), strict=True))
        inputs |= dict(zip(COUNTS, counts[tick].tolist(), strict=True))
        model.set_inputs(inputs)
        want, got = model.run(), await core.tick(**inputs)
        assert (got.fault, got.cycles) == ("NONE", image.cycles)
        assert got.words == want.output_bits, f"tick {tick}"
    assert watch.clocks > count * image.cycles and watch.words > count * len(image.bundles) // 2
    assert os.environ["PROGRAM"] in PROGRAMS
    dut._log.info(f"{watch.clocks} clocks, {watch.words} words")
