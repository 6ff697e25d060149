# SPDX-License-Identifier: Apache-2.0
"""The changelog begins with the version of the package, its date, and how to upgrade to it.

What is not released yet is in docs/changes, a fragment each.
"""

from __future__ import annotations

import datetime
import re
import sys
import tomllib
from pathlib import Path

from packaging.version import Version

from asip_asm.project import ROOT
from tests.bench.commands import output

HEADING = re.compile(r"^## (\S+)(?: \((\S+)\))?$", re.M)


def test_newest_entry__is_the_version_of_the_package__dated__with_an_upgrade_note():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = HEADING.findall(text)
    assert len(found) == text.count("\n## ") > 1
    (version, date), (before, _) = found[:2]
    assert version == project["version"]
    datetime.date.fromisoformat(date)
    versions = [Version(each) for each, _ in found]
    assert versions == sorted(versions, reverse=True) and len(set(versions)) == len(versions)
    newest = HEADING.split(text)[3]
    assert newest.startswith(f"\n\nUpgrade from {before}\n\n- ")


def test_fragments__are_all_in_the_draft_of_the_next_version():
    towncrier = Path(sys.executable).with_name("towncrier")
    draft = output(towncrier, "build", "--draft", "--version", "next", cwd=ROOT)
    fragments = sorted((ROOT / "docs/changes").glob("*.md"))
    assert draft.count("\n- ") == len(fragments) > 0
    for fragment in fragments:
        lines = fragment.read_text(encoding="utf-8").splitlines()
        assert "\n- " + "\n  ".join(lines) + "\n" in draft, fragment.name


def test_pages__name_the_wheel_of_this_version():
    """And the release step its tag."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    pages = {"docs/your_robot.md": "microtick-{}-py3", "CONTRIBUTING.md": "git tag -a v{} "}
    for page, text in pages.items():
        assert text.format(project["version"]) in (ROOT / page).read_text(encoding="utf-8")
