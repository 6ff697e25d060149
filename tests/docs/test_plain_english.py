# SPDX-License-Identifier: Apache-2.0
"""README, pages and changes have few long sentences and few house words; each is printed, with a
cure."""

import pytest

from tests.docs.plain_english import Finding, changes, house_words, long_sentences, pages

MOST_LONG, MOST_HOUSE = 20, 60  # in all pages together
MOST_WRITTEN = 35  # pages that are not generated
PAGES = pages()
TEXTS = PAGES | changes()


def listed(findings: list[Finding]) -> str:
    return "\n".join(str(finding) for finding in findings)


def test_pages__sentences_are_short() -> None:
    found = [f for page, text in TEXTS.items() for f in long_sentences(page, text)]
    assert len(found) <= MOST_LONG, listed(found)


def test_pages__few_house_words() -> None:
    found = [f for page, text in TEXTS.items() for f in house_words(page, text)]
    assert len(found) <= MOST_HOUSE, listed(found)


def test_pages__few_are_written_by_hand() -> None:
    written = [page for page, text in PAGES.items() if not text.startswith("<!-- GENERATED")]
    written.remove("README.md")
    assert len(written) <= MOST_WRITTEN, f"{len(written)} pages, merge some: {', '.join(written)}"


LONG = " ".join(["The", *["word"] * 34, "ends."])


@pytest.mark.parametrize(
    "text",
    [
        LONG,
        f"Short. {LONG}",
        f"- {LONG}",
        f"First line\n{LONG}",
        LONG.replace("word word", "word `some code`"),
        f"## A heading\n\n{LONG}",
    ],
)
def test_long_sentence__is_found(text: str) -> None:
    (finding,) = long_sentences("page.md", text)
    assert "split it" in str(finding)


@pytest.mark.parametrize(
    "text",
    [
        LONG.replace(" word", "", 1),
        LONG.replace("word word word", "word. Word word"),
        f"```\n{LONG}\n```",
        f"| head |\n| --- |\n| {LONG} |",
    ],
)
def test_long_sentence__is_not_seen_in_code_tables_and_short_ones(text: str) -> None:
    assert not list(long_sentences("page.md", text))


@pytest.mark.parametrize("word", ["behind", "told", "Beside", "but for", "but\nfor"])
def test_house_word__is_found_in_text_and_tables(word: str) -> None:
    (finding,) = house_words("page.md", f"One line.\n\nIt is {word} it.")
    assert str(finding).startswith("page.md:3: ") and ", write " in str(finding)
    if "\n" not in word:
        assert list(house_words("page.md", f"| head |\n| --- |\n| is {word} it |"))


def test_house_word__is_not_seen_in_code() -> None:
    assert not list(house_words("page.md", "A file `beside.py`.\n\n```\nbehind\n```"))
