# SPDX-License-Identifier: Apache-2.0
"""Build hook of the wheel: everything goes below one package, `microtick`.

`sim/core/api.py` of the checkout is `microtick/sim/core/api.py` of the wheel, and `sim.core` is
imported as `microtick.sim.core`; docs/api.md says why. The hook changes the names of modules in
imports, in texts and in comments. It refuses a source whose names it could not change without a
doubt.

The wheel and the source package also get a file with the commit that they were made of, which
sim/report/provenance.py reads.
"""

from __future__ import annotations

import ast
import re
import runpy
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PACKAGE = "microtick"
PARTS = ("asip_asm", "sim")  # packages of the checkout, in the order of their layers
INIT = '''\
# SPDX-License-Identifier: Apache-2.0
"""Microtick as its wheel installs it: `asip_asm` and `sim` of the checkout, and their files."""
'''
MAIN = '''\
# SPDX-License-Identifier: Apache-2.0
"""python -m microtick: the command microtick."""

import sys

from microtick.sim.verbs import main

if __name__ == "__main__":
    sys.exit(main())
'''
DOTTED = re.compile(rf"(?<![\w./-])(?:{'|'.join(PARTS)})(?:\.[A-Za-z_]\w*)+")
FROM = re.compile(rf"^(\s*from )({'|'.join(PARTS)})(?= import )", re.M)


class WheelError(Exception):
    """A source that cannot be put below the package."""


def is_module(name: str, root: Path) -> bool:
    """Whether a dotted name is a module or package of the checkout."""
    place = root.joinpath(*name.split("."))
    return place.with_suffix(".py").is_file() or (place / "__init__.py").is_file()


def moved(text: str, root: Path) -> str:
    """The text with `sim.x` as `microtick.sim.x` wherever `sim.x` is a module."""

    def longer(found: re.Match[str]) -> str:
        first_two = ".".join(found[0].split(".")[:2])
        return f"{PACKAGE}.{found[0]}" if is_module(first_two, root) else found[0]

    return FROM.sub(rf"\1{PACKAGE}.\2", DOTTED.sub(longer, text))


def moved_source(text: str, name: str, root: Path) -> str:
    """The same of Python, proved: code differs in imports and texts alone, which name no part.

    Raises WheelError for a form that this module does not change or must not change.
    """
    before, result = ast.parse(text), moved(text, root)
    for node in ast.walk(before):
        if isinstance(node, ast.Import) and any(top(each.name) in PARTS for each in node.names):
            raise WheelError(f"{name}:{node.lineno}: write 'from x import y' for modules of ours")
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if is_module(f"{node.value.id}.{node.attr}", root) and node.value.id in PARTS:
                raise WheelError(f"{name}:{node.lineno}: rename the variable '{node.value.id}'")
    for old, new in zip(ast.walk(before), ast.walk(ast.parse(result)), strict=True):
        if not same(old, new, root):
            raise WheelError(f"{name}:{getattr(old, 'lineno', 1)}: cannot be moved")
    return result


def top(name: str) -> str:
    """First part of a dotted name."""
    return name.partition(".")[0]


def same(old: ast.AST, new: ast.AST, root: Path) -> bool:
    """Whether a node was moved as it should be; children are compared by themselves."""
    if type(old) is not type(new):
        return False
    for field in old._fields:
        a, b = getattr(old, field, None), getattr(new, field, None)
        if isinstance(old, ast.ImportFrom) and field == "module" and not old.level:
            a = f"{PACKAGE}.{a}" if top(str(a)) in PARTS else a
        elif isinstance(old, ast.Constant) and isinstance(a, str):
            a = moved(a, root)
        if not isinstance(a, ast.AST | list) and a != b:
            return False
    return True


class Hook(BuildHookInterface):
    """What hatchling calls. An editable installation is the checkout and is not changed."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Write changed files to a folder of their own and have them taken."""
        if version == "editable":
            return
        self._folder = tempfile.TemporaryDirectory(prefix="microtick-wheel-")
        forced, folder = build_data["force_include"], Path(self._folder.name)
        for name, text in self._files():
            file = folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
            forced[str(file)] = name

    def _files(self) -> Iterator[tuple[str, str]]:
        """Names and texts of files that are not in the checkout as they are in the package."""
        root, builder = Path(self.root), self.build_config.builder
        provenance = runpy.run_path(str(root / "sim/report/provenance.py"))
        if (commit := provenance["commit"]()) != provenance["UNKNOWN"]:
            yield provenance["BUILT_FROM"].name, commit
        if self.target_name != "wheel":
            return
        yield "__init__.py", INIT
        yield "__main__.py", MAIN
        for file in builder.recurse_selected_project_files():
            path = Path(file.relative_path)
            if path.parts[0] in PARTS and path.suffix in (".py", ".md"):
                text = Path(file.path).read_text(encoding="utf-8")
                change = moved_source(text, str(path), root) if path.suffix == ".py" else None
                change = moved(text, root) if change is None else change
                if change != text:
                    yield str(path), change
        scripts = builder.metadata.core.scripts
        scripts.update({name: f"{PACKAGE}.{place}" for name, place in scripts.items()})

    def finalize(self, version: str, build_data: dict[str, Any], artifact: str) -> None:
        """Remove the folder."""
        if version != "editable":
            self._folder.cleanup()
