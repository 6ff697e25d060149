# SPDX-License-Identifier: Apache-2.0
"""Cycles of the matrix laws on `wide` with another number of lanes, as JSON on standard output.

    python -m scripts.lane_study 2

The compiler reads the number of lanes from one record of isa.toml. This process changes that
record before it imports the compiler; nothing else differs from `wide`. The RTL has up to four.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from asip_asm import isa as isa_module
from asip_asm.command import command, script_parser

CONFIGURATION = "wide"


def use_lanes(lanes: int) -> None:
    """Makes `wide` of this process have so many lanes in each pipe."""
    shipped = isa_module.default_isa()
    configurations = dict(shipped.configurations)
    wide = configurations[CONFIGURATION]
    configurations[CONFIGURATION] = dataclasses.replace(wide, lanes=lanes - 1)
    changed = dataclasses.replace(shipped, configurations=configurations)
    setattr(isa_module, "default_isa", lambda: changed)  # noqa: B010


def measure() -> list[dict[str, Any]]:
    """For each law its name, cycles and words of the longer stream, or why it does not fit."""
    # Imported here: they take the instruction set as it is when they are imported.
    from asip_asm.model.read import ModelError
    from scripts.matrix_table import longest_stream, matrix_laws

    found: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as folder:
        for name, configuration, build in matrix_laws(Path(folder)):
            if configuration != CONFIGURATION:
                continue
            try:
                built = build()
            except ModelError as error:
                found.append({"law": name, "refused": str(error)})
            else:
                words = longest_stream(built.image)
                found.append({"law": name, "cycles": built.cycles, "stream": words})
    return found


@command("scripts/lane_study.py")
def main(argv: list[str] | None = None) -> int:
    """Command line; exit 0, 2 for a wrong number."""
    parser = script_parser(__doc__, "python -m scripts.lane_study 8")
    parser.add_argument(
        "lanes", type=int, choices=(2, 4, 8), help="lanes of each multiply-add pipe"
    )
    use_lanes(parser.parse_args(argv).lanes)
    print(json.dumps(measure()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
