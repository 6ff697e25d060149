# SPDX-License-Identifier: Apache-2.0
"""Command asip-objdump: show what is in a program image."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from asip_asm.command import command_parser, run_command
from asip_asm.disassemble import DecodeError, disassemble
from asip_asm.image import Image, ImageError
from asip_asm.listing import symbols

EPILOG = """examples:
  asip-objdump -d build/leg.asip.json > again.s
  asip-objdump -h -t build/leg.asip.json
  asip-objdump --reseal build/leg.asip.json     (after an edit by hand)

exit status: 0 shown, 1 the file is no image or cannot be decoded, 2 wrong command line
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if not (options.disassemble or options.header or options.symbols or options.reseal):
        parser.error("one of -d, -h, -t, --reseal is needed")
    return run_command("asip-objdump", lambda: _show(options))


def _show(options: argparse.Namespace) -> int:
    try:
        image = Image.load(options.image, sealed=not options.reseal)
        parts = []
        if options.reseal:
            image.save(options.image)
            parts.append(f"{options.image}: sealed with {image.to_json()['checksum']}\n")
        if options.header:
            parts.append(header(image))
        if options.symbols:
            parts.append(symbols(image))
        if options.disassemble:
            parts.append(disassemble(image))
    except (ImageError, DecodeError) as error:
        print(f"asip-objdump: error: {error}", file=sys.stderr)
        return 1
    sys.stdout.write("\n".join(parts))
    return 0


def header(image: Image) -> str:
    """Title, configuration and sizes of an image."""
    cycles = "with branches" if image.cycles is None else str(image.cycles)
    rows = [
        ("title", image.title),
        ("configuration", image.configuration),
        ("entry", str(image.entry)),
        ("bundles", str(len(image.bundles))),
        ("cycles", cycles),
        ("inputs", str(len(image.inputs))),
        ("constants", str(len({c.index for c in image.constants}))),
        ("outputs", f"{len(image.outputs)}, mask {image.output_mask:08x}"),
        ("states", str(len(image.states))),
        ("exports", str(len(image.exports))),
        ("data words", str(len(image.data))),
        ("watchdog", str(image.watchdog)),
    ]
    rows += [
        (f"  {f.name}", f"entry {f.entry}, cycles {f.cycles}, mask {f.output_mask:08x}")
        for f in image.functions
    ]
    return "".join(f"{name:14s} {value}".rstrip() + "\n" for name, value in rows)


def _parser() -> argparse.ArgumentParser:
    description = "Show what is in a program image."
    parser = command_parser("asip-objdump", description, EPILOG, add_help=False)
    parser.add_argument("image", type=Path, help="image written by asip-as")
    parser.add_argument(
        "-d",
        "--disassemble",
        action="store_true",
        help="source text that assembles to the same image",
    )
    parser.add_argument("-h", "--header", action="store_true", help="title, configuration, sizes")
    parser.add_argument("-t", "--symbols", action="store_true", help="symbol table")
    parser.add_argument(
        "--reseal",
        action="store_true",
        help="take an image that was edited by hand as it is: write the right checksum into it",
    )
    parser.add_argument("--help", action="help", help="show this text")
    return parser


if __name__ == "__main__":
    sys.exit(main())
