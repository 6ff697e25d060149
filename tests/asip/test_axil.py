# SPDX-License-Identifier: Apache-2.0
"""AXI4-Lite port `asip_axil`: lint, and the cocotb scenarios of axil_tb.py on a small program.

Replay of one scenario: `SEED=n SCENARIO=name pytest tests/asip/test_axil.py`. Expected words come
from the instruction-set model.
"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from asip_asm.assemble import assemble
from asip_asm.isa import default_isa
from sim.core.iss.core import Iss
from sim.rtl.asip_bus import BLOCK, load_words
from sim.rtl.build import ROOT, WAIVERS, file_list, verilator_driver
from tests.bus.axil import run_scenarios

SOURCES = file_list("asip/asip.f")
SOURCES += [ROOT / "rtl/bus/axil_bridge.sv", ROOT / "rtl/asip/asip_axil.sv"]
BENCH = Path(__file__).with_name("axil_tb.py")
PROGRAM = ROOT / "sim/core/host/leg_length.s"
HEADER = """.program "weights"
.config {configuration}
.input x, y, z
.input counter : int
.output sum, safe = 0.0
"""
WEIGHTED = {
    "stream": """.stream W, pin A = 0.5, -2.0, 4.0
        seek W
        fmul s, W+, x
        fmadd t, W+, y, s
        fmadd sum_of, W+, z, t
        mov sum, sum_of
        halt
""",
    "wide": """.vectors W, pin B = 0.5, -2.0, 4.0, 8.0, 1.0, 3.0, -1.5, 0.25
        seek W
        vfmul v, W+, x
        vfmadd w, W+, y, v
        vout sum_of, z, w, 2
        mov sum, sum_of
        halt
""",
}
"""Programs that need what a configuration has more than `fast`: a stream, and lanes."""
TICKS = ((3.0, 0.5, 4.0, 7), (-1.5, 2.25, 0.125, -12), (1e-3, 0.0, 1e3, 40000))


def plan(image) -> dict:
    """Words to write, words to expect (instruction-set model), for axil_tb.py."""
    model, ticks = Iss(image.to_json()), []
    for tick in TICKS:
        values = dict(zip(("x", "y", "z", "counter"), tick, strict=True))
        words = [*np.array(tick[:3], np.float32).view(np.uint32).tolist(), tick[3] & 0xFFFFFFFF]
        model.set_inputs(values)
        result = model.run()
        assert result.fault.name == "NONE"
        outputs = [(BLOCK["outputs"] + o.index, result.output_bits[o.name]) for o in image.outputs]
        inputs = [BLOCK["constants"] + entry.index for entry in image.inputs]
        ticks.append({"inputs": list(zip(inputs, words, strict=True)), "outputs": outputs})
    return {"load": list(load_words(image)), "ticks": ticks, "data": BLOCK["data"]}


@pytest.mark.quick("fast")
@pytest.mark.parametrize("configuration", default_isa().configurations)
def test_axil__every_scenario(configuration):
    folder = ROOT / "build/axil" / configuration
    folder.mkdir(parents=True, exist_ok=True)
    todo = folder / "plan.json"
    program = PROGRAM
    if configuration in WEIGHTED:
        program = folder / "weights.s"
        program.write_text(HEADER.format(configuration=configuration) + WEIGHTED[configuration])
    todo.write_text(json.dumps(plan(assemble(program, configuration=configuration))))
    parameters = default_isa().configurations[configuration].parameters
    environment = {"AXIL_PLAN": str(todo)}
    run_scenarios("asip_axil", SOURCES, BENCH, folder, parameters, environment)


@pytest.mark.parametrize("configuration", default_isa().configurations)
def test_axil__lint(configuration):
    command = [verilator_driver(), "--lint-only", "-Wall", "--quiet", "--top-module", "asip_axil"]
    parameters = default_isa().configurations[configuration].parameters
    command += [*(f"-G{name}={value}" for name, value in parameters.items()), WAIVERS, *SOURCES]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
