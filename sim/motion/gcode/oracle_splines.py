# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC's own points of the splines of a program: `gcode`, the module that makes its previews.

rs274 prints of a spline no more than NURBS_FEED(n, ...) with its number of control points. The same
interpreter in this module evaluates it at 15 n steps of the parameter. It runs in a Python of its
own, because it needs LinuxCNC's libraries: this file is also that program.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from asip_asm.files import write_text

Point = tuple[float, float, float]
_MM = 25.4  # the module counts in inches
_MOVES = ("straight_traverse", "straight_feed", "arc_feed")
_ANSWERS = {
    "get_external_length_units": 1 / _MM,  # of the machine, per mm
    "get_external_angular_units": 1.0,  # per degree
    "get_axis_mask": 0b101111,  # X Y Z A C
    "get_tool": (-1, *(0.0,) * 12, 0),  # none
    "check_abort": False,
    "get_block_delete": False,
}


def blocks(text: str, library: str, modules: Path) -> list[list[Point]]:
    """Ends of the moves [mm] of each block that has any, in coordinates of the program.

    library: LD_LIBRARY_PATH; modules: folder of gcode. Raises RuntimeError if it cannot read.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "program.ngc"
        write_text(file, text)
        write_text(Path(folder) / "parameters", "5161 0\n5220 1\n")
        run = subprocess.run(
            [sys.executable, "-P", __file__, str(file)],
            cwd=folder,
            env={**os.environ, "LD_LIBRARY_PATH": library, "PYTHONPATH": str(modules)},
            capture_output=True,
            text=True,
            timeout=20,
        )
        lines = run.stdout.splitlines()
    if run.returncode != 0 or not lines:
        raise RuntimeError((run.stderr.strip() or "no output").splitlines()[-1])
    found = json.loads(lines[-1])
    return [[(x * _MM, y * _MM, z * _MM) for x, y, z in block] for block in found if block]


class _Canon:
    """Object that the interpreter calls; it stores the ends of the moves by block."""

    def __init__(self) -> None:
        self.blocks: list[list[tuple[float, ...]]] = [[]]
        self.parameter_file = "parameters"

    def __getattr__(self, name: str):
        if name.startswith("_"):
            raise AttributeError(name)

        def called(*values: float) -> object:
            if name == "arc_feed":
                first, second, _, _, _, third, *_ = values
                self.blocks[-1].append((first, second, third))
            elif name in _MOVES:
                self.blocks[-1].append(values[:3])
            return _ANSWERS.get(name)

        return called

    def next_line(self, state: object) -> None:
        """The interpreter calls this for each line."""
        self.blocks.append([])


if __name__ == "__main__":
    import gcode

    canon = _Canon()
    result, _ = gcode.parse(sys.argv[1], canon, "G21", "", "")
    if result > gcode.MIN_ERROR:
        sys.exit(gcode.strerror(result))
    sys.stdout.write("\n" + json.dumps(canon.blocks) + "\n")
