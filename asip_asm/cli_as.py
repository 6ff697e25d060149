# SPDX-License-Identifier: Apache-2.0
"""Command asip-as: assemble a program."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path

from asip_asm.assemble import build_program, encode
from asip_asm.c_image import to_c
from asip_asm.command import command_parser, run_command
from asip_asm.debug_map import map_path
from asip_asm.debug_values import debug_map
from asip_asm.diagnostics import AssemblyError, closest, counted, report_text
from asip_asm.files import open_output, refuse_overwriting
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.lint import WARNINGS
from asip_asm.listing import listing, symbols
from asip_asm.memory_formats import to_intel_hex, to_mif, to_readmemh
from asip_asm.report import report_program
from asip_asm.search import Progress

FORMATS: dict[str, tuple[Callable[[Image], str], str]] = {
    "json": (Image.dumps, ".asip.json"),
    "c": (to_c, ".asip.h"),
    "readmemh": (to_readmemh, ".mem"),
    "ihex": (to_intel_hex, ".hex"),
    "mif": (to_mif, ".mif"),
}
"""Text of an image, and how the names of such files end."""
EPILOG = """examples:
  asip-as leg.s -o build/leg.asip.json --listing build/leg.lst
  asip-as leg.s -O --report
  asip-as leg.s -O0 --config small -D R=0.6 --format readmemh -o build/leg.hex
  asip-as asip_asm/programs/tracking_optimised.s --params my_robot.toml -o build/mine.asip.json

exit status: 0 assembled, 1 errors in the source text or a file, 2 wrong command line
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    return run_command("asip-as", lambda: _assemble(options))


def _assemble(options: argparse.Namespace) -> int:
    to_text, suffix = FORMATS[options.format]
    output = options.output or options.source.parent / (options.source.stem + suffix)
    beside = map_path(output) if options.format == "json" else None
    written = [path for path in (output, beside, options.listing, options.symbols) if path]
    refuse_overwriting(written, [options.source])
    progress = _Progress()
    try:
        program, machine = build_program(
            options.source,
            configuration=options.config,
            optimise=options.optimise,
            defines=dict(options.define),
            include_path=options.include,
            params=options.params,
            progress=progress.show,
        )
        refuse_overwriting(written, program.files)
        image = encode(program, machine, options.source)
        shown = [w for w in program.warnings if f"no-{w.code}" not in options.warnings]
        if shown:
            print(report_text(shown), file=sys.stderr)
        if shown and (options.warn_error or "error" in options.warnings):
            print(
                f"asip-as: {counted(len(shown), 'warning')} taken as errors, nothing written",
                file=sys.stderr,
            )
            return 1
        as_c = options.format == "c"
        text = to_c(image, options.prefix or "") if as_c else to_text(image)
        texts = {output: text}
        if beside:
            texts[beside] = debug_map(program, machine, image).dumps()
        if options.listing:
            texts[options.listing] = listing(image)
        if options.symbols:
            texts[options.symbols] = symbols(image)
    except AssemblyError as error:
        count = len(error.diagnostics)
        print(error.report(), file=sys.stderr)
        print(f"asip-as: {counted(count, 'error')}, nothing written", file=sys.stderr)
        return 1
    finally:
        progress.clear()
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        with open_output(path) as file:
            file.write(text)
    print(summary(image, output))
    if options.report:
        print(report_program(program, machine).render(), end="")
    return 0


class _Progress:
    """How far the search for a schedule is, on a terminal, from the second `AFTER` on."""

    AFTER = 1.0

    def __init__(self) -> None:
        self.start = time.monotonic()
        self.shown = False

    def show(self, state: Progress) -> None:
        passed = time.monotonic() - self.start
        if passed < self.AFTER or not sys.stderr.isatty():
            return
        self.shown = True
        left = passed * (state.effort - state.tried) / max(1, state.tried)
        print(
            f"\rschedule {state.tried} of {state.effort} tried: {state.cycles} cycles, at least "
            f"{state.bound}; {left:.0f} s left  ",
            end="",
            file=sys.stderr,
            flush=True,
        )

    def clear(self) -> None:
        if self.shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def summary(image: Image, output: Path) -> str:
    """Line that says what was written."""
    operations = sum(len(entries) for entries in image.sources)
    constants = len({c.index for c in image.constants})
    cycles = f", about {image.cycles} cycles" if image.cycles is not None else ""
    return (
        f"{output}: {image.configuration}, {counted(len(image.bundles), 'bundle')}, "
        f"{counted(operations, 'operation')}, {counted(len(image.inputs), 'input')}, "
        f"{counted(constants, 'constant')}, {counted(len(image.outputs), 'output')}{cycles}"
    )


def parse_arguments(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of the command line; SystemExit(2) if they are wrong."""
    parser = command_parser("asip-as", "Assemble a program into an image.", EPILOG)
    parser.add_argument("source", type=Path, help="source file")
    parser.add_argument("-o", dest="output", type=Path, metavar="FILE", help="file to write")
    level = parser.add_mutually_exclusive_group()
    level.add_argument(
        "-O",
        dest="optimise",
        action="store_true",
        default=True,
        help="schedule operations into bundles (default)",
    )
    level.add_argument(
        "-O0",
        dest="optimise",
        action="store_false",
        help="one operation per bundle, in the order written",
    )
    parser.add_argument(
        "--config", choices=tuple(default_isa().configurations), help="configuration of the core"
    )
    parser.add_argument(
        "-D",
        dest="define",
        action="append",
        default=[],
        type=_definition,
        metavar="NAME=VALUE",
        help="replace the value of a parameter",
    )
    parser.add_argument(
        "--params",
        type=Path,
        metavar="FILE",
        help="parameter file (TOML) to read in place of the one that .params names",
    )
    parser.add_argument(
        "-I",
        dest="include",
        action="append",
        default=[],
        type=Path,
        metavar="DIR",
        help="folder to search for included files",
    )
    parser.add_argument("--listing", type=Path, metavar="FILE", help="write a listing")
    parser.add_argument("--symbols", type=Path, metavar="FILE", help="write the symbol table")
    parser.add_argument(
        "--report",
        action="store_true",
        help="print cycles, lower bounds, occupancy, stalls and registers in use",
    )
    parser.add_argument(
        "--format",
        choices=tuple(FORMATS),
        default="json",
        help="json: the whole image, and its debug map next to it (default); c: tables for the C "
        "driver; others: program memory alone",
    )
    parser.add_argument(
        "--prefix",
        type=_prefix,
        metavar="NAME",
        help="first part of every name with --format c (default: made of the program's title)",
    )
    parser.add_argument(
        "-W",
        dest="warnings",
        action="append",
        default=[],
        type=_warning_option,
        metavar="no-CODE",
        help="switch a warning off (-Wno-unused-input), or take all as errors (-Werror); codes: "
        + ", ".join(WARNINGS),
    )
    parser.add_argument(
        "--warn-error", action="store_true", help="take warnings as errors, as -Werror does"
    )
    return parser.parse_args(arguments)


def _definition(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not name or not equals or not value:
        raise argparse.ArgumentTypeError(f"'{text}' is not NAME=VALUE")
    return name, value


def _warning_option(text: str) -> str:
    known = ["error", *(f"no-{code}" for code in WARNINGS)]
    if text not in known:
        near = closest(text, known) or f"known are {', '.join(known)}"
        raise argparse.ArgumentTypeError(f"no warning option '{text}'; {near}")
    return text


def _prefix(text: str) -> str:
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", text):
        raise argparse.ArgumentTypeError(f"'{text}' is not a C identifier")
    return text


if __name__ == "__main__":
    sys.exit(main())
