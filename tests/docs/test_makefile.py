# SPDX-License-Identifier: Apache-2.0
"""The Makefile: few targets with a line of help each, and a cure for each that it had before."""

from __future__ import annotations

import os
import re
import subprocess

import pytest

from sim.rtl.build import ROOT
from sim.verbs import GROUPS, OF_A_CHECKOUT, verbs

TEXT = (ROOT / "Makefile").read_text(encoding="utf-8")
EXPLAINED = re.findall(r"^([a-z-]+):.*## \S", TEXT, re.M)
MOST = 16
"""What a newcomer can take in."""
INTERNAL = {"tools-for-tests", "checks"} | {
    f"lint-{part}" for part in ("rtl", "python", "types", "registers", "site")
}
"""Parts of others, which nobody types."""
PHONY = set(" ".join(re.findall(r"^\.PHONY: (.*)$", TEXT, re.M)).split())
LISTS = {
    name: words.replace("\\\n", " ").split()
    for name, words in re.findall(r"^(\w+) := ((?:.*\\\n)*.*)$", TEXT, re.M)
}
MOVED = [*LISTS["VERBS"], *LISTS["RENAMED"], *LISTS["TOOL_TARGETS"]]


def made(*words: str) -> subprocess.CompletedProcess[str]:
    """How make ends, as called from a shell."""
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}
    return subprocess.run(
        ["make", *words], cwd=ROOT, env=environment, capture_output=True, text=True
    )


def test_targets__are_few_and_each_is_explained():
    assert 10 < len(EXPLAINED) <= MOST
    lists = {f"$({name})" for name in ("VERBS", "RENAMED", "TOOL_TARGETS")}
    assert PHONY == {*EXPLAINED, *INTERNAL, *lists}
    shown = made("help").stdout
    assert re.findall(r"^  make ([a-z-]+) ", shown, re.M) == EXPLAINED
    assert ".venv/bin/microtick --help" in shown


@pytest.mark.parametrize("target", MOVED)
def test_target_of_earlier_versions__names_in_one_line_what_replaced_it(target):
    done = made(target)
    assert done.returncode == 2 and done.stdout == "" and done.stderr.count("\n") == 1
    (cure,) = re.findall(r"is now '([^']+)'", done.stderr)
    words = cure.split()
    if words[0] == "make":
        assert words[1] in EXPLAINED
    else:
        assert words[0] == ".venv/bin/microtick"
        assert words[1] in verbs(GROUPS | OF_A_CHECKOUT)


@pytest.mark.parametrize("tool", LISTS["TOOL_TARGETS"])
def test_tools__are_got_by_their_names_and_by_no_other(tool):
    done = made("-n", "tools", f"T={tool}")
    assert done.returncode == 0 and re.search(r"scripts/\w+\.sh|sim[.\w]*\.oracle", done.stdout)
    wrong = made("-n", "tools", f"T={tool}x")
    assert wrong.returncode == 2 and tool in wrong.stderr
