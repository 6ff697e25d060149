# SPDX-License-Identifier: Apache-2.0
"""The prompt of asip-dbg: line editing, history, completion by what the program has."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from prompt_toolkit import PromptSession
from prompt_toolkit.completion import CompleteEvent, Completer, Completion
from prompt_toolkit.document import Document
from prompt_toolkit.history import FileHistory, InMemoryHistory
from prompt_toolkit.shortcuts import CompleteStyle

from sim.debug.asip_dbg.completion import completions, last_word
from sim.debug.asip_dbg.session import Session

PROMPT = "(asip-dbg) "


class _Words(Completer):
    def __init__(self, session: Session) -> None:
        self.session = session

    def get_completions(self, document: Document, event: CompleteEvent) -> Iterator[Completion]:
        text = document.text_before_cursor
        for word in completions(self.session, text):
            yield Completion(word, start_position=-len(last_word(text)))


def make_prompt(session: Session) -> PromptSession:
    """Prompt with the history of earlier sessions, saved in ~/.asip_dbg_history."""
    try:
        path = Path.home() / ".asip_dbg_history"
        with path.open("a"):
            pass
        history: FileHistory | InMemoryHistory = FileHistory(str(path))
    except (OSError, RuntimeError):
        history = InMemoryHistory()
    return PromptSession(
        history=history,
        completer=_Words(session),
        complete_while_typing=False,
        complete_style=CompleteStyle.READLINE_LIKE,
        reserve_space_for_menu=0,
    )
