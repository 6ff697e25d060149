# SPDX-License-Identifier: Apache-2.0
"""Every commit that a document or a saved result names is one of this history."""

from __future__ import annotations

import re
import subprocess

from asip_asm.project import ROOT
from tests.bench.needs import needs

NAMED = re.compile(
    r"\bcommits? (?:of )?`?([0-9a-f]{7,12})\b|, ([0-9a-f]{12}) \(|commit\": \"([0-9a-f]+)\""
)


def git(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)


def named(text: str) -> set[str]:
    """Commits that a text names."""
    return {next(filter(None, found.groups())) for found in NAMED.finditer(text)}


@needs("history")
def test_commits__named_as_the_measured_one__are_in_the_history():
    files = [
        ROOT / "README.md",
        *(ROOT / "docs").glob("*.md"),
        *(ROOT / "docs/data").glob("*.json"),
    ]
    found = {(file.name, name) for file in files for name in named(file.read_text())}
    assert len({name for _, name in found}) > 5
    lost = [
        f"{file}: {n}"
        for file, n in sorted(found)
        if git("cat-file", "-e", f"{n}^{{commit}}").returncode
    ]
    assert not lost, f"{', '.join(lost)}: not in this history; measure again"
    foreign = [
        f"{file}: {n}"
        for file, n in sorted(found)
        if git("merge-base", "--is-ancestor", n, "HEAD").returncode
    ]
    assert not foreign, f"{', '.join(foreign)}: of another branch; measure again"


def test_commits__in_the_forms_of_the_documents__are_seen():
    text = "Measured at commit 610ca437cc99 (asip_fast, asip_small), a180cc1ac7cb (n2_core)."
    assert named(text) == {"610ca437cc99", "a180cc1ac7cb"}
    assert named('"commit": "0c9d858730ad"') == {"0c9d858730ad"}
