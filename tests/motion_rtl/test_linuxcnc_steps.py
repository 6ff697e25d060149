# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC on the step and direction front-end: its component's accesses, and a whole run."""

from __future__ import annotations

import numpy as np
import pytest

from sim.bus.linuxcnc.config import BUS, STEPS, compile_component
from sim.bus.linuxcnc.steps import PERIOD, READ, WRITE, Port, play
from sim.rtl.gen.motion_regmap import REGMAP
from tests.bench.needs import needs

LINE_IN_ALL_AXES = 2


def write(port: Port, name: str, value: int, offset: int = 0) -> None:
    port.access(WRITE, REGMAP.address(name) + offset, value & 0xFFFFFFFF)


def period(port: Port, steps: tuple[int, ...]) -> None:
    """A servo period as the component makes it."""
    longest = max(map(abs, steps))
    if longest:
        for axis, count in enumerate(steps):
            write(port, "PATH_WORD", count, axis)
        write(port, "PATH_FEED", 100_000 // (longest + 1))
        write(port, "PATH_COMMAND", LINE_IN_ALL_AXES)
    port.access(PERIOD, 0, 0)


def test_port__lines_of_a_period__are_on_the_lines_at_its_end():
    port = Port()
    write(port, "SOURCE", 31)
    wanted = [(3, -200, 0, 1, 7), (0, 0, 0, 0, 0), (-3, 201, 5, 0, -280), (1, 1, 1, 1, 1)]
    for steps in wanted:
        period(port, steps)
    assert np.array_equal(port.counted(), np.cumsum(wanted, axis=0))
    sent = [port.access(READ, REGMAP.address("POSITION") + axis, 0) for axis in range(5)]
    assert [word - (word >> 31 << 32) for word in sent] == np.sum(wanted, axis=0).tolist()
    assert not port.rtl.path_faults()


def test_port__an_axis_without_source__is_a_fault_that_the_component_sees():
    port = Port()
    period(port, (1, 0, 0, 0, 0))
    assert port.rtl.path_faults() == {"axis"}
    assert port.access(READ, REGMAP.address("PATH_STATUS"), 0) & 0x7F00


@needs("linuxcnc")
@pytest.mark.parametrize("component", [BUS, STEPS])
def test_component__compiles(tmp_path, component):
    assert compile_component(tmp_path, component).is_file()


@pytest.mark.full
@needs("linuxcnc")
def test_linuxcnc__every_step_of_a_program__is_on_the_lines(tmp_path):
    program = tmp_path / "short.ngc"
    program.write_text("G21 G90 G64 P0.01\nF3000\nG1 X1.5 Y-0.75 A0.2\nG1 X1 Z600.4 C-1\nM2\n")
    folder = tmp_path / "run"
    folder.mkdir()
    report = play(folder, program)
    assert report["messages"] == [] and report["faults"] == [] and report["lost"] == 0
    assert report["steps"] == [1000, -750, 400, 200, -1000]
    assert report["apart"] == report["at_rest"] == 0
    assert report["end"] == pytest.approx([1.0, -0.75, 600.4, 0.2, -1.0], abs=1e-6)
