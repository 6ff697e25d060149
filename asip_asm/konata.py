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


def konata_log(profile: Profile) -> str:
    """The log of a run; cycle 0 is the profile's."""
    events: dict[int, list[str]] = defaultdict(list)
    for execution in profile.executions:
        number = execution.number
        events[execution.decode] += [
            f"I\t{number}\t{execution.address}\t0",
            f"L\t{number}\t0\t{_left(execution)}",
            f"L\t{number}\t1\t{_hover(execution)}",
            *(f"W\t{number}\t{producer}\t0" for producer in execution.producers),
        ]
        for name, start, end in stages(execution):
            events[start].append(f"S\t{number}\t0\t{name}")
            events[end].append(f"E\t{number}\t0\t{name}")
    retired = sorted(profile.executions, key=lambda e: (e.end, e.number))
    for order, execution in enumerate(retired):
        events[execution.end].append(f"R\t{execution.number}\t{order}\t0")
    rows = ["Kanata\t0004", "C=\t0"]
    now = 0
    for cycle in sorted(events):
        if cycle > now:
            rows.append(f"C\t{cycle - now}")
            now = cycle
        rows += sorted(events[cycle], key=lambda row: "EILWSR".index(row[0]))
    return "\n".join(rows) + "\n"


def _left(execution: Execution) -> str:
    equation = f"  ({execution.equation})" if execution.equation else ""
    return f"{execution.address}.{execution.slot} {_line(execution.text)}{equation}"


def _hover(execution: Execution) -> str:
    result = f" {execution.target} = {execution.word:08x}" if execution.word is not None else ""
    return _line(f"{execution.where} {execution.unit}{result}")


def _line(text: str) -> str:
    """Text without the characters that separate records."""
    return " ".join(text.split())
