# SPDX-License-Identifier: Apache-2.0
"""Types: `make lint` runs mypy on everything; no error is silenced without code and reason."""

from __future__ import annotations

import re

from asip_asm.project import ROOT


def test_ignores__name_their_code_and_their_reason():
    for package in ("asip_asm", "sim", "scripts"):
        for file in (ROOT / package).rglob("*.py"):
            for line in re.findall(r".*#\s*type:\s*ignore.*", file.read_text(encoding="utf-8")):
                assert re.search(r"type: ignore\[[\w-]+\]\s+# \w", line), f"{file}: {line}"
