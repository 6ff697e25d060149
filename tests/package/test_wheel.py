# SPDX-License-Identifier: Apache-2.0
"""The wheel in an empty environment outside the checkout: every command on a small input."""

from __future__ import annotations

import os
import subprocess
import tomllib
from pathlib import Path

import pytest

from asip_asm.project import BUILD, ROOT
from tests.package.environment import build_wheel, install

COMMANDS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
    "scripts"
]
PROGRAM = """\
.program "weighted sum"
.input   x, y
.const   w = 0.25
.output  z, safe = 0.0

        fmul    t, w, x
        fmadd   s, t, y, x
        fsat    z, s, -1.0, 1.0
        halt
"""
HELLO = ROOT / "nios_sw/images/run/demo_hello_fpga1.elf"
SUM = "z = 0.5"  # (0.25 * 0.4) * 1 + 0.4


class Installed:
    """The commands of an environment, run in a folder of its own, with an empty cache."""

    def __init__(self, folder: Path, commands: Path) -> None:
        self.folder, self.commands = folder, commands
        # No PATH to a Python, none of this environment's variables: as after opening a terminal.
        self.environment = {"PATH": "/usr/bin:/bin", "XDG_CACHE_HOME": str(folder / "cache")}
        self.environment |= {name: os.environ[name] for name in ("CXX",) if name in os.environ}

    def run(self, command: str, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
        """The command's exit status and text. A model takes a minute or so to build."""
        return subprocess.run(
            [self.commands / command, *arguments],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=1200,
        )

    def must(self, command: str, *arguments: str | Path) -> str:
        """Standard output of the command, which must end with status 0."""
        done = self.run(command, *arguments)
        assert done.returncode == 0, f"{command} {arguments}\n{done.stdout}{done.stderr}"
        return done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    folder = tmp_path_factory.mktemp("wheel")
    commands = install(build_wheel(folder), folder / "environment")
    work = folder / "work"
    work.mkdir()
    (work / "sum.s").write_text(PROGRAM, encoding="utf-8")
    return Installed(work, commands)


@pytest.fixture(scope="module")
def image(installed: Installed) -> str:
    installed.must("asip-as", "sum.s", "-o", "sum.asip.json", "--listing", "sum.lst")
    return "sum.asip.json"


def test_commands__of_the_wheel__are_those_run_here(installed: Installed) -> None:
    assert set(COMMANDS) == {"asip-as", "asip-objdump", "asip-run", "nios-run"}
    for command in COMMANDS:
        assert "usage" in installed.must(command, "--help")


def test_every_module__in_the_empty_environment__is_imported(installed: Installed) -> None:
    """A third-party package that no requirement names would end this with ModuleNotFoundError."""
    script = (
        "import importlib, pkgutil, sys\n"
        "names = [m.name for p in ('asip_asm', 'sim')\n"
        "         for m in pkgutil.walk_packages(importlib.import_module(p).__path__, p + '.')]\n"
        "for name in names:\n"
        "    if not name.endswith('.__main__'):\n"
        "        importlib.import_module(name)\n"
        "print(len(names), sys.modules['sim'].__file__)\n"
    )
    number, place = installed.must("python", "-c", script).split()
    assert int(number) > 150
    assert not Path(place).is_relative_to(ROOT)


def test_asip_as_and_objdump__of_the_wheel__make_and_read_an_image(
    installed: Installed, image: str
) -> None:
    assert "fsat" in (installed.folder / "sum.lst").read_text(encoding="utf-8")
    assert '.program "weighted sum"' in installed.must("asip-objdump", "-d", image)


def test_asip_run__on_the_model_and_the_core_of_the_wheel__computes(
    installed: Installed, image: str
) -> None:
    # A core that the checkout has built already is taken if its sources are the wheel's.
    models = installed.folder / "cache/microtick/model"
    models.mkdir(parents=True, exist_ok=True)
    for built in BUILD.glob("model/asip-*[0-9a-f]"):
        (models / built.name).symlink_to(built)
    values = ("--set", "x=0.4", "--set", "y=1")
    assert SUM in installed.must("asip-run", image, *values, "--iss")
    assert SUM in installed.must("asip-run", image, *values)


def test_nios_run__of_the_wheel__builds_its_system_and_runs_a_program(
    installed: Installed,
) -> None:
    text = installed.must("nios-run", "--system", "fpga1", HELLO)
    assert text.startswith("square root of 2 on FPGA1: 1.4142135,")
    built = installed.folder.glob("cache/microtick/model/n2_system-*/libn2_system.so")
    assert len(list(built)) == 1
