# SPDX-License-Identifier: Apache-2.0
"""Mutations of texts, JSON data and command lines, drawn from the given generator alone."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from typing import Any

from tests.fuzz.engine import Campaign

CHARACTERS = 4 << 20
"""Largest text that the mutations make, more than any tool takes."""
TOKEN = re.compile(r"\w+|\s+|[^\w\s]")
WORDS = (
    *("0", "-0", "-1", "1", "2147483647", "2147483648", "4294967296", "1e308", "-1e309", "1e-400"),
    *("NaN", "nan", "Infinity", "-inf", "0x", "0xffffffffffffffffff", "1_000", "٣", "1e999999999"),
    *("", " ", "\t", "\\", "/", "..", "%s", "{}", "{0}", "$HOME", "\0", "\x1b[2J", "é", "\ufeff"),
    *("(", ")", "[", "]", "{", "}", '"', "'", ",", ";", ":", "=", "#", "|", "-", "--", "\u2028"),
)
"""Words that are wrong nearly everywhere."""
VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, 1, -1, 2, 31, 32, 63, 64, 127, 128, 1023, 1024, 65536, 2**31, 2**32),
    *(2**64, -(2**63), 10**400, 0.5, -0.0, 1e308, float("inf"), float("-inf"), float("nan")),
    *("", "0", "x", "zero", "00000000", "ffffffff", "FFFFFFFF", "a0", "c63", "c64", "k0", "\0"),
    *("é" * 40, "a" * 5000, [], {}, [None], [[]], {"": 0}, ["x"] * 300),
)
"""JSON values that are wrong nearly everywhere."""


def mutated_text(rng: Random, text: str, words: Sequence[str]) -> str:
    """The text after 1 to 6 edits; `words` are of the language of the text."""
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        text = rng.choice(TEXT_EDITS)(rng, text, words)[:CHARACTERS]
    return text


def _word(rng: Random, words: Sequence[str]) -> str:
    return rng.choice(words if words and rng.random() < 0.6 else WORDS)


def _edit_tokens(rng: Random, text: str, words: Sequence[str]) -> str:
    tokens = TOKEN.findall(text) or [""]
    i = rng.randrange(len(tokens))
    kind = rng.randrange(5)
    if kind == 0:
        tokens[i] = _word(rng, words)
    elif kind == 1:
        tokens.insert(i, _word(rng, words))
    elif kind == 2:
        del tokens[i]
    elif kind == 3:
        j = rng.randrange(len(tokens))
        tokens[i], tokens[j] = tokens[j], tokens[i]
    else:
        tokens[i] *= rng.choice((2, 3, 40, 400, 5000))
    return "".join(tokens)


def _edit_lines(rng: Random, text: str, words: Sequence[str]) -> str:
    lines = text.splitlines(keepends=True) or [""]
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(5)
    if kind == 0:
        del lines[i]
    elif kind == 1:
        lines.insert(j, lines[i])
    elif kind == 2:
        lines[i], lines[j] = lines[j], lines[i]
    elif kind == 3:
        lines[i] *= rng.choice((2, 30, 300))
    else:
        lines.insert(i, " ".join(_word(rng, words) for _ in range(rng.randint(1, 6))) + "\n")
    return "".join(lines)


def _edit_characters(rng: Random, text: str, words: Sequence[str]) -> str:
    i = rng.randrange(len(text) + 1)
    kind = rng.randrange(4)
    if kind == 0:
        return text[:i] + chr(rng.choice((rng.randrange(128), rng.randrange(0x3000)))) + text[i:]
    if kind == 1:
        return text[:i] + text[i + 1 :]
    if kind == 2:
        return text[:i]
    length = rng.choice((1, 8, 60))
    return text[:i] + text[i : i + length] * rng.choice((2, 20, 600)) + text[i + length :]


def _nest(rng: Random, text: str, words: Sequence[str]) -> str:
    i, depth = rng.randrange(len(text) + 1), rng.choice((3, 70, 2000))
    opened, closed = rng.choice((("(", ")"), ("[", "]"), ("{", "}"), ("-", ""), ("((-", "))")))
    return text[:i] + opened * depth + "1" + closed * depth + text[i:]


TEXT_EDITS: tuple[Callable[[Random, str, Sequence[str]], str], ...] = (
    *(_edit_tokens,) * 5,
    *(_edit_lines,) * 3,
    *(_edit_characters,) * 2,
    _nest,
)


def mutated_json(rng: Random, data: Any) -> Any:
    """A copy of the data with 1 to 4 places changed, taken out, doubled or exchanged."""
    data = json.loads(json.dumps(data))
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        places = list(_places(data))
        if not places:
            return rng.choice(VALUES)
        holder, key = rng.choice(places)
        kind = rng.randrange(8)
        if kind == 0:
            del holder[key]
        elif kind == 1 and isinstance(holder, list):
            holder.insert(key, holder[rng.randrange(len(holder))])
        elif kind == 2:
            other, place = rng.choice(places)
            holder[key], other[place] = other[place], holder[key]
        elif kind == 3 and isinstance(holder, dict):
            holder[rng.choice(("", "x", "name", "\0", f"{key}_"))] = holder[key]
        elif kind == 4 and isinstance(holder[key], str) and holder[key]:
            holder[key] = _edit_characters(rng, holder[key], ())
        elif kind == 5 and isinstance(holder[key], int):
            holder[key] += rng.choice((-1, 1, 7, 1 << 16, -(1 << 31)))
        else:
            holder[key] = rng.choice(VALUES)
        if _is_cyclic(data):
            return rng.choice(VALUES)
    return data


def _places(data: Any) -> list[tuple[Any, Any]]:
    """Every (container, key or index) in the data."""
    found: list[tuple[Any, Any]] = []
    pending = [data]
    while pending:
        node = pending.pop()
        keys = (
            node if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
        )
        for key in keys:
            found.append((node, key))
            pending.append(node[key])
    return found


def _is_cyclic(data: Any, above: tuple[int, ...] = ()) -> bool:
    """Whether an exchange has put a container into itself."""
    if id(data) in above:
        return True
    inner = data.values() if isinstance(data, dict) else data if isinstance(data, list) else ()
    return any(_is_cyclic(item, (*above, id(data))) for item in inner)


def files_of_every_kind() -> None:
    """What a command line may name, in the working directory: an empty file, a folder, an endless
    file, a pipe that nothing writes."""
    Path("empty").write_bytes(b"")
    Path("folder").mkdir()
    Path("zero").symlink_to("/dev/zero")
    os.mkfifo("pipe")


def mutated_arguments(rng: Random, arguments: Sequence[str], words: Sequence[str]) -> list[str]:
    """A command line after up to 2 edits, without '/'; `words`: the tool's own words."""
    result = list(arguments)
    for _ in range(rng.choice((0, 1, 1, 2))):
        i = rng.randrange(len(result) + 1)
        kind = rng.randrange(6)
        if kind < 2 or not result:
            result.insert(i, _word(rng, words))
        elif kind == 2:
            result[i % len(result)] = _word(rng, words)
        elif kind == 3:
            del result[i % len(result)]
        elif kind == 4:
            result.insert(i, rng.choice(result))
        else:
            j = i % len(result)
            result[j] = _edit_tokens(rng, result[j], words)[:100_000]
    # No program is ever given a zero byte; without '/' no case writes outside its folder.
    return [argument.translate({0: None, ord("/"): "_"}) for argument in result]


def command_lines(
    name: str,
    main: Callable[[list[str]], int | None],
    lines: Sequence[str],
    words: str,
    files: Callable[[Random], None],
    prepare: Callable[[], object] = lambda: None,
) -> Campaign:
    """Campaign of mutated command lines of a tool, next to files of every kind and its own `files`.

    words: options of the tool and names of files.
    """

    def case(rng: Random) -> int | None:
        files(rng)
        files_of_every_kind()
        return main(mutated_arguments(rng, rng.choice(lines).split(), words.split()))

    return Campaign(name, 5_000, case, prepare)
