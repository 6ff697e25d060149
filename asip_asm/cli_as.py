# SPDX-License-Identifier: Apache-2.0
"""Command asip-as: assemble a program."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from asip_asm.assemble import build_program, encode
from asip_asm.c_image import to_c
from asip_asm.diagnostics import AssemblyError
from asip_asm.image import MEMORY_FORMATS, Image
from asip_asm.isa import default_isa
from asip_asm.listing import listing, symbols
from asip_asm.report import report_program

FORMATS = {"json": Image.dumps, "c": to_c} | MEMORY_FORMATS
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
    try:
        program, machine = build_program(
            options.source,
            configuration=options.config,
            optimise=options.optimise,
            defines=dict(options.define),
            include_path=options.include,
            params=options.params,
        )
        image = encode(program, machine, options.source)
        text = FORMATS[options.format](image)
        output = options.output or _default_output(options.source, options.format)
        _write(output, text)
        if options.listing:
            _write(options.listing, listing(image))
        if options.symbols:
            _write(options.symbols, symbols(image))
    except AssemblyError as error:
        count = len(error.diagnostics)
        print(error.report(), file=sys.stderr)
        print(
            f"asip-as: {count} error{'' if count == 1 else 's'}, nothing written", file=sys.stderr
        )
        return 1
    except OSError as error:
        print(f"asip-as: error: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    print(summary(image, output))
    if options.report:
        print(report_program(program, machine).render(), end="")
    return 0


def summary(image: Image, output: Path) -> str:
    """Line that says what was written."""
    operations = sum(len(entries) for entries in image.sources)
    constants = len({c.index for c in image.constants})
    cycles = f", about {image.cycles} cycles" if image.cycles is not None else ""
    return (
        f"{output}: {image.configuration}, {_count(len(image.bundles), 'bundle')}, "
        f"{_count(operations, 'operation')}, {_count(len(image.inputs), 'input')}, "
        f"{_count(constants, 'constant')}, {_count(len(image.outputs), 'output')}{cycles}"
    )


def parse_arguments(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of the command line; SystemExit(2) if they are wrong."""
    parser = argparse.ArgumentParser(
        prog="asip-as",
        description="Assemble a program into an image.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
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
        help="json: the whole image (default); c: tables for the C driver; others: program memory "
        "alone",
    )
    return parser.parse_args(arguments)


def _definition(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not name or not equals or not value:
        raise argparse.ArgumentTypeError(f"'{text}' is not NAME=VALUE")
    return name, value


def _default_output(source: Path, format_name: str) -> Path:
    suffix = {
        "json": ".asip.json",
        "c": ".asip.h",
        "readmemh": ".mem",
        "ihex": ".hex",
        "mif": ".mif",
    }
    return source.with_suffix(suffix[format_name])


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


if __name__ == "__main__":
    sys.exit(main())
