# SPDX-License-Identifier: Apache-2.0
"""A trace of FPGA1 or FPGA2 as a pipeline log for Konata, and as a timeline of functions.

Stages of n2_core: D decode, E execute, M memory, A align. An instruction waits in D for an operand,
in A for the bus, a division or a custom instruction.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asip_asm.konata import Row, kanata
from sim.rtl.n2_lockstep_isa import OP_CUSTOM, default_isa
from sim.rtl.nios_image import Program
from sim.rtl.nios_profile import custom_names

WRITES, EXCEPTION = 1, 2
CALLS = ("call", "callr")
STAGES = ("decode", "execute", "memory", "align", "end")

Steps = NDArray[np.void]


def text_of(word: int, names: Mapping[int, str]) -> str:
    """An instruction in assembly language, a custom one by its name."""
    if word & 63 == OP_CUSTOM:
        number = word >> 6 & 255
        c, a, b = (word >> shift & 31 for shift in (17, 27, 22))
        return f"{names.get(number, f'custom {number}')} r{c}, r{a}, r{b}"
    return default_isa().disassemble(word)


def konata(steps: Steps, program: Program, platform: str) -> str:
    """The pipeline log of a trace; cycle 0 is that of the first decode."""
    names = custom_names(platform)
    begin = steps[0]["decode"] if len(steps) else 0
    rows = []
    for number, step in enumerate(steps):
        word, flags = int(step["word"]), int(step["flags"])
        cycles = [int(step[name] - begin) for name in STAGES]
        function = program.function_at(int(step["pc"]))
        result = f" r{flags >> 8} = {step['value']:08x}" if flags & WRITES else ""
        result += " exception" if flags & EXCEPTION else ""
        rows.append(
            Row(
                number,
                int(step["pc"]),
                f"{step['pc']:08x} {text_of(word, names)}",
                function + result,
                list(zip("DEMA", cycles, cycles[1:], strict=False)),
            )
        )
    return kanata(rows)


def timeline(steps: Steps, program: Program, clock_mhz: float) -> str:
    """When the program was in which function: JSON of Chrome's trace events, which Perfetto opens.

    A call opens a function, and a return to a caller closes what it called. Another way into a
    function takes the place of the one before it. Times are in us of the system's clock.
    """
    begin = steps[0]["decode"] if len(steps) else 0
    events: list[dict[str, Any]] = []
    stack: list[str] = []

    def event(kind: str, name: str, cycle: int) -> None:
        events.append({"name": name, "ph": kind, "ts": cycle / clock_mhz, "pid": 1, "tid": 1})

    def close(depth: int, cycle: int) -> None:
        while len(stack) > depth:
            event("E", stack.pop(), cycle)

    now = 0
    for function, cycle, enters in visits(steps, program):
        now = cycle - int(begin)
        if not enters:
            known = function in stack
            close(len(stack) - stack[::-1].index(function) if known else len(stack) - 1, now)
            if known:
                continue
        stack.append(function)
        event("B", function, now)
    close(0, int(steps[-1]["end"] - begin) if len(steps) else now)
    return json.dumps({"traceEvents": events, "displayTimeUnit": "ns"}) + "\n"


def visits(steps: Steps, program: Program) -> Iterator[tuple[str, int, bool]]:
    """Each change of function: name, cycle, whether a call or an exception led to it."""
    before, entering = "", True
    isa = default_isa()
    end = int(steps[0]["decode"]) if len(steps) else 0
    for step in steps:
        function = program.function_at(int(step["pc"]))
        if function != before or entering:
            yield function, end, entering
        record = isa.find(int(step["word"]))
        called = record is not None and record.name in CALLS
        entering = called or bool(int(step["flags"]) & EXCEPTION)
        before, end = function, int(step["end"])
