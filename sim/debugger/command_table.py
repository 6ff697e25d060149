# SPDX-License-Identifier: Apache-2.0
"""The table of asip-dbg's commands: names, usage, help, and the search for a name."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from asip_asm.diagnostics import closest, shortened


class CommandError(Exception):
    """A command cannot be carried out; the message says why and what would be right."""


class AssertionMissed(CommandError):
    """`assert` found its expression false."""


class Quit(Exception):
    """End of the session with this exit status."""

    def __init__(self, status: int = 0) -> None:
        super().__init__(status)
        self.status = status


Action = Callable[[Any, str], None]
"""Method of `Commands`: gets what stands behind the name."""


@dataclass(frozen=True)
class Command:
    """A command: names, first the full one, how it is written, what it does, whether an empty line
    repeats it, whether it lets the core go.
    """

    names: tuple[str, ...]
    usage: str
    doc: str
    function: Action
    repeats: bool = False
    runs: bool = False


COMMANDS: dict[str, Command] = {}
TOPICS = ("registers", "state", "faults", "breakpoints", "values", "inputs", "outputs")
TOPICS += ("display", "line", "target")
"""Of `info`."""


def command(
    *names: str, usage: str = "", repeats: bool = False, runs: bool = False
) -> Callable[[Action], Action]:
    """Enter a method into the table; its docstring is the help. `repeats`: an empty line does it
    again; `runs`: it lets the core go.
    """

    def enter(function: Action) -> Action:
        doc = inspect.cleandoc(function.__doc__ or "")
        entry = Command(names, f"{names[0]} {usage}".strip(), doc, function, repeats, runs)
        for name in names:
            COMMANDS[name] = entry
        return function

    return enter


def find_command(word: str) -> Command:
    """Command of a name or the beginning of one. Raises CommandError."""
    if word in COMMANDS:
        return COMMANDS[word]
    found = {entry.names[0]: entry for name, entry in COMMANDS.items() if name.startswith(word)}
    if len(found) == 1:
        return next(iter(found.values()))
    if found:
        raise CommandError(f"'{word}' is ambiguous: {', '.join(sorted(found))}")
    near = closest(word, COMMANDS) or "help lists the commands"
    raise CommandError(f"no command '{shortened(word)}'; {near}")
