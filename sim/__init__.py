# SPDX-License-Identifier: Apache-2.0
"""Simulation of the project's hardware. `Core` puts a program into a control loop of one's own:
docs/own_machine.md."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sim.moved import install

if TYPE_CHECKING:
    from sim.core.api import Core, CoreError, CoreFault, Ticks

__all__ = ["Core", "CoreError", "CoreFault", "Ticks"]

install()


def __getattr__(name: str) -> Any:
    """The public names on first use: parts of this package do not load Verilator for them."""
    if name not in __all__:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    from sim.core import api

    return getattr(api, name)
