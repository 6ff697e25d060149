# SPDX-License-Identifier: Apache-2.0
"""What stands behind a command: forms, counts, numbers, conditions."""

from __future__ import annotations

import re
from collections.abc import Iterator

from asip_asm.diagnostics import shortened
from sim.debugger.command_table import CommandError
from sim.debugger.expressions import CHARACTERS


def script_lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines of a script with their numbers, empty ones left out."""
    for number, line in enumerate(text.splitlines(), 1):
        if line.strip():
            yield number, line


def form_of(rest: str) -> tuple[str, str]:
    """Form of a `/x` and the text behind it."""
    match = re.match(r"/(\S*)\s*", rest)
    if match is None:
        return "", rest
    if match.group(1) not in ("x", "d", "u", "t", "f"):
        raise CommandError(f"no form '/{shortened(match.group(1))}'; there are /x /d /u /t /f")
    return match.group(1), rest[match.end() :].strip()


def condition_of(rest: str) -> tuple[str, str]:
    """Text before an `if`, and the expression behind it."""
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
    """Refuse text behind a command that takes none."""
    if rest:
        raise CommandError(f"{name} takes nothing behind it; got '{shortened(rest)}'")
