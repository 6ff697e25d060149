# SPDX-License-Identifier: Apache-2.0
"""The test of every section of docs/cocotb_blocks.md, run as a user saves it."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from scripts.doc_blocks import code_blocks, write_files

PAGE = ROOT / "docs/cocotb_blocks.md"
FILES = [block.title for block in code_blocks(PAGE) if block.title]


def test_page__every_section_has_a_test():
    assert len(FILES) == PAGE.read_text(encoding="utf-8").count("\n## ")


@pytest.mark.parametrize("name", FILES)
def test_page__test_of_a_kind_of_block(name, tmp_path, monkeypatch):
    write_files(PAGE, tmp_path)
    monkeypatch.chdir(tmp_path)
    module = runpy.run_path(name)
    module[Path(name).stem]()
