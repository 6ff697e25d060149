# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Nios II core share: model, QEMU's presence, programs on the core."""

from __future__ import annotations

from functools import cache

import numpy as np

from sim.rtl.n2_lockstep_rtl import N2Rtl


@cache
def core(**parameters: int) -> N2Rtl:
    """The Verilated core, one per set of parameters in a process."""
    return N2Rtl(parameters)


def registers(records: np.ndarray) -> dict[int, int]:
    """Last value written to each register."""
    return {int(r["dst"]): int(r["value"]) for r in records if r["write"]}
