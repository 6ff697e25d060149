# SPDX-License-Identifier: Apache-2.0
"""Scripts for Quartus and Platform Designer under tclsh, with the tool's commands substituted."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from tests.bench.commands import output
from tests.bench.needs import require

COMPONENT = (
    "set_module_property add_fileset set_fileset_property add_fileset_file add_parameter "
    "set_parameter_property add_interface set_interface_property add_interface_port send_message"
).split()


def calls(script: str, commands: Iterable[str]) -> list[tuple[str, ...]]:
    """The calls of `commands` that a script makes, in order, each as its words."""
    record = 'puts -nonewline "[join [linsert $args 0 NAME] \\x1f]\\x1e"'
    stand_ins = f"foreach name {{{' '.join(commands)}}} {{\n"
    stand_ins += f"  proc $name args [string map [list NAME $name] {{{record}}}]\n}}\n"
    made = output(require("tclsh"), "/dev/stdin", input=stand_ins + script)
    return [tuple(call.split("\x1f")) for call in made.split("\x1e")[:-1]]


class Component:
    """A component of Platform Designer as its script describes it; `then` is run after that."""

    def __init__(self, script: Path, then: str = "", **parameters: int) -> None:
        given = " ".join(f"{name} {value}" for name, value in parameters.items())
        self.calls = calls(
            f"array set given {{{given}}}\n"
            "rename add_parameter record_parameter\n"
            "proc add_parameter {name type default args} {\n"
            "  record_parameter $name $type $default {*}$args\n"
            "  if {![info exists ::given($name)]} { set ::given($name) $default }\n}\n"
            "proc get_parameter_value name { return $::given($name) }\n"
            f"proc get_module_property name {{ return {{{script.parent}}} }}\n"
            f"package provide qsys 13.1\nsource {{{script}}}\n{then}\n",
            COMPONENT,
        )
        defaults = {words[0]: int(words[2]) for words in self.of("add_parameter")}
        self.parameters = defaults | parameters

    def of(self, command: str) -> list[tuple[str, ...]]:
        """Arguments of every call of a command."""
        return [words[1:] for words in self.calls if words[0] == command]
