# SPDX-License-Identifier: Apache-2.0
"""Options of asip-dbg, and the session and target that they ask for."""

from __future__ import annotations

import argparse
from pathlib import Path

from asip_asm.command import command_parser
from asip_asm.isa import default_isa
from sim.core.backends import Backend, IssBackend
from sim.debug.asip_dbg.program import DebuggedProgram
from sim.debug.asip_dbg.session import Session, SessionError
from sim.debug.asip_run.inputs import assignments, read_inputs
from sim.rtl.asip_bus import AsipError

EPILOG = """examples:
  asip-dbg leg.s --set x=0.3 --set y=0.1
  asip-dbg build/leg.asip.json --inputs path.csv -x find_fault.dbg --batch
  asip-dbg leg.s --iss -ex 'break (7)' -ex run -ex 'print q'
  asip-dbg leg.s --config small --port /dev/ttyUSB0
  asip-dbg --dap leg.s

An image needs its debug map (leg.asip.map.json) next to it; asip-as and asip-model write it. help
at the prompt lists the commands; docs/debugger.md is a session from a wrong program to its fault.

exit status: 0 or what quit says, 1 an error in a file, script or target, 2 wrong command line,
3 an assert that failed
"""


def open_session(options: argparse.Namespace) -> Session:
    """Session of the options. Raises what the program, inputs or target raise."""
    program = DebuggedProgram(
        options.program, options.config, not options.unoptimised, options.function
    )
    image = program.image
    types = {entry.name: entry.type for entry in image.inputs}
    inputs = assignments(options.set, types, "input")
    states = assignments(options.state, {s.name: s.type for s in image.states}, "state")
    rows = read_inputs(options.inputs, types) if options.inputs else []
    session = Session(program, make_target(options, image.configuration), states, rows)
    if inputs and session.target.driven:
        raise SessionError(
            "inputs are those of the machine's host; leave --set out, or give --load"
        )
    session.values.inputs.update(inputs)
    return session


def parse_arguments(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of the command line; exits with status 2 if they are wrong."""
    parser = command_parser(
        "asip-dbg", "Debug a program on the core by the names of its source.", EPILOG
    )
    parser.add_argument(
        "program", type=Path, nargs="?", help="source text, or image written by asip-as (*.json)"
    )
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--iss",
        action="store_true",
        help="debug on the instruction-set model, which needs no build and has no cycles; the "
        "default is the Verilated core with its debug block, built at first use",
    )
    place.add_argument(
        "--uart",
        action="store_true",
        help="debug on the Verilated core through its serial pins",
    )
    place.add_argument(
        "--connect",
        metavar="ADDRESS",
        help="debug the core at tcp://HOST:PORT or serial:PATH[?baud=N], which has the program and "
        "gets its ticks from another host",
    )
    parser.add_argument(
        "--load",
        action="store_true",
        help="with --connect: load the program, write inputs and start ticks from here",
    )
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
        "--function",
        metavar="NAME",
        help="function to debug, if the image has several (asip-model)",
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
        "-ex",
        dest="commands",
        action="append",
        metavar="COMMAND",
        help="execute a command of the debugger",
    )
    parser.add_argument("--batch", action="store_true", help="end after the commands of -x and -ex")
    parser.add_argument(
        "--dap",
        action="store_true",
        help="serve the Debug Adapter Protocol on standard input and output, as for VS Code",
    )
    parser.add_argument(
        "--port",
        metavar="DEVICE|N",
        help="debug the board at this serial port, as --load --connect serial:DEVICE; a number, "
        "with --dap: serve on this TCP port of the loopback address (0: a free one)",
    )
    options = parser.parse_args(arguments)
    if options.port is not None:
        take_port(parser, options)
    if options.load and not options.connect:
        parser.error("--load goes with --connect; without it the program is always loaded")
    if options.program is None and not (options.dap or options.port is not None):
        parser.error("which program? asip-dbg PROGRAM")
    return options


def take_port(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """`--port` of a board, or of the DAP server: then it becomes a number."""
    if options.port.lstrip("-").isdecimal():
        options.port = int(options.port)
        if not 0 <= options.port <= 65535:
            parser.error(f"--port {options.port}: 0 to 65535")
        return
    if options.connect or options.iss or options.uart:
        parser.error("--port DEVICE is a place of its own; leave --connect, --iss, --uart out")
    device = options.port
    options.connect = device if device.startswith(("serial:", "tcp:")) else f"serial:{device}"
    options.load, options.port = True, None


def make_target(options: argparse.Namespace, configuration: str) -> Backend:
    """Where programs of a configuration are debugged. Raises AsipError."""
    if options.iss:
        return IssBackend()
    # A session on the model takes none of these.
    from sim.debug.backend import BlockBackend, open_block
    from sim.debug.client import Client

    if options.connect:
        return open_block(options.connect, driven=not options.load)
    from sim.debug.model import DebugRtl
    from sim.rtl.build import BuildError

    try:
        model = DebugRtl(configuration)
    except BuildError as error:
        raise AsipError(f"{error}\n--iss debugs without a built core") from None
    if options.uart:
        return BlockBackend(
            lambda: Client(model.serial_link()), "Verilated core by its serial pins"
        )
    return open_block(model)
