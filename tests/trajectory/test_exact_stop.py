# SPDX-License-Identifier: Apache-2.0
"""Set-points of whole programs: ticks, stops, continuity, limits and the letters A, G, H."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.motion.gcode.interpreter import parse, parse_file
from sim.motion.geometry.curves import Arc, RateLimits, to_si
from sim.motion.geometry.moves import Motion
from sim.motion.trajectory.__main__ import main
from sim.motion.trajectory.exact_stop import (
    GRID,
    MotionSettings,
    TooLongError,
    Trajectory,
    Workspace,
    WorkspaceError,
    generate,
    on_number_grid,
)
from sim.robot.parameters import Robot

PATHS = Path(__file__).parents[2] / "sim" / "paths"
FEED = 2 / 60  # m/s
DEFAULTS = MotionSettings()
# Brisk motion of the small programs below, independent of the machine's own gentle settings.
BRISK = {"acceleration_time": 0.06, "jerk_time": 0.024, "rates": RateLimits(rapid=0.1)}


def run(text: str, **options) -> Trajectory:
    return generate(parse(text), MotionSettings(**{**BRISK, **options}))


@pytest.fixture(scope="module")
def agh() -> Trajectory:
    return generate(parse_file(PATHS / "agh.ngc"))


def tool_speed(trajectory: Trajectory) -> np.ndarray:
    return np.linalg.norm(trajectory.velocity[:, :3], axis=1)


def check_derivatives(trajectory: Trajectory, settings: MotionSettings) -> None:
    """Central differences of position and velocity against velocity and acceleration.

    Acceleration is continuous with a Lipschitz constant J (the largest jerk), so the position's
    central difference is off by at most J h^2 / 6. The acceleration's own step over a tick is at
    most J h, and the velocity's central difference is off by at most J h / 2 (a kink of the jerk
    in the middle of the tick). Roundings: ulp(1 m or rad) / h and of speeds below 2 per s.
    """
    h = trajectory.t[1]
    jerk = largest_jerk(trajectory, settings)
    p, v, a = trajectory.position, trajectory.velocity, trajectory.acceleration
    slope = (p[2:] - p[:-2]) / (2 * h)
    assert np.all(np.abs(slope - v[1:-1]) <= jerk * h**2 / 6 + 4 * 2.2e-16 / h)
    change = (v[2:] - v[:-2]) / (2 * h)
    assert np.all(np.abs(change - a[1:-1]) <= jerk * h / 2 + 4 * 4.4e-16 / h)
    assert np.all(np.abs(np.diff(a, axis=0)) <= jerk * h * (1 + 1e-9) + 1e-12)


def largest_jerk(trajectory: Trajectory, settings: MotionSettings) -> np.ndarray:
    """Bound of every axis' jerk (5,): j p' + 3 a v p'' + v^3 p''' with the peaks of each block."""
    tr, tm = settings.acceleration_time, settings.jerk_time
    bound = np.zeros(5)
    for block in trajectory.blocks:
        v = block.speed
        a = v / (tr - tm)
        rates = np.abs(block.curve.end - block.curve.start) / block.curve.length * a / tm
        # The shift to the number grid: half a step, of 2^-22 for an angle above 2 rad, at each end.
        rates += 4 * GRID / block.curve.length * a / tm
        if isinstance(block.curve, Arc):
            r = block.curve.radius
            for axis in block.curve.axes:
                rates[axis] += a / tm + 3 * a * v / r + v**3 / r**2
        bound = np.maximum(bound, rates)
    return bound


def check_block_ends(trajectory: Trajectory) -> None:
    """Every block begins exactly at its start, at rest; the last tick is the end, at rest."""
    for block, tick in zip(trajectory.blocks, trajectory.first_ticks[:-1], strict=True):
        assert np.all(trajectory.position[tick] == on_number_grid(to_si(block.move.start)))
        assert not trajectory.velocity[tick].any()
        assert not trajectory.acceleration[tick].any()
    end = on_number_grid(to_si(trajectory.blocks[-1].move.end))
    assert np.all(trajectory.position[-1] == end)
    assert not trajectory.velocity[-1].any() and not trajectory.acceleration[-1].any()


def test_generate__one_line__lasts_the_s_curve_rounded_up_to_a_tick():
    # 100 mm at 2 m/min: 3 s and 60 ms of acceleration; 1.0001 mm more take 30.003 ms more.
    assert run("G1 X100 F2000\nM2", lead_in=0.0).first_ticks.tolist() == [0, 30600]
    assert run("G1 X101.0001 F2000\nM2", lead_in=0.0).first_ticks.tolist() == [0, 30901]


def test_generate__lead_in__rests_at_the_start_for_its_time():
    trajectory = run("G1 X10 F2000\nM2", lead_in=0.05)
    assert trajectory.first_ticks[0] == 500
    assert np.all(trajectory.block[:500] == -1) and trajectory.block[500] == 0
    assert np.all(trajectory.position[:501] == on_number_grid(to_si((0, 0, 600, 0, 0))))
    assert not trajectory.velocity[:501].any()


def test_generate__shapes_and_times__are_those_of_the_ticks():
    trajectory = run("G1 X10 F2000\nM2")
    n = len(trajectory)
    assert trajectory.t.shape == trajectory.block.shape == (n,)
    for array in (trajectory.position, trajectory.velocity, trajectory.acceleration):
        assert array.shape == (n, 5) and array.dtype == np.float64
    assert trajectory.t[-1] == pytest.approx((n - 1) * 100e-6, rel=1e-15)


def test_generate__corner__stops_exactly():
    trajectory = run("G1 X10 F2000\nY10\nM2")
    check_block_ends(trajectory)
    check_derivatives(trajectory, MotionSettings(**BRISK))


def test_generate__collinear_blocks__are_one_motion():
    pieces = run("G1 X10 C5 F2000\nX30 C15\nX100 C50\nM2")
    whole = run("G1 X100 C50 F2000\nM2")
    assert len(pieces) == len(whole)
    # The pieces are measured one by one: three roundings of a length of 0.1 m.
    assert np.max(np.abs(pieces.position - whole.position)) < 3e-16
    # 10 mm and 30 mm into the path at feed: 0.03 s of acceleration have cost 1 mm.
    assert pieces.first_ticks.tolist() == [1000, 1000 + 3300, 1000 + 9300, 1000 + 30600]
    assert tool_speed(pieces)[pieces.first_ticks[1]] == pytest.approx(FEED)


@pytest.mark.parametrize(
    ("name", "second"),
    [
        ("other feed", "G1 X20 F1000"),
        ("other direction", "G1 X20 Y0.001"),
        ("reversal", "G1 X0"),
        ("rapid", "G0 X20"),
        ("table starts to turn", "G1 X20 C1"),
        ("table only", "G1 C10"),
        ("tangent arc", "G3 X20 Y10 J10"),
    ],
)
def test_generate__joint_that_is_not_smooth__is_a_stop(name, second):
    trajectory = run(f"G1 X10 F2000\n{second}\nM2")
    check_block_ends(trajectory)
    check_derivatives(trajectory, MotionSettings(**BRISK))


def test_generate__circle_cut_into_two_arcs__does_not_stop():
    trajectory = run("G0 X30\nG3 X0 Y30 I-30 C90 F2000\nX-30 Y0 J-30 C180\nM2")
    middle = trajectory.first_ticks[2]
    assert tool_speed(trajectory)[middle] == pytest.approx(FEED, rel=1e-4)
    check_derivatives(trajectory, MotionSettings(**BRISK))


def test_generate__rapid__runs_at_the_rapid_rate():
    assert tool_speed(run("G0 X100\nM2")).max() == pytest.approx(0.1)


def test_generate__move_shorter_than_its_acceleration__keeps_the_acceleration_time():
    assert run("G1 X0.5 F2000\nM2", lead_in=0.0).first_ticks.tolist() == [0, 1200]


coordinates = st.integers(-100, 100)


@settings(max_examples=40)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["G0", "G1"]),
            st.tuples(coordinates, coordinates, coordinates, coordinates, coordinates),
        ),
        min_size=1,
        max_size=4,
    )
)
def test_generate__random_lines__are_continuous_and_end_exactly(moves):
    blocks = [f"{g} X{x} Y{y} Z{600 + z} A{a} C{c}" for g, (x, y, z, a, c) in moves]
    text = "\n".join(["F6000", *blocks, "G0 X0 Y0 Z601 A0 C0", "M2"])
    trajectory = run(text, lead_in=0.0)
    check_derivatives(trajectory, MotionSettings(**BRISK))
    assert np.all(trajectory.position[-1] == on_number_grid(to_si((0, 0, 601, 0, 0))))
    assert np.all(np.abs(trajectory.velocity[:, 3:]) <= math.pi / 2 * (1 + 4 * GRID / 1e-3))
    assert np.all(tool_speed(trajectory) <= 0.1 * (1 + 4 * GRID / 1e-3))


def test_generate__set_point_outside_the_workspace__names_tick_line_value_and_limit():
    with pytest.raises(WorkspaceError) as caught:
        generate(parse("G0 X100\nG1 Z800 F2000\nM2", file="high.ngc"), MotionSettings(**BRISK))
    error = caught.value
    assert (error.line, error.axis, error.limit) == (2, "z", 0.75)
    # At feed: 150 mm and 1 mm of acceleration later, after rest and the rapid of 10 600 ticks.
    assert error.tick == 1000 + 10600 + 45300 + 1
    assert 0.75 < error.value < 0.75 + FEED * 1.001e-4 + GRID
    assert str(error).startswith(
        f"high.ngc:2: error: tick {error.tick} leaves the workspace; got z = 750.00"
    )
    assert str(error).splitlines()[0].endswith("expected z <= 750 mm")


@pytest.mark.parametrize(
    ("code", "axis", "limit"),
    [
        *(("X-151", "x", -0.15), ("Y151", "y", 0.15), ("Z449", "z", 0.45), ("X151", "x", 0.15)),
        *(("A181", "A", math.pi), ("A-181", "A", -math.pi)),
    ],
)
def test_generate__each_side_of_the_workspace__is_checked(code, axis, limit):
    with pytest.raises(WorkspaceError) as caught:
        run(f"G0 {code}\nM2")
    assert (caught.value.axis, caught.value.limit) == (axis, limit)


def test_generate__travel_of_the_table__is_that_of_the_robot():
    tight = replace(Robot.load(), tilt_min=-0.1, tilt_max=0.2, rotation_min=-0.3, rotation_max=0.4)
    settings = MotionSettings(tight)
    for end, text in (
        ("A-5.8", "got A = -5.7.*expected A >= -5.72958 degree"),
        ("A11.5", "got A = 11.4.*expected A <= 11.4592 degree"),
        ("C-17.2", "got C = -17.*expected C >= -17.1887 degree"),
        ("C23", "got C = 22.9.*expected C <= 22.9183 degree"),
    ):
        with pytest.raises(WorkspaceError, match=text):
            generate(parse(f"G0 {end}\nM2"), settings)
    generate(parse("G0 A-5.7 C-17.1\nA11.4 C22.9\nM2"), settings)
    edge = replace(tight, tilt_max=math.pi)  # binary32 has a larger one
    generate(parse("G0 A180\nM2"), MotionSettings(edge))


def test_generate__arc_that_touches_the_workspace__is_accepted():
    run("G0 X150\nG3 I-150 F6000\nG0 X0\nZ450\nZ750\nM2")


def test_generate__workspace__is_that_of_the_robot():
    tight = replace(Robot.load(), x_max=0.01, y_max=0.01, z_min=0.59, z_max=0.61)
    with pytest.raises(WorkspaceError):
        generate(parse("G0 X11\nM2"), MotionSettings(tight))


def test_defaults__workspace_and_period__are_those_of_the_specification():
    robot = Robot.load()
    turns = 60 * math.pi
    assert Workspace.of(robot) == Workspace(
        (-0.150, -0.150, 0.450, -math.pi, -turns), (0.150, 0.150, 0.750, math.pi, turns)
    )
    assert DEFAULTS.period == robot.T_s == 100e-6


def test_generate__program_without_motion__is_refused():
    with pytest.raises(ValueError, match="empty.ngc: error: the program has no motion"):
        generate(parse("M2", file="empty.ngc"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"jerk_time": 0.0}, "jerk_time = 0.0 is outside its limit: jerk_time > 0"),
        ({"jerk_time": 0.19}, "jerk_time <= acceleration_time/2 = 0.18"),
        ({"lead_in": -1.0}, "lead_in = -1.0 is outside its limit: lead_in >= 0"),
    ],
)
def test_motion_settings__bad_value__is_named_with_its_limit(options, message):
    with pytest.raises(ValueError) as caught:
        MotionSettings(**options)
    assert message in str(caught.value)


# Example paths

# Strokes of each letter by source line numbers N, and the normal of its plane (comment of agh.ngc).
STROKES = {
    "A": ((120, 130, 170), (0.48, -0.64, 0.60)),
    "G": ((230, 235, 240, 243, 246), (0, -1, 0)),
    "H": ((330, 370, 410), (0.60, 0, 0.80)),
}
UP = {"A": (-0.36, 0.48, 0.80), "G": (0, 0, 1), "H": (0, 1, 0)}


def letter(trajectory: Trajectory, name: str) -> np.ndarray:
    """Positions (n, 5) [m, rad] of the strokes of one letter."""
    numbers = {f"N{number}" for number in STROKES[name][0]}
    chosen = [i for i, b in enumerate(trajectory.blocks) if b.move.source.split()[0] in numbers]
    assert len(chosen) == len(numbers)
    return trajectory.position[np.isin(trajectory.block, chosen)]


def test_agh__number_of_ticks__is_the_published_one(agh):
    assert len(agh) == 298_334


def test_agh__every_block__begins_and_ends_exactly_and_the_motion_is_smooth(agh):
    check_block_ends(agh)
    check_derivatives(agh, DEFAULTS)


def test_agh__drawing_speed__reaches_two_metres_per_minute_and_never_exceeds_it(agh):
    drawing = [i for i, b in enumerate(agh.blocks) if b.move.motion is not Motion.RAPID]
    speed = tool_speed(agh)
    for index in drawing:
        top = speed[agh.block == index].max()
        assert top <= FEED * (1 + 2 * GRID / agh.blocks[index].curve.length)
        if agh.blocks[index].curve.length > FEED * DEFAULTS.acceleration_time:
            # Slowed to whole ticks: by less than one tick of the block's duration.
            ticks = np.sum(agh.block == index)
            shift = 2 * GRID / agh.blocks[index].curve.length
            assert top >= FEED * (1 - 1 / (ticks - 1) - shift)


@pytest.mark.parametrize("name", STROKES)
def test_agh__letter__is_forty_millimetres_high_in_its_own_plane(agh, name):
    points = letter(agh, name)[:, :3]
    normal = np.array(STROKES[name][1])
    *_, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    # Flat except for half a step of the number grid at the stops, over strokes of 10 mm and more.
    assert abs(axes[2] @ normal) == pytest.approx(1, abs=(GRID / 0.01) ** 2)
    assert np.ptp((points - points[0]) @ normal) < 2 * GRID
    # The end of every stroke falls on a tick or within v T_s of one.
    height = np.ptp(points @ np.array(UP[name]))
    assert height == pytest.approx(0.040, abs=2 * GRID)


def test_agh__planes__differ_by_more_than_thirty_degrees():
    normals = [np.array(normal) for _, normal in STROKES.values()]
    for i, first in enumerate(normals):
        assert np.linalg.norm(first) == pytest.approx(1)
        for second in normals[:i]:
            assert math.degrees(math.acos(abs(first @ second))) > 30


@pytest.mark.parametrize("name", STROKES)
def test_agh__letter__moves_all_five_axes(agh, name):
    span = np.ptp(letter(agh, name), axis=0)
    moving = span > [1e-3, 1e-3, 1e-3, 0.01, 0.01]
    assert list(moving) == [True, name != "G", True, True, True]


def test_agh__workspace__is_kept_with_room_for_the_whole_letters(agh):
    workspace = Workspace.of(Robot.load())
    assert np.all(agh.position[:, :3] >= workspace.lower[:3])
    assert np.all(agh.position[:, :3] <= workspace.upper[:3])
    assert np.max(np.abs(agh.position[:, :3] - [0, 0, 0.6])) < 0.06


def test_agh__run_twice__gives_the_same_bits(agh):
    again = generate(parse_file(PATHS / "agh.ngc"))
    for name in ("t", "position", "velocity", "acceleration", "block", "first_ticks"):
        assert getattr(again, name).tobytes() == getattr(agh, name).tobytes()


def test_circle__path__is_a_circle_of_sixty_millimetres_at_two_metres_per_minute():
    trajectory = generate(parse_file(PATHS / "circle.ngc"))
    drawing = trajectory.block == 1
    points = trajectory.position[drawing, :3]
    assert np.hypot(points[:, 0], points[:, 1]) == pytest.approx(0.03, abs=GRID)
    assert np.all(points[:, 2] == round(0.6 / GRID) * GRID)
    assert tool_speed(trajectory)[drawing].max() == pytest.approx(FEED, rel=1e-4)
    # Steady: the acceleration is v^2/r towards the centre.
    middle = trajectory.first_ticks[1] + np.count_nonzero(drawing) // 2
    speed = tool_speed(trajectory)[middle]
    assert np.linalg.norm(trajectory.acceleration[middle]) == pytest.approx(speed**2 / 0.03)
    check_derivatives(trajectory, DEFAULTS)


# Command line


def test_command__program__prints_a_summary_and_writes_every_set_point(tmp_path, capsys):
    table = tmp_path / "new" / "circle.csv"
    assert main([str(PATHS / "circle.ngc"), "--csv", str(table)]) == 0
    out = capsys.readouterr().out
    assert "83350 set-points, 8.3349 s" in out
    trajectory = generate(parse_file(PATHS / "circle.ngc"))
    values = np.loadtxt(table, delimiter=",", skiprows=1)
    assert np.array_equal(values[:, 1:6], trajectory.position)
    assert np.array_equal(values[:, 11:], trajectory.acceleration)
    assert table.read_text().startswith("t,x,y,z,alpha,gamma,v_x,")


def test_command__program_with_a_mistake__shows_it_and_fails(tmp_path, capsys):
    path = tmp_path / "bad.ngc"
    path.write_text("G1 X1\nM2\n")
    assert main([str(path)]) == 1
    assert capsys.readouterr().err.startswith(f"{path}:1:1: error: no feed is set for G1")


def test_command__missing_file__says_so_and_fails(tmp_path, capsys):
    assert main([str(tmp_path / "none.ngc")]) == 1
    told = f"error: {tmp_path / 'none.ngc'}: No such file or directory\n"
    assert capsys.readouterr().err == f"python -m sim.motion.trajectory: {told}"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--jerk-time", "1"], "error: jerk_time = 1.0 is outside its limit"),
        (["--rapid", "-1"], "error: --rapid = -1 is outside its limit: > 0 m/min"),
        (["--table", "nan"], "error: --table = nan is outside its limit: > 0 degree/s"),
        (["--acceleration-time", "1e300"], "circle.ngc:5: error: the motion is too long"),
        (["--lead-in", "1e12"], "error: the motion is too long to be held; got 1e+12 s"),
    ],
)
def test_command__bad_option__says_so_and_fails(options, message, capsys):
    assert main([str(PATHS / "circle.ngc"), *options]) == 1
    assert message in capsys.readouterr().err


def test_generate__feed_next_to_nothing__is_refused_at_its_line_before_it_fills_the_memory():
    with pytest.raises(TooLongError, match=r"a.ngc:2: error: .* got 6e\+06 s") as caught:
        generate(parse("G1 X1 F100\nX11 F0.0001\nM2", file="a.ngc"))
    assert "    2 |   X11 F0.0001" in str(caught.value)
