# SPDX-License-Identifier: Apache-2.0
"""The table of asip-dbg's commands: names, usage, help, the search for a name; and what is
after a name: forms, counts, numbers, conditions."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from asip_asm.diagnostics import closest, shortened
from sim.debug.asip_dbg.expressions import CHARACTERS


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
"""Method of `Commands`: gets what follows the name."""


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
TOPICS = (
    *("registers", "state", "faults", "breakpoints", "values", "inputs", "outputs", "streams"),
    *("display", "line", "target"),
)
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


def form_of(rest: str) -> tuple[str, str]:
    """Form of a `/x` and the text after it."""
    match = re.match(r"/(\S*)\s*", rest)
    if match is None:
        return "", rest
    if match.group(1) not in ("x", "d", "u", "t", "f"):
        raise CommandError(f"no form '/{shortened(match.group(1))}'; there are /x /d /u /t /f")
    return match.group(1), rest[match.end() :].strip()


def condition_of(rest: str) -> tuple[str, str]:
    """Text before an `if`, and the expression after it."""
    if len(rest) > CHARACTERS:
        raise CommandError(f"a place has at most {CHARACTERS} characters")
    match = re.search(r"(?:^|\s)if\s+(.*)$", rest)
    return (rest[: match.start()].strip(), match.group(1)) if match else (rest.strip(), "")


def count_of(rest: str, least: int = 1, most: int = 10**9) -> int:
    """A number, 1 without one."""
    if not rest:
        return 1
    if not (rest.isascii() and rest.isdecimal() and len(rest) < 11 and least <= int(rest) <= most):
        raise CommandError(f"'{shortened(rest)}' is not a number {least}..{most}")
    return int(rest)


def numbers_of(rest: str) -> list[int]:
    """Numbers with blanks or commas between them; bundles may be written *7."""
    words = rest.replace(",", " ").split()
    return [count_of(word.lstrip("*"), least=0) for word in words]


def nothing_in(rest: str, name: str) -> None:
    """Refuse text after a command that takes none."""
    if rest:
        raise CommandError(f"{name} takes no argument; got '{shortened(rest)}'")
