# SPDX-License-Identifier: Apache-2.0
"""Annotated sources: golden words of ok_*.s, verbatim errors of err_*.s."""

import json
import re
from pathlib import Path

import pytest

from asip_asm.disassemble import disassemble
from tests.asm.annotated import (
    FOLDER,
    WARNING,
    expected_errors,
    expected_words,
    found_errors,
    found_warnings,
    run,
)

ROOT = FOLDER.parents[1]
GOOD = sorted(path.name for path in FOLDER.glob("ok_*.s"))
DOUBTFUL = sorted(path.name for path in FOLDER.glob("warn_*.s"))
PROJECT = [
    *sorted((ROOT / "asip_asm" / "programs").glob("*.s")),
    ROOT / "sim" / "core" / "host" / "leg_length.s",
]
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


@pytest.mark.parametrize("name", DOUBTFUL)
def test_doubtful_source__gives_the_stated_warnings_and_no_other(name: str) -> None:
    assert found_warnings(source(name)) == expected_errors(source(name), WARNING)


@pytest.mark.parametrize("path", PROJECT, ids=lambda path: path.name)
def test_program_of_the_project__has_no_warning(path: Path) -> None:
    assert found_warnings(path.relative_to(ROOT)) == []


def test_samples_of_the_documents__have_no_warning(tmp_path: Path) -> None:
    samples = 0
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        blocks = re.findall(r"^```[^\n]*\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)
        for text in (text for text in blocks if ".output" in text and "        halt" in text):
            sample = tmp_path / f"{page.stem}.s"
            sample.write_text(text, encoding="utf-8")
            assert found_warnings(sample) == [], f"{page.name}\n{text}"
            samples += 1
    assert samples > 10


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
