# SPDX-License-Identifier: Apache-2.0
"""Arguments of `launch` and `attach` as the options of the command line, with their checks."""

from __future__ import annotations

import argparse
import contextlib
import io
from collections.abc import Mapping
from typing import Any

from sim.debug.asip_dbg.options import parse_arguments
from sim.debug.asip_run.inputs import UserError

SWITCHES = {"iss": "--iss", "uart": "--uart", "load": "--load"}
TEXTS = {"configuration": "--config", "connect": "--connect", "function": "--function"}
ASSIGNMENTS = {"set": "--set", "state": "--state"}
NAMES = {"token", "program", "inputs", "optimise", "stopOnEntry", *SWITCHES, *TEXTS, *ASSIGNMENTS}
OF_CLIENTS = {
    *("noDebug", "name", "type", "request", "console", "internalConsoleOptions", "debugServer"),
    *("preLaunchTask", "postDebugTask", "presentation", "serverReadyAction"),
    *("suppressMultipleSessionWarning", "windows", "linux", "osx"),
}
"""What clients add by themselves or read in launch.json for themselves, and hand on; names that
begin with `__` too."""


def launch_options(arguments: Mapping[str, Any], options: argparse.Namespace) -> argparse.Namespace:
    """Options of a session; `options` are those that the server was started with. Raises UserError
    naming the argument.
    """
    unknown = [n for n in arguments if n not in NAMES | OF_CLIENTS and not n.startswith("__")]
    if unknown:
        raise UserError(f"launch: no argument '{unknown[0]:.40}'; there are {', '.join(NAMES)}")
    for name in ("optimise", "stopOnEntry", *SWITCHES):
        if not isinstance(arguments.get(name, False), bool):
            raise UserError(f'launch: "{name}" is true or false, without quotes')
    program = arguments.get("program") or options.program
    if not isinstance(program, str) and program is None:
        raise UserError('launch needs "program": a source text, or an image written by asip-as')
    words = []  # each value in the word of its option: none can be taken for an option itself
    for name, option in SWITCHES.items():
        given = arguments.get(name, getattr(options, name, False))
        words += [option] if given else []
    for name, option in TEXTS.items():
        if name in arguments:
            words.append(f"{option}={arguments[name]}")
    for name, option in ASSIGNMENTS.items():
        given = arguments.get(name, {})
        if not isinstance(given, Mapping):
            raise UserError(f'launch: "{name}" is an object of names and values')
        words += [f"{option}={key}={value}" for key, value in given.items()]
    if "inputs" in arguments:
        words.append(f"--inputs={arguments['inputs']}")
    if arguments.get("optimise") is False:
        words.append("-O0")
    errors = io.StringIO()
    try:
        with contextlib.redirect_stderr(errors):
            return parse_arguments([*words, "--", str(program)])
    except SystemExit:
        message = (errors.getvalue().strip().splitlines() or ["launch: wrong arguments"])[-1]
        raise UserError(message.removeprefix("asip-dbg: error: ")) from None
