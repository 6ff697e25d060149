# SPDX-License-Identifier: Apache-2.0
"""Tool tables of LinuxCNC ("Tool Table Format"): a line for each tool.

line = T number, then words such as Z-12.5 in any order, `;` and a remark. X Y Z A C are offsets for
G43, D is the diameter for G41 and G42, Q the orientation of a lathe tool; pocket P and the other
words are read and do nothing here. An empty line has no tool.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from asip_asm.files import read_text
from sim.motion.gcode.errors import GcodeErrors, Mistakes, TooManyErrors
from sim.motion.gcode.words import MAX_NUMBER
from sim.motion.geometry.moves import AXES, Pose


@dataclass(frozen=True)
class Tool:
    """offset [mm, degree] of G43; diameter [mm]; orientation: 1 to 8 of a lathe tool."""

    offset: Pose = (0.0,) * 5
    diameter: float = 0.0
    orientation: int = 0


NO_TOOLS: Mapping[int, Tool] = {}

MAX_BYTES = 10_000_000  # largest tool table

_WORD = re.compile(r"([A-Za-z])([+-]?(?:\d+\.?\d*|\.\d+))(?=\s|$)")
_TEXT = re.compile(r"\S+")


def tool_table(lines: Iterable[str], file: str = "<tools>", unit: float = 1.0) -> dict[int, Tool]:
    """Tools by number; unit: mm of one X, Y, Z or D of the table.

    Raises GcodeErrors with every mistake: no word, a number beyond MAX_NUMBER, no T, T that is no
    integer from 1 on, or a second line for a tool.
    """
    tools: dict[int, Tool] = {}
    mistakes = Mistakes(file)
    with suppress(TooManyErrors):
        for number, raw in enumerate(lines, start=1):
            source = raw.rstrip("\r\n").expandtabs(1)
            mistakes.place(number, source)
            _take_line(source.partition(";")[0], tools, unit, mistakes)
    if mistakes.found:
        raise GcodeErrors(tuple(mistakes.found))
    return tools


def _take_line(text: str, tools: dict[int, Tool], unit: float, mistakes: Mistakes) -> None:
    """A line without its remark; nothing of it counts with a mistake."""
    values: dict[str, float] = {}
    for run in _TEXT.finditer(text):
        word = _WORD.match(text, run.start())
        if word is None:
            mistakes.report(
                run.start() + 1,
                run.group(),
                "not a word of a tool table",
                "a letter and a number",
                "put remarks after a ;",
            )
            return
        value = float(word.group(2))
        if abs(value) > MAX_NUMBER:
            mistakes.report(
                run.start() + 1,
                word.group(),
                "the number is out of range",
                f"a magnitude of at most {MAX_NUMBER:g}",
                "check the decimal point",
            )
            return
        values[word.group(1).upper()] = value
    tool = values.get("T", 0.0)
    if values and (tool < 1 or not tool.is_integer() or tool in tools):
        mistakes.report(
            1,
            text.rstrip(),
            "the tool is there already" if tool in tools else "the line has no tool",
            "T with an integer of at least 1, once for each tool",
            "write for instance T1 Z12.5 ; drill",
        )
    elif values:
        x, y, z, a, c = (values.get(letter, 0.0) for letter in AXES)
        offset = (x * unit, y * unit, z * unit, a, c)
        diameter = values.get("D", 0.0) * unit
        tools[int(tool)] = Tool(offset, diameter, int(values.get("Q", 0.0)))


def tool_file(path: Path) -> dict[int, Tool]:
    """As `tool_table`, from a file in mm. Raises GcodeErrors, and OSError without such a file."""
    return tool_table(read_text(path, MAX_BYTES, "a tool table").splitlines(), str(path))


def add_tools_option(parser: argparse.ArgumentParser) -> None:
    """The option --tools of the command lines that read G-code."""
    parser.add_argument(
        "--tools",
        type=Path,
        metavar="FILE",
        help="LinuxCNC tool table for T, G43, G41 [mm, degree]",
    )


def tools_of(arguments: argparse.Namespace) -> Mapping[int, Tool]:
    """The table of --tools, without the option none; raises as `tool_file`."""
    return NO_TOOLS if arguments.tools is None else tool_file(arguments.tools)
