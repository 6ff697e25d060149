# SPDX-License-Identifier: Apache-2.0
"""Places where a user wants to stop: lines, equations, bundles, labels, names of values."""

from __future__ import annotations

import re
from dataclasses import dataclass

from asip_asm.diagnostics import closest, shortened
from sim.debug.asip_dbg.program import DebuggedProgram

FORMS = "a LINE, FILE:LINE, (EQUATION), *BUNDLE, a label or the name of a value"
_EQUATION = re.compile(r"(?:\(|eq(?:uation)?\s*\(?\s*)([A-Z]?[0-9][0-9A-Za-z.-]*)\s*\)?")
_BUNDLE = re.compile(r"(?:\*|bundle\s+)\s*(0[xX][0-9a-fA-F]+|[0-9]+)")
_LINE = re.compile(r"(?:(.+):)?([0-9]+)")


class LocationError(ValueError):
    """There is no such place; the message says what there is."""


@dataclass(frozen=True)
class Location:
    """Bundles in front of which to stop, and the place in words."""

    bundles: tuple[int, ...]
    text: str
    file: str = ""
    line: int = 0


def find_location(program: DebuggedProgram, text: str, position: int) -> Location:
    """The place that a text names; empty: where the program is. Raises LocationError."""
    text = text.strip()
    if not text:
        return _bundle(program, position)
    if match := _EQUATION.fullmatch(text):
        return _equation(program, match.group(1))
    if match := _BUNDLE.fullmatch(text):
        return _bundle(program, int(match.group(1), 0))
    if match := _LINE.fullmatch(text):
        if len(match.group(2)) > 9:
            raise LocationError(f"line {shortened(match.group(2))} is beyond every file")
        return line_location(program, match.group(1), int(match.group(2)))
    if text in program.image.labels:
        address = program.image.labels[text]
        return Location((address,), f"label {text}, bundle {address}")
    return _value(program, text)


def line_location(program: DebuggedProgram, name: str | None, wanted: int) -> Location:
    """A line of a source, or the next one below it with operations. Raises LocationError."""
    file = program.file_of(name) if name else program.main
    if file is None:
        raise LocationError(
            f"no source '{shortened(name or '')}'; the program has {', '.join(program.map.files)}"
        )
    lines = program.code_lines(file)
    line = min((n for n in lines if n >= wanted), default=None)
    if line is None:
        last = max(lines, default=None)
        known = f"its last operation is in line {last}" if last else "it has no operations"
        raise LocationError(f"{file} has no operation in line {wanted} or below; {known}")
    note = f", the first operation from line {wanted} on" if line != wanted else ""
    bundles = tuple(lines[line])
    return Location(bundles, f"{file}:{line}, {_bundles(bundles)}{note}", file, line)


def _equation(program: DebuggedProgram, name: str) -> Location:
    equations = program.equations()
    if name not in equations:
        known = ", ".join(f"({n})" for n in equations)
        raise LocationError(
            f"no operation has a comment with equation ({name})"
            + (f"; the program has {known}" if known else "; the program names no equation")
        )
    bundles = equations[name]
    text = f"equation ({name}), bundle {bundles[0]}"
    if len(bundles) > 1:
        text += f", the first of {len(bundles)} with a part of it"
    return Location((bundles[0],), text)


def _bundle(program: DebuggedProgram, bundle: int) -> Location:
    if not 0 <= bundle < program.bundles:
        raise LocationError(f"there is no bundle {bundle}; they go to {program.bundles - 1}")
    return Location((bundle,), f"bundle {bundle}")


def _value(program: DebuggedProgram, name: str) -> Location:
    writes = sorted({w.bundle for value in program.map.named(name) for w in value.writes})
    if writes:
        return Location(tuple(writes), f"{name} is computed, {_bundles(tuple(writes))}")
    if program.map.named(name):
        raise LocationError(f"nothing computes '{name}' in a run: it keeps its value")
    names = [*program.map.names(), *program.image.labels]
    help_text = closest(name, names) or f"a place is {FORMS}"
    raise LocationError(f"no label or value '{shortened(name)}'; {help_text}")


def _bundles(bundles: tuple[int, ...]) -> str:
    one = len(bundles) == 1
    return f"bundle{'' if one else 's'} {', '.join(map(str, bundles))}"
