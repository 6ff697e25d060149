# SPDX-License-Identifier: Apache-2.0
"""Curves of blocks against points of a circle written down by hand and against trigonometry."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.motion.gcode.interpreter import parse
from sim.motion.geometry.curves import RateLimits, build_path
from sim.motion.geometry.moves import Pose

# One ulp of a coordinate below 1 m, and a few roundings of it.
POINT_TOLERANCE = 1e-15
BESIDE = (50.0, 0.0, 600.0, 0.0, 0.0)


def only_block(text: str, rates: RateLimits | None = None, start: Pose | None = None):
    (block,) = build_path(parse(f"{text}\nM2", start=start), rates)
    return block


def points(block, shares):
    return block.curve.evaluate(np.array(shares) * block.curve.length)[0]


# A quarter turn counter-clockwise about (0, 0, 600) in each plane goes from its first to its second
# axis; in G18 the first axis is Z, the second X. Middle point and arc length are those of a circle
# of radius 50 mm.
HALF = 0.050 * math.sqrt(0.5)
QUARTERS = [
    ("G17 G3 X0 Y50 I-50", (50, 0, 600), (0, 0.05, 0.6), (HALF, HALF, 0.6)),
    ("G17 G2 X0 Y-50 I-50", (50, 0, 600), (0, -0.05, 0.6), (HALF, -HALF, 0.6)),
    ("G18 G3 Z600 X50 K-50", (0, 0, 650), (0.05, 0, 0.6), (HALF, 0, 0.6 + HALF)),
    ("G18 G2 Z600 X-50 K-50", (0, 0, 650), (-0.05, 0, 0.6), (-HALF, 0, 0.6 + HALF)),
    ("G19 G3 Y0 Z650 J-50", (0, 50, 600), (0, 0, 0.65), (0, HALF, 0.6 + HALF)),
    ("G19 G2 Y0 Z550 J-50", (0, 50, 600), (0, 0, 0.55), (0, HALF, 0.6 - HALF)),
]


@pytest.mark.parametrize(("code", "start", "end", "middle"), QUARTERS)
def test_arc__quarter_turn_in_every_plane_and_direction__passes_the_middle(
    code, start, end, middle
):
    block = only_block(f"F1000 {code}", start=(*start, 0.0, 0.0))
    assert block.curve.length == pytest.approx(0.05 * math.pi / 2, rel=1e-15)
    first, half, last = points(block, [0.0, 0.5, 1.0])
    assert first[:3] == pytest.approx(np.array(start) / 1e3, abs=POINT_TOLERANCE)
    assert half[:3] == pytest.approx(middle, abs=POINT_TOLERANCE)
    assert last[:3] == pytest.approx(end, abs=POINT_TOLERANCE)


@pytest.mark.parametrize(
    ("code", "sweep"),
    [
        ("G3 X0 Y50 R50", 90),
        ("G2 X0 Y50 R50", -90),
        ("G3 X0 Y50 R-50", 270),
        ("G2 X0 Y50 R-50", -270),
        ("G3 X-50 Y0 R50", 180),
        ("G2 X-50 Y0 R50", -180),
    ],
)
def test_arc__radius_format__sign_of_r_selects_the_shorter_or_the_longer_arc(code, sweep):
    block = only_block(f"F1000 {code}", start=BESIDE)
    assert math.degrees(block.curve.sweep) == pytest.approx(sweep)
    assert block.curve.radius == pytest.approx(0.05)
    # The centre of the arc is the origin or, turned the other way, the point (50, 50).
    same_side = (sweep in (90, -270)) or abs(sweep) == 180
    assert block.curve.centre == pytest.approx((0, 0) if same_side else (0.05, 0.05), abs=1e-15)


@pytest.mark.parametrize("code", ["G3 I-50", "G3 X50 Y0 I-50", "G2 I-50"])
def test_arc__end_at_the_start__is_a_full_turn(code):
    block = only_block(f"F1000 {code}", start=BESIDE)
    assert abs(block.curve.sweep) == pytest.approx(2 * math.pi, rel=1e-15)
    opposite = points(block, [0.5])[0]
    assert opposite[:2] == pytest.approx((-0.05, 0), abs=2e-17 + POINT_TOLERANCE)


def test_arc__with_third_axis__is_a_helix_of_its_true_length():
    block = only_block("F1000 G3 X-50 Z640 I-50 C90", start=BESIDE)
    assert block.curve.length == pytest.approx(math.hypot(0.05 * math.pi, 0.04), rel=1e-15)
    middle = points(block, [0.5])[0]
    assert middle == pytest.approx((0, 0.05, 0.62, 0, math.pi / 4), abs=POINT_TOLERANCE)
    _, direction, _ = block.curve.evaluate(np.linspace(0, block.curve.length, 9))
    assert np.linalg.norm(direction[:, :3], axis=1) == pytest.approx(np.ones(9), rel=1e-14)


@pytest.mark.parametrize(
    "code",
    ["G18 G2 X9 Z603 I4 K3", "G19 G3 Y1 Z603 J-1 K2 P2 X3", "G18 G3 X0 Y3 Z603 R7"],
)
def test_arc__plane_of_a_rotated_system__is_the_arc_turned_about_z(code):
    flat = only_block(f"F1000 {code}").curve
    text = f"G10 L2 P1 X3 Y-2 Z1 R37\nG0 X0 Y0 Z600\nF1000 {code}\nM2"
    turned, s = build_path(parse(text))[-1].curve, np.linspace(0, flat.length, 33)
    assert turned.length == pytest.approx(flat.length, rel=1e-12)
    cos, sin = math.cos(math.radians(37)), math.sin(math.radians(37))
    matrix = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    expected = [each[:, :3] @ matrix.T for each in (*flat.evaluate(s), flat.third(s))]
    expected[0] = expected[0] + (0.003, -0.002, 0.001)
    for here, there in zip((*turned.evaluate(s), turned.third(s)), expected, strict=True):
        assert here[:, :3] == pytest.approx(there, rel=1e-8, abs=1e-9 * abs(there).max())


def test_arc__end_off_the_circle_within_the_tolerance__ends_at_the_programmed_point():
    block = only_block("F1000 G3 X0.0011 Y50.0012 I-50", start=BESIDE)
    assert points(block, [0.0])[0][:2] == pytest.approx((0.05, 0), abs=POINT_TOLERANCE)
    assert points(block, [1.0])[0][:2] == pytest.approx((1.1e-6, 0.0500012), abs=POINT_TOLERANCE)


@given(
    code=st.sampled_from(["G2", "G3"]),
    plane=st.sampled_from([("G17", 0, 1), ("G18", 2, 0), ("G19", 1, 2)]),
    begin=st.floats(-180, 180),
    turn=st.floats(1, 359),
    radius=st.floats(1, 100),
    share=st.floats(0, 1),
)
def test_arc__any_angle__agrees_with_trigonometry(code, plane, begin, turn, radius, share):
    name, first, second = plane
    sign = 1 if code == "G3" else -1

    def at(angle: float) -> np.ndarray:
        point = np.zeros(3)
        point[first] = radius * math.cos(math.radians(angle))
        point[second] = radius * math.sin(math.radians(angle))
        return point

    begin_point, end_point = at(begin), at(begin + sign * turn)
    words = " ".join(f"{letter}{x:.9f}" for letter, x in zip("XYZ", end_point, strict=True))
    offsets = " ".join(f"{'IJK'[axis]}{-begin_point[axis]:.9f}" for axis in sorted((first, second)))
    block = only_block(f"F1000 {name} {code} {words} {offsets}", start=(*begin_point, 0.0, 0.0))
    # The text has digits of 1 pm: end and centre are off by 0.71 pm at most. The centre moves the
    # radius by 0.71 pm and, seen from it, the angles at both ends by 0.71 pm and 1.42 pm of arc.
    want = at(begin + sign * turn * share) / 1e3
    assert points(block, [share])[0][:3] == pytest.approx(want, abs=(0.71 + 0.71 + 2.13) * 1e-12)
    sweep = math.radians(turn)
    assert block.curve.length == pytest.approx(
        radius / 1e3 * sweep, abs=(0.71 * sweep + 2.13) * 1e-12
    )


@pytest.mark.parametrize("code", ["G1 X30 Y-40 Z612 A10 C-20", "G3 X40 Y40 I20 J20 Z612 A10 C-20"])
def test_curve__derivatives__are_those_of_the_points(code):
    block = only_block(f"F1000 {code}")
    length = block.curve.length
    s = np.linspace(0.1, 0.9, 33) * length
    step = 1e-4 * length
    ahead, here, behind = (block.curve.evaluate(s + d) for d in (step, 0.0, -step))
    # Central differences of a circle of radius 28 mm: error step^2/6 * R^-2 and 4 roundings of a
    # coordinate below 1 m (2.2e-16) over the step.
    radius = 0.028
    truncation = step**2 / 6 / radius**2
    assert (ahead[0] - behind[0]) / (2 * step) == pytest.approx(
        here[1], abs=truncation + 1e-15 / step
    )
    assert (ahead[1] - behind[1]) / (2 * step) == pytest.approx(
        here[2], abs=truncation / radius + 1e-14 / step
    )


def test_line__five_axes__are_interpolated_together_and_end_exactly():
    block = only_block("G1 X30 Y-40 Z600 A10 C-20 F2000")
    assert block.curve.length == pytest.approx(0.05, rel=1e-15)
    assert block.speed == pytest.approx(2 / 60)
    assert points(block, [0.25])[0] == pytest.approx(
        (0.0075, -0.01, 0.6, math.radians(2.5), math.radians(-5)), abs=POINT_TOLERANCE
    )
    assert list(points(block, [1.0])[0]) == [
        0.03,
        -0.04,
        0.6,
        math.radians(10),
        math.radians(-20),
    ]


def test_line__axis_at_rest__does_not_move_by_rounding():
    block = only_block("G1 X33.3 Z600 F2000")
    assert np.all(points(block, np.linspace(0, 1, 1001))[:, 2] == 0.6)


def test_table_move__without_tool_path__is_measured_and_fed_in_degrees():
    block = only_block("G1 A30 C40 F600")
    assert not block.measures_tool_path
    assert math.degrees(block.curve.length) == pytest.approx(50)
    assert math.degrees(block.speed) == pytest.approx(10)


def test_table_move__programmed_in_inches__keeps_its_degrees_and_its_feed():
    block = only_block("G20 G1 A30 C40 F600")
    assert math.degrees(block.curve.length) == pytest.approx(50)
    assert math.degrees(block.speed) == pytest.approx(10)


def test_feed__in_inches__is_converted():
    """F comes before the unit in a block's order (NISTIR 6556, table 8): G20 acts on later F."""
    here, later = build_path(parse("G20 G1 X1 F10\nX2 F10\nM2"))
    assert here.speed == pytest.approx(0.010 / 60)
    assert later.speed == pytest.approx(0.254 / 60)


def test_rapid__of_the_table__runs_the_faster_axis_at_its_limit():
    block = only_block("G0 A30 C40", RateLimits(table=1.0))
    _, direction, _ = block.curve.evaluate(np.array([0.0]))
    assert np.abs(direction[0] * block.speed)[3:] == pytest.approx((0.75, 1.0))


@pytest.mark.parametrize("code", ["G0 X1 C90", "G1 X1 C90 F6000"])
def test_speed__much_turn_on_little_path__is_lowered_to_the_table_limit(code):
    block = only_block(code, RateLimits(rapid=0.1, table=1.0))
    assert block.speed == pytest.approx(1e-3 / math.radians(90))


def test_block__that_stays_in_place__is_left_out():
    assert build_path(parse("G1 X0 F100\nM2")) == ()


@pytest.mark.parametrize("name", ["rapid", "table"])
def test_rate_limits__not_positive__are_refused(name):
    with pytest.raises(ValueError, match=f"{name} = 0.0 is outside its limit: {name} > 0"):
        RateLimits(**{name: 0.0})


def test_arc__turns__are_run_before_its_end():
    block = only_block("G3 X0 Y50 Z630 I-50 P3 F600", start=BESIDE)
    turn = 2 * math.pi * 0.05
    assert block.curve.length == pytest.approx(math.hypot(2.25 * turn, 0.03))
    assert points(block, [4 / 9, 8 / 9, 1.0]) == pytest.approx(
        np.array([(0.05, 0, 0.6 + 0.03 * 4 / 9, 0, 0), (0.05, 0, 0.6 + 0.03 * 8 / 9, 0, 0),
                  (0, 0.05, 0.63, 0, 0)]), abs=1e-15,
    )  # fmt: skip


SPIRALS = ["G3 X-50.04 Y0 I-50", "G2 X-49.96 Y0 Z640 I-50 A5", "G3 X50.03 Y0 I-50 P3",
           "G17 G3 X50.02 Y.3 Z601 I-50"]  # fmt: skip


@pytest.mark.quick("G2 *")
@pytest.mark.parametrize("text", SPIRALS)
def test_spiral__of_an_arc_off_its_circle__is_that_of_even_growth(text):
    """Radius and height over the angle are straight lines; s is the length; derivatives agree."""
    curve = only_block(f"{text} F600", start=BESIDE).curve
    s = np.linspace(0.0, curve.length, 20001)
    q, d1, d2 = curve.evaluate(s)
    d3 = curve.third(s)
    angle = np.unwrap(np.arctan2(q[:, 1], q[:, 0]))
    share = (angle - angle[0]) / (angle[-1] - angle[0])
    for value in (np.hypot(q[:, 0], q[:, 1]), q[:, 2], q[:, 3]):
        assert value == pytest.approx(value[0] + (value[-1] - value[0]) * share, abs=1e-12)
    assert np.linalg.norm(d1[:, :3], axis=1) == pytest.approx(np.ones(len(s)), abs=1e-12)
    for value, slope in ((q, d1), (d1, d2), (d2, d3)):
        step = (value[2:] - value[:-2]) / (s[2:] - s[:-2])[:, None]
        assert step == pytest.approx(slope[1:-1], rel=1e-6, abs=1e-6 * np.abs(slope).max())
    end = parse(f"G90 {text} F600\nM2", start=BESIDE).moves[0].end
    assert q[-1, :3] * 1e3 == pytest.approx(end[:3], abs=1e-12)
