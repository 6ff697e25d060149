# SPDX-License-Identifier: Apache-2.0
"""Count the rooms of sim, its folders, and the arrows between them: from a room to one it imports.

The order of the rooms is that of the contract in pyproject.toml. Exit status: 1 if there are more
than ten rooms, more arrows than are allowed or one back up; each import back up is named.
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


def order() -> list[str]:
    """The rooms from the ground up, as the contract lists them."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"][
        "importlinter"
    ]["contracts"]
    (layers,) = (each["layers"] for each in contracts if each.get("containers") == [PACKAGE])
    return layers[::-1]


def faults(rooms: list[str], imports: Iterable[tuple[str, str]]) -> tuple[int, list[str]]:
    """Number of arrows, and what is wrong. imports: names of the importing and imported module."""
    arrows, wrong = set(), []
    for importer, imported in sorted(imports):
        pair = tuple(name.split(".")[1] for name in (importer, imported) if "." in name)
        if len(pair) < 2 or pair[0] == pair[1] or not {*pair} <= {*rooms}:
            continue
        arrows.add(pair)
        if rooms.index(pair[0]) < rooms.index(pair[1]):
            wrong.append(f"{importer} -> {imported}: back up, from {pair[0]} to {pair[1]}")
    if len(rooms) > MOST_ROOMS:
        wrong.append(f"{len(rooms)} rooms, at most {MOST_ROOMS}: {', '.join(rooms)}")
    if len(arrows) > MOST_ARROWS:
        shown = ", ".join(f"{one} -> {other}" for one, other in sorted(arrows))
        wrong.append(f"{len(arrows)} arrows, at most {MOST_ARROWS}: {shown}")
    return len(arrows), wrong


def main() -> int:
    graph = grimp.build_graph(PACKAGE, cache_dir=None)
    rooms = order()
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
