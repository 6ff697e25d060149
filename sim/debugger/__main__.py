# SPDX-License-Identifier: Apache-2.0
"""Command asip-dbg: stop a program on the core, look into it, go on."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from asip_asm.command import run_command
from asip_asm.debug_map import DebugMapError
from asip_asm.diagnostics import AssemblyError
from asip_asm.image import ImageError
from asip_asm.isa import default_isa
from sim.asip_run.inputs import UserError, assignments, read_inputs
from sim.debugger.command_table import AssertionMissed, CommandError, Quit
from sim.debugger.commands import Commands
from sim.debugger.program import DebuggedProgram, ProgramError
from sim.debugger.session import Session
from sim.debugger.target import Target, TargetError, TargetGone
from sim.debugger.targets import add_target_options, make_target

MISSED = 3
"""Exit status of a false `assert`, as of every comparison beyond its bound."""

EPILOG = """examples:
  asip-dbg leg.s --set x=0.3 --set y=0.1
  asip-dbg build/leg.asip.json --inputs path.csv -x find_fault.dbg --batch
  asip-dbg leg.s --iss -ex 'break (7)' -ex run -ex 'print q'
  asip-dbg --dap leg.s

An image needs its debug map beside it (leg.asip.map.json), which asip-as writes. help at the prompt
lists the commands; docs/debugger.md is a session from a wrong program to its fault.

exit status: 0 or what quit says, 1 an error in a file, script or target, 2 wrong command line,
3 an assert that failed
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    return run_command("asip-dbg", lambda: _command(options))


def _command(options: argparse.Namespace) -> int:
    try:
        if options.dap or options.port is not None:
            from sim.debugger.dap_server import serve

            return serve(options)
        session = open_session(options)
    except AssemblyError as error:
        print(error.report(), file=sys.stderr)
        return 1
    except (UserError, ImageError, DebugMapError, ProgramError, TargetError) as error:
        print(f"asip-dbg: error: {error}", file=sys.stderr)
        return getattr(error, "status", 1)
    try:
        return _debug(session, options)
    finally:
        session.target.close()


def open_session(options: argparse.Namespace, target: Target | None = None) -> Session:
    """Session of the options. Raises what the program, inputs or target raise."""
    program = DebuggedProgram(options.program, options.config, not options.unoptimised)
    image = program.image
    types = {entry.name: entry.type for entry in image.inputs}
    inputs = assignments(options.set, types, "input")
    states = assignments(options.state, {s.name: s.type for s in image.states}, "state")
    rows = read_inputs(options.inputs, types) if options.inputs else []
    session = Session(program, target or make_target(options, image), states, rows)
    session.values.inputs.update(inputs)
    return session


def _debug(session: Session, options: argparse.Namespace) -> int:
    terminal = sys.stdin.isatty() and not options.batch
    commands = Commands(session, print, color=terminal and sys.stdout.isatty())
    program = session.program
    print(
        f"{program.path}: '{program.image.title}', {program.image.configuration}, "
        f"{program.bundles} bundles, on the {session.target.label}"
    )
    changed = program.changed_files()
    if changed:
        print(
            f"asip-dbg: warning: changed since it was assembled: {', '.join(changed)}; lines may "
            "be others, assemble again",
            file=sys.stderr,
        )
    try:
        failed = 0
        for line in options.commands:
            failed = _one(commands, line) or failed
        if options.batch:
            return failed
        return _interactive(commands) if terminal else _piped(commands) or failed
    except Quit as end:
        return end.status


def _one(commands: Commands, line: str) -> int:
    """Carry out a line; exit status if the session ended with it. Raises Quit."""
    try:
        commands.execute(line)
    except AssertionMissed as error:
        print(f"asip-dbg: {error}", file=sys.stderr)
        return MISSED
    except TargetGone as error:
        print(f"asip-dbg: error: {error}; `reconnect` looks for it again", file=sys.stderr)
        return 1
    except CommandError as error:
        print(f"asip-dbg: error: {error}", file=sys.stderr)
        return 1
    return 0


def _piped(commands: Commands) -> int:
    """Commands of standard input that is no terminal; the first exit status that is not 0."""
    failed = 0
    for line in sys.stdin:
        status = _one(commands, line if line.strip() else "#")
        failed = failed or status
        sys.stdout.flush()
    return failed


def _interactive(commands: Commands) -> int:
    from sim.debugger.prompt import PROMPT, make_prompt

    ask: Callable[[str], str] = make_prompt(commands.session).prompt
    while True:
        try:
            _one(commands, ask(PROMPT))
        except KeyboardInterrupt:
            print("Ctrl-C: `quit` or Ctrl-D ends the session")
        except EOFError:
            return 0


def parse_arguments(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of the command line; exits with status 2 if they are wrong."""
    parser = argparse.ArgumentParser(
        prog="asip-dbg",
        description="Debug a program on the core by the names of its source.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "program", type=Path, nargs="?", help="source text, or image written by asip-as (*.json)"
    )
    add_target_options(parser)
    parser.add_argument(
        "--config", choices=tuple(default_isa().configurations), help="configuration of the core"
    )
    parser.add_argument(
        "-O0",
        dest="unoptimised",
        action="store_true",
        help="assemble a source with one operation per bundle, in the order written",
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="input of the ticks"
    )
    parser.add_argument(
        "--state", action="append", default=[], metavar="NAME=VALUE", help="first value of a state"
    )
    parser.add_argument(
        "--inputs", type=Path, metavar="FILE", help="CSV file with a row of inputs for each tick"
    )
    parser.add_argument(
        "-x",
        dest="commands",
        action="append",
        default=[],
        type=lambda file: f"source {file}",
        metavar="SCRIPT",
        help="carry out the commands of a file, before those that are typed",
    )
    parser.add_argument(
        "-ex", dest="commands", action="append", metavar="COMMAND", help="carry out a command"
    )
    parser.add_argument("--batch", action="store_true", help="end after the commands of -x and -ex")
    parser.add_argument(
        "--dap",
        action="store_true",
        help="serve the Debug Adapter Protocol on standard input and output, as for VS Code",
    )
    parser.add_argument(
        "--port",
        type=int,
        metavar="N",
        help="with --dap: serve on this TCP port of the loopback address (0: a free one)",
    )
    options = parser.parse_args(arguments)
    if options.program is None and not (options.dap or options.port is not None):
        parser.error("which program? asip-dbg PROGRAM")
    if options.port is not None and not 0 <= options.port <= 65535:
        parser.error(f"--port {options.port}: 0 to 65535")
    return options


if __name__ == "__main__":
    sys.exit(main())
