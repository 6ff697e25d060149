# SPDX-License-Identifier: Apache-2.0
"""docs/your_robot.md word for word: its files and commands in an empty folder."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from scripts.doc_blocks import code_blocks
from sim.harness.build import ROOT

BLOCKS = code_blocks(ROOT / "docs/your_robot.md")


def test_commands_of_the_page_compile_prove_and_run(tmp_path):
    home = tmp_path / "home"
    work = home / "robot"
    work.mkdir(parents=True)
    (home / "microtick").symlink_to(ROOT)
    for block in BLOCKS:
        if block.title:
            (work / block.title).write_text(block.text)
    script = "".join(block.text for block in BLOCKS if block.language == "sh")
    tools = Path(sys.executable).parent
    done = subprocess.run(
        ["sh", "-e"],
        input=script,
        cwd=work,
        env={"HOME": str(home), "PATH": f"{tools}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=900,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("bits equal the interpreter's") == 6
    assert len(re.findall("^proved$", done.stdout, re.M)) == 4
    assert "200 ticks of 2 functions in turn" in done.stdout
    assert "closed loop: 1000 ticks" in done.stdout
    on_core, in_c, _ = re.findall(r"^ *torque +=? *([-+0-9.e]+)", done.stdout, re.M)
    assert float(on_core) == float(in_c) != 0
