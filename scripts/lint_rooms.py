# SPDX-License-Identifier: Apache-2.0
"""Count the rooms of sim, its folders, and the arrows between them: from a room to one it imports.

The rooms are those of the contract in pyproject.toml. With it, import-linter refuses an arrow back
up and a folder that is no room. Exit status: 1 if there are too many rooms or arrows.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterable

import grimp

from asip_asm.project import ROOT

PACKAGE = "sim"
MOST_ROOMS = 10
MOST_ARROWS = 31
"""Those of today, of the 45 that ten rooms in an order can have."""


def listed() -> list[str]:
    """The rooms as the contract lists them."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "importlinter"
    ]["contracts"]
    (layers,) = (each["layers"] for each in contracts if each.get("containers") == [PACKAGE])
    return layers


def faults(rooms: list[str], imports: Iterable[tuple[str, str]]) -> tuple[int, list[str]]:
    """Number of arrows, and what is wrong. imports: names of the importing and imported module."""
    arrows, wrong = set(), []
    for importer, imported in sorted(imports):
        pair = tuple(name.split(".")[1] for name in (importer, imported) if "." in name)
        if len(pair) < 2 or pair[0] == pair[1] or not {*pair} <= {*rooms}:
            continue
        arrows.add(pair)
    if len(rooms) > MOST_ROOMS:
        wrong.append(f"{len(rooms)} rooms, at most {MOST_ROOMS}: {', '.join(rooms)}")
    if len(arrows) > MOST_ARROWS:
        shown = ", ".join(f"{one} -> {other}" for one, other in sorted(arrows))
        wrong.append(f"{len(arrows)} arrows, at most {MOST_ARROWS}: {shown}")
    return len(arrows), wrong


def main() -> int:
    graph = grimp.build_graph(PACKAGE, cache_dir=None)
    rooms = listed()
    imports = [
        (importer, imported)
        for importer in graph.modules
        for imported in graph.find_modules_directly_imported_by(importer)
    ]
    arrows, wrong = faults(rooms, imports)
    for text in wrong:
        print(f"{PACKAGE}: {text}", file=sys.stderr)
    print(f"{PACKAGE}: {len(rooms)} rooms, {arrows} arrows between them")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
