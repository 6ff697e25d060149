# SPDX-License-Identifier: Apache-2.0
"""robot.inc is what scripts/gen_robot_inc.py makes of sim/robot.toml."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

from sim.model.parameters import Robot

ROOT = Path(__file__).parents[2]
INCLUDE = ROOT / "asip_asm" / "programs" / "robot.inc"


def test_include_is_up_to_date():
    script = ROOT / "scripts" / "gen_robot_inc.py"
    done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_include_holds_every_parameter_with_its_value():
    lines = re.findall(r"^\.param (\w+) += (\S+) ", INCLUDE.read_text(), re.M)
    assert {name: float(value) for name, value in lines} == asdict(Robot.load())
