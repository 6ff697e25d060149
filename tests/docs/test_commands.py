# SPDX-License-Identifier: Apache-2.0
"""README and docs as a newcomer reads them: commands exist and take their options, the quick ones
run, programs assemble, Python runs."""

from __future__ import annotations

import os
import re
import runpy
import sys

import pytest

from asip_asm.assemble import assemble
from scripts.doc_blocks import code_blocks, write_files
from sim.rtl.build import ROOT, verilator_driver
from sim.rtl.plain import plain
from tests.bench.commands import output
from tests.docs.commands import (
    PAGES,
    Command,
    block_commands,
    inline_commands,
    names_of_tests,
    programs,
    shell_lines,
)

MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
CONSOLE = dict(
    re.findall(r'^([\w-]+) = "([\w.]+):main"$', (ROOT / "pyproject.toml").read_text(), re.M)
)
# Beginnings of the commands in blocks that are not run here, each with its reason.
NOT_RUN = {
    "make run": "minutes: the main job, tests/run",
    "make test": "is what runs this",
    ".venv/bin/microtick motion": "minutes",
    ".venv/bin/microtick linuxcnc": "minutes: tests/ethercat/test_linuxcnc.py",
    ".venv/bin/python -m sim.bus.linuxcnc.steps": "tests/motion_rtl/test_linuxcnc_steps.py",
    "scripts/debian_tool.sh": "installs packages",
    ".venv/bin/pytest": "tests/docs/test_debugging.py runs it",
    ".venv/bin/microtick dual": "minutes",
    ".venv/bin/microtick bitstream": "place and route, minutes",
    "openFPGALoader": "needs a board",
    ".venv/bin/asip-run leg.s --config small --port": "needs a board, tests/silicon/test_board.py",
    ".venv/bin/asip-dbg leg.s --config small --port": "needs a board, tests/silicon/test_board.py",
    ".venv/bin/asip-dbg build/two.asip.json": "tests/debugger/test_functions.py makes it",
    "asip-scope": "needs a board, tests/scope/test_block.py",
    "make tools T=nios-toolchain": "builds a cross compiler",
    ".venv/bin/microtick nios-sw": "needs the cross compiler",
    ".venv/bin/microtick side-by-side": "needs the cross compiler, tests/model_compiler",
    ".venv/bin/python -m tests.conformance": "minutes, and tools: tests/conformance",
    ".venv/bin/python -m tests.cocotb": "minutes: runs the cocotb tests, tests/cocotb",
    ".venv/bin/python -m scripts.code_coverage": "an hour: runs all suites, tests/cocotb",
    "nios": "needs the cross compiler or a model that takes minutes to build",
    ".venv/bin/python scripts/synth_unit.py": "needs Yosys, minutes",
    ".venv/bin/python -m sim.bench.motion.show": "minutes",
    ".venv/bin/python -m sim.motion.lookahead.stress": "minutes without --count",
    ".venv/bin/python -m sim.bench.run.nios_profile": "builds another model, minutes",
    "python -m sim.bench.dual": "builds another model, minutes",
    "python -m sim.motion.gcode.oracle": "needs LinuxCNC's interpreter, tests/gcode",
    "python -m sim.motion.lookahead --figures": "a minute, tests/lookahead",
    "python -m sim.motion.planner --figures": "a minute, tests/planner",
    "cc ": "a fragment, its main.c is the reader's; own_machine.md has a whole one",
    "yosys": "is not part of this set-up, tests/fpu",
}
BLOCKS = list(block_commands())
EVERY = [*BLOCKS, *inline_commands()]
RUN = [c for c in BLOCKS if not any(c.text.startswith(start) for start in NOT_RUN)]
TESTS = names_of_tests()


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """A folder that looks like the checkout, with a build folder and part programs of its own."""
    root = tmp_path_factory.mktemp("checkout")
    for path in ROOT.iterdir():
        if path.name not in ("build", ".git"):
            (root / path.name).symlink_to(path)
    (root / "part.ngc").write_text((ROOT / "sim/paths/circle.ngc").read_text())
    (root / "tool.tbl").write_text("T1 P1 D6.0 Z10.0\n")
    for page in PAGES:
        write_files(page, root)
    return root


def environment() -> dict[str, str]:
    """As after `. .venv/bin/activate`, Verilator on the path; MICROTICK without a space."""
    path = [str(ROOT / ".venv/bin"), str(verilator_driver().parent), os.environ["PATH"]]
    return {**os.environ, "PATH": os.pathsep.join(path), "MICROTICK": str(plain(ROOT))}


def test_lists__hold_something_and_no_reason_is_left_over():
    assert len(RUN) > 8 and len(EVERY) > 100 and len(TESTS) > 1000
    texts = [command.text for command in BLOCKS]
    for start in NOT_RUN:
        assert any(text.startswith(start) for text in texts), f"'{start}' is in no block any more"


@pytest.mark.quick(
    "README.md*",
    "fast_programs.md*",
    "gcode.md*",
    "integration.md*",
    "motion.md*",
    "nios_systems.md*",
    "robot_parameters.md*",
    "units.md*",
)
@pytest.mark.parametrize("command", RUN, ids=str)
def test_command_of_a_block__runs(command, checkout):
    output("sh", "-ec", command.text, cwd=checkout, env=environment(), timeout=600)


def configurations(text: str) -> list[str]:
    """The configuration that a program states, else those of every core without streams."""
    stated = re.search(r"^\.config\s+(\w+)", text, re.MULTILINE)
    return [stated[1]] if stated else ["fast", "small"]


@pytest.mark.parametrize(
    ("configuration", "block"),
    [(name, block) for block in programs() for name in configurations(block.text)],
    ids=str,
)
def test_program__assembles(block, configuration, tmp_path):
    path = tmp_path / "program.s"
    path.write_text(block.text)
    assert assemble(path, configuration=configuration).bundles


# Pages whose Python is not run here, each with its reason.
PYTHON_NOT_RUN = {
    "ethercat_application.md": "needs a device on an interface, tests/ethercat/test_device.py",
    "cocotb.md": "for the wheel, tests/cocotb/test_page.py",
    "integration.md": "needs a platform of LiteX, tests/asip/test_litex.py",
}
PYTHON = [
    block
    for page in PAGES
    for block in code_blocks(page)
    if block.language == "python" and block.page not in PYTHON_NOT_RUN
]


@pytest.mark.parametrize("block", PYTHON, ids=str)
def test_python_block__runs(block, checkout):
    output(sys.executable, "-c", block.text, cwd=checkout, timeout=600)


def findings_of_make(command: Command) -> list[str]:
    """What the Makefile and the tests do not have of a command."""
    targets = re.findall(r"^([a-z-]+):.*## ", MAKEFILE, re.M)
    findings, values = [], {}
    for word in command.words[1:]:
        name, equals, value = word.partition("=")
        values[name] = value
        if not equals and name not in targets:
            findings.append(f"no target {name}")
        if equals and not re.search(rf"\$\({name}\)", MAKEFILE):
            findings.append(f"no variable {name}")
    if {"test", "test-full"} & set(values):
        for test in values.get("T", "").lower().split(" or "):
            if not any(test in name for name in TESTS):
                findings.append(f"no test for T={test}")
    file = values.get("GCODE") or values.get("ROBOT")
    if file and not file.startswith("my_") and not (ROOT / file).exists():
        findings.append(f"no file {file}")
    return [f"{command}: {finding}" for finding in findings]


def test_make__targets_variables_files_and_tests_exist():
    commands = [c for c in EVERY if c.words and c.words[0] == "make"]
    assert [text for command in commands for text in findings_of_make(command)] == []


def test_make__findings__of_a_command_that_is_gone():
    gone = Command("page.md", "make tset T=no_such_test GCODE=gone.ngc COLOUR=red")
    assert len(findings_of_make(gone)) == 3
    assert len(findings_of_make(Command("page.md", "make test T=no_such_test"))) == 1


def python_of(command: Command) -> tuple[str, list[str]] | None:
    """What the command runs: a module, or a script with a slash in it; None for neither."""
    words = command.words
    name = words[0].rpartition("/")[2]
    if name in CONSOLE:
        return CONSOLE[name], words[1:]
    if name == "pytest" or words[1:3] == ["-m", "pytest"]:
        return None
    if name == "python" and words[1:2] == ["-m"]:
        # Of the wheel, which has the packages of the checkout below `microtick`.
        if words[2] in CONSOLE:
            return CONSOLE[words[2]], words[3:]
        return words[2].removeprefix("microtick."), words[3:]
    return (words[1], words[2:]) if name == "python" and len(words) > 1 else None


def with_options(commands: list[Command]) -> list[Command]:
    """One command for each set of options of a module."""
    found = {}
    for command in commands:
        target = python_of(command) if command.words else None
        if target:
            options = tuple(word for word in target[1] if word.startswith("-"))
            found.setdefault((target[0], options), command)
    return list(found.values())


@pytest.mark.filterwarnings("ignore:.*found in sys.modules")
@pytest.mark.parametrize("command", with_options(EVERY), ids=str)
def test_python__module_or_script_exists_and_takes_its_options(command, monkeypatch, capsys):
    """`--help` after the words: their values are read before it, and it names every option."""
    module, words = python_of(command)
    monkeypatch.setattr(sys, "argv", [module, *words, "--help"])
    monkeypatch.chdir(ROOT)
    run = runpy.run_path if "/" in module else runpy.run_module
    with pytest.raises(SystemExit) as stop:
        run(module, run_name="__main__")
    shown = capsys.readouterr()
    if "make setup-synth" in str(stop.value.code):  # the cure, where the solver is missing
        return
    assert stop.value.code in (0, None) and "usage:" in shown.out, shown.err
    options = [word.partition("=")[0] for word in words if re.match("-{1,2}[A-Za-z]", word)]
    known = re.findall(r"(?<![\w-])-{1,2}[A-Za-z][\w-]*", shown.out)
    assert set(options) <= set(known), f"unknown: {set(options) - set(known)}"


def test_shell_blocks__hold_nothing_but_commands():
    known = re.compile(
        r"(make|microtick|python|cc|cp|verilator|yosys|nios|asip|openFPGALoader|\.venv/bin/|scripts/)"
    )
    assert [str(command) for command in BLOCKS if not known.match(command.text)] == []


def test_fragments__are_the_only_blocks_left():
    left = [
        block
        for page in PAGES
        for block in code_blocks(page)
        if block.language in ("", "sh") and not shell_lines(block) and ".output" not in block.text
    ]
    assert all(re.search(r"[{|]|->", block.text) for block in left), left
