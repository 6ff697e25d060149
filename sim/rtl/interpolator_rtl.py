# SPDX-License-Identifier: Apache-2.0
"""The Verilated step interpolator as a Python object: one job in, all its steps out."""

from __future__ import annotations

import ctypes
import math
from pathlib import Path

import numpy as np

from sim.rtl.build import ROOT, build_library
from sim.rtl.sources import sources_of
from sim.rtl.verilated import Verilated

FOLDERS = (ROOT / "rtl",)  # where its sources are; tests put changed copies first
PLANES = {"xy": 0, "zx": 1, "yz": 2}
LONGEST = 1 << 24  # steps of a job


class InterpolatorRtl(Verilated):
    """One interpolator. Steps come as (n, 3) arrays of -1, 0, 1 in x, y, z."""

    prefix, end = "interpolator", "delete"

    def __init__(self) -> None:
        top = "step_interpolator"
        harness = Path(__file__).with_name("interpolator_harness.cpp")
        u64, pointer = ctypes.c_uint64, ctypes.c_void_p
        super().__init__(
            build_library(top, sources_of(top, FOLDERS), harness),
            {"run": (u64, pointer, pointer, u64, ctypes.c_int)},
        )

    def line(
        self, u: int, v: int, combined: bool = False, plane: str = "xy", pause: int = 0
    ) -> np.ndarray:
        """Steps from (0, 0) to (u, v) in the plane's axes."""
        return self._run([0, PLANES[plane], combined, 0, 0, 0, 0, u, v, 0], abs(u) + abs(v), pause)

    def arc(
        self,
        start: tuple[int, int],
        end: tuple[int, int],
        radius_squared: int,
        clockwise: bool = False,
        combined: bool = False,
        turns: int = 0,
        plane: str = "xy",
        pause: int = 0,
    ) -> np.ndarray:
        """Steps around the origin, `turns` whole turns more than needed to reach the end."""
        error = start[0] ** 2 + start[1] ** 2 - radius_squared
        job = [1, PLANES[plane], combined, clockwise, turns, *start, *end, error]
        return self._run(job, (turns + 2) * 8 * (math.isqrt(radius_squared) + 2), pause)

    def _run(self, job: list[int], most: int, pause: int) -> np.ndarray:
        words = np.array(job, dtype=np.int32)
        steps = np.zeros(most + 1, dtype=np.uint8)
        count = self._call("run", words.ctypes.data, steps.ctypes.data, len(steps), pause)
        if count > most:
            raise RuntimeError(f"job {job} does not end after {most} steps")
        bits = steps[:count, None] >> np.arange(6) & 1
        moved, negative = bits[:, :3].astype(np.int64), bits[:, 3:].astype(np.int64)
        return moved * (1 - 2 * negative)
