# SPDX-License-Identifier: Apache-2.0
"""Annotated sources: golden words of ok_*.s, verbatim errors of err_*.s."""

import json
from pathlib import Path

import pytest

from asip_asm.disassemble import disassemble
from tests.asm.annotated import FOLDER, expected_errors, expected_words, found_errors, run

ROOT = FOLDER.parents[1]
GOOD = sorted(path.name for path in FOLDER.glob("ok_*.s"))
BAD = sorted(path.name for path in FOLDER.glob("err_*.s"))


@pytest.fixture(autouse=True)
def in_repository(monkeypatch: pytest.MonkeyPatch) -> None:
    """Messages and images show paths relative to the working directory."""
    monkeypatch.chdir(ROOT)


def source(name: str) -> Path:
    return FOLDER.relative_to(ROOT) / name


@pytest.mark.parametrize("name", GOOD)
def test_good_source__gives_the_stated_words(name: str) -> None:
    assert run(source(name)).bundles == expected_words(source(name))


@pytest.mark.parametrize("name", BAD)
def test_bad_source__gives_the_stated_errors_and_no_other(name: str) -> None:
    expected = expected_errors(source(name))
    assert expected, f"{name} states no error"
    assert found_errors(source(name)) == expected


@pytest.mark.parametrize("name", ["ok_leg_length", "ok_states", "ok_constants", "ok_branches"])
def test_good_source__gives_the_golden_image(name: str) -> None:
    golden = source(f"golden_{name.removeprefix('ok_')}.asip.json")
    found = run(source(f"{name}.s")).to_json()
    expected = json.loads(golden.read_text(encoding="utf-8"))
    # The estimate follows the latencies of the arithmetic units; it exists without branches only.
    assert (found.pop("cycles") is None) == (expected.pop("cycles") is None)
    assert expected.pop("checksum").startswith("sha256:") and found.pop("checksum")
    assert found == expected


@pytest.mark.parametrize("name", GOOD)
def test_good_source__disassembled__reassembles_to_the_same_image(
    name: str, tmp_path: Path
) -> None:
    image = run(source(name))
    again = tmp_path / "again.s"
    again.write_text(disassemble(image), encoding="utf-8")
    copy = run(again)
    copy.sources = image.sources
    assert copy == image
