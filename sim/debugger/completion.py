# SPDX-License-Identifier: Apache-2.0
"""What may stand where a command line ends: commands, names of the program, files."""

from __future__ import annotations

import os
from collections.abc import Iterable

from sim.debugger.command_table import COMMANDS, TOPICS, CommandError, find_command
from sim.debugger.session import Session

PLACES = ("break", "tbreak", "list")
NAMES = ("print", "display", "watch", "set", "assert", "break", "tbreak")
FILES = ("source", "inputs")


def completions(session: Session, text: str) -> list[str]:
    """Words that may stand where a line ends, in place of its last word."""
    words = text.split()
    last = "" if not words or text[-1:].isspace() else words[-1]
    if len(words) <= 1 and last == (words[0] if words else ""):
        return sorted({e.names[0] for name, e in COMMANDS.items() if name.startswith(last)})
    try:
        command = find_command(words[0]).names[0]
    except CommandError:
        return []
    known: Iterable[str] = ()
    if command == "info":
        known = TOPICS
    elif command == "help":
        known = sorted({entry.names[0] for entry in COMMANDS.values()})
    elif command == "x":
        known = session.program.image.data_names
    elif command in FILES:
        return _files(last)
    elif command in (*NAMES, *PLACES):
        known = session.values.names()
        if command in PLACES:
            equations = [f"({name})" for name in session.program.equations()]
            known = [*known, *session.program.image.labels, *equations]
    return [name for name in known if name.startswith(last)]


def _files(start: str) -> list[str]:
    folder, _, name = start.rpartition("/")
    try:
        found = sorted(os.listdir(folder or ("/" if start.startswith("/") else ".")))
    except OSError:
        return []
    prefix = start[: len(start) - len(name)]
    return [prefix + entry for entry in found if entry.startswith(name)]
