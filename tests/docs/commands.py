# SPDX-License-Identifier: Apache-2.0
"""The commands that README and docs show, in blocks and in running text."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from scripts.doc_blocks import Block, code_blocks
from sim.rtl.build import ROOT

OWN_TESTS = ("own_machine.md", "your_robot.md")  # word for word: test_own_machine, test_wheel
PAGES = [
    ROOT / "README.md",
    *sorted(page for page in (ROOT / "docs").glob("*.md") if page.name not in OWN_TESTS),
]
FIRST_WORD = re.compile(
    r"(?:make|python|pytest|cc|verilator|yosys|nios2-elf-gcc|microtick|(?:\.venv/bin/)?(?:asip|nios)-\w+"
    r"|\.venv/bin/\w+)(?: |$)"
)
INLINE = re.compile(
    r"`((?:make|microtick |python -m|python scripts/|\.venv/bin/|asip-|nios-)[^`\n]*)`"
)
PLACEHOLDER = re.compile(r"\.\.\.|\b(?:name|n|N|NAME|FILE|COMMIT|prog)\b|://host")


@dataclass(frozen=True)
class Command:
    """A command line as the page shows it, without its comment."""

    where: str
    text: str

    @property
    def words(self) -> list[str]:
        return shlex.split(self.text, comments=True)

    def __str__(self) -> str:
        return f"{self.where} {self.text}"


def shell_lines(block: Block) -> list[str]:
    """Command lines of a block, continued ones joined; empty for another kind of block."""
    joined = block.text.replace("\\\n", " ")
    lines = [line for line in joined.splitlines() if line.strip()]
    if block.language not in ("", "sh") or not any(FIRST_WORD.match(line) for line in lines):
        return []
    return [" ".join(line.split()) for line in lines]


def block_commands() -> Iterator[Command]:
    """Commands of the shell blocks."""
    for page in PAGES:
        for block in code_blocks(page):
            for line in shell_lines(block):
                yield Command(str(block), line)


def inline_commands() -> Iterator[Command]:
    """Commands between backquotes in the text of every Markdown file, placeholders left out."""
    tracked = [*PAGES, *(ROOT / "docs" / name for name in OWN_TESTS), *ROOT.glob("[!.]*/README.md")]
    tracked += [page for page in ROOT.glob("[!.]*/*/**/README.md") if "build" not in page.parts]
    for page in tracked:
        text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
        for found in INLINE.finditer(text):
            for part in found[1].split("; proved: "):
                if not PLACEHOLDER.search(part):
                    yield Command(page.name, part)


def programs() -> Iterator[Block]:
    """Whole programs in assembly."""
    for page in PAGES:
        for block in code_blocks(page):
            whole = re.search(r"^\s*halt\b|\bhalt$", block.text, re.M) and ".output" in block.text
            if whole and block.language != "python":
                yield block


def names_of_tests(root: Path = ROOT) -> list[str]:
    """Folder, file and function of every test, as `make test T=` sees them, in lower case."""
    names = []
    for path in sorted((root / "tests").rglob("test_*.py")):
        place = path.relative_to(root / "tests").as_posix()
        for function in re.findall(r"^def (test_\w+)", path.read_text(encoding="utf-8"), re.M):
            names.append(f"{place}::{function}".lower())
    return names
