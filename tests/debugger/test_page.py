# SPDX-License-Identifier: Apache-2.0
"""docs/debugger.md: its session is carried out, its files for editors are held against the code."""

from __future__ import annotations

import json
import re
import shlex

import jsonschema
import pytest

from asip_asm.isa import default_isa
from scripts.doc_blocks import code_blocks
from sim.debug.asip_dbg.command_table import CommandError, find_command
from sim.debug.asip_dbg.commands import Commands
from sim.debug.asip_dbg.dap_launch import NAMES, OF_CLIENTS, launch_options
from sim.debug.asip_dbg.options import open_session, parse_arguments
from sim.rtl.build import ROOT

PAGE = ROOT / "docs/debugger.md"
TEXT = PAGE.read_text()
PROMPT = "(asip-dbg) "
BLOCKS = code_blocks(PAGE)
FILES = {block.title: block.text for block in BLOCKS if block.title}
TRANSCRIPT = "".join(block.text for block in BLOCKS if block.text.startswith(PROMPT))
START = re.search(r"`\.venv/bin/asip-dbg (leg\.s --iss [^`]*)`", TEXT)[1]


def session(arguments: str) -> str:
    """The transcript as the debugger gives it for the commands on the page."""
    lines: list[str] = []
    commands = Commands(open_session(parse_arguments(shlex.split(arguments))), lines.append)
    for line in TRANSCRIPT.splitlines():
        if line.startswith(PROMPT):
            lines.append(line)
            try:
                commands.execute(line.removeprefix(PROMPT))
            except CommandError as error:
                lines.append(f"asip-dbg: error: {error}")
    return "\n".join(lines) + "\n"


def test_every_step_of_the_session(tmp_path, monkeypatch):
    (tmp_path / "leg.s").write_text(FILES["leg.s"])
    monkeypatch.chdir(tmp_path)
    assert session(START) == TRANSCRIPT


def test_the_cure_of_the_session(tmp_path, monkeypatch):
    wrong, right = FILES["leg.s"].splitlines()[13], "        fmadd   q, z, z, t"
    assert "fnmsub  q, z, z, t" in wrong and "`fmadd q, z, z, t`" in TEXT
    (tmp_path / "leg.s").write_text(FILES["leg.s"].replace(wrong, right))
    monkeypatch.chdir(tmp_path)
    lines: list[str] = []
    Commands(open_session(parse_arguments(shlex.split(START))), lines.append).execute("run")
    assert lines[-1].startswith("F       0.09")
    assert "\n".join(lines[1:]) in TRANSCRIPT


def test_commands_of_the_page_exist():
    table = TEXT[TEXT.index("| to | command |") :].split("\n\n")[0]
    shown = re.findall(r"`([^`]+)`", table)
    assert len(shown) > 30
    for text in shown:
        if not text.startswith("if "):
            find_command(re.match(r"[a-z]+", text)[0])


def test_launch_file_and_its_arguments():
    (configuration,) = json.loads(FILES["launch.json"])["configurations"]
    path = configuration["program"].replace("${workspaceFolder}", str(ROOT / "tests/debugger"))
    options = launch_options(configuration | {"program": path}, parse_arguments(["--dap"]))
    assert options.iss and "x=0.3" in options.set
    extension = json.loads(FILES["package.json"])["contributes"]["debuggers"][0]
    assert extension["type"] == configuration["type"] and extension["args"] == ["--dap"]
    table = TEXT[TEXT.index("| argument | what |") :].split("\n\n")[0]
    first_cells = " ".join(row.split("|")[1] for row in table.splitlines())
    assert set(re.findall(r"`(\w+)`", first_cells)) == NAMES


def test_editor_checks_the_launch_file_as_the_server_does():
    (configuration,) = json.loads(FILES["launch.json"])["configurations"]
    (debugger,) = json.loads(FILES["package.json"])["contributes"]["debuggers"]
    schemas = debugger["configurationAttributes"]
    launch, attach = (schemas[name] | {"additionalProperties": False} for name in schemas)
    assert set(launch["properties"]) == NAMES
    assert tuple(launch["properties"]["configuration"]["enum"]) == tuple(
        default_isa().configurations
    )
    of_editor = {"debugServer": 4711, "preLaunchTask": "build", "presentation": {"order": 1}}
    assert launch_options(configuration | of_editor, parse_arguments(["--dap"])).iss
    own = {name: configuration[name] for name in configuration if name not in OF_CLIENTS}
    jsonschema.Draft7Validator.check_schema(launch)
    jsonschema.validate(own, launch)
    for wrong in (own | {"iss": "yes"}, own | {"programme": "x"}, {"iss": True}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, launch)
    jsonschema.validate({"program": "leg.s", "connect": "tcp://localhost:2331"}, attach)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"program": "leg.s"}, attach)
