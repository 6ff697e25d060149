# SPDX-License-Identifier: Apache-2.0
"""Processes of a job, and how a job that is killed is started."""

from __future__ import annotations

import os
import re
import signal
import time
from collections.abc import Callable
from pathlib import Path

DEADLINE = 20.0  # s, against a hang
MARK = "MICROTICK_JOB"
"""Variable that a job and all that it starts have, in whatever session they are."""


def _running(belongs: Callable[[Path], bool]) -> dict[int, str]:
    """Number -> command line of the processes that have not ended."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            state = (folder / "stat").read_text().rpartition(")")[2].split()[0]
            if state not in "ZX" and belongs(folder):
                command = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode()
                found[int(folder.name)] = command
        except OSError:
            pass  # it has ended, or belongs to another user
    return found


def members(session: int) -> list[str]:
    """Command lines of the processes of a session."""

    def belongs(folder: Path) -> bool:
        return int((folder / "stat").read_text().rpartition(")")[2].split()[3]) == session

    return list(_running(belongs).values())


def marked(mark: str) -> dict[int, str]:
    """Number -> command line of the processes with a value of `MARK`."""
    wanted = f"{MARK}={mark}".encode()
    return _running(lambda folder: wanted in (folder / "environ").read_bytes().split(b"\0"))


def marked_soon(mark: str, command: str) -> dict[int, str]:
    """`marked` once a process with this command line is there; as it is after `DEADLINE`.

    A process that has just begun a program has no variables yet, and `marked` does not see it.
    """
    end = time.monotonic() + DEADLINE
    while True:
        found = marked(mark)
        if command in {text.strip() for text in found.values()} or time.monotonic() > end:
            return found
        time.sleep(0.02)


def marked_environment(mark: str) -> dict[str, str]:
    """Variables of a job with a mark, as if no make were above it: T and RUN of a campaign, which
    make puts into the environment, would choose the tests of a job too.
    """
    flags = os.environ.get("MAKEFLAGS", "")
    unwanted = {"MAKEFLAGS", "MAKELEVEL", "MFLAGS", *re.findall(r"(\w+)=", flags)}
    return {k: v for k, v in os.environ.items() if k not in unwanted} | {MARK: mark}


def obey_signals() -> None:
    """As in a terminal: a campaign in the background, or under nohup, ignores INT or HUP."""
    for name in ("SIGINT", "SIGHUP", "SIGTERM"):
        signal.signal(getattr(signal, name), signal.SIG_DFL)
