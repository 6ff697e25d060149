# SPDX-License-Identifier: Apache-2.0
"""Code blocks of a Markdown page, for the tests and commands that run them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from asip_asm.files import write_text

BLOCK = re.compile(
    r'^```(?P<language>\w*)(?: title="(?P<title>[^"]+)")?\n(?P<text>.*?)^```$', re.M | re.S
)


@dataclass(frozen=True)
class Block:
    """A fenced block: first line number, language ('' without one), title or None, text."""

    page: str
    line: int
    language: str
    title: str | None
    text: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def write_files(page: Path, folder: Path) -> None:
    """Write the blocks that have a title into the folder."""
    for block in code_blocks(page):
        if block.title:
            write_text(folder / block.title, block.text)


def code_blocks(page: Path) -> list[Block]:
    """Blocks of the page in order."""
    source = page.read_text(encoding="utf-8")
    return [
        Block(
            page.name,
            source.count("\n", 0, found.start()) + 1,
            found["language"],
            found["title"],
            found["text"],
        )
        for found in BLOCK.finditer(source)
    ]
