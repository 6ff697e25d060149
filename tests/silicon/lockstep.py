# SPDX-License-Identifier: Apache-2.0
"""A module and its netlist side by side: the same random inputs, every output in every clock."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from sim.harness.build import build_library
from sim.harness.sources import sources_of
from sim.harness.waves import load_model
from tests.bench.faults import write_if_changed
from tests.silicon.netlist import BUILD, CELL_CHECKS, ROOT, Netlist, make_netlist

HARNESS = Path(__file__).with_name("lockstep_harness.cpp")
CLOCK, RESET = "clk_i", "rst_ni"


@dataclass(frozen=True)
class Outcome:
    """first: clock of the first difference, None without one; changes: clocks in which an output
    of the module changed."""

    first: int | None
    changes: int


def wrapper(top: str, parameters: Mapping[str, int], netlist: Netlist) -> str:
    """SystemVerilog text of a module with both in it."""
    inputs: list[str] = []
    outputs: list[str] = []
    pins = {CLOCK: CLOCK, RESET: RESET}
    at = {"input": 0, "output": 0}
    for name, (direction, bits) in netlist.ports.items():
        if name in pins:
            continue
        place = f"[{at[direction]}+:{bits}]"
        (inputs if direction == "input" else outputs).append(f".{name}(%s{place})")
        at[direction] += bits
    given = ", ".join(f".{name}({value})" for name, value in parameters.items())

    def instance(module: str, values: str, result: str) -> str:
        clock = [f".{name}({name})" for name in pins if name in netlist.ports]
        ports = [*clock, *(p % "stimulus_i" for p in inputs), *(p % result for p in outputs)]
        return f"  {module} {values} u_{result} ({', '.join(ports)});\n"

    high = at["output"] - 1
    return (
        f"module lockstep_{top} (input logic {CLOCK}, {RESET}, "
        f"input logic [{max(at['input'], 65) - 1}:0] stimulus_i, "
        "output logic differs_o, changes_o);\n"
        f"  logic [{high}:0] rtl, netlist, before_q;\n"
        + instance(top, f"#({given})" if given else "", "rtl")
        + instance(netlist.module, "", "netlist")
        + f"  always_ff @(posedge {CLOCK}) before_q <= rtl;\n"
        "  assign differs_o = rtl != netlist;\n"
        "  assign changes_o = rtl != before_q;\n"
        "endmodule\n"
    )


def run(
    top: str,
    parameters: Mapping[str, int] | None = None,
    clocks: int = 100_000,
    seed: int = 1,
    netlist_folders: Sequence[Path] = (ROOT / "rtl",),
) -> Outcome:
    """Compare `top` with its netlist, made from `netlist_folders`. Raises NetlistError."""
    parameters = dict(parameters or {})
    netlist = make_netlist(top, parameters, f"{top}_netlist", netlist_folders)
    text = BUILD / f"lockstep_{netlist.verilog.parent.name}.sv"
    write_if_changed(text, wrapper(top, parameters, netlist))
    # A pair without the checks of simulation: random inputs are no protocol.
    library = build_library(
        f"lockstep_{top}",
        [*sources_of(top), *netlist.sources, text],
        HARNESS,
        defines={"SYNTHESIS": ""},
        harness_flags=(f"-DMODEL=Vlockstep_{top}", f"-I{ROOT / 'sim/harness'}"),
        model_flags=CELL_CHECKS,
    )
    lib = load_model(library)
    widths = [
        bits
        for name, (direction, bits) in netlist.ports.items()
        if direction == "input" and name not in (CLOCK, RESET)
    ]
    changes = ctypes.c_uint64()
    lib.lockstep_run.restype = ctypes.c_int64
    first = lib.lockstep_run(
        ctypes.c_uint64(seed),
        ctypes.c_uint64(clocks),
        ctypes.c_uint32(len(widths)),
        (ctypes.c_uint32 * len(widths))(*widths),
        ctypes.byref(changes),
    )
    return Outcome(None if first < 0 else first, changes.value)
