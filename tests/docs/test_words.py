# SPDX-License-Identifier: Apache-2.0
"""No word in code or documents that only those who began the project understood."""

import re

from asip_asm.project import ROOT
from tests.bench.commands import output

# A "seed" is where random numbers begin, nothing else.
PRIVATE = re.compile(
    r"seed[ _-]?0\d\d|seed[ _-]?(compatible|plan|mode)|SeedPlan|\brobot\.md\b", re.I
)
TEXTS = (".py", ".md", ".sv", ".s", ".inc", ".c", ".h", ".cpp", ".toml", ".yml", ".sh", ".txt")


def test_private_words__no_file_has_them():
    listed = output("git", "ls-files", cwd=ROOT).splitlines()
    files = [ROOT / name for name in listed if name.endswith(TEXTS)]
    assert len(files) > 500
    found = [
        f"{file.relative_to(ROOT)}:{number}: {line.strip()}"
        for file in files
        if file.name != "test_words.py" and file.is_file()
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1)
        if PRIVATE.search(line)
    ]
    assert not found, "\n".join(found)


def test_private_words__are_seen():
    assert PRIVATE.search("mode of seed 002") and PRIVATE.search("seed_plan(1)")
    assert not PRIVATE.search("random programs, seed 1, of --seed 12")
