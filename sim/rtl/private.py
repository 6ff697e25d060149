# SPDX-License-Identifier: Apache-2.0
"""Folders that only their owner may enter, and small secrets in them."""

from __future__ import annotations

import errno
import os
import stat
import tempfile
from pathlib import Path


def private_folder(folder: Path) -> Path:
    """The folder, made with mode 0700 if it is missing.

    Raises OSError naming the folder if it is a link, belongs to another user, or lets others write.
    A folder of this user that others may only enter is closed to them.
    """
    try:
        folder.mkdir(mode=0o700, parents=True)
    except FileExistsError:
        pass
    found = os.lstat(folder)
    if not stat.S_ISDIR(found.st_mode):
        raise OSError(errno.ENOTDIR, "is no folder; remove it", str(folder))
    if found.st_uid != os.getuid():
        raise OSError(
            errno.EPERM, f"belongs to the user {found.st_uid}; remove it or set TMPDIR", str(folder)
        )
    if found.st_mode & 0o022:
        raise OSError(
            errno.EPERM, "other users may write into it; remove it, it is made again", str(folder)
        )
    if found.st_mode & 0o077:
        os.chmod(folder, 0o700)
    return folder


def runtime_folder() -> Path:
    """The folder of this user for what lives as long as a server. Raises OSError."""
    given = os.environ.get("XDG_RUNTIME_DIR", "")
    if given and os.path.isabs(given) and os.path.isdir(given):
        if os.stat(given).st_uid == os.getuid():
            return private_folder(Path(given) / "microtick")
    return private_folder(Path(tempfile.gettempdir()) / f"microtick-{os.getuid()}")


def write_secret(path: Path, text: str) -> None:
    """A file that only its owner reads, in the place of any file of that name.

    Raises OSError naming it; the old file then stays.
    """
    new = path.with_name(f".{path.name}.{os.getpid()}")
    new.unlink(missing_ok=True)
    file = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    try:
        with open(file, "w", encoding="ascii") as stream:
            stream.write(text)
        new.replace(path)
    except OSError as error:
        new.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from None
