# SPDX-License-Identifier: Apache-2.0
"""Planted faults of the proofs still find their text in the RTL; needs neither solver nor Yosys."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("tests/formal", "tests/formal_motion")


def _faults() -> list[tuple[str, str]]:
    """(file below rtl/, text to replace) of every `Fault(..)` that is written with constants."""
    found = []
    for source in sorted(path for folder in FOLDERS for path in (ROOT / folder).glob("*.py")):
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Fault":
                words = [argument.value for argument in node.args if hasattr(argument, "value")]
                if len(words) == 3 and source.name not in ("test_formal.py", Path(__file__).name):
                    found.append((words[0], words[1]))
    return found


FAULTS = _faults()


def test_faults__are_found() -> None:
    assert len(FAULTS) > 40


@pytest.mark.parametrize(("file", "text"), FAULTS)
def test_fault__its_text_stands_in_the_unit(file: str, text: str) -> None:
    assert text in (ROOT / "rtl" / file).read_text(encoding="utf-8")
