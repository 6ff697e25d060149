# SPDX-License-Identifier: Apache-2.0
"""Counts long sentences and house words on the pages: `python -m tests.docs.plain_english`."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt
from markdown_it.token import Token

from asip_asm.project import ROOT

LONGEST = 35  # words in a sentence
SENTENCE_END = re.compile(r"(?<=[.!?])\)?\s+(?=[^a-z\s])")
ABBREVIATION = re.compile(r"\b(?:e\.g|i\.e|vs|cf|Dr|no|fig|sec)\.$", re.I)
# Each house word, and what an engineer writes instead.
CURES = {
    r"behind": "after, following or downstream of",
    r"kept": "saved, cached or left",
    r"stands?|stood": "is, or is defined in",
    r"beside": "next to, alongside or compared with",
    r"tells?|told": "reports, prints or states",
    r"but\s+for": "except",
    r"anew": "again",
    r"alike": "the same",
    r"judge[sd]?": "checked",
    r"said": "stated",
    r"asked for": "requested",
}
HOUSE_WORD = re.compile(rf"\b(?:{'|'.join(f'({word})' for word in CURES)})\b", re.I)
MARKDOWN = MarkdownIt("commonmark").enable("table")


@dataclass(frozen=True)
class Finding:
    """A place in a page and what to do about it."""

    page: str
    line: int
    text: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}: {self.text}"


def prose(inline: Token) -> str:
    """Text of a block; code in the text counts as one word, a picture as none."""
    parts = []
    for child in inline.children or []:
        if child.type == "code_inline":
            parts.append("`code`")
        elif child.type in ("softbreak", "hardbreak"):
            parts.append("\n")
        elif child.type == "text":
            parts.append(child.content)
    return "".join(parts)


def sentences(text: str) -> Iterator[tuple[int, str]]:
    """Each sentence with the number of lines before it in the block."""
    begin = 0
    for end in [*(m.end() for m in SENTENCE_END.finditer(text)), len(text)]:
        if ABBREVIATION.search(text[begin:end].rstrip()):
            continue
        yield text.count("\n", 0, begin), text[begin:end].strip()
        begin = end


def words(sentence: str) -> int:
    """Words of a sentence; a dash or a sign by itself is none."""
    return sum(1 for word in sentence.split() if re.search(r"\w", word))


def blocks(source: str) -> Iterator[tuple[int, str, bool]]:
    """First line, prose and whether it is in a table, of each block that is not code."""
    table = False
    line = 1
    for token in MARKDOWN.parse(source):
        table = (table or token.type == "table_open") and token.type != "table_close"
        if token.map:
            line = token.map[0] + 1
        if token.type == "inline":
            yield line, prose(token), table


def long_sentences(page: str, source: str) -> Iterator[Finding]:
    """Sentences of more words than LONGEST outside of tables."""
    for line, text, table in blocks(source):
        for before, sentence in [] if table else sentences(text):
            count = words(sentence)
            if count > LONGEST:
                start = " ".join(sentence.split()[:8])
                yield Finding(page, line + before, f"{count} words, split it: {start} ...")


def house_words(page: str, source: str) -> Iterator[Finding]:
    """House words in text and tables."""
    for line, text, _ in blocks(source):
        for found in HOUSE_WORD.finditer(text):
            cure = list(CURES.values())[found.lastindex - 1]
            place = line + text.count("\n", 0, found.start())
            yield Finding(page, place, f"`{found[0]}`, write {cure}")


def pages(root: Path = ROOT) -> dict[str, str]:
    """Text of README and of every page; fragments of the changelog are no pages."""
    found = texts(root, root / "README.md", *sorted((root / "docs").rglob("*.md")))
    return {page: text for page, text in found.items() if not page.startswith("docs/changes/")}


def changes(root: Path = ROOT) -> dict[str, str]:
    """Text of each fragment of the changelog."""
    return texts(root, *sorted((root / "docs/changes").glob("*.md")))


def texts(root: Path, *files: Path) -> dict[str, str]:
    return {str(f.relative_to(root)): f.read_text(encoding="utf-8") for f in files}


def main() -> int:
    """Print every finding of the pages named, or of all, and the two counts."""
    chosen = {
        p: t for p, t in (pages() | changes()).items() if not sys.argv[1:] or p in sys.argv[1:]
    }
    long = [f for page, text in chosen.items() for f in long_sentences(page, text)]
    house = [f for page, text in chosen.items() for f in house_words(page, text)]
    print("\n".join(str(f) for f in sorted([*long, *house], key=lambda f: (f.page, f.line))))
    print(f"{len(long)} sentences of more than {LONGEST} words, {len(house)} house words")
    return 0


if __name__ == "__main__":
    sys.exit(main())
