# SPDX-License-Identifier: Apache-2.0
"""SCurve against the figures of the S-curve paper and an exact rational integration by phases."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.motion.planner.check import exact_profile
from sim.motion.planner.figures import SEGMENTS_3, TABLE_3
from sim.motion.planner.scurve import SCurve, SCurveClass, SCurveError

# Relative rounding of the closed forms: some twenty operations of half an ulp each, of terms not
# larger than the result, and sums and differences of positions not larger than the length.
ROUNDING = 1e-14


@pytest.mark.parametrize(
    ("length", "tm"), [(length, tm) for length, rows in TABLE_3.items() for tm in rows]
)
def test_scurve__paths_of_the_paper__have_the_printed_figures(length, tm):
    am, jerk, *displacements = TABLE_3[length][tm]
    s1, s2, s3 = map(float, displacements)
    curve = SCurve(100, 600, 0.6, float(tm), float(length))
    # The shorter path is too short for vm.
    peak, s4, t4, time = (600, 380, 0.6333, 1.8333) if length == "800" else (400, 0, 0, 1.2)
    assert curve.kind is SCurveClass(int(SEGMENTS_3[length][tm]))
    assert curve.cruise_critical_length == pytest.approx(420)
    assert curve.peak_speed == pytest.approx(peak)
    assert curve.peak_acceleration == pytest.approx(float(am), abs=0.005)
    assert curve.jerk == pytest.approx(float(jerk or 0.0), abs=0.005)
    assert curve.displacements == pytest.approx((s1, s2, s3, s4, s3, s2, s1), abs=5e-5)
    assert curve.total_time == pytest.approx(time, abs=5e-5 if length == "800" else 1.2e-6)
    assert curve.durations[3] == pytest.approx(t4, abs=5e-5)


@pytest.mark.parametrize("tm", [0.0, 0.15, 0.3])
def test_scurve__path_too_short_to_accelerate__runs_one_second_at_v0(tm):
    curve = SCurve(100, 600, 0.6, tm, 100)
    assert curve.acceleration_critical_length == pytest.approx(120)
    assert curve.kind is SCurveClass.CONSTANT
    assert curve.total_time == 1.0
    samples = curve.profile(np.linspace(0, 1, 11))
    assert samples.position == pytest.approx(np.linspace(0, 100, 11))
    assert np.all(samples.velocity == 100) and np.all(samples.acceleration == 0)


@pytest.mark.parametrize(
    ("length", "tm", "total"), [(200, 0.0, 1.0267), (80, 0.1, 0.8), (20, 0.2, 0.6667)]
)
def test_scurve__hardware_experiment_of_the_paper__has_the_derived_time(length, tm, total):
    assert SCurve(30, 300, 0.4, tm, length).total_time == pytest.approx(total, abs=5e-5)


def test_scurve__simulation_of_the_paper__has_the_derived_phases():
    curve = SCurve(15, 200, 0.4, 0.1, 100)
    assert curve.durations == pytest.approx((0.1, 0.2, 0.1, 0.07, 0.1, 0.2, 0.1))
    assert curve.displacements == pytest.approx(
        (2.5278, 21.5, 18.9722, 14, 18.9722, 21.5, 2.5278), abs=5e-5
    )


def test_scurve__no_start_speed__ends_at_an_exact_stop():
    for length in (0.0001, 0.005, 0.4):
        curve = SCurve(0.0, 0.1, 0.06, 0.024, length)
        end = curve.profile(curve.total_time)
        assert (end.position, end.velocity, end.acceleration) == (length, 0.0, 0.0)


def test_scurve__time_outside_the_move__holds_start_and_end():
    curve = SCurve(0.02, 0.1, 0.06, 0.024, 0.3)
    samples = curve.profile([-1.0, curve.total_time + 1.0])
    assert list(samples.position) == [0.0, 0.3]
    assert list(samples.velocity) == [0.02, 0.02]
    assert list(samples.acceleration) == [0.0, 0.0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0, 0, 1, 0.1, 1), "vm = 0 is outside its limit: vm > 0"),
        ((-1, 2, 1, 0.1, 1), "v0 = -1 is outside its limit: 0 <= v0 <= vm = 2"),
        ((3, 2, 1, 0.1, 1), "v0 = 3 is outside its limit: 0 <= v0 <= vm = 2"),
        ((0, 2, 0, 0.0, 1), "tr = 0 is outside its limit: tr > 0"),
        ((0, 2, 1, 0.6, 1), "tm = 0.6 is outside its limit: 0 <= tm <= tr/2 = 0.5"),
        ((0, 2, 1, -0.1, 1), "tm = -0.1 is outside its limit: 0 <= tm <= tr/2 = 0.5"),
        ((0, 2, 1, 0.1, 0), "length = 0 is outside its limit: length > 0"),
        ((0, 2, 1, 0.1, math.inf), "length = inf is outside its limit: length > 0"),
        ((0, 2, 1, 0.1, math.nan), "length = nan is outside its limit: length > 0"),
    ],
)
def test_scurve__bad_parameter__is_named_with_its_limit(arguments, message):
    with pytest.raises(SCurveError) as caught:
        SCurve(*arguments)
    assert str(caught.value) == f"S-curve parameter {message}"


# Each class by construction: share of tm in tr/2, and the length relative to the critical ones.
TM_SHARE = {"no jerk phase": 0, "jerk phase": None, "only jerk phases": 1}
CLASS_OF = {
    ("cruise", "jerk phase"): SCurveClass.SEVEN_SEGMENT,
    ("no cruise", "jerk phase"): SCurveClass.SIX_SEGMENT,
    ("cruise", "only jerk phases"): SCurveClass.FIVE_SEGMENT,
    ("no cruise", "only jerk phases"): SCurveClass.FOUR_SEGMENT,
    ("cruise", "no jerk phase"): SCurveClass.TRAPEZOID,
    ("no cruise", "no jerk phase"): SCurveClass.TRIANGLE,
    ("constant", "jerk phase"): SCurveClass.CONSTANT,
}


@st.composite
def curves(draw, span: str, jerk: str) -> SCurve:
    vm = draw(st.floats(1e-3, 10))
    tr = draw(st.floats(1e-3, 2))
    least = 0.01 if span == "constant" else 0.0
    v0 = vm * draw(st.floats(least, 0.9))
    share = TM_SHARE[jerk]
    tm = tr / 2 * (draw(st.floats(0.05, 0.95)) if share is None else share)
    low, high = 2 * v0 * tr, (v0 + vm) * tr
    inside = draw(st.floats(0.05, 0.95))
    length = {
        "constant": low * inside,
        "no cruise": low + (high - low) * inside,
        "cruise": high * (1 + 3 * inside),
    }[span]
    return SCurve(v0, vm, tr, tm, length)


@pytest.mark.parametrize("key", CLASS_OF)
@given(data=st.data())
def test_scurve__any_time_of_every_class__agrees_with_rational_integration(key, data):
    curve = data.draw(curves(*key))
    assert curve.kind is CLASS_OF[key]
    share = data.draw(st.floats(0, 1))
    time = curve.total_time * share
    position, speed, acceleration = (float(x) for x in exact_profile(curve, time))
    got = curve.profile(time)
    # The time itself carries the rounding of the total time, amplified by speed and slope.
    late = 4 * np.spacing(curve.total_time)
    assert got.position == pytest.approx(
        position, abs=ROUNDING * curve.length + curve.peak_speed * late
    )
    assert got.velocity == pytest.approx(
        speed, abs=ROUNDING * curve.peak_speed + curve.peak_acceleration * late
    )
    if curve.tm > 0:  # without a jerk phase the acceleration steps at the joints
        # The speed won is a difference of speeds that may be larger than itself.
        rounding = ROUNDING * (curve.v0 + curve.peak_speed) / (curve.tr - curve.tm)
        assert got.acceleration == pytest.approx(acceleration, abs=rounding + curve.jerk * late)


@pytest.mark.parametrize("key", CLASS_OF)
@given(data=st.data())
def test_scurve__joints_of_every_class__are_continuous(key, data):
    curve = data.draw(curves(*key))
    joints = np.cumsum(curve.durations)[:-1]
    gap = 1e-9 * curve.total_time
    before, after = curve.profile(joints - gap), curve.profile(joints + gap)
    step = 2 * gap
    late = 8 * np.spacing(curve.total_time)
    assert np.all(
        np.abs(after.position - before.position)
        <= curve.peak_speed * (step + late) + ROUNDING * curve.length
    )
    assert np.all(
        np.abs(after.velocity - before.velocity)
        <= curve.peak_acceleration * (step + late) + ROUNDING * curve.peak_speed
    )
    if curve.tm > 0:
        assert np.all(
            np.abs(after.acceleration - before.acceleration)
            <= curve.jerk * (step + late) + ROUNDING * curve.peak_acceleration
        )


@pytest.mark.parametrize("key", CLASS_OF)
@given(data=st.data())
def test_scurve__sum_of_the_phases__is_the_length_and_the_time(key, data):
    curve = data.draw(curves(*key))
    assert math.fsum(curve.displacements) == pytest.approx(curve.length, rel=ROUNDING)
    assert math.fsum(curve.durations) == pytest.approx(curve.total_time, rel=ROUNDING)
    assert float(curve.profile(curve.total_time).position) == curve.length
    assert curve.v0 <= curve.peak_speed <= curve.vm
