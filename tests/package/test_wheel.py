# SPDX-License-Identifier: Apache-2.0
"""The wheel in an empty environment outside the checkout: every command on a small input."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from scripts.doc_blocks import code_blocks, write_files
from sim import verbs
from sim.report import provenance
from tests.bench.commands import output
from tests.bench.copies import share_models
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
IMPORT_ALL = """\
import importlib, json, pkgutil, sys
count, missed = 0, []
for module in pkgutil.walk_packages(importlib.import_module("microtick").__path__, "microtick."):
    if not module.name.endswith(".__main__"):
        try:
            last = importlib.import_module(module.name)
            count += 1
        except ModuleNotFoundError:
            missed.append(module.name)
foreign = sorted({"asip_asm", "sim", "scripts", "tests"} & set(sys.modules))
print(json.dumps({"imported": count, "missed": missed, "place": last.__file__, "foreign": foreign}))
"""
HELP_OF_VERBS = """\
import contextlib, io, json
from microtick.sim import verbs
found = {}
for name in verbs.verbs(verbs.offered()):
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            status = verbs.main([name, "--help"])
        except SystemExit as stop:
            status = stop.code
    found[name] = status, said.getvalue()
print(json.dumps(found))
"""
NEED_AN_EXTRA = {"model", "mpc", "cocotb", "linuxcnc", "lsp", "robots", "side-by-side"}
OF_THE_EXTRA = (
    *("microtick.asip_asm.model.", "microtick.sim.laws."),
    *("microtick.sim.bench.platforms.", "microtick.sim.bench.shown_robots."),
    *("microtick.sim.bench.drive.", "microtick.sim.bench.certificate_goals"),
    *("microtick.sim.bench.best_goals", "microtick.sim.bench.matrix_law_goals"),
    *(
        "microtick.sim.bench.stream_law_goals",
        "microtick.sim.bench.observer_goals",
        "microtick.sim.motion.lookahead.optimum",
    ),
)
OF_THE_BUS = [  # the extra `bus`
    f"microtick.sim.bus.{module}"
    for module in (
        *("dc_run", "death_run", "device_run", "disturbed_run", "kickcat_master"),
        *("linuxcnc.machine", "linuxcnc.master", "linuxcnc.page", "linuxcnc.result"),
        *("locked_run", "path_page", "path_run", "pysoem_master", "redundant", "session"),
    )
]
OF_THE_EDITOR = ["microtick.sim.debug.language_server"]  # the extra `editor`
OF_LITEX = ["microtick.sim.rtl.litex"]  # the extra `litex`
OF_COCOTB = [  # the extra `cocotb`
    f"microtick.sim.cocotb.{module}"
    for module in (
        *("agent", "asip", "axil", "clocked", "custom", "mii", "nios", "runner", "unit"),
    )
]
LAW = """\
import casadi as ca
q, goal = ca.SX.sym("q"), ca.SX.sym("goal")
ca.Function("law", [q, goal], [40 * (goal - q)], ["q", "goal"], ["torque"]).save("law.casadi")
"""
INTERFACE = """\
title = "spring"
[[input]]
names = ["q", "goal"]
unit = "rad"
limits = [-1.0, 1.0]
meaning = "measured and wanted angle"
[[output]]
names = ["torque"]
unit = "N m"
safe = 0.0
meaning = "torque of the drive"
"""
HELLO = ROOT / "nios_sw/images/run/demo_hello_fpga1.elf"
SUM = "z = 0.5"  # (0.25 * 0.4) * 1 + 0.4


# Folders of a user's own project, which Python finds first.
OWN_FOLDERS = ("asip_asm", "sim", "scripts", "tests")


class Installed:
    """The commands of an environment, run in a folder of its own, with an empty cache."""

    def __init__(self, folder: Path, commands: Path) -> None:
        self.folder, self.commands = folder, commands
        # No PATH to a Python, none of this environment's variables: as after opening a terminal.
        self.environment = {"PATH": "/usr/bin:/bin", "XDG_CACHE_HOME": str(folder / "cache")}
        kept = ("CXX", "MODEL_OPTIMISATION", "OPENBLAS_NUM_THREADS")
        self.environment |= {name: os.environ[name] for name in kept if name in os.environ}

    def must(self, command: str, *arguments: str | Path) -> str:
        """Standard output of the command, which must end with status 0. A model takes a minute or
        so to build.
        """
        options = {"cwd": self.folder, "env": self.environment, "timeout": 1200}
        return output(self.commands / command, *arguments, **options)


def installed_in(folder: Path, wheel: Path, extra: str = "") -> Installed:
    """A new environment with the wheel and an extra, and an empty folder to work in."""
    work = folder / "work"
    for name in OWN_FOLDERS:
        (work / name).mkdir(parents=True)
        (work / name / "__init__.py").write_text("raise SystemExit('the user's own package')\n")
    (work / "microtick/sim").mkdir(parents=True)  # a checkout of that name
    return Installed(work, install(wheel, folder / "environment", extra))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_wheel(tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    found = installed_in(tmp_path_factory.mktemp("plain"), wheel)
    (found.folder / "sum.s").write_text(PROGRAM, encoding="utf-8")
    return found


@pytest.fixture(scope="module")
def image(installed: Installed) -> str:
    installed.must("asip-as", "sum.s", "-o", "sum.asip.json", "--listing", "sum.lst")
    return "sum.asip.json"


def test_wheel__holds_what_its_commands_read_and_nothing_of_the_checkout(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    for needed in (
        "asip_asm/isa.toml",
        "asip_asm/programs/tracking_optimised.s",
        "sim/robot.toml",
        "sim/paths/agh.ngc",
        "sim/debug/scope/page/index.html",
        "sim/rtl/asip_harness.cpp",
        "rtl/asip/asip.sv",
        "rtl/waivers.vlt",
        "nios_sw/system.toml",
    ):
        assert f"microtick/{needed}" in names
    assert len(set(names)) == len(names)
    tops = {name.split("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"microtick"}


@pytest.mark.full
def test_source_package__makes_the_same_wheel__with_its_commit(wheel: Path, tmp_path: Path) -> None:
    """Without git, below another repository: the commit is that of the checkout."""
    source = "import hatchling.build; print(hatchling.build.build_sdist({!r}))"
    said = output(sys.executable, "-c", source.format(str(tmp_path)), cwd=ROOT)
    with tarfile.open(tmp_path / said.strip()) as archive:
        archive.extraction_filter = staticmethod(lambda member, path: member)  # our own files
        archive.extractall(tmp_path / "unpacked")
    (unpacked,) = (tmp_path / "unpacked").iterdir()
    again = build_wheel(tmp_path, unpacked)
    with zipfile.ZipFile(wheel) as first, zipfile.ZipFile(again) as second:
        assert first.namelist() == second.namelist()
        assert all(first.read(name) == second.read(name) for name in first.namelist())
        assert first.read("microtick/COMMIT").decode() == provenance.commit()


def test_commands__of_the_wheel__are_those_run_here(installed: Installed) -> None:
    asip = {f"asip-{name}" for name in ("as", "objdump", "run", "dbg", "model", "scope")}
    assert set(COMMANDS) == asip | {"nios-run", "microtick"}
    for command in set(COMMANDS) - {"asip-model"}:
        assert f"usage: {command} " in installed.must(command, "--help")


def test_verbs__of_the_wheel__explain_themselves_or_name_the_extra(installed: Installed) -> None:
    """The entry `python -m microtick` is the command; both know the verbs of the wheel alone."""
    assert installed.must("python", "-P", "-m", "microtick") == installed.must("microtick")
    found = json.loads(installed.must("python", "-c", HELP_OF_VERBS))
    wanted = verbs.verbs(verbs.GROUPS)
    assert set(found) == set(wanted) and not set(found) & set(verbs.verbs(verbs.OF_A_CHECKOUT))
    for name, (status, said) in found.items():
        if status == 1:
            extra = re.search(r"pip install 'microtick\[(\w+)\]'", said)
            assert extra and extra[1] in verbs.EXTRAS.values(), said
        else:
            assert status == 0 and said.startswith(f"usage: microtick {name} "), said
    assert {name for name, (status, _) in found.items() if status} <= NEED_AN_EXTRA


def test_every_module__in_the_empty_environment__is_imported_or_needs_the_extra(
    installed: Installed,
) -> None:
    """A module that imports a package which no requirement names would be among those missed."""
    found = json.loads(installed.must("python", "-c", IMPORT_ALL))
    assert found["imported"] > 150 and found["foreign"] == []
    assert not Path(found["place"]).is_relative_to(ROOT)
    assert all(
        module.startswith((*OF_THE_EXTRA, *OF_THE_BUS, *OF_COCOTB, *OF_LITEX, *OF_THE_EDITOR))
        for module in found["missed"]
    ), found["missed"]


def test_asip_as_and_objdump__of_the_wheel__make_and_read_an_image(
    installed: Installed, image: str
) -> None:
    assert "fsat" in (installed.folder / "sum.lst").read_text(encoding="utf-8")
    assert '.program "weighted sum"' in installed.must("asip-objdump", "-d", image)
    place = "from microtick import asip_asm; print(asip_asm.__path__[0])"
    programs = Path(installed.must("python", "-c", place).strip(), "programs")
    installed.must("asip-as", programs / "tracking_optimised.s", "-o", "tracking.asip.json")


def test_asip_run__on_the_model_and_the_core_of_the_wheel__computes(
    installed: Installed, image: str
) -> None:
    # A core that the checkout has built already is taken if its sources are the wheel's.
    share_models(installed.folder / "cache/microtick", "asip-*[0-9a-f]", "verilated-*")
    values = ("--set", "x=0.4", "--set", "y=1")
    assert SUM in installed.must("asip-run", image, *values, "--iss")
    assert SUM in installed.must("asip-run", image, *values)


def test_asip_dbg__of_the_wheel__stops_in_an_image(installed: Installed, image: str) -> None:
    commands = ("-ex", "break z", "-ex", "run", "-ex", "info values")
    text = installed.must("asip-dbg", image, "--iss", "--batch", *commands)
    assert "breakpoint 1, z is computed" in text and "sum.s:" in text


def test_nios_run__of_the_wheel__builds_its_system_and_runs_a_program(
    installed: Installed,
) -> None:
    text = installed.must("nios-run", "--system", "fpga1", HELLO)
    assert text.startswith("square root of 2 on FPGA1: 1.4142135,")
    built = installed.folder.glob("cache/microtick/model/n2_system-*/libn2_system.so")
    assert len(list(built)) == 1


def test_asip_model__without_its_packages__says_how_to_get_them(installed: Installed) -> None:
    done = subprocess.run(
        [installed.commands / "asip-model", "--help"],
        cwd=installed.folder,
        env=installed.environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "asip-model: error: CasADi is not installed",
        "help: pip install 'microtick[model]', or make setup in a checkout",
    ]


@pytest.fixture(scope="module")
def with_model(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    return installed_in(tmp_path_factory.mktemp("model"), wheel, "model")


def test_asip_model__with_its_extra__writes_a_program(with_model: Installed) -> None:
    installed, folder = with_model, with_model.folder
    assert (
        json.loads(installed.must("python", "-c", IMPORT_ALL))["missed"]
        == OF_THE_BUS + OF_COCOTB + OF_THE_EDITOR + OF_LITEX
    )
    installed.must("python", "-c", LAW)
    (folder / "law.interface.toml").write_text(INTERFACE, encoding="utf-8")
    assert "cycles" in installed.must("asip-model", "law.casadi", "law.interface.toml")
    assert (folder / "law.asip.json").is_file()


@pytest.mark.full
def test_your_robot__word_for_word_with_the_wheel(
    with_model: Installed, wheel: Path, tmp_path: Path
) -> None:
    """Files and commands of docs/your_robot.md in an empty folder, as after `pip install`."""
    page = ROOT / "docs/your_robot.md"
    assert f"pip install 'dist/{wheel.name}[model]'" in page.read_text(encoding="utf-8")
    work = tmp_path / "robot"
    work.mkdir()
    write_files(page, work)
    blocks = code_blocks(page)
    (first,) = (block for block in blocks if block.language != "sh" and not block.title)
    assert first.text.startswith("pip wheel ") and blocks[0] is first  # all others run here
    commands = [block.text for block in blocks if block.language == "sh"]
    (work / "page.sh").write_text("".join(commands), encoding="utf-8")
    share_models(with_model.folder / "cache/microtick", "asip-*[0-9a-f]", "verilated-*")
    environment = with_model.environment | {"HOME": str(tmp_path)}
    environment["PATH"] = f"{with_model.commands}:{environment['PATH']}"
    said = output("sh", "-e", "page.sh", cwd=work, env=environment, timeout=900)
    assert said.count("bits equal the interpreter's") == 10
    assert "200 ticks: bits equal the exact interpreter's" in said  # microtick mpc
    assert "40 ticks: bits equal the exact interpreter's" in said  # with a cone
    assert "0 words of 250 ticks unlike the interpreter's" in said
    assert "distance from the optimum (Clarabel), 100 initial states" in said
    assert len(re.findall("^proved$", said, re.M)) == 9
    assert "200 ticks of 2 functions in turn" in said
    assert "closed loop: 1000 ticks" in said
    on_core, in_c, _ = re.findall(r"^(?!.* N m ) *torque +=? *([-+0-9.e]+)", said, re.M)
    assert float(on_core) == float(in_c) != 0
