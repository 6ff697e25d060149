# SPDX-License-Identifier: Apache-2.0
"""The reading order of docs/index.md is that of the site, and every page is in it."""

import re

from asip_asm.project import ROOT

PAGE = re.compile(r"\b[\w/]+\.md\b")


def test_pages__of_the_index__are_those_of_the_site_in_order() -> None:
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    order = PAGE.findall(site[site.index("\nnav:") :])
    index = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    assert ["index.md", *re.findall(r"\]\(([\w/]+\.md)\)", index)] == order
    assert sorted(order) == sorted(path.name for path in (ROOT / "docs").glob("*.md"))
