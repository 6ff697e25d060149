# SPDX-License-Identifier: Apache-2.0
"""A module and its netlist side by side: the same random inputs, every output in every clock."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from sim.rtl.build import build_library
from sim.rtl.sources import sources_of
from sim.rtl.waves import load_model
from tests.bench.faults import write_if_changed
from tests.silicon.netlist import BUILD, MODEL_FLAGS, ROOT, Netlist, make_netlist

HARNESS = Path(__file__).with_name("lockstep_harness.cpp")
CLOCK, RESET = "clk_i", "rst_ni"
SEED = 1


@dataclass(frozen=True)
class Outcome:
    """first: clock of the first difference, None without one; bits: of all outputs; still: those
    that never changed, so that nothing is known of them."""

    first: int | None
    bits: int
    still: tuple[str, ...]


def output_bits(netlist: Netlist) -> list[str]:
    """Every bit of the outputs, in the order in which they follow each other."""
    return [
        f"{name}[{n}]"
        for name, (direction, bits) in netlist.ports.items()
        if direction == "output"
        for n in range(bits)
    ]


def still_bits(netlist: Netlist, moved: int) -> tuple[str, ...]:
    """Bits of the outputs that are 0 in `moved`."""
    return tuple(name for n, name in enumerate(output_bits(netlist)) if not moved >> n & 1)


def wrapper(top: str, netlist: Netlist) -> str:
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

    def instance(module: str, result: str) -> str:
        clock = [f".{name}({name})" for name in pins if name in netlist.ports]
        ports = [*clock, *(p % "stimulus_i" for p in inputs), *(p % result for p in outputs)]
        return f"  {module} u_{result} ({', '.join(ports)});\n"

    high = at["output"] - 1
    wide = max(at["output"], 65) - 1  # an array of words in C++
    return (
        f"module lockstep_{top} (input logic {CLOCK}, {RESET}, "
        f"input logic [{max(at['input'], 65) - 1}:0] stimulus_i, "
        f"output logic differs_o, output logic [{wide}:0] moved_o);\n"
        f"  logic [{high}:0] rtl, netlist, before_q, moved_q;\n"
        "  logic begun_q;\n"
        + instance(top, "rtl")
        + instance(netlist.module, "netlist")
        + f"  always_ff @(posedge {CLOCK}) begin\n"
        "    before_q <= rtl;\n"
        f"    begun_q <= {RESET};\n"
        "    moved_q <= begun_q ? moved_q | rtl ^ before_q : '0;\n"
        "  end\n"
        "  assign differs_o = rtl != netlist;\n"
        f"  assign moved_o = {wide + 1}'(moved_q);\n"
        "endmodule\n"
    )


def run(
    top: str,
    clocks: int,
    netlist_folders: Sequence[Path] = (ROOT / "rtl",),
    make: Callable[..., Netlist] = make_netlist,
) -> Outcome:
    """Compare `top` with its netlist, that `make` makes of `netlist_folders`.

    Raises NetlistError.
    """
    netlist = make(top, name=f"{top}_netlist", folders=netlist_folders)
    text = BUILD / f"lockstep_{netlist.verilog.parent.name}.sv"
    write_if_changed(text, wrapper(top, netlist))
    # A pair without the checks of simulation: random inputs are no protocol.
    library = build_library(
        f"lockstep_{top}",
        [*sources_of(top), *netlist.sources, text],
        HARNESS,
        defines={"SYNTHESIS": ""},
        harness_flags=(f"-DMODEL=Vlockstep_{top}", f"-I{ROOT / 'sim/rtl'}"),
        model_flags=MODEL_FLAGS,
    )
    lib = load_model(library)
    inputs = [
        width
        for name, (direction, width) in netlist.ports.items()
        if direction == "input" and name not in (CLOCK, RESET)
    ]
    bits = len(output_bits(netlist))
    moved = (ctypes.c_uint32 * -(-bits // 32))()
    lib.lockstep_run.restype = ctypes.c_int64
    first = lib.lockstep_run(
        ctypes.c_uint64(SEED),
        ctypes.c_uint64(clocks),
        ctypes.c_uint32(len(inputs)),
        (ctypes.c_uint32 * len(inputs))(*inputs),
        ctypes.c_uint32(len(moved)),
        moved,
    )
    still = still_bits(netlist, int.from_bytes(bytes(moved), "little"))
    return Outcome(None if first < 0 else first, bits, still)
