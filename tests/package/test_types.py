# SPDX-License-Identifier: Apache-2.0
"""The check of types: which errors count, and that an error more than allowed is found."""

from __future__ import annotations

import re

import pytest

from asip_asm.project import ROOT
from scripts import lint_types

ONE = 'asip_asm/image.py:3: error: "None" has no attribute "x"  [union-attr]'
TWO = "sim/rtl/build.py:7: error: Missing return  [return]"


def test_errors__are_counted_by_package_and_room():
    found = lint_types.by_folder([ONE, TWO, TWO, "sim/rtl/build.py:7: note: error"])
    assert {folder: len(lines) for folder, lines in found.items()} == {"asip_asm": 1, "sim/rtl": 2}
    assert lint_types.by_folder(["sim/moved.py:1: error: x"])["sim/moved.py"]
    with pytest.raises(ValueError, match="no file"):
        lint_types.by_folder(["error: no file"])


def test_errors__beyond_those_allowed_are_findings():
    found = lint_types.by_folder([ONE, TWO, TWO])
    assert lint_types.findings(found, {"asip_asm": 1, "sim/rtl": 2}) == []
    (*lines, last) = lint_types.findings(found, {"asip_asm": 1, "sim/rtl": 1})
    assert lines == [TWO, TWO] and last == "sim/rtl: 2 errors, 1 allowed"
    assert all(each.startswith("sim/") for each in lint_types.LEFT)


def test_ignores__name_their_code_and_their_reason():
    for package in ("asip_asm", "sim", "scripts"):
        for file in (ROOT / package).rglob("*.py"):
            for line in re.findall(r".*#\s*type:\s*ignore.*", file.read_text(encoding="utf-8")):
                assert re.search(r"type: ignore\[[\w-]+\]\s+# \w", line), f"{file}: {line}"
