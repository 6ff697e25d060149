# SPDX-License-Identifier: Apache-2.0
"""Files that a user names: read with a limit, written never over an input."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterable, Iterator
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


@contextlib.contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A file in the same folder for the new content of `path`, with the same suffix.

    It takes the place of `path` when everything is written: a reader, a full disk or the end of
    this process never leaves half a file. Raises OSError naming `path`; the old file then stays.
    """
    target = Path(os.path.realpath(path))
    new = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        if target.exists():
            if not os.access(target, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
            mode = stat.S_IMODE(target.stat().st_mode)
            new.touch(mode | stat.S_IWUSR)
            yield new
            new.chmod(mode)
        else:
            yield new
        new.replace(target)
    except OSError as error:
        if error.filename in (None, new, str(new)):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from None
        raise
    finally:
        with contextlib.suppress(OSError):  # a file system may be read-only
            new.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write UTF-8 text as `replaced` does; to a device or a pipe directly. Raises OSError."""
    with open_output(path) as stream:
        stream.write(text)


def write_bytes(path: Path, data: bytes) -> None:
    """Write a binary file as `replaced` does. Raises OSError."""
    with replaced(path) as new:
        new.write_bytes(data)


@contextlib.contextmanager
def open_output(path: Path) -> Iterator[TextIO]:
    """The file to write UTF-8 text to. A regular file is written as `replaced` does.

    Raises OSError, also for a pipe that nothing reads: to open it would wait for ever.
    """
    if path.is_file() or not path.exists():
        with replaced(path) as new, open(new, "w", encoding="utf-8", newline="") as stream:
            yield stream
            stream.flush()
        return
    try:
        file = os.open(path, os.O_WRONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError as error:
        if error.errno == errno.ENXIO:
            raise OSError(errno.ENXIO, "is a pipe that nothing reads", str(path)) from None
        raise
    os.set_blocking(file, True)
    with open(file, "w", encoding="utf-8", newline="") as stream:
        yield stream


def refuse_overwriting(outputs: Iterable[Path], inputs: Iterable[Path]) -> None:
    """Raises OSError if a file to write is one of the inputs, by whatever name, or named twice."""
    inputs = list(inputs)
    written: list[Path] = []
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
