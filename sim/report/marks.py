# SPDX-License-Identifier: Apache-2.0
"""Measured text of a page in docs: what is between a pair of marks is written by a command.

The marks of a name: `<!-- name: written by ... -->` and `<!-- end of name -->`, a line each.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from asip_asm.files import write_text


class MarksError(ValueError):
    """A page has lost its marks; says which, and what to do."""


def between_marks(page: str, texts: Mapping[str, str], file: object) -> str:
    """The page with these texts, by the name of their marks. Raises MarksError for a name of which
    it has no marks, or more than one pair; file: named there.
    """
    for name, text in texts.items():
        marks = re.compile(rf"(<!-- {name}: [^\n]*-->\n).*?(<!-- end of {name} -->)", re.DOTALL)

        def filled(found: re.Match[str], text: str = text) -> str:
            return found[1] + text + found[2]

        page, count = marks.subn(filled, page)
        if count != 1:
            raise MarksError(
                f"{file}: error: {count} pairs of marks `<!-- {name}: ... -->`, "
                f"`<!-- end of {name} -->`; restore the pair of marks around the text"
            )
    return page


def text_between(page: str, name: str, file: object) -> str:
    """The text between the marks of a name. Raises MarksError as `between_marks`."""
    between_marks(page, {name: ""}, file)
    begin = page.index("\n", page.index(f"<!-- {name}: ")) + 1
    return page[begin : page.index(f"<!-- end of {name} -->", begin)]


def write_between_marks(page: Path, texts: Mapping[str, str]) -> None:
    """Put the texts into a page. Raises MarksError as `between_marks`."""
    text = between_marks(page.read_text(encoding="utf-8"), texts, page)
    write_text(page, text)
