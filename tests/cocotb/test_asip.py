# SPDX-License-Identifier: Apache-2.0
"""The ASIP under cocotb: the tests of asip_tb.py on both configurations and in Icarus.

Icarus simulates with four states: the monitor and the driver refuse an X on any control output.
"""

from asip_asm.isa import default_isa
from tests.cocotb import asip_tb, states_tb, stream_tb, vectors_tb
from tests.cocotb.bench import Run, one_test_each

SHAPES = {
    name: default_isa().configurations[name].parameters for name in default_isa().without_streams
}
IN_ICARUS = "^(states__|fault__output_that|fault__illegal|host__interrupts)"

RUNS = {name: Run("asip", asip_tb, "", shape) for name, shape in SHAPES.items()}
RUNS |= {f"{name}-states": Run("asip", states_tb, "", shape) for name, shape in SHAPES.items()}
SIZES = {"Words": stream_tb.WORDS, "Lanes": stream_tb.LANES - 1}
RUNS["stream"] = Run("asip_stream", stream_tb, "", SIZES)
RUNS["wide-vectors"] = Run("asip", vectors_tb, "", default_isa().configurations["wide"].parameters)

test_scenario = one_test_each(
    RUNS | {"icarus": Run("asip", asip_tb, IN_ICARUS, SHAPES["fast"], "icarus")},
    quick=("fast-*", "icarus-*", "stream-*"),
)
