# SPDX-License-Identifier: Apache-2.0
"""asip-dbg on a core with lanes and streams: vectors, their lanes, the words of streams."""

from __future__ import annotations

import pytest

from sim.debug.asip_dbg.command_table import CommandError
from sim.rtl.asip_bus import AsipError
from tests.debugger import debugged
from tests.debugger.debugged import LANES


@pytest.fixture
def lanes() -> debugged.Debugger:
    debugger = debugged.Debugger(LANES)
    debugger.tell("break 13", "run")
    return debugger


def refused(debugger: debugged.Debugger, line: str) -> str:
    with pytest.raises(CommandError) as error:
        debugger.commands.execute(line)
    return str(error.value)


def test_vector__shows_all_lanes__and_each_by_its_number(lanes):
    assert lanes.tell("print v").startswith("v = [1, 2, 3, 4]  (vector, a0")
    assert lanes.tell("print v2").startswith("v2 = [11, 14, 17, 20]")
    assert lanes.tell("print/x v") == "print/x v = ".removeprefix("print/x ") + (
        "[0x3f800000, 0x40000000, 0x40400000, 0x40800000]"
    )
    assert lanes.tell("print v2[3]").startswith("v2[3] = 20  (0x41a00000, a1.3, lane 3 of 4")
    assert lanes.tell("print v2[0] + v2[3]") == "v2[0] + v2[3] = 31"
    assert "lanes 0 to 3" in refused(lanes, "print v[4]")
    assert "no value 'x0[1]'" in refused(lanes, "print x0[1]")


def test_lane__set__changes_the_sum(lanes):
    lanes.tell("set v2[3] = 100", "continue")
    assert lanes.tell("info outputs").splitlines()[-1].split()[:2] == ["y", "142"]


def test_lane__cannot_be_watched_alone(lanes):
    assert "watch the vector" in refused(lanes, "watch v2[1]")
    assert "a1" in lanes.tell("watch v2")


def test_stream__words_and_next_places(lanes):
    assert lanes.tell("print W[5]").startswith(
        "W[5] = 6  (0x40c00000, sa1, stream of pipe A, lane 1"
    )
    assert lanes.tell("x/8f W").splitlines() == ["W[0]:  1  2  3  4", "W[4]:  5  6  7  8"]
    assert "8 words, 0 to 7" in refused(lanes, "print W[8]")
    assert "constant of the program" in refused(lanes, "set W[1] = 2")
    assert "never written" in refused(lanes, "watch W")
    told = lanes.tell("info streams")
    assert "0..1" in told and "vectors" in told and "pipe A takes place 2 next" in told


def test_core__shows_the_first_lane_and_says_so(lanes, monkeypatch):
    read = lanes.session.target.read

    def first(place: str) -> int:
        if "." in place:
            raise AsipError(f"{place}: the core shows the first lane alone, --iss all")
        return read(place)

    monkeypatch.setattr(lanes.session.target, "read", first)
    assert "v = 1  (0x3f800000, a0, lane 0 of a vector, the others only with --iss" in lanes.tell(
        "print v"
    )
    assert "first lane alone" in refused(lanes, "print v[1]")
