# SPDX-License-Identifier: Apache-2.0
"""Every entry of the robot's file acts in a command or is in the command's list of unused ones."""

from __future__ import annotations

import tomllib

import pytest

from asip_asm.project import ROOT
from sim.motion.lookahead import __main__ as lookahead
from sim.robot.parameter_uses import UNUSED
from sim.robot.parameters import ROBOT_TOML
from tests.run import robot_entries


def test_entries__moved_are_those_of_the_file():
    entries = tomllib.loads(ROBOT_TOML.read_text(encoding="utf-8"))
    assert sorted(entries) == sorted(robot_entries.ENTRIES)
    assert set(UNUSED) == set(robot_entries.COMMANDS)


@pytest.mark.parametrize("command", UNUSED)
def test_entry__moved_alone__changes_the_command_or_is_in_its_list(command):
    assert robot_entries.unused(command) == set(UNUSED[command])
    assert len(UNUSED[command]) == len(set(UNUSED[command]))


def test_help__counts_the_entries_that_the_command_does_not_use__the_page_names_them(capsys):
    with pytest.raises(SystemExit):
        lookahead.main(["--help"])
    text = " ".join(capsys.readouterr().out.split())
    assert f"{len(UNUSED['lookahead'])} of them" in text
    assert "docs/robot_parameters.md" in text
    page = (ROOT / "docs/robot_parameters.md").read_text(encoding="utf-8")
    rows = {row.split("`")[1]: row for row in page.splitlines() if row.startswith("| `")}
    for name in UNUSED["lookahead"]:
        assert "lookahead" in rows[name].split("|")[-2], name
