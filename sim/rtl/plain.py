# SPDX-License-Identifier: Apache-2.0
"""Paths that make can read: a link represents a folder with a space or so in its name.

Verilator writes makefiles, and make cannot quote. So whatever goes into one is named through a
link in the folder for temporary files to the folder of the project, and make works in a folder
next to that link. A project in a folder with a plain name uses its own paths.
"""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from pathlib import Path

from asip_asm.project import BUILD, ROOT
from sim.rtl.private import private_folder

ODD = re.compile(r"[^A-Za-z0-9_./+,=@-]")


def plain(path: Path) -> Path:
    """The same file under a name that make can read; relative paths count from here.

    Raises OSError if no link can be made where one is needed.
    """
    path = path.absolute()
    if not ODD.search(str(path)):
        return path
    base = ROOT if path.is_relative_to(ROOT) else path.parent
    return _link(base) / path.relative_to(base)


def workshop(folder: Path) -> Path:
    """The folder below BUILD itself, or one next to a link, in which make can work.

    Raises OSError if the folder next to the link belongs to another user, or is open to others.
    """
    if not ODD.search(str(folder.absolute())):
        return folder
    shop = private_folder(_link(ROOT).with_suffix(".build"))
    other = shop / folder.absolute().relative_to(BUILD)
    other.mkdir(parents=True, exist_ok=True, mode=0o700)
    return other


def _link(folder: Path) -> Path:
    """A link to the folder, the same one each time, of this user."""
    name = hashlib.sha256(str(folder).encode()).hexdigest()[:16]
    link = Path(tempfile.gettempdir()) / f"microtick-{os.getuid()}-{name}"
    try:
        link.symlink_to(folder, target_is_directory=True)
    except FileExistsError:
        if os.lstat(link).st_uid != os.getuid() or Path(os.readlink(link)) != folder:
            raise
    return link
