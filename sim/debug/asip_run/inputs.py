# SPDX-License-Identifier: Apache-2.0
"""What the user gives: the program, inputs and states by name, CSV tables, names to print."""

from __future__ import annotations

import csv
import io
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path

from asip_asm.assemble import assemble
from asip_asm.files import read_text
from asip_asm.image import Image
from sim.core.backends import is_register, unknown

INPUT_BYTES = 64 << 20
"""Largest table of inputs: 100 000 runs with 20 inputs take about 20 MiB."""


class UserError(Exception):
    """What the user gave cannot be run; `status` is the command's exit status."""

    def __init__(self, message: str, status: int = 1) -> None:
        super().__init__(message)
        self.status = status


def load_image(path: Path, configuration: str | None, function: str | None = None) -> Image:
    """Image of a source text, or an image file (*.json); of several functions in it one."""
    if path.suffix == ".json":
        image = image_of_file(path, configuration)
    else:
        image = assemble(path, configuration=configuration)
    if image.functions and function is None:
        there = ", ".join(f.name for f in image.functions)
        raise UserError(f"{path} holds the functions {there}; choose one with --function", 2)
    return image if function is None else image.function(function)


def image_of_file(path: Path, configuration: str | None) -> Image:
    """Image of an image file; UserError if it is for another configuration than is wanted."""
    image = Image.load(path)
    if configuration not in (None, image.configuration):
        raise UserError(
            f"{path} is for configuration '{image.configuration}', not '{configuration}'; "
            "assemble it again"
        )
    return image


def assignments(pairs: Sequence[str], types: Mapping[str, str], what: str) -> dict[str, int]:
    """Words of 'name=value' texts."""
    words = {}
    for pair in pairs:
        name, equals, text = pair.partition("=")
        if not equals:
            raise UserError(f"'{pair}' is not NAME=VALUE", 2)
        if name not in types:
            raise UserError(unknown(what, name, types), 2)
        try:
            words[name] = parse_word(text, types[name])
        except ValueError as error:
            raise UserError(f"{what} {name}: {error}", 2) from None
    return words


def parse_word(text: str, type_name: str) -> int:
    """32-bit word of a number. Raises ValueError saying what is wrong."""
    text = text.strip()
    if len(text) > 400:
        raise ValueError(f"'{text[:20]}...' has {len(text)} characters")
    if text[:2].lower() == "0f" and type_name == "float":
        try:
            return _word(int(text[2:], 16), text)
        except ValueError:
            raise ValueError(f"'{text}' is not 0f and 8 hexadecimal digits") from None
    if type_name == "int":
        try:
            value = int(text, 0)
        except ValueError:
            raise ValueError(f"'{text}' is not an integer") from None
        return _word(value, text)
    try:
        return int.from_bytes(struct.pack(">f", float(text)), "big")
    except ValueError:
        raise ValueError(f"'{text}' is not a number") from None
    except OverflowError:
        raise ValueError(f"{text} is too large for single precision") from None


def _word(value: int, text: str) -> int:
    if not -(1 << 31) <= value < 1 << 32:
        raise ValueError(f"{text} does not fit in 32 bits")
    return value & 0xFFFFFFFF


def read_inputs(path: Path, types: Mapping[str, str]) -> list[dict[str, int]]:
    """Words of every row of a CSV file whose header names inputs."""
    rows = []
    with io.StringIO(read_text(path, INPUT_BYTES, "a table of inputs"), newline="") as file:
        reader = csv.reader(file, skipinitialspace=True)
        try:
            header = [name.strip() for name in next(reader, [])]
            if not header:
                raise UserError(f"{path}: empty, expected a header with names of inputs")
            for name in header:
                if name not in types:
                    raise UserError(f"{path}:1: {unknown('input', name, types)}")
                if header.count(name) > 1:
                    raise UserError(f"{path}:1: input '{name}' appears in two columns")
            for row in reader:
                if not row:
                    continue
                where = f"{path}:{reader.line_num}"
                if len(row) != len(header):
                    raise UserError(f"{where}: {len(row)} values for {len(header)} names")
                words = {}
                for name, text in zip(header, row, strict=True):
                    try:
                        words[name] = parse_word(text, types[name])
                    except ValueError as error:
                        raise UserError(f"{where}: {name}: {error}") from None
                rows.append(words)
        except csv.Error as error:
            raise UserError(f"{path}: not a CSV text: {error}") from None
    if not rows:
        raise UserError(f"{path}: no row below the header")
    return rows


def printed_names(image: Image, text: str | None) -> list[str]:
    """Names to print: those requested, or all outputs and exports."""
    outputs = [output.name for output in image.outputs]
    known = [*outputs, *(export.name for export in image.exports)]
    if text is None:
        return known
    known += [state.name for state in image.states]
    names = [name.strip() for name in text.split(",") if name.strip()]
    for name in names:
        if name not in known and not is_register(name):
            raise UserError(unknown("output, export, state or register", name, known), 2)
    return names
