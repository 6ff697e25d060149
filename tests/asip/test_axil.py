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
def test_axil__every_scenario(configuration):
    shape = default_isa().configurations[configuration]
    folder = ROOT / "build/axil" / configuration
    folder.mkdir(parents=True, exist_ok=True)
    todo = folder / "plan.json"
    todo.write_text(json.dumps(plan(assemble(PROGRAM, configuration=configuration))))
    parameters = {"FmaPipes": shape.fma_pipes, "Slots": len(shape.slots)}
    environment = {"AXIL_PLAN": str(todo)}
    run_scenarios("asip_axil", SOURCES, BENCH, folder, parameters, environment)


@pytest.mark.parametrize("parameters", [(), ("-GFmaPipes=1", "-GSlots=1")])
def test_axil__lint(parameters):
    command = [verilator_driver(), "--lint-only", "-Wall", "--quiet", "--top-module", "asip_axil"]
    command += [*parameters, WAIVERS, *SOURCES]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
