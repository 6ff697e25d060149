# SPDX-License-Identifier: Apache-2.0
"""The exact planner against the paper's figures and an independent rational integration."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.motion.planner.check import exact_profile
from sim.motion.planner.figures import RESULTS_FILE, figures, numbers, printed
from sim.motion.planner.ramp_time import ramp_time_plan
from sim.motion.planner.scurve import SCurve, SCurveError, closed_forms
from tests.planner.test_scurve import CLASS_OF, curves


@pytest.mark.parametrize("result", numbers(), ids=lambda r: f"fig{r.figure}-{r.name}")
def test_plan__number_of_a_figure__is_the_one_printed(result):
    assert result.agrees, f"{result.ours!r}, the paper has {result.published}"


def test_printed__next_digit__is_not_the_same():
    assert printed("19.1667", Fraction(115, 6)) and not printed("19.1668", Fraction(115, 6))
    assert printed("420", 420.5) and not printed("420", 420.6)


def test_figures__folder__holds_drawings_and_numbers(tmp_path):
    results = figures(tmp_path / "new")
    files = {path.name for path in (tmp_path / "new").iterdir()}
    kinds = ("png", "svg", "plotly.json")
    drawings = {f"scurve_fig{n}.{kind}" for n in (3, 12, 15) for kind in kinds}
    assert files == drawings | {RESULTS_FILE}
    document = json.loads((tmp_path / "new" / RESULTS_FILE).read_text())
    assert [entry["name"] for entry in document] == [result.name for result in results]
    assert all(entry["agrees"] for entry in document)
    assert Counter(entry["source"] for entry in document).keys() == {"stated", "derived"}


# --------------------------------------------------------------- bits of an independent model


def rounded(state) -> tuple[float, ...]:
    return tuple(float(x) for x in state)


@pytest.mark.parametrize("key", CLASS_OF)
@given(data=st.data())
def test_plan__any_time_of_every_class__has_the_bits_of_rational_integration(key, data):
    curve = data.draw(curves(*key))
    plan = ramp_time_plan(curve.v0, curve.vm, curve.tr, curve.tm, curve.length)
    assert plan.forms.kind is CLASS_OF[key]
    time = float(plan.total_time) * data.draw(st.floats(0, 0.999))
    position, speed, acceleration = exact_profile(plan, time)
    got = plan.at(time)
    assert rounded(got)[:2] == rounded((position, speed))
    if plan.tm > 0:  # without a jerk phase the acceleration steps at the joints
        assert rounded(got)[2] == float(acceleration)
    sampled = plan.sample([time])
    assert (sampled.position[0], sampled.velocity[0]) == rounded((position, speed))


@pytest.mark.parametrize("key", CLASS_OF)
@given(data=st.data())
def test_plan__phases_of_every_class__add_up_exactly(key, data):
    curve = data.draw(curves(*key))
    plan = ramp_time_plan(curve.v0, curve.vm, curve.tr, curve.tm, curve.length)
    assert sum(phase.duration for phase in plan.phases) == plan.total_time
    assert sum(phase.displacement for phase in plan.phases) == plan.length
    assert plan.phases[-1].end.position == plan.length
    assert plan.phases[-1].end.speed == plan.v0
    for phase, displacement in zip(plan.phases, plan.forms.displacements, strict=True):
        # Closed forms (6) against the integral of the phase, not a digit apart.
        assert phase.displacement == displacement
    for before, after in zip(plan.phases, plan.phases[1:], strict=False):
        assert before.end[:2] == after.start[:2]
        if plan.tm > 0:
            assert before.end.acceleration == after.start.acceleration
    # The plan in doubles that samples whole paths is the same move.
    assert curve.kind is plan.forms.kind
    assert curve.total_time == pytest.approx(float(plan.total_time), rel=1e-13)


def test_plan__every_class_by_its_boundary__is_told_apart_exactly():
    vm, v0, tr = Fraction(1, 3), Fraction(1, 7), Fraction(3, 11)
    alpha, beta, least = (v0 + vm) * tr, 2 * v0 * tr, Fraction(1, 10**30)
    for tm, (cruise, none) in {
        Fraction(0): (3, 2),
        tr / 5: (7, 6),
        tr / 2: (5, 4),
        tr / 2 - least: (7, 6),
        least: (7, 6),
    }.items():
        for length, segments in (
            (alpha + least, cruise),
            (alpha, none),
            (beta + least, none),
            (beta, 1),
            (least, 1),
        ):
            assert ramp_time_plan(v0, vm, tr, tm, length).forms.kind.value == segments
    assert ramp_time_plan(0, vm, tr, tr / 2, least).forms.kind.value == 4


def test_plan__decimal_texts__are_taken_as_written():
    plan = ramp_time_plan("0.1", "0.6", "0.6", "0.15", "0.8")
    assert plan.total_time == Fraction(11, 6) and plan.forms.jerk == Fraction(200, 27)
    assert ramp_time_plan(0.1, 0.6, 0.6, 0.15, 0.8).total_time != plan.total_time


def test_plan__time_outside_the_move__holds_start_and_end():
    plan = ramp_time_plan("0.02", "0.1", "0.06", "0.024", "0.3")
    assert rounded(plan.at(-1)) == (0.0, 0.02, 0.0)
    assert rounded(plan.at(plan.total_time)) == rounded(plan.at(99)) == (0.3, 0.02, 0.0)
    assert plan.sample(np.zeros((2, 3))).position.shape == (2, 3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("0", "0", "1", "0.1", "1"), "vm = 0.0 is outside its limit: vm > 0"),
        (("-1", "2", "1", "0.1", "1"), "v0 = -1.0 is outside its limit: 0 <= v0 <= vm = 2.0"),
        (("3", "2", "1", "0.1", "1"), "v0 = 3.0 is outside its limit: 0 <= v0 <= vm = 2.0"),
        (("0", "2", "0", "0", "1"), "tr = 0.0 is outside its limit: tr > 0"),
        (("0", "2", "1", "0.6", "1"), "tm = 0.6 is outside its limit: 0 <= tm <= tr/2 = 0.5"),
        (("0", "2", "1", "-0.1", "1"), "tm = -0.1 is outside its limit: 0 <= tm <= tr/2 = 0.5"),
        (("0", "2", "1", "0.1", "-5"), "length = -5.0 is outside its limit: length > 0"),
        (("0", "2", "1", "0.1", math.inf), "length = inf is not a finite number"),
        (("0", math.nan, "1", "0.1", "1"), "vm = nan is not a finite number"),
        (("0", "fast", "1", "0.1", "1"), "vm = 'fast' is not a finite number"),
        (("0", "1/0", "1", "0.1", "1"), "vm = '1/0' is not a finite number"),
    ],
)
def test_plan__bad_parameter__is_named_with_its_limit(arguments, message):
    with pytest.raises(SCurveError) as caught:
        ramp_time_plan(*arguments)
    assert str(caught.value).startswith(f"S-curve parameter {message}")


def test_plan__jerk_wrong_by_its_last_bit__is_not_the_rational_model(monkeypatch):
    """Negative control of the comparison of bits."""
    curve = SCurve(0.1, 0.6, 0.6, 0.15, 0.8)
    parameters = (curve.v0, curve.vm, curve.tr, curve.tm, curve.length)
    want = rounded(exact_profile(curve, 0.1))
    assert rounded(ramp_time_plan(*parameters).at(0.1)) == want

    def inexact(*values):
        forms = closed_forms(*values)
        return replace(forms, jerk=Fraction(math.nextafter(float(forms.jerk), math.inf)))

    monkeypatch.setattr("sim.motion.planner.ramp_time.closed_forms", inexact)
    assert rounded(ramp_time_plan(*parameters).at(0.1)) != want
