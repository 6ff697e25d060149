# SPDX-License-Identifier: Apache-2.0
"""The prompt of asip-dbg: line editing, history, completion by what the program has."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from prompt_toolkit import PromptSession
from prompt_toolkit.completion import CompleteEvent, Completer, Completion
from prompt_toolkit.document import Document
from prompt_toolkit.history import FileHistory, InMemoryHistory

from sim.debugger.command_table import COMMANDS
from sim.debugger.session import Session

PROMPT = "(asip-dbg) "
PLACES = ("break", "tbreak", "list")
NAMES = ("print", "display", "watch", "set", "assert", "break", "tbreak")
FILES = ("source", "inputs")
TOPICS = ("registers", "state", "faults", "breakpoints", "values", "inputs", "outputs", "display")


def completions(session: Session, text: str) -> list[str]:
    """Words that may stand where a line ends, in place of its last word."""
    words = text.split()
    last = "" if not words or text[-1:].isspace() else words[-1]
    if len(words) <= 1 and last == (words[0] if words else ""):
        return sorted({e.names[0] for name, e in COMMANDS.items() if name.startswith(last)})
    entries = [entry for name, entry in COMMANDS.items() if name.startswith(words[0])]
    names = {entry.names[0] for entry in entries}
    command = (
        words[0]
        if words[0] in names
        else COMMANDS.get(words[0], entries[0]).names[0]
        if (entries)
        else ""
    )
    known: Iterable[str] = ()
    if command == "info":
        known = (*TOPICS, "line", "target")
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


class _Words(Completer):
    def __init__(self, session: Session) -> None:
        self.session = session

    def get_completions(self, document: Document, event: CompleteEvent) -> Iterator[Completion]:
        text = document.text_before_cursor
        last = "" if not text or text[-1].isspace() else text.split()[-1]
        for word in completions(self.session, text):
            yield Completion(word, start_position=-len(last))


def make_prompt(session: Session) -> PromptSession:
    """Prompt with the history of earlier sessions, kept in ~/.asip_dbg_history."""
    try:
        path = Path.home() / ".asip_dbg_history"
        with path.open("a"):
            pass
        history: FileHistory | InMemoryHistory = FileHistory(str(path))
    except (OSError, RuntimeError):
        history = InMemoryHistory()
    return PromptSession(history=history, completer=_Words(session), complete_while_typing=False)
