# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Nios II core share: model, QEMU's presence, programs on the core."""

from __future__ import annotations

import os
from functools import cache

import numpy as np
import pytest

from sim.harness.n2_lockstep import clear_registers, find_qemu
from sim.harness.n2_lockstep_rtl import N2Rtl
from tests.nios.n2_programs import Program

SEED = int(os.environ.get("SEED", "1"))


def require_qemu() -> None:
    """Skip by name where QEMU is missing; a failure under CI=true."""
    if find_qemu() is None:
        if os.environ.get("CI") == "true":
            pytest.fail("qemu-system-nios2 is missing; scripts/qemu.sh gets it")
        pytest.skip("qemu-system-nios2 is missing; scripts/qemu.sh gets it")


@cache
def core(**parameters: int) -> N2Rtl:
    """The Verilated core, one per set of parameters in a process."""
    return N2Rtl(parameters)


def load(program: Program, model: N2Rtl | None = None) -> N2Rtl:
    """Clear registers and memories, load the program, reset; no wait states, no interrupts."""
    model = model or core()
    clear_registers(model)
    for memory in (model.itcm, model.dtcm, model.avalon):
        memory[:] = 0
    for address, data in program.image():
        model.load(address, data)
    model.waits(0)
    model.reset()
    return model


def registers(records: np.ndarray) -> dict[int, int]:
    """Last value written to each register."""
    return {int(r["dst"]): int(r["value"]) for r in records if r["write"]}
