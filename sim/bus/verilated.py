# SPDX-License-Identifier: Apache-2.0
"""What the Verilated models of the bus have in common: building, time, TAP devices."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from asip_asm.project import ROOT
from sim.rtl import verilated
from sim.rtl.build import build_library
from sim.rtl.sources import RTL, sources_of
from sim.rtl.waves import load_model

HERE = Path(__file__).parent


def load(
    top: str,
    harness: Path,
    longs: Sequence[str],
    folders: Sequence[Path] = (RTL,),
    parameters: Mapping[str, int] | None = None,
) -> ctypes.CDLL:
    """The model of a top with its harness and these parameters; longs: its functions of 64 bits.
    Raises BuildError."""
    lib = load_model(
        build_library(
            top,
            sources_of(top, tuple(folders)),
            harness,
            parameters,
            headers=[HERE / "ring.h", HERE / "capture.h"],
            harness_flags=["-I", str(ROOT / "sim/rtl"), "-I", str(HERE)],
        )
    )
    for name in longs:
        getattr(lib, name).restype = ctypes.c_uint64
    return lib


class BusModel(verilated.Verilated):
    """A model of the bus: time, and frames between its ports and TAP devices."""

    end = "delete"
    new: tuple[Any, ...] = ()  # types of the arguments of `<prefix>_new`

    def __init__(self, lib: ctypes.CDLL, *arguments: object) -> None:
        super().__init__(lib, {"new": (None, *self.new)}, *arguments)

    @property
    def _model(self) -> ctypes.c_void_p:
        return ctypes.c_void_p(self._handle)

    def run(self, ns: int) -> None:
        """Let time pass."""
        self._call("run", ctypes.c_uint64(ns))

    @property
    def now(self) -> int:
        """Simulated time, ps."""
        return self._call("now")

    def capture(self, path: Path) -> None:
        """Write what `served` carries to a pcap file. Raises OSError."""
        if not self._call("capture", str(path).encode()):
            raise OSError(f"{path} cannot be written")

    @contextmanager
    def served(self, *taps: int) -> Iterator[None]:
        """Frames pass between TAP devices, open and not blocking, and the model, whose time goes on
        in a thread of its own."""
        self._call("restart")  # here: the thread may begin after `stop`
        service = threading.Thread(target=self._call, args=("serve", *taps), daemon=True)
        service.start()
        try:
            yield
        finally:
            self._call("stop")
            service.join()
