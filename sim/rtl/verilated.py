# SPDX-License-Identifier: Apache-2.0
"""One instance of a Verilated model in this process, by the C interface of its harness."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from sim.rtl.waves import load_model

Signatures = Mapping[str, tuple[Any, ...]]
"""By name of a C function: the type of its result, None without, and those of its arguments after
the model. "new": (None, types of all arguments), left out if there are none."""


class Verilated:
    """prefix, end: `<prefix>_new` makes a model, `<prefix>_<end>` frees it.

    The functions of a library of `build_library` have the model, here `_handle`, as first argument.
    """

    prefix: str
    end = "free"
    _handle: int | None = None

    def __init__(
        self, library: Path | ctypes.CDLL, signatures: Signatures, *arguments: object
    ) -> None:
        """arguments: of `<prefix>_new`. Raises TypeError if `signatures` has other types for them.

        Without a type, ctypes would pass a number as 32 bits and cut an address.
        """
        _, *types = signatures.get("new", (None,))
        if len(types) != len(arguments):
            raise TypeError(
                f"{self.prefix}_new: {len(arguments)} arguments, but the signature of 'new' has "
                f"{len(types)} types"
            )
        self._lib = load_model(library) if isinstance(library, Path) else library
        others = {name: types for name, types in signatures.items() if name != "new"}
        self._bind({self.end: (None,), **others})
        self._process = os.getpid()
        new = getattr(self._lib, f"{self.prefix}_new")
        new.restype, new.argtypes = ctypes.c_void_p, types
        self._handle = new(*arguments)

    def _bind(self, signatures: Signatures) -> None:
        for name, (result, *arguments) in signatures.items():
            function = getattr(self._lib, f"{self.prefix}_{name}")
            function.restype, function.argtypes = result, [ctypes.c_void_p, *arguments]

    def _call(self, name: str, *arguments: object) -> Any:
        """What `<prefix>_<name>` returns for this model."""
        return getattr(self._lib, f"{self.prefix}_{name}")(self._model, *arguments)

    @property
    def _model(self) -> int | ctypes.c_void_p | None:
        """The handle; a class may refuse one that is closed."""
        return self._handle

    def _word(self, name: str, *arguments: object) -> int | None:
        """The word that a function writes to its last argument; None if it returns 0."""
        word = ctypes.c_uint32()
        return word.value if self._call(name, *arguments, ctypes.byref(word)) else None

    def _events(self, name: str, dtype: DTypeLike, *words: int) -> NDArray[Any]:
        """All events that a function copies, (n, *words); without a place it gives their number."""
        count = self._call(name, None, 0)
        events = np.zeros((count, *words), dtype)
        self._call(name, events.ctypes.data, count)
        return events

    def close(self) -> None:
        """Free the model; the object is of no use afterwards.

        In a fork of the process that made it, only forget it: the model's threads are not in the
        copy, and freeing would wait for them forever.
        """
        # First without a handle: an interrupt after the call must not free the model twice.
        handle, self._handle = self._handle, None
        if handle is not None and os.getpid() == self._process:
            getattr(self._lib, f"{self.prefix}_{self.end}")(handle)

    def __del__(self) -> None:
        self.close()
