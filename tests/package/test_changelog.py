# SPDX-License-Identifier: Apache-2.0
"""The changelog begins with the version of the package, its date, and how to upgrade to it.

What is not released yet may come before it.
"""

from __future__ import annotations

import datetime
import re
import tomllib

from packaging.version import Version

from asip_asm.project import ROOT

UNRELEASED = re.compile(r"^## Unreleased\n.*?(?=^## )", re.M | re.S)
HEADING = re.compile(r"^## (\S+)(?: \((\S+)\))?$", re.M)


def test_newest_entry__is_the_version_of_the_package__dated__with_an_upgrade_note():
    text = UNRELEASED.sub("", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
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


def test_pages__name_the_wheel_of_this_version():
    """And the release step its tag."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    pages = {"docs/your_robot.md": "microtick-{}-py3", "CONTRIBUTING.md": "git tag -a v{} "}
    for page, text in pages.items():
        assert text.format(project["version"]) in (ROOT / page).read_text(encoding="utf-8")
