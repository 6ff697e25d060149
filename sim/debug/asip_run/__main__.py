# SPDX-License-Identifier: Apache-2.0
"""Command asip-run: run a program on the Verilated core or on the instruction-set model."""

from __future__ import annotations

import argparse
import sys
from contextlib import nullcontext
from pathlib import Path

from asip_asm.command import command_parser, count, run_command
from asip_asm.files import open_output, refuse_overwriting
from asip_asm.image import Image, ImageError
from asip_asm.isa import default_isa
from sim.core.fault import NO_FAULT
from sim.debug.asip_run.coverage import Coverage
from sim.debug.asip_run.inputs import UserError, assignments, load_image, printed_names, read_inputs
from sim.debug.asip_run.runner import Runner, limit_note
from sim.debug.asip_run.show import write_profile, write_row, write_text, write_trace

MAX_CYCLES = 500_000
FAULTS_SHOWN = 20
"""Faults of which --keep-going shows the place."""

EPILOG = """examples:
  asip-run leg.s --set x=0.3 --set y=0.1
  asip-run build/leg.asip.json --iss --inputs path.csv --print F1,l1 > forces.csv
  asip-run leg.s --set x=0.3 --profile --konata build/leg.konata --gantt build/leg.html
  asip-run leg.s --inputs path.csv --coverage build/leg.csv > all.csv
  asip-run leg.s --inputs path.csv --keep-going > all.csv
  asip-run leg.s --config small --ticks 3 --state sum=1.5 --trace build/writes.txt
  asip-run leg.s --config small --port /dev/ttyUSB0 --set x=0.3

Floats may be written as bits (0f3f800000). Inputs that are not given are 0. With --inputs the
result is a CSV table, one row per run; a run after the last row repeats it.

With --iss the bits are those of the core, except for fsin and fcos: the model rounds them
correctly, the core's error is below 0.532 units in the last place, so
that about one result in 500 differs in its last bit (docs/numerics.md). A note says so when the
program uses them.

exit status: 0 all runs done, 1 a fault, or an error in a file, 2 wrong command line
"""

SINES = {"fsin", "fcos"}
SINE_NOTE = (
    "asip-run: note: fsin and fcos are correctly rounded here; the core's result may differ in its "
    "last bit (docs/numerics.md)"
)


def operations(image: Image) -> set[str]:
    """Names of the operations in the program."""
    return {source.op for sources in image.sources for source in sources}


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    return run_command("asip-run", lambda: _run(options), UserError, ImageError)


def _run(options: argparse.Namespace) -> int:
    files = [path for path in (options.trace, options.konata, options.gantt) if path]
    if options.coverage:
        if options.coverage.suffix == ".lst":
            raise UserError(
                "--coverage names the CSV file; the listing, .lst, is put next to it", 2
            )
        if options.program.suffix == ".json":
            raise UserError("--coverage lists the source; give it in place of its image", 2)
        files += [options.coverage, options.coverage.with_suffix(".lst")]
    inputs = [options.program, *([options.inputs] if options.inputs else [])]
    refuse_overwriting(files, inputs)
    image = load_image(options.program, options.config, options.function)
    watchdog = image.watchdog
    image.watchdog = min(watchdog, options.max_cycles)
    types = {word.name: word.type for word in image.inputs}
    fixed = dict.fromkeys(types, 0) | assignments(options.set, types, "input")
    state_types = {state.name: state.type for state in image.states}
    states = assignments(options.state, state_types, "state")
    names = printed_names(image, options.print)
    rows = read_inputs(options.inputs, types) if options.inputs else [{}]
    ticks = len(rows) if options.ticks is None else options.ticks
    profile = options.profile or options.konata or options.gantt or options.coverage
    if profile and options.iss:
        raise UserError("the model has no clock cycles to profile; use --rtl", 2)
    if options.port and (profile or options.trace):
        raise UserError("a board does not report every write; use --rtl, or asip-scope on it", 2)
    trace_on = bool(options.trace or profile)
    if options.iss and not SINES.isdisjoint(operations(image)):
        print(SINE_NOTE, file=sys.stderr)
    place = options.port or ("iss" if options.iss else "rtl")
    runner = Runner(image, states, place, trace_on)
    table = bool(options.inputs)
    faults = 0
    coverage = Coverage(image)
    with open_output(options.trace) if options.trace else nullcontext() as trace:
        for tick in range(ticks):
            result = runner.run(fixed | rows[min(tick, len(rows) - 1)], names)
            write = write_row if table else write_text
            write(sys.stdout, image, tick, names, result)
            if trace:
                write_trace(trace, tick, result)
            if result.cause == NO_FAULT:
                if profile and result.observed.trace:
                    coverage.add(tick + 1, result.observed.trace)
                continue
            note = limit_note(result, watchdog, options.max_cycles)
            problem = f"run {tick + 1}: {result.text}{note}"
            if not options.keep_going:
                raise UserError(problem)
            faults += 1
            if faults <= FAULTS_SHOWN:
                sys.stdout.flush()
                print(f"asip-run: error: {problem}", file=sys.stderr)
    if profile and result.observed.trace:
        file = sys.stderr if table else sys.stdout
        write_profile(file, image, result.observed.trace, options.konata, options.gantt)
        file.write(coverage.summary() if ticks > 1 else "")
    if options.coverage:
        coverage.write(options.coverage)
        print(coverage.covered(), end="", file=sys.stderr)
    if faults:
        raise UserError(f"{faults} of {ticks} runs ended with a fault")
    return 0


def parse_arguments(arguments: list[str] | None) -> argparse.Namespace:
    """Options of the command line; exits with status 2 if they are wrong."""
    parser = command_parser(
        "asip-run",
        "Run a program on the Verilated core, the instruction-set model or a board.",
        EPILOG,
    )
    parser.add_argument(
        "program", type=Path, help="source text, or image written by asip-as (*.json)"
    )
    place = parser.add_mutually_exclusive_group()
    place.add_argument("--rtl", action="store_true", help="run on the Verilated core (default)")
    place.add_argument(
        "--iss",
        action="store_true",
        help="run on the instruction-set model, bits as the core's except fsin, fcos",
    )
    place.add_argument(
        "--port",
        metavar="DEVICE",
        help="run on the board at this serial port, /dev/ttyUSB0 or /dev/ttyACM0?baud=115200 "
        "(docs/boards.md), or on the core at tcp://HOST:PORT",
    )
    parser.add_argument(
        "--config", choices=tuple(default_isa().configurations), help="configuration of the core"
    )
    parser.add_argument("--function", metavar="NAME", help="of an image with several")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="input of every run"
    )
    parser.add_argument(
        "--inputs", type=Path, metavar="FILE", help="CSV file with a row of inputs for each run"
    )
    parser.add_argument(
        "--keep-going",
        action="store_true",
        help="clear a fault and go on with the next run; the exit status is still 1",
    )
    parser.add_argument(
        "--max-cycles",
        type=count,
        default=MAX_CYCLES,
        metavar="N",
        help="cycles (with --iss: bundles) after which a run is stopped as by the program's "
        f"watchdog, if that is larger (default {MAX_CYCLES})",
    )
    parser.add_argument("--ticks", type=count, metavar="N", help="number of runs")
    parser.add_argument(
        "--state",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="state before the first run",
    )
    parser.add_argument(
        "--print",
        metavar="NAME,...",
        help="outputs, exports, states, registers to show (default: all outputs and exports)",
    )
    parser.add_argument(
        "--trace", type=Path, metavar="FILE", help="write every register and output written"
    )
    parser.add_argument(
        "--profile",
        action="store_true",
        help="where the cycles of the last run went, and cycles of all runs (with --inputs on "
        "standard error)",
    )
    parser.add_argument(
        "--coverage",
        type=Path,
        metavar="FILE",
        help="profile, and executions and cycles of each source line over all runs: a CSV file, "
        "and a listing next to it (.lst)",
    )
    parser.add_argument(
        "--konata",
        type=Path,
        metavar="FILE",
        help="profile, and a pipeline log for the Konata viewer",
    )
    parser.add_argument(
        "--gantt",
        type=Path,
        metavar="FILE",
        help="profile, and an HTML chart of units over clock cycles",
    )
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
