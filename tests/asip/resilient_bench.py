# SPDX-License-Identifier: Apache-2.0
"""Benches of the core with redundancy and of the core with streams, on the RTL of the project or on
a copy with a planted fault.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path

from sim.rtl.asip_rtl import HARNESS, AsipRtl
from sim.rtl.build import build_library, file_list

RTL: Path | None = None
"""Folder with other sources of rtl/asip, such as a planted fault."""


class CopyRtl(AsipRtl):
    """A configuration with the sources of `RTL`, and further parameters of the top."""

    more: Mapping[str, int] = {}

    def _library(self, parameters: Mapping[str, int]) -> Path:
        files = file_list("asip/asip.f")
        if RTL is not None:
            files = [RTL / path.name if path.parent.name == "asip" else path for path in files]
        return build_library(self.top, files, HARNESS, {**parameters, **self.more})


class ResilientRtl(CopyRtl):
    """`fast` with Resilience."""

    more = {"Resilience": 1}


@functools.cache
def core() -> ResilientRtl:
    """The one core; every test loads all that it needs."""
    return ResilientRtl("fast")


@functools.cache
def stream_core(configuration: str) -> CopyRtl:
    """The one core of a configuration with streams; every test loads all that it needs."""
    return CopyRtl(configuration)
