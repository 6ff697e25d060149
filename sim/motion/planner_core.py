# SPDX-License-Identifier: Apache-2.0
"""The planner and the sampler on the Verilated core: asip_asm/programs/planner_*.s."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.assemble import assemble
from sim.harness.asip_rtl import AsipError, AsipRtl, TickResult

PROGRAMS = Path(__file__).parents[2] / "asip_asm/programs"
PARAMETERS = ("v0", "vm", "tr", "tm", "L")
ERRORS = (
    "no error",
    "not 0 < vm < 1e30",
    "not 0 <= v0 <= vm",
    "not 0 < tr < 1e30",
    "not 0 <= tm <= tr/2",
    "not 0 < L < 1e30",
    "acceleration, jerk or cruise time is not below 1e30",
)


@dataclass(frozen=True)
class CoreRun:
    """Outputs by name, (runs,) each in binary32, and clock cycles of every run."""

    outputs: dict[str, NDArray[np.float32]]
    cycles: NDArray[np.uint32]


class CoreProgram:
    """One of the planner's programs on its own core, configuration 'fast' or 'small'."""

    def __init__(self, name: str, configuration: str = "fast") -> None:
        self.image = assemble(PROGRAMS / f"{name}.s", configuration=configuration)
        self.core = AsipRtl(configuration)
        self.core.load(self.image)

    def run(self, inputs: dict[str, ArrayLike]) -> CoreRun:
        """Run once per row of the inputs (runs,), given by name; integers where declared so.

        Raises AsipError if a run faults.
        """
        types = {entry.name: entry.type for entry in self.image.inputs}
        columns = [
            np.asarray(values, dtype=np.int32 if types[name] == "int" else np.float32)
            for name, values in inputs.items()
        ]
        data = np.column_stack([column.view(np.uint32) for column in columns])
        outputs = [output.name for output in self.image.outputs]
        result: TickResult = self.core.run(
            self.core.input_addresses(list(inputs)), data, self.core.output_addresses(outputs)
        )
        if result.fault != "NONE":
            raise AsipError(
                f"run {len(result.words)} of {self.image.title} ended in {result.fault}"
            )
        words = np.ascontiguousarray(result.words.T).view(np.float32)
        return CoreRun(dict(zip(outputs, words, strict=True)), result.cycles)
