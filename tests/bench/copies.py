# SPDX-License-Identifier: Apache-2.0
"""Copies of files and of the project, for tests that change something in them."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from asip_asm.project import BUILD


def share_models(build: Path, *patterns: str) -> None:
    """Link models of this checkout into another build folder, by their names below build/model.

    "verilated-*" is Verilator's run-time library. A name has the hash of all that goes in, so that
    none is taken for another one.
    """
    folder = build / "model"
    folder.mkdir(parents=True, exist_ok=True)
    for pattern in patterns:
        for built in BUILD.glob(f"model/{pattern}"):
            (folder / built.name).symlink_to(built)


def edited_folder(folder: Path, copy: Path, file: str, pattern: str, new: str) -> Path:
    """A copy of a folder, made again; in one of its files the match of a regular expression, of
    which there must be one, is `new`."""
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(folder, copy)
    text, count = re.subn(pattern, new, (copy / file).read_text())
    assert count == 1, f"{file}: {count} matches of {pattern}"
    (copy / file).write_text(text)
    return copy


def edited(source: Path, folder: Path, old: str, new: str) -> Path:
    """A copy of a file in the folder, the first `old`, which must be there, being `new` in it."""
    text = source.read_text(encoding="utf-8")
    assert old in text
    copy = folder / source.name
    copy.write_text(text.replace(old, new, 1), encoding="utf-8")
    return copy


def changed(source: Path, folder: Path, change: str) -> Path:
    """As `edited`, for a change `a<b|c>d`: `abd` in the source, `acd` in the copy.

    There is no `<` in a, no `|` in b and no `>` in d.
    """
    before, right, wrong, after = re.fullmatch(r"([^<]*)<([^|]*)\|(.*)>(.*)", change, re.S).groups()
    return edited(source, folder, before + right + after, before + wrong + after)
