# SPDX-License-Identifier: Apache-2.0
"""Goals of the motion front-end: measured on samples, and misses that are seen."""

from __future__ import annotations

import pytest

from sim.bench.motion import (
    goals_drive,
    goals_lookahead,
    goals_planner,
    goals_rtl,
    sizes,
)
from sim.motion.gcode.oracle import LEAST_EQUAL, Samples
from sim.motion.lookahead import figures as lookahead_figures
from sim.motion.lookahead import stress

STUDY = {
    "1st-order loop: no feed-forward": 2.5,
    "1st-order loop: velocity": 0.0996,
    "1st-order loop: velocity and acceleration": 0.0110,
    "1st-order loop: velocity and acceleration, S-curve": 0.0032,
    "1st-order loop: peak dI/dt, trapezoid over S-curve": 24.25,
    "load step 1.8 N m; 160 Hz read as i-p": 4.505,
    "+-1 of 144 000 counts under 0.0 N m: targets met": 5.0,
    "+-1 of 144 000 counts under 1.8 N m: targets met": 5.0,
}


def test_planner__samples_meet_their_goals():
    goals = [
        *goals_planner.classes(1),
        *goals_planner.ruckig(10),
        *goals_planner.short_move(),
        goals_planner.override(3),
        goals_planner.core(20),
    ]
    # Nine moves meet five of the seven classes, thirty moves are a sample of those with Ruckig.
    by_name = {goal.name: goal for goal in goals}
    assert len(by_name) == len(goals)
    few = {"S-curve: classes of moves that occurred"}
    assert {name for name, goal in by_name.items() if goal.met is False} <= few
    assert by_name["time-optimal moves compared with Ruckig"].met is None


@pytest.mark.full
def test_rtl__samples_meet_their_goals():
    goals = [
        *goals_rtl.rest_to_rest(),
        *goals_rtl.fastest(),
        goals_rtl.jitter(),
        goals_rtl.drive_times(2),
        *goals_rtl.slow_pulses(),
        *goals_rtl.lines(4),
        *goals_rtl.circles(6),
        *goals_rtl.line_in_axes(2),
    ]
    assert [goal.name for goal in goals if not goal.met] == []


def test_sizes__not_measured__say_how(monkeypatch, tmp_path):
    monkeypatch.setattr(goals_rtl, "measured_sizes", lambda: sizes.current(tmp_path / "none.json"))
    goals = list(goals_rtl.sizes())
    assert goals and all(goal.met is None and "motion-size" in goal.note for goal in goals)


@pytest.mark.full
def test_lookahead__samples_meet_their_goals():
    goals = [
        goals_lookahead.times,
        goals_lookahead.corners,
        goals_lookahead.corner_speed,
        goals_lookahead.derivatives,
    ]
    found = [goal for check in goals for goal in _each(check())]
    found += [*goals_lookahead.random_programs(3), goals_lookahead.odd(1)]
    found += goals_lookahead.long_part(500)
    assert [goal.name for goal in found if goal.met is False] == []
    assert {goal.name for goal in found if goal.met is None} == {
        "random programs planned",
        "paths of tiny, empty and repeated moves without a stall",
        "part of 10^6 moves in five axes: moves planned, every tick",
        "part of 10^6 moves in five axes: time of a core",
        "part of 10^6 moves in five axes: memory",
    }


def _each(found):
    return [found] if hasattr(found, "met") else list(found)


def test_lookahead__corner_beyond_p_and_broken_limit__are_missed(monkeypatch):
    monkeypatch.setattr(stress, "VIOLATION", 0.5)
    corner = lookahead_figures.corner_program
    monkeypatch.setattr(
        lookahead_figures,
        "corner_program",
        lambda mode, angle=90.0: corner(
            mode.replace("P", "P0") if mode == "G64 P0.1" else f"G64 P{2 * float(mode[5:])}", angle
        ),
    )
    assert goals_lookahead.corners().met is False
    assert next(goals_lookahead.random_programs(3)).met is False


def test_drives__worse_than_asked__are_missed():
    assert all(goal.met for goal in goals_drive.study(STUDY))
    worse = {name: value * (0.9 if "+-1" in name else 10) for name, value in STUDY.items()}
    worse["1st-order loop: peak dI/dt, trapezoid over S-curve"] = 4.9
    assert not any(goal.met for goal in goals_drive.study(worse))


@pytest.mark.parametrize(("off", "met"), [(0.5, True), (1.1, False)])
def test_step_axes__more_than_a_step_off__are_missed(off, met):
    values = {"five axes: final counts off": 0.0, "five axes: steps off the plan": off}
    assert [goal.met for goal in goals_drive.step_axes(values)] == [True, met]


def test_samples__refused_and_different__are_counted_apart():
    found = Samples(["a", "e"], {"b": "x"}, {"c": "y"}, {"d": "z"}, {"a", "b", "c"})
    assert found.text == "1 of 3 equal, 1 different, 1 refused"
    assert not found.goal_met
    names = [str(number) for number in range(LEAST_EQUAL)]
    assert Samples(names, moving={*names, "more"}).goal_met
    assert not Samples(names[1:], moving=set(names)).goal_met
    assert not Samples(names, {"more": "x"}, moving=set(names)).goal_met
