# SPDX-License-Identifier: Apache-2.0
"""Write docs/robot_parameters.md from sim/robot.toml and the limits of sim/robot/parameters.py.

With --check nothing is written; exit 1 if the page would differ.
"""

from __future__ import annotations

import sys
import tomllib
from dataclasses import fields

from scripts.generated import run, template
from sim.robot.drives import Drives
from sim.robot.parameter_uses import UNUSED
from sim.robot.parameters import ROBOT_TOML, Robot

SCRIPT = "scripts/gen_robot_page.py"


def generate() -> dict[str, str]:
    """Text of the page by its path."""
    entries = tomllib.loads(ROBOT_TOML.read_text(encoding="utf-8"))
    rows = []
    records = {field.name: field for field in (*fields(Drives), *fields(Robot))}
    for field in (records[name] for name in entries):
        entry, meta = entries[field.name], field.metadata
        cells = (
            f"`{field.name}`",
            meta["unit"],
            f"{meta['low']:g} .. {meta['high']:g}",
            entry["meaning"],
            meta["why"],
            ", ".join(command for command, names in UNUSED.items() if field.name in names) or "-",
        )
        rows.append("| " + " | ".join(cells) + " |")
    text = template("robot_parameters.md.j2").render(script=SCRIPT, rows=rows)
    return {"docs/robot_parameters.md": text}


if __name__ == "__main__":
    sys.exit(run(SCRIPT, "Write the page of the robot's parameters.", generate))
