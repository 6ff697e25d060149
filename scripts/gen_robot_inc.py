# SPDX-License-Identifier: Apache-2.0
"""Write asip_asm/programs/robot.inc, the robot's parameters for programs, from sim/robot.toml.

`python scripts/gen_robot_inc.py` writes the file, `--check` exits with 1 if it differs.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "sim" / "robot.toml"
TARGET = ROOT / "asip_asm" / "programs" / "robot.inc"
HEADER = """\
; SPDX-License-Identifier: Apache-2.0
; Generated from sim/robot.toml by scripts/gen_robot_inc.py: the robot's parameters.
"""


def render() -> str:
    """Text of robot.inc: per parameter its meaning as a comment and a .param line with unit."""
    parameters = tomllib.loads(SOURCE.read_text(encoding="utf-8"))
    lines = [
        f"; {entry['meaning']}\n.param {name} = {entry['value']!r}  ; [{entry['unit']}]"
        for name, entry in parameters.items()
    ]
    return HEADER + "\n".join(lines) + "\n"


def main(arguments: list[str]) -> int:
    """Write or check the file; returns the exit status."""
    text = render()
    if arguments == ["--check"]:
        if TARGET.is_file() and TARGET.read_text(encoding="utf-8") == text:
            return 0
        sys.stderr.write(f"{TARGET.relative_to(ROOT)} differs: run scripts/gen_robot_inc.py\n")
        return 1
    TARGET.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
