# SPDX-License-Identifier: Apache-2.0
"""The tests of the assembler search for every schedule themselves."""

import pytest

from asip_asm import schedule, search


@pytest.fixture(autouse=True)
def searching(monkeypatch):
    monkeypatch.setattr(schedule, "search", search.search)
