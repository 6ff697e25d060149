# SPDX-License-Identifier: Apache-2.0
"""From the instant of an axis' samples to its new compare values, counted on the RTL.

Front-end, servo link and processor of one axis (axis_loop.sv) take the program of its current loop
and run by themselves. The end is the clock in which all three compare values are in the bridge.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from asip_asm.isa import default_isa
from sim.bench.drive.current_loop import loop_program
from sim.bench.drive.start_up import WINDOW, dead_clocks, least_clocks
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.rtl.asip_bus import CLEAR, CSR, load_words
from sim.rtl.gen.drive_regmap import REGMAP
from tests.servo.clocked import FOLDERS, Clocked

PERIODS = 4
HERE = Path(__file__).parent


def writes(drives: Drives, setting: Setting, configuration: str) -> list[tuple[int, int, int]]:
    """What brings axis and program up: whether to the front-end, address, word."""
    registers = {
        "PWM": dict(half_period=setting.half, minimum=least_clocks(drives)),
        "DEAD_TIME": dict(clocks=dead_clocks(drives)),
        "WINDOW": dict(start=WINDOW),
        "LINK": dict(enable=1, orders=1),
    }
    front = [
        (1, REGMAP.address(name), REGMAP.registers[name].word(**fields))
        for name, fields in registers.items()
    ]
    image = loop_program(drives, setting, configuration, axes=(0,)).image
    core = [(CSR["CONTROL"], CLEAR), *load_words(image)]
    return [*((0, address, word) for address, word in core), *front]


def latency(drives: Drives, setting: Setting, configuration: str = "fast") -> list[int]:
    """Clocks from each instant to the values in force. Raises ValueError if a run has a fault."""
    words = np.array(writes(drives, setting, configuration))
    shape = default_isa().configurations[configuration]
    parameters = {"FmaPipes": shape.fma_pipes, "Slots": len(shape.slots)}
    bench = Clocked(
        "axis_loop",
        ("write", "front", "address", "writedata", "bits"),
        ("wait", "instant", "in_force", "fault"),
        parameters,
        (*FOLDERS, HERE),
    )
    clocks = len(words) + PERIODS * setting.half
    write = np.zeros((4, clocks), dtype=np.int64)
    write[0, : len(words)], write[1:, : len(words)] = 1, words.T
    bits = np.arange(clocks) // 6 % 2  # no current: ones and zeros in turn
    names = ("write", "front", "address", "writedata")
    found = bench.run(clocks, **dict(zip(names, write, strict=True)), bits=bits)
    if found["wait"][: len(words)].any() or found["fault"].any():
        raise ValueError("the axis did not take its program, or a run ended with a fault")
    instants, ends = np.flatnonzero(found["instant"]), np.flatnonzero(found["in_force"])
    instants = instants[instants < ends[-1]]
    return (ends[-len(instants) :] - instants).tolist()
