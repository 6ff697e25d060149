# SPDX-License-Identifier: Apache-2.0
"""Pipeline log of a profile in the text format that the Konata viewer opens ('Kanata', version 4).

Records, separated by tabs: `C=` first cycle, `C` cycles passed, `I` operation (number, number in
the program, thread), `L` label (0: left pane, 1: on hover), `S` and `E` start and end of a stage,
`W` consumer and producer of a value, `R` retirement (number, order, 0: not flushed). Stages are D
(more than one cycle: the bundle waits), R1 and on, E1 to En and W; an operation retires in the
cycle after its last stage.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from asip_asm.profile import Execution, Profile


def stages(execution: Execution) -> list[tuple[str, int, int]]:
    """Stages of an execution in order: name, first cycle, first cycle after it."""
    last = execution.end - (execution.target is not None)
    result = [
        ("D", execution.decode, execution.issue + 1),
        *_cycles("R", execution.issue + 1, execution.start),
        *_cycles("E", execution.start, last),
    ]
    return [*result, ("W", last, execution.end)] if execution.target is not None else result


def _cycles(name: str, start: int, end: int) -> list[tuple[str, int, int]]:
    return [(f"{name}{i}", cycle, cycle + 1) for i, cycle in enumerate(range(start, end), 1)]


@dataclass(frozen=True)
class Row:
    """An instruction of a log: its texts, the rows that made its operands, its stages.

    A stage is its name, its first cycle and the first cycle after it. The first begins the row.
    """

    number: int
    address: int
    left: str
    hover: str
    stages: Sequence[tuple[str, int, int]]
    producers: Sequence[int] = ()


def kanata(found: Iterable[Row]) -> str:
    """The log of rows; its first cycle is 0."""
    events: dict[int, list[str]] = defaultdict(list)
    found = list(found)
    for row in found:
        number = row.number
        events[row.stages[0][1]] += [
            f"I\t{number}\t{row.address}\t0",
            f"L\t{number}\t0\t{_line(row.left)}",
            f"L\t{number}\t1\t{_line(row.hover)}",
            *(f"W\t{number}\t{producer}\t0" for producer in row.producers),
        ]
        for name, start, end in row.stages:
            events[start].append(f"S\t{number}\t0\t{name}")
            events[end].append(f"E\t{number}\t0\t{name}")
    retired = sorted(found, key=lambda row: (row.stages[-1][2], row.number))
    for order, row in enumerate(retired):
        events[row.stages[-1][2]].append(f"R\t{row.number}\t{order}\t0")
    lines = ["Kanata\t0004", "C=\t0"]
    now = 0
    for cycle in sorted(events):
        if cycle > now:
            lines.append(f"C\t{cycle - now}")
            now = cycle
        lines += sorted(events[cycle], key=lambda line: "EILWSR".index(line[0]))
    return "\n".join(lines) + "\n"


def konata_log(profile: Profile) -> str:
    """The log of a run; cycle 0 is the profile's."""
    return kanata(
        Row(e.number, e.address, _left(e), _hover(e), stages(e), e.producers)
        for e in profile.executions
    )


def _left(execution: Execution) -> str:
    equation = f"  ({execution.equation})" if execution.equation else ""
    return f"{execution.address}.{execution.slot} {execution.text}{equation}"


def _hover(execution: Execution) -> str:
    result = f" {execution.target} = {execution.word:08x}" if execution.word is not None else ""
    return f"{execution.where} {execution.unit}{result}"


def _line(text: str) -> str:
    """Text without the characters that separate records."""
    return " ".join(text.split())
