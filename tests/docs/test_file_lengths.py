# SPDX-License-Identifier: Apache-2.0
"""Length of the files that people write (CONTRIBUTING.md)."""

import subprocess

from asip_asm.project import ROOT


def test_files_of_the_packages__have_450_lines_at_most():
    command = ["git", "ls-files", "asip_asm", "sim", "scripts"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    files = [ROOT / name for name in listed.stdout.splitlines() if "/gen/" not in name]
    assert files and [f for f in files if f.read_bytes().count(b"\n") > 450] == []
