# SPDX-License-Identifier: Apache-2.0
"""Assertion files of sim/rtl/assertions that bind to the modules of a model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from asip_asm.project import BUILD, ROOT

FOLDER = Path(__file__).resolve().with_name("assertions")
RULES = sorted(FOLDER.glob("*_rules.sv"))  # checkers that several of the files instantiate


def assertions_of(sources: Sequence[Path]) -> list[Path]:
    """Files with the assertions of the modules in `sources`: <module>_sva.sv, and what they use.

    None if any source is no file of the project but a changed copy: what a planted fault breaks is
    for the tests of its table to find.
    """
    for source in sources:
        place = Path(source).resolve()
        if not place.is_relative_to(ROOT) or place.is_relative_to(BUILD):
            return []
    found = (FOLDER / f"{Path(source).stem}_sva.sv" for source in sources)
    bound = list(dict.fromkeys(path for path in found if path.is_file()))
    return [*RULES, *bound] if bound else []
