# SPDX-License-Identifier: Apache-2.0
"""A Verilated block as a function of arrays: what its inputs are, clock by clock, to its outputs.

`Accesses` makes such inputs of a host's reads and writes.

The C++ around the model is written here from the names of the ports. Inputs of a row settle before
a rising edge; outputs of the row are those just before that edge, so a register shows a change one
row later. The block starts out of reset with the first row's inputs.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from asip_asm.project import BUILD, ROOT
from asip_asm.regmap import RegisterMap
from sim.rtl.build import build_library
from sim.rtl.sources import sources_of
from sim.rtl.waves import load_model
from tests.bench.faults import write_if_changed

FOLDERS = (ROOT / "rtl",)  # where the sources are; tests of planted faults put changed copies first
RESET = 2  # clocks

TEMPLATE = """// Written by tests/servo/clocked.py.
#include "V{top}.h"
#include "bench.h"

struct Block : Bench<Block, V{top}> {{
  void drive(const int64_t* row) {{
{drive}
  }}
  void show(int64_t* row) {{
{show}
  }}
}};

extern "C" __attribute__((visibility("default")))
void clocked_run(const int64_t* in, int64_t* out, uint64_t n, int reset) {{
  Block block;
  block.drive(in);
  block.reset(reset, 0);
  for (uint64_t i = 0; i < n; ++i, in += {inputs}, out += {outputs}) {{
    block.drive(in);
    block.settle();
    block.show(out);
    block.edge();
  }}
}}
"""


class Clocked:
    """Module `top` with these ports (clock and reset apart), each of 64 bits at most.

    folders: where its sources are, by default `FOLDERS`.
    """

    def __init__(
        self,
        top: str,
        inputs: Sequence[str],
        outputs: Sequence[str],
        parameters: Mapping[str, int] | None = None,
        folders: Sequence[Path] | None = None,
    ) -> None:
        self.inputs, self.outputs = tuple(inputs), tuple(outputs)
        text = TEMPLATE.format(
            top=top,
            drive="\n".join(f"    top->{n}_i = row[{i}];" for i, n in enumerate(inputs)),
            show="\n".join(f"    row[{i}] = top->{n}_o;" for i, n in enumerate(outputs)),
            inputs=len(inputs),
            outputs=len(outputs),
        )
        harness = BUILD / "model" / "clocked" / f"{top}.cpp"
        write_if_changed(harness, text)
        library = build_library(
            top,
            sources_of(top, folders or FOLDERS),
            harness,
            parameters,
            harness_flags=(f"-I{ROOT / 'sim/rtl'}",),
        )
        self._run = load_model(library).clocked_run
        self._run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_int]

    def run(self, clocks: int, **inputs: np.ndarray | int) -> dict[str, np.ndarray]:
        """Outputs by name, a row a clock; an input is an array or a constant, by default 0."""
        if unknown := inputs.keys() - set(self.inputs):
            raise ValueError(f"no input {sorted(unknown)}; there are {self.inputs}")
        given = np.zeros((clocks, len(self.inputs)), dtype=np.int64)
        for column, name in enumerate(self.inputs):
            given[:, column] = inputs.get(name, 0)
        found = np.zeros((clocks, len(self.outputs)), dtype=np.int64)
        self._run(given.ctypes.data, found.ctypes.data, clocks, RESET)
        return {name: found[:, column] for column, name in enumerate(self.outputs)}


def signed(values: np.ndarray, width: int) -> np.ndarray:
    """Two's complement of so many bits."""
    values = values & ((1 << width) - 1)
    return values - ((values >> (width - 1)) << width)


class Accesses:
    """Accesses to registers of a block, one after the other: a write takes a clock, a read two.

    columns: what they are at the block's ports, by name.
    """

    def __init__(self, regmap: RegisterMap, clocks: int) -> None:
        self.regmap = regmap
        names = ("address", "read", "write", "writedata")
        self.columns = {name: np.zeros(clocks, dtype=np.int64) for name in names}
        self.reads: list[int] = []

    def write(self, clock: int, name: str, **fields: int) -> None:
        """A write in this clock."""
        self._access(clock, "write", self.regmap.address(name))
        self.columns["writedata"][clock] = self.regmap.registers[name].word(**fields)

    def read(self, clock: int, *names: str, index: int = 0) -> None:
        """Reads from this clock on; index: of the place of a register."""
        for n, name in enumerate(names):
            start, address = clock + 2 * n, self.regmap.address(name) + index
            self._access(start, "read", address)
            self._access(start + 1, "read", address)
            self.reads.append(start)

    def _access(self, clock: int, kind: str, address: int) -> None:
        assert not self.columns["read"][clock] and not self.columns["write"][clock]
        self.columns[kind][clock], self.columns["address"][clock] = 1, address

    def words(self, found: Mapping[str, np.ndarray]) -> list[int]:
        """What was read, in the order of `read`, by the outputs of the block."""
        reads = np.array(self.reads, dtype=np.int64)
        assert found["waitrequest"][reads].all() and not found["waitrequest"][reads + 1].any()
        return found["readdata"][reads + 1].tolist()
