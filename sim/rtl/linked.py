# SPDX-License-Identifier: Apache-2.0
"""Models that Verilator's own makefile builds, linked with the objects that all models share."""

from __future__ import annotations

from sim.rtl import coverage, runtime, waves
from sim.rtl.plain import plain


def linked(*names: str, optimisation: str = "-O1") -> tuple[list[str], str]:
    """Options for Verilator, and variables for its makefile, so that a model is one source and is
    linked with these objects of `runtime`."""
    traced = ["verilated_fst_c"] if waves.wanted() else []
    counted = ["verilated_cov"] if coverage.wanted() else []
    objects = " ".join(str(plain(path)) for path in runtime.objects(*names, *traced, *counted))
    return ["-LDFLAGS", objects], f"VM_PARALLEL_BUILDS=0 OPT_FAST={optimisation} VK_GLOBAL_OBJS="
