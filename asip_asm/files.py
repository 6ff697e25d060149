# SPDX-License-Identifier: Apache-2.0
"""Files that a user names: read with a limit, written never over an input."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO, TextIO

KINDS = (
    (stat.S_ISDIR, "is a folder"),
    (stat.S_ISFIFO, "is a pipe"),
    (stat.S_ISCHR, "is a device"),
    (stat.S_ISBLK, "is a device"),
    (stat.S_ISSOCK, "is a socket"),
)


class FileRefused(OSError):
    """A file that exists but is not what is wanted: no regular file, too large, no text."""


def open_regular(path: Path, what: str) -> BinaryIO:
    """A regular file, open for reading; `what` it should be, for messages.

    Raises FileRefused for folders, pipes and devices, OSError.
    """
    # Without O_NONBLOCK a pipe without a writer would never open.
    file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    mode = os.fstat(file).st_mode
    for is_kind, text in KINDS:
        if is_kind(mode):
            os.close(file)
            raise FileRefused(errno.EINVAL, f"{text}, {what} is a regular file", str(path))
    return open(file, "rb")


def read_bytes(path: Path, limit: int, what: str) -> bytes:
    """Contents of a regular file of at most `limit` bytes. Raises as `open_regular`, and
    FileRefused for more bytes than that.
    """
    with open_regular(path, what) as stream:
        data = stream.read(limit + 1)
    if len(data) > limit:
        raise FileRefused(
            errno.EFBIG, f"larger than {limit} bytes, the most that {what} may have", str(path)
        )
    return data


def read_text(path: Path, limit: int, what: str) -> str:
    """Text of a file in UTF-8, with or without a byte order mark. Raises as `read_bytes`,
    also if it is no such text.
    """
    data = read_bytes(path, limit, what)
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise FileRefused(errno.EILSEQ, "is UTF-16 text; save it as UTF-8", str(path))
    if b"\0" in data:
        raise FileRefused(errno.EILSEQ, f"is a binary file, {what} is UTF-8 text", str(path))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        byte = data[error.start]
        raise FileRefused(
            errno.EILSEQ, f"line {line} is not UTF-8 text: byte 0x{byte:02x}", str(path)
        ) from None


def open_output(path: Path) -> TextIO:
    """The file to write UTF-8 text to. Raises OSError, also for a pipe that nothing reads: to open
    it would wait for ever.
    """
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NONBLOCK | os.O_CLOEXEC
    try:
        file = os.open(path, flags, 0o666)
    except OSError as error:
        if error.errno == errno.ENXIO:
            raise OSError(errno.ENXIO, "is a pipe that nothing reads", str(path)) from None
        raise
    os.set_blocking(file, True)
    return open(file, "w", encoding="utf-8", newline="")


def refuse_overwriting(outputs: Iterable[Path], inputs: Iterable[Path]) -> None:
    """Raises OSError if a file to write is one of the inputs, by whatever name, or named twice."""
    inputs, written = list(inputs), []
    for output in outputs:
        for other in inputs:
            if _same(output, other):
                raise OSError(
                    errno.EEXIST, f"would overwrite the input {other}; name another", str(output)
                )
        for other in written:
            if _same(output, other):
                raise OSError(errno.EEXIST, "is named for two different outputs", str(output))
        written.append(output)


def _same(first: Path, second: Path) -> bool:
    try:
        return os.path.samefile(first, second)
    except OSError:
        return os.path.realpath(first) == os.path.realpath(second)
