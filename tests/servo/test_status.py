# SPDX-License-Identifier: Apache-2.0
"""What STATUS of the drives' front-end says in words, and where commands pass it on."""

from __future__ import annotations

from unittest.mock import Mock

import numpy as np
import pytest

from sim.bench.drive import response, start_up
from sim.bench.drive.path import Chain
from sim.bench.drive.status import told
from sim.core import closed_loop
from sim.core.controller import ControllerFault
from sim.robot.records import SetPoints
from sim.rtl.gen.drive_regmap import REGMAP

NONE = dict.fromkeys([*REGMAP.registers["STATUS"].fields, *REGMAP.registers["CAUSE"].fields], 0)


@pytest.mark.parametrize(
    ("flags", "begins", "has", "not_has"),
    [
        ({"trip": 1}, "tripped: leg 1 (leg 1: overcurrent or power stage; check", "", "encoder"),
        ({"trip": 8, "illegal": 8}, "tripped: tilt (tilt: encoder", "cable", "overcurrent"),
        (
            {"trip": 17, "illegal": 16},
            "tripped: leg 1, rotation (",
            "rotation: encoder, both lines changed at once; check its cable, and its speed against "
            "ENCODER; leg 1: overcurrent",
            "leg 1, rotation: ",
        ),
        ({"trip": 31, "undervoltage": 1}, "tripped: leg 1, leg 2, leg 3, tilt, rotation (under",
         "U_dc", "overcurrent"),
        ({"trip": 31, "overvoltage": 1}, "tripped: ",
         "was above BUS_LIMIT; check the brake resistor", "overcurrent"),
        ({"trip": 31, "stop": 1}, "tripped: ", "stop: a processor that orders", "overcurrent"),
        ({"trip": 31, "fault": 1}, "tripped: ", "watchdog", "overcurrent"),
        ({"trip": 31, "late": 1}, "tripped: ", "late: ", "overcurrent"),
        ({"trip": 3, "plausible": 2}, "tripped: leg 1, leg 2 (leg 2: a phase had voltage",
         "; leg 1: overcurrent", "sum of"),
        ({"trip": 9, "sum": 8}, "tripped: leg 1, tilt (tilt: the sum", "; leg 1: over", "voltage"),
        ({"trip": 2, "index_lost": 2}, "tripped: leg 2 (leg 2: its encoder's index", "glitches",
         "overcurrent"),
        ({"illegal": 2}, "no axis has tripped (leg 2: encoder", "", "overcurrent"),
    ],
)  # fmt: skip
def test_told__names_axes_causes_and_what_to_do(flags, begins, has, not_has):
    text = told(NONE | flags)
    assert text.startswith(begins) and has in text and not_has not in text
    assert text.endswith("`recover` and start up again")


def test_told__nothing_without_a_fault():
    assert told(NONE | {"index": 31, "busy": 1}) == ""


def tripped(trip: int = 8, shoot_through: int = 0) -> Mock:
    """In place of `ChainRtl`: whatever is done, the tilt axis has tripped, or gates overlapped."""
    system = Mock(spec=["status", "look", "clock", "trace", "order"])
    system.status.return_value = NONE | {"trip": trip}
    system.look.return_value = Mock(clock=0, shoot_through=shoot_through)
    return system


def test_measured_loops__a_trip_and_a_shoot_through_are_told_apart():
    with pytest.raises(start_up.StartUpError, match="measured, tripped: tilt .*check winding"):
        response.record(tripped(), [], [])
    with pytest.raises(start_up.StartUpError, match="RTL of the PWM .*no_shoot_through"):
        response.record(tripped(trip=0, shoot_through=1), [], [])


def test_path_and_release__tell_which_axis_and_why():
    with pytest.raises(start_up.StartUpError, match="brakes opened, tripped: tilt .*check winding"):
        start_up.release(tripped())
    chain = object.__new__(Chain)
    chain.system, chain.controller = tripped(), Mock(spec=["tick"], tick=7)
    with pytest.raises(ControllerFault, match="tick 7: tripped: tilt .*check winding"):
        chain.advance(0)


@pytest.mark.parametrize(("drives", "more"), [(True, "--loops"), (False, "f_table$")])
def test_plant_that_stops__both_causes_are_told_where_there_are_drives(monkeypatch, drives, more):
    parts = ["joints", "tool", "counts", "step"]
    stopped = Mock(spec=parts, joints=[0.0] * 5, tool=[0.0] * 3)
    stopped.counts.return_value = (0,) * 5
    stopped.step.side_effect = ValueError("the current loops stopped with a fault")
    silent = Mock(spec=["prime", "step"])
    silent.step.return_value.outputs = np.zeros((1, 5))
    monkeypatch.setattr(closed_loop, "Plant", lambda *start: stopped)
    path = SetPoints.from_words(np.zeros((3, 15), "f4"))
    given = stopped if drives else None
    with pytest.raises(ControllerFault, match=rf"tick 0: .*with a fault.*f_legs or .*{more}"):
        closed_loop.run(None, path, silent, lambda ticks: None, plant=given)
