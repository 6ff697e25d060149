# SPDX-License-Identifier: Apache-2.0
"""Tool tables of LinuxCNC ("Tool Table Format") as offsets for G43: a line for each tool.

line = T number, then words such as Z-12.5 in any order, `;` and a remark. X Y Z A C are offsets;
pocket P, diameter D and the other words are read and do nothing here. An empty line has no tool.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from sim.motion.gcode import AXES, Pose
from sim.motion.gcode_words import MAX_ERRORS, GcodeError, GcodeErrors

_WORD = re.compile(r"([A-Za-z])([+-]?(?:\d+\.?\d*|\.\d+))(?=\s|$)")
_TEXT = re.compile(r"\S+")


def tool_table(lines: Iterable[str], file: str = "<tools>", unit: float = 1.0) -> dict[int, Pose]:
    """Offsets [mm, degree] by number of the tool; unit: mm of one X, Y or Z of the table.

    Raises GcodeErrors with every mistake: no word, no T, T that is no integer from 1 on, or a
    second line for a tool.
    """
    tools: dict[int, Pose] = {}
    errors: list[GcodeError] = []
    for number, raw in enumerate(lines, start=1):
        source = raw.rstrip("\r\n").expandtabs(1)
        text = source.partition(";")[0]
        values: dict[str, float] = {}

        def error(column: int, offending: str, what: str, expected: str, help: str) -> None:
            place = file, number, column, source  # noqa: B023
            errors.append(GcodeError(*place, offending, what, expected, help))

        for run in _TEXT.finditer(text):
            word = _WORD.match(text, run.start())
            if word is None:
                error(
                    run.start() + 1,
                    run.group(),
                    "not a word of a tool table",
                    "a letter and a number",
                    "put remarks behind a ;",
                )
                break
            values[word.group(1).upper()] = float(word.group(2))
        else:
            tool = values.get("T", 0.0)
            if values and (tool < 1 or not tool.is_integer() or tool in tools):
                error(
                    1,
                    text.rstrip(),
                    "the tool is there already" if tool in tools else "the line has no tool",
                    "T with an integer of at least 1, once for each tool",
                    "write for instance T1 Z12.5 ; drill",
                )
            elif values:
                x, y, z, a, c = (values.get(letter, 0.0) for letter in AXES)
                tools[int(tool)] = (x * unit, y * unit, z * unit, a, c)
        if len(errors) == MAX_ERRORS:
            break
    if errors:
        raise GcodeErrors(tuple(errors))
    return tools
