# SPDX-License-Identifier: Apache-2.0
"""What is shown of a run: text for people, CSV rows, files."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from asip_asm.files import open_output
from asip_asm.gantt import gantt_page
from asip_asm.image import Image
from asip_asm.konata import konata_log
from asip_asm.profile import ProfileError, Trace, profile_run
from sim.core.backends import flag_text, number
from sim.core.fault import NO_FAULT
from sim.debug.asip_run.inputs import UserError
from sim.debug.asip_run.runner import Run


def value_text(word: int, type_name: str) -> str:
    """Shortest decimal text that gives the word again; integers as such."""
    value = number(word, type_name)
    if type_name == "int" or value != value:
        return str(value)
    return str(np.float32(value)).removesuffix(".0")


def types_of(image: Image) -> Callable[[str], str]:
    """Type by name; outputs, exports without a declaration and registers are floats."""
    return lambda name: image.types.get(name, "float")


def write_text(file: TextIO, image: Image, tick: int, names: Sequence[str], result: Run) -> None:
    """One run for people."""
    type_of = types_of(image)
    width = max(map(len, names), default=0)
    counters = ", ".join(
        f"{name.lower()} {count}" for name, count in result.observed.counters.items()
    )
    state = "done" if result.cause == NO_FAULT else f"fault {result.cause}"
    file.write(f"run {tick + 1}: {state}, {counters}, flags {flag_text(result.flags).upper()}\n")
    for name in names:
        word = result.words[name]
        file.write(f"  {name:{width}s} = {value_text(word, type_of(name)):14s} {word:08x}\n")


def write_row(file: TextIO, image: Image, tick: int, names: Sequence[str], result: Run) -> None:
    """One run as a row of the CSV table, the header before the first."""
    type_of = types_of(image)
    counters = [name.lower() for name in result.observed.counters]
    out = csv.writer(file, lineterminator="\n")
    if tick == 0:
        out.writerow(["run", *names, "fault", "flags", *counters])
    values = [value_text(result.words[name], type_of(name)) for name in names]
    row = [tick + 1, *values, result.cause, flag_text(result.flags).upper()]
    out.writerow([*row, *result.observed.counters.values()])


def write_profile(
    file: TextIO, image: Image, trace: Trace, konata: Path | None, gantt: Path | None
) -> None:
    """Profile of a run for people, and the files that show it clock by clock."""
    try:
        profile = profile_run(image, trace)
    except ProfileError as error:
        raise UserError(f"profile: {error}") from None
    file.write(profile.render())
    for path, text in ((konata, konata_log), (gantt, gantt_page)):
        if path:
            path.parent.mkdir(parents=True, exist_ok=True)
            with open_output(path) as file:
                file.write(text(profile))


def write_trace(file: TextIO, tick: int, result: Run) -> None:
    """The register and output writes of a run, one per line: run, register, word, value as a
    float."""
    for register, word in result.observed.writes:
        file.write(f"{tick + 1} {register} {word:08x} {value_text(word, 'float')}\n")
