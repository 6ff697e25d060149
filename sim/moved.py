# SPDX-License-Identifier: Apache-2.0
"""The names that modules had before they moved into rooms: each still imports, with a warning.

`from sim.lookahead.planner import Lookahead` gives the module `sim.motion.lookahead.planner`,
and `python -m sim.lookahead` runs it.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import warnings
from collections.abc import Sequence
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import CodeType, ModuleType

PACKAGE = __name__.rpartition(".")[0]
# Old name -> new name, both without the package; modules of a folder have moved with it.
MOVED = {
    "page": "report",
    "goals": "report.goals",
    "model": "robot",
    "harness": "rtl",
    "harness.assertions": "rtl.assertion_files",
    "board": "rtl.board",
    "private": "rtl.private",
    "processes": "rtl.processes",
    "custom_table": "rtl.custom_table",
    "core_backends": "core.backends",
    "core_fault": "core.fault",
    "iss": "core.iss",
    "driver": "core.host",
    "fpbench": "core.fpbench",
    "run": "bench.run",
    "run.controller": "core.controller",
    "run.closed_loop": "core.closed_loop",
    "gcode": "motion.gcode",
    "path": "motion.geometry",
    "lookahead": "motion.lookahead",
    "planner": "motion.planner",
    "trajectory": "motion.trajectory",
    "command": "motion.command",
    **{f"motion.{name}": f"bench.motion.{name}" for name in ("show", "step_stream")},
    "robots": "laws",
    **{
        f"robots.{name}": f"bench.shown_robots.{name}"
        for name in ("__main__", "campaign", "core_goals", "cycles", "job", "own_errors", "page")
    },
    "asip_model": "laws.asip_model",
    "native": "laws.native",
    **{
        f"prove_{name}": f"laws.prove_{name}"
        for name in ("casadi", "functions", "points", "program", "reference")
    },
    "certificate_errors": "laws.certificate_errors",
    "certificate_goals": "bench.certificate_goals",
    "debugger": "debug.asip_dbg",
    "asip_run": "debug.asip_run",
    "scope": "debug.scope",
    "gdb": "debug.gdb",
    "guard": "debug.guard",
    "nios_run": "debug.nios_run",
    "ethercat": "bus",
    "coe": "bus.coe",
    "dual": "bench.dual",
    "platforms": "bench.platforms",
    "drive": "bench.cnc",
    "servo": "bench.drive",
    "servo.clocks": "laws.drive.clocks",
    "servo.current_law": "laws.drive.current_law",
    "nios_bench": "bench.nios_bench",
}


def moved(name: str) -> str | None:
    """Today's full name of a module that had this full name, None where no such module moved."""
    parts = name.removeprefix(f"{PACKAGE}.").split(".")
    for n in range(len(parts), 0, -1):
        if new := MOVED.get(".".join(parts[:n])):
            return ".".join([PACKAGE, new, *parts[n:]])
    return None


class Loader(InspectLoader):
    """Gives the module of the new name for the old one; its code, for `python -m`."""

    def __init__(self, spec: ModuleSpec) -> None:
        self._spec = spec

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = importlib.import_module(self._spec.name)
        self._own = module.__spec__  # The import system writes another into the module.
        return module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self._own

    def is_package(self, fullname: str) -> bool:
        return self._spec.submodule_search_locations is not None

    def get_code(self, fullname: str) -> CodeType | None:
        return self._inspected().get_code(self._spec.name)

    def get_source(self, fullname: str) -> str | None:
        return self._inspected().get_source(self._spec.name)

    def _inspected(self) -> InspectLoader:
        if not isinstance(self._spec.loader, InspectLoader):
            raise ImportError(f"{self._spec.name} has no source")
        return self._spec.loader


class Finder(MetaPathFinder):
    """Asked first: below a folder's old name, the usual finder would load each module again."""

    def __init__(self) -> None:
        self._warned: set[str] = set()

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if not fullname.startswith(f"{PACKAGE}.") or not (new := moved(fullname)):
            return None
        spec = importlib.util.find_spec(new)
        if spec is None:
            return None
        if not any(f"{fullname}.".startswith(f"{name}.") for name in self._warned):
            self._warned.add(fullname)
            warnings.warn(f"{fullname} is now {new}", FutureWarning, stacklevel=2)
        found = ModuleSpec(fullname, Loader(spec), origin=spec.origin)
        found.submodule_search_locations = spec.submodule_search_locations
        return found


def install() -> None:
    """Once, from the package itself."""
    if not any(isinstance(finder, Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, Finder())
