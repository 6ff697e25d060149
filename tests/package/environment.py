# SPDX-License-Identifier: Apache-2.0
"""An empty environment with the project's wheel and what the wheel declares, nothing else."""

from __future__ import annotations

import subprocess
import sys
import venv
from collections.abc import Iterable
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement

from asip_asm.project import ROOT

PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"]


def build_wheel(folder: Path, sources: Path = ROOT) -> Path:
    """The wheel of the sources, by default of this checkout, built into `folder`."""
    command = [*PIP, "wheel", "--no-deps", "--no-build-isolation", "-w", str(folder), str(sources)]
    subprocess.run(command, check=True, cwd=folder)
    (wheel,) = folder.glob("*.whl")
    return wheel


def install(wheel: Path, folder: Path, extra: str = "", also: Iterable[str] = ()) -> Path:
    """The bin folder of a new environment with the wheel, its declared dependencies, an extra's and
    further packages.

    The dependencies are links to the locked packages that the tests run in: what no requirement
    names, direct or not, cannot be imported there.
    """
    venv.create(folder, symlinks=True)
    python = folder / "bin/python"
    subprocess.run(
        [*PIP, f"--python={python}", "install", "--no-deps", "--no-index", str(wheel)], check=True
    )
    (packages,) = folder.glob("lib/python*/site-packages")
    (own,) = Distribution.discover(path=[str(packages)])
    for needed in _closure([*(own.requires or ()), *also], extra):
        for entry in needed.entry_points.select(group="console_scripts"):
            call = f"import sys, {entry.module}\nsys.exit({entry.module}.{entry.attr}())\n"
            (python.parent / entry.name).write_text(f"#!{python}\n{call}", encoding="utf-8")
            (python.parent / entry.name).chmod(0o755)
        for name in {file.parts[0] for file in needed.files or ()} - {".."}:
            link = packages / name
            if not link.is_symlink():
                link.symlink_to(needed.locate_file(name))
    return python.parent


def _closure(requirements: Iterable[str], extra: str) -> list[Distribution]:
    """The distributions that the requirements name, and those which these name in turn."""
    found: dict[str, Distribution] = {}
    waiting = [Requirement(text) for text in requirements]
    while waiting:
        wanted = waiting.pop()
        if wanted.marker and not wanted.marker.evaluate({"extra": extra}):
            continue
        name = wanted.name.lower()
        if name not in found:
            found[name] = distribution(name)
            waiting += map(Requirement, found[name].requires or ())
        assert found[name].version in wanted.specifier, f"{wanted}: {found[name].version}"
    return list(found.values())
