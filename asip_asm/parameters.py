# SPDX-License-Identifier: Apache-2.0
"""Parameter files (TOML) that programs and simulations share: `name = 1.5`, or a table of that name
whose `value` is the number (`unit` and `meaning` are for readers).
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from asip_asm.files import FileRefused, read_text

LARGEST_FILE = 1 << 20  # bytes

_POSITION = re.compile(r"(.*) \(at line (\d+), column (\d+)\)", re.DOTALL)
_NAME = re.compile(r"\s*\[?\s*[\"']?([A-Za-z_][A-Za-z0-9_]*)")


class ParameterFileError(ValueError):
    """A parameter file has a mistake; the text is `file:line:column: error: cause`."""


def read_toml(path: Path) -> tuple[dict[str, Any], dict[str, int]]:
    """Content of a TOML file, and the line that first begins with each name.

    Raises ParameterFileError, OSError.
    """
    try:
        text = read_text(path, LARGEST_FILE, "a parameter file")
    except FileRefused as error:
        raise ParameterFileError(f"{path}: error: {error.strerror}") from None
    try:
        content = tomllib.loads(text)
    except RecursionError:
        raise ParameterFileError(f"{path}: error: tables or lists nested too deep") from None
    except ValueError as error:  # TOMLDecodeError, and int() of too many digits
        match = _POSITION.fullmatch(str(error))
        cause, line, column = match.groups() if match else (str(error), "1", "1")
        if "at end of document" in cause:
            line = str(len(text.splitlines()) or 1)
        raise ParameterFileError(f"{path}:{line}:{column}: error: {cause}") from None
    lines: dict[str, int] = {}
    for number, row in enumerate(text.splitlines(), 1):
        match = _NAME.match(row)
        if match:
            lines.setdefault(match.group(1), number)
    return content, lines


Parameters = dict[str, tuple[int | float, int]]
"""Name -> (number, line)."""


def read_parameters(path: Path) -> Parameters:
    """Name -> (number, line) of a parameter file. Raises ParameterFileError, OSError."""
    content, lines = read_toml(path)
    found = {}
    for name, entry in content.items():
        value = entry.get("value") if isinstance(entry, dict) else entry
        line = lines.get(name, 1)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ParameterFileError(
                f"{path}:{line}: error: {name} is not a number; "
                f"expected '{name} = 1.5', or a table [{name}] with 'value = 1.5'"
            )
        found[name] = (value, line)
    return found
