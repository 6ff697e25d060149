# SPDX-License-Identifier: Apache-2.0
"""The C driver, and the Verilated core as a library that its programs link with."""

from __future__ import annotations

from pathlib import Path

from asip_asm.isa import default_isa
from sim.rtl.build import build_library, file_list

DRIVER = Path(__file__).parent


def simulated_core(configuration: str = "fast", resilience: int = 0) -> Path:
    """Shared library with the functions of `sim_bus.h`, built at first use. Raises BuildError.

    resilience: the core's parameter of this name.
    """
    shape = default_isa().configurations[configuration]
    parameters = shape.parameters | {"Resilience": resilience}
    return build_library("asip", file_list("asip/asip.f"), DRIVER / "sim_bus.cpp", parameters)
