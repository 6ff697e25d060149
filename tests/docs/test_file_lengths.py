# SPDX-License-Identifier: Apache-2.0
"""Length of the files that people write (CONTRIBUTING.md)."""

from asip_asm.project import ROOT
from tests.bench.commands import output


def test_files_of_the_packages__have_800_lines_at_most():
    listed = output("git", "ls-files", "asip_asm", "sim", "scripts", cwd=ROOT).splitlines()
    files = [ROOT / name for name in listed if "/gen/" not in name and not name.endswith(".lock")]
    assert files and [f for f in files if f.read_bytes().count(b"\n") > 800] == []
