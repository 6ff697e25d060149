# SPDX-License-Identifier: Apache-2.0
"""Annotated assembly sources: how to assemble them and what they must give.

A source may say `; assemble: <options of asip-as>` in its first line. Every
`; error: message => help` must be the error of its line, verbatim; at the start of a line it is an
error without a place; `; warning: message => help [code]` likewise. Every `; = <hexadecimal>` is
a bundle, in order.
"""

from __future__ import annotations

import shlex
from pathlib import Path

from asip_asm.assemble import assemble, parse_program
from asip_asm.cli_as import parse_arguments
from asip_asm.diagnostics import AssemblyError, Diagnostic
from asip_asm.image import Image

FOLDER = Path(__file__).parent
ERROR = "; error: "
WARNING = "; warning: "
WORD = "; = "


def run(path: Path) -> Image:
    """Assemble with the options that the source states."""
    first = path.read_text(encoding="utf-8").splitlines()[0]
    _, _, options = first.partition("; assemble: ")
    parsed = parse_arguments([str(path), *shlex.split(options)])
    return assemble(
        path,
        configuration=parsed.config,
        optimise=parsed.optimise,
        defines=dict(parsed.define),
        include_path=parsed.include,
    )


def expected_errors(path: Path, mark: str = ERROR) -> list[tuple[int, str]]:
    """(line, 'message => help') of each annotation, line 0 for errors without a place."""
    errors = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        code, *texts = line.split(mark)
        errors += [(number if code else 0, text.strip()) for text in texts]
    return sorted(errors)


def found_errors(path: Path) -> list[tuple[int, str]]:
    """The same of the errors that assembling the source gives."""
    try:
        run(path)
    except AssemblyError as error:
        return sorted((_line(d, path), _text(d)) for d in error.diagnostics)
    return []


def found_warnings(path: Path) -> list[tuple[int, str]]:
    """(line, 'message => help [code]') of the warnings that assembling the source gives."""
    return sorted((_line(w, path), f"{_text(w)} [{w.code}]") for w in parse_program(path).warnings)


def expected_words(path: Path) -> list[str]:
    """Bundles that the source states."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line.split(WORD)[1].strip() for line in lines if WORD in line]


def _line(diagnostic: Diagnostic, path: Path) -> int:
    if diagnostic.place is None or Path(diagnostic.place.line.file).name != path.name:
        return 0
    return diagnostic.place.line.number


def _text(diagnostic: Diagnostic) -> str:
    tail = f" => {diagnostic.help}" if diagnostic.help else ""
    return diagnostic.message + tail
