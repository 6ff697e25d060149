# SPDX-License-Identifier: Apache-2.0
"""Bench of the core with redundancy: programs of single bundles, whole ticks on the RTL."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path

from sim.rtl.asip_rtl import HARNESS, AsipRtl
from sim.rtl.build import build_library, file_list

RTL: Path | None = None
"""Folder with other sources of rtl/asip, such as a planted fault."""


class ResilientRtl(AsipRtl):
    """`fast` with Resilience."""

    def _library(self, parameters: Mapping[str, int]) -> Path:
        files = file_list("asip/asip.f")
        if RTL is not None:
            files = [RTL / path.name if path.parent.name == "asip" else path for path in files]
        return build_library(self.top, files, HARNESS, {**parameters, "Resilience": 1})


@functools.cache
def core() -> ResilientRtl:
    """The one core; every test loads all that it needs."""
    return ResilientRtl("fast")
