# SPDX-License-Identifier: Apache-2.0
"""Command asip-dbg: stop a program on the core, look into it, go on."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Callable

from asip_asm.command import run_command
from asip_asm.debug_map import DebugMapError
from asip_asm.image import ImageError
from sim.debug.asip_dbg.command_table import AssertionMissed, CommandError, Quit
from sim.debug.asip_dbg.commands import Commands
from sim.debug.asip_dbg.options import open_session, parse_arguments
from sim.debug.asip_dbg.program import ProgramError
from sim.debug.asip_dbg.session import Session, SessionError
from sim.debug.asip_run.inputs import UserError
from sim.rtl.asip_bus import AsipError, LinkError

MISSED = 3
"""Exit status of a false `assert`, as of every comparison beyond its bound."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    errors = (UserError, ImageError, DebugMapError, ProgramError, AsipError, SessionError)
    return run_command("asip-dbg", lambda: _command(options), *errors)


def _command(options: argparse.Namespace) -> int:
    if options.dap or options.port is not None:
        from sim.debug.asip_dbg.dap_server import serve

        return serve(options)
    session = open_session(options)
    try:
        return _debug(session, options)
    finally:
        session.target.close()


def _debug(session: Session, options: argparse.Namespace) -> int:
    terminal = sys.stdin.isatty() and not options.batch
    commands = Commands(session, print, color=terminal and sys.stdout.isatty())
    session.log = print
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
    except LinkError as error:
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
    from sim.debug.asip_dbg.prompt import PROMPT, make_prompt

    # A shell starts what it runs in the background with Ctrl-C ignored, and children inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    ask: Callable[[str], str] = make_prompt(commands.session).prompt
    while True:
        try:
            _one(commands, ask(PROMPT))
        except KeyboardInterrupt:
            print("Ctrl-C: `quit` or Ctrl-D ends the session")
        except EOFError:
            return 0


if __name__ == "__main__":
    sys.exit(main())
