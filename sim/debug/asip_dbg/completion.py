# SPDX-License-Identifier: Apache-2.0
"""What may be where a command line ends: commands, names of the program, files."""

from __future__ import annotations

from collections.abc import Iterable
from glob import escape, glob

from sim.debug.asip_dbg.command_table import COMMANDS, TOPICS, CommandError, find_command
from sim.debug.asip_dbg.session import Session

PLACES = ("break", "tbreak", "list")
NAMES = ("print", "display", "watch", "set", "assert", "break", "tbreak")
FILES = ("source", "inputs")


def last_word(text: str) -> str:
    """What has been typed of the word where a line ends."""
    return "" if not text or text[-1].isspace() else text.split()[-1]


def completions(session: Session, text: str) -> list[str]:
    """Words that may be where a line ends, in place of its last word."""
    words, last = text.split(), last_word(text)
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
        return sorted(glob(escape(last) + "*", include_hidden=True))
    elif command in (*NAMES, *PLACES):
        known = session.values.names()
        if command in PLACES:
            equations = [f"({name})" for name in session.program.equations()]
            known = [*known, *session.program.image.labels, *equations]
    return [name for name in known if name.startswith(last)]
