# SPDX-License-Identifier: Apache-2.0
"""Cached results count for their fingerprint and undamaged only."""

from __future__ import annotations

import pytest

from sim.report import cache
from sim.report.cache import Entry


def never() -> int:
    """A measurement that must not be made."""
    raise AssertionError("measured again")


def test_result__is_measured_once_for_a_fingerprint(tmp_path):
    first, second = (Entry(tmp_path / "folder/a.json", mark) for mark in ("one", "two"))
    found = {"cases": [0.1, None], "counts": {3: (1, 2)}}
    read = {"cases": [0.1, None], "counts": {"3": [1, 2]}}
    assert cache.load(first) is None
    # The first caller gets what later ones get: numbers as names are text in JSON.
    assert cache.result_of(first, lambda: found) == cache.result_of(first, never) == read
    assert cache.load(second) is None
    assert cache.result_of(second, lambda: 0) == cache.result_of(second, never) == 0
    assert cache.load(first) is None


@pytest.mark.parametrize(
    ("right", "wrong"),
    [("51", "52"), ('"result"', '"outcome"'), ("}", ""), ("fingerprint", "finger"), ("{", "[1]")],
)
def test_result__of_a_damaged_file__is_reported_and_measured_again(right, wrong, tmp_path, capsys):
    entry = Entry(tmp_path / "a.json", "mark")
    cache.save(entry, 51)
    text = entry.path.read_text()
    assert right in text
    entry.path.write_text(text.replace(right, wrong))
    assert cache.load(entry) is None
    assert capsys.readouterr().err == f"{entry.path}: damaged, so its result does not count\n"
    assert cache.result_of(entry, lambda: 53) == 53


def test_result__that_json_cannot_hold__leaves_the_earlier_one(tmp_path):
    entry = Entry(tmp_path / "a.json", "mark")
    cache.save(entry, 1)
    with pytest.raises(TypeError):
        cache.save(entry, {1, 2})
    assert cache.load(entry) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


def test_fingerprint__changes_with_names_contents_and_choices_alone(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    one, other = folder / "one.py", folder / "other.py"
    one.write_text("1")
    other.write_text("2")
    first = cache.fingerprint([folder], "choice")
    (folder / "one.pyc").write_text("compiled")
    assert cache.fingerprint([folder], "choice") == first
    assert cache.fingerprint([other, one, folder], "choice") == first
    assert cache.fingerprint([one], "choice") != first
    assert cache.fingerprint([folder], "other choice") != first
    other.write_text("3")
    changed = cache.fingerprint([folder], "choice")
    other.rename(folder / "renamed.py")
    assert len({first, changed, cache.fingerprint([folder], "choice")}) == 3


def test_fingerprint__of_a_file_that_is_not_there__is_an_error(tmp_path):
    with pytest.raises(FileNotFoundError, match="none"):
        cache.fingerprint([tmp_path / "none"])
