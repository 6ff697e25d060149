# SPDX-License-Identifier: Apache-2.0
"""Text from outside as a part of an assembly source: whoever writes a source quotes with these."""

from __future__ import annotations

import re

_ESCAPED = re.compile(r'\\(["\\])')


def quoted(text: str) -> str:
    """A string of the language: one line, `"` and `\\` after a `\\`."""
    plain = one_line(text).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{plain}"'


def unquoted(text: str) -> str:
    """Text of a string as `quoted` writes it; any other `\\` is itself."""
    return _ESCAPED.sub(r"\1", text[1:-1])


def note(text: str) -> str:
    """Text for a comment: one line, which gives the assembler no order (`-Wno-...:`)."""
    return one_line(text).replace("-Wno-", "-W no-")


def one_line(text: str) -> str:
    """The text with a space for each character that ends a line or is not shown."""
    return "".join(c if c.isprintable() else " " for c in text)
