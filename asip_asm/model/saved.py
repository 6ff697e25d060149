# SPDX-License-Identifier: Apache-2.0
"""Files of `casadi.Function.save`: read as data, opened by CasADi in a confined child alone.

CasADi runs code when it opens a function that was made with `jit`, or that calls a library. Such a
file is refused by what it names, before CasADi sees it. The text of a file is two characters a
byte, 'a' to 'p', the lower half first; in these bytes a text is its length (int32) and characters,
and each function's options follow its names: jit and jit_cleanup (a byte each), jit_serialize
(text), jit_temp_suffix (a byte), jit_base_name (text), jit_options (a count, int64, ...).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import msgspec
import numpy as np

from asip_asm.files import read_bytes
from asip_asm.model.confined import BYTES, SECONDS, Confined, confined
from asip_asm.model.read import ModelError, Scalars, scalars

FILE_BYTES = 1 << 26
CURE = "save a function of plain expressions"
CLASSES = {
    **dict.fromkeys(
        ("External", "GenericExternal", "DllLibrary", "ShellCompiler", "ClangCompiler"),
        "an external library or an Importer, whose code would run when the file is opened",
    ),
    **dict.fromkeys(("CallbackInternal", "Callback"), "a callback into a program"),
    **dict.fromkeys(
        ("FmuFunction", "Fmu2", "Fmu3", "OnnxFunction"), "a model of another tool, with its library"
    ),
    **dict.fromkeys(
        ("Nlpsol", "Conic", "Rootfinder", "Integrator", "Simulator"),
        "a solver, which has no scalar operations",
    ),
    **dict.fromkeys(
        ("Interpolant", "BlazingSplineFunction"), "an interpolant, which has no scalar operations"
    ),
}
"""Classes of CasADi that no law may hold, with what they are."""
_CLASS = re.compile(
    b"|".join(len(n).to_bytes(4, "little") + n.encode() for n in CLASSES), re.DOTALL
)
_OPTIONS = re.compile(rb"(?P<jit>.)(?P<cleanup>.)\x06\0\0\0source.(?P<length>..\0\0)", re.DOTALL)
_BINARY = re.compile(rb"\x04\0\0\0link|\x05\0\0\0embed", re.DOTALL)
_DEBUG = 16  # offset of the flag, after the check number and the version


@dataclass(frozen=True)
class SavedFunction:
    """A saved function that was read: its bytes, and its scalar instructions as data."""

    path: Path
    content: bytes
    scalars: Scalars

    def use(
        self,
        work: Callable[[ca.Function], bytes],
        seconds: int = SECONDS,
        memory: int = BYTES,
    ) -> bytes:
        """Answer of `work` on the function as CasADi loads it, in a confined child.

        Raises ModelError.
        """
        return _use(self.path, self.content, work, seconds, memory)


def load_saved(path: Path) -> SavedFunction:
    """The function of a file. Raises ModelError, OSError."""
    if not path.exists():
        raise ModelError(f"{path}: no such file; write one with casadi.Function.save")
    content = read_bytes(path, FILE_BYTES, "a saved function")
    inspect(path, content)
    data = _use(path, content, lambda function: msgspec.msgpack.encode(scalars(function)))
    return SavedFunction(path, content, msgspec.msgpack.decode(data, type=Scalars))


def inspect(path: Path, content: bytes) -> None:
    """Refuse a file by what its bytes name. Raises ModelError."""
    data = _decoded(content)
    if len(data) <= _DEBUG or data[:8] != (123456789012345).to_bytes(8, "little"):
        raise ModelError(f"{path}: not a file of casadi.Function.save")
    if data[_DEBUG]:
        raise ModelError(f"{path}: saved with the option debug; {CURE} without it")
    if found := _CLASS.search(data):
        name = found.group()[4:].decode()
        raise ModelError(f"{path}: holds '{name}': {CLASSES[name]}; {CURE}")
    if _BINARY.search(data):
        raise ModelError(f"{path}: holds code compiled by jit, which would run; {CURE}")
    for options in _OPTIONS.finditer(data):
        after = options.end() + int.from_bytes(options["length"], "little")
        if options["jit"] != b"\0" or data[after : after + 8] != bytes(8):
            raise ModelError(
                f"{path}: a function in it has the option jit or jit_options, with which CasADi "
                f"starts a compiler when it opens the file; {CURE} without them"
            )


def _decoded(content: bytes) -> bytes:
    """Bytes of the text; empty if it is no such text."""
    content = content.rstrip(b"\r\n")
    if len(content) % 2 or content.strip(b"abcdefghijklmnop"):
        return b""
    digits = np.frombuffer(content, np.uint8) - ord("a")
    return (digits[::2] | digits[1::2] << 4).tobytes()


def _use(
    path: Path,
    content: bytes,
    work: Callable[[ca.Function], bytes],
    seconds: int = SECONDS,
    memory: int = BYTES,
) -> bytes:
    ca.has_linsol("symbolicqr")  # the one solver that expands; the child can load no library
    text = content.decode("ascii")
    try:
        return confined(
            lambda: work(ca.StringDeserializer(text).unpack_function()), seconds, memory
        )
    except Confined as error:
        raise ModelError(
            f"{path}: not a file of casadi.Function.save with this version of CasADi, or not a "
            f"law: {error}"
        ) from None
