# SPDX-License-Identifier: Apache-2.0
"""The two-processor system with its real programs: set-points, hand-over, closed loop, refusals."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from sim.bench.dual.__main__ import main
from sim.bench.dual.moves import RING_RECORDS, PathNotSuitedError, moves_of, rest
from sim.bench.dual.report import nominal_clocks, set_point_errors
from sim.bench.dual.system import TwoProcessors, program
from sim.core import closed_loop
from sim.core.controller import AsipController, ControllerFault
from sim.motion.gcode.interpreter import parse, parse_file
from sim.motion.trajectory.exact_stop import MotionSettings, generate
from sim.motion.trajectory.program import set_points
from sim.robot.parameters import Robot
from sim.robot.plant import Plant
from sim.robot.records import SET_POINTS
from sim.rtl.dual_rtl import DualRtl

MOVES = Path(__file__).with_name("moves.ngc")
SHORT = 512  # clocks of a period, above all work
QUICK = MotionSettings(acceleration_time=0.012, jerk_time=0.005, lead_in=0.001)
NAMES = (
    ("x", "y", "z", "alpha", "gamma"),
    ("vx", "vy", "vz", "w_alpha", "w_gamma"),
    ("ax", "ay", "az", "eps_alpha", "eps_gamma"),
)
HOME = np.array([0.0, 0.0, 0.6, 0.0, 0.0])
COUNTS = [[2_400_000, 2_400_000, 2_400_000, 0, 0]]
# A word is the result of about twenty roundings to binary32 of parts not above its largest value.
ROUNDINGS = 20 * 2.0**-24
# A position is rounded once more at its own size.
POSITION_ROUNDING = 2.0**-24
# The time to the end of a move is rounded four times at the size of the move's duration; a word is
# off by its rate of change times that. The acceleration changes by its largest value in jerk_time.
TIME_ROUNDING = 4 * 2.0**-24


@pytest.fixture(scope="module")
def trajectory():
    return generate(parse_file(MOVES), QUICK)


@pytest.fixture(scope="module")
def closed(trajectory):
    """The whole path of short moves in closed loop: controller, recording, set-points planned."""
    path = set_points(trajectory, None)
    controller = TwoProcessors(Robot.load(), moves_of(trajectory, QUICK), SHORT)
    recording = closed_loop.run(Robot.load(), path, controller, lambda n: None)
    return controller, recording, path


def made(controller: TwoProcessors, ticks: int) -> np.ndarray:
    return np.array(controller.set_points[:ticks])


# ---------------------------------------------------------------------- set-points


@pytest.mark.full
def test_set_points__lines_arcs_and_table_moves_are_those_of_the_plan_in_double(closed, trajectory):
    controller, _, path = closed
    errors = set_point_errors(path, made(controller, len(path)))
    late = TIME_ROUNDING * np.diff(trajectory.first_ticks).max() * QUICK.period
    jerk = np.abs(trajectory.acceleration).max(axis=0) / QUICK.jerk_time
    motion = (trajectory.position, trajectory.velocity, trajectory.acceleration)
    for order, change in enumerate((*motion[1:], jerk[np.newaxis])):
        values = motion[order]
        limit = ROUNDINGS * np.ptp(values, axis=0) + late * np.abs(change).max(axis=0)
        if order == 0:
            limit += POSITION_ROUNDING * np.abs(values).max(axis=0)
        for axis in range(5):
            name = NAMES[order][axis]
            assert errors[name] <= limit[axis], f"{name}: {errors[name]:.3g} > {limit[axis]:.3g}"
    assert max(errors[name] for name in ("x", "y", "z")) < 1e-6


def test_set_points__stops_are_exact_and_at_rest(closed, trajectory):
    controller, _, path = closed
    ticks = trajectory.first_ticks[1:]
    words = made(controller, len(path))[ticks].astype(np.float64)
    planned = path.words()[ticks]
    positions = [SET_POINTS.index(name) for name in ("x", "y", "z", "alpha", "gamma")]
    assert np.array_equal(words[:, positions], planned[:, positions].astype(np.float32))
    rates = [i for i in range(15) if i not in positions and SET_POINTS[i][0] in "vw"]
    assert not words[:, rates].any()


def test_set_points__end_is_held_until_a_further_move_arrives(trajectory):
    moves = moves_of(trajectory, QUICK)[:2]
    controller = TwoProcessors(Robot.load(), moves, SHORT)
    controller.start()
    ticks = sum(move.duration for move in moves)
    controller.periods(COUNTS * (ticks + 20))
    words = made(controller, ticks + 20)
    end = set_points(trajectory, None).words()[ticks].astype(np.float32)
    assert np.array_equal(words[ticks:], np.tile(end, (20, 1)))
    controller.append(moves_of(trajectory, QUICK)[2:3])
    controller.set_points.clear()
    controller.periods(COUNTS * 60)
    late = np.array(controller.set_points)
    begin = int(np.argmax(np.any(late != end, axis=1))) - 1
    follow = set_points(trajectory, None).words()[ticks : ticks + 50]
    assert np.abs(late[begin : begin + 50] - follow).max() < 1e-3


def test_ring__more_moves_than_it_holds_run_in_order():
    """Rests at known heights: the ring goes round, the host writes ahead."""
    heights = [0.6 + 0.001 * i for i in range(3 * RING_RECORDS + 5)]
    moves = [rest(np.array([0.0, 0.0, z, 0.0, 0.0]), 7 + i % 5) for i, z in enumerate(heights)]
    controller = TwoProcessors(Robot.load(), moves, SHORT)
    controller.start()
    ticks = sum(move.duration for move in moves)
    for _ in range(0, ticks, 50):
        controller.periods(COUNTS * 50)
        controller.feed()
    z = made(controller, ticks)[:, 2]
    expected = np.repeat(np.float32(heights), [move.duration for move in moves])
    assert np.array_equal(z, expected)


# ---------------------------------------------------------------------- hand-over and loop


def test_closed_loop__commands_are_those_of_one_core_on_the_same_words(closed):
    """The tracking program alone, given what was handed over, answers with the same bits."""
    controller, recording, path = closed
    alone = AsipController(program("tracking_optimised", "fast", Robot.load()))
    words = made(controller, len(path))
    alone.prime(words[0], recording.counts[0])
    again = alone.batch(words, recording.counts)
    assert np.array_equal(again.outputs.view(np.uint32), recording.ticks.outputs.view(np.uint32))


def test_closed_loop__tool_follows_as_with_one_core(closed):
    controller, recording, path = closed
    robot = Robot.load()
    alone = AsipController(program("tracking_optimised", "fast", Robot.load()))
    other = closed_loop.run(robot, path, alone, lambda n: None)
    ours = np.linalg.norm(recording.tool - path.position, axis=1)
    theirs = np.linalg.norm(other.tool - path.position, axis=1)
    resolution = max(robot.resolution[:3])
    assert ours.max() < theirs.max() + 2 * resolution
    assert theirs.max() > 0


def test_closed_loop__same_bits_twice_and_whatever_the_length_of_a_period(trajectory):
    """A few ticks over the first change of moves, at two lengths of a period and twice at one."""
    path = set_points(trajectory, 30)
    runs = []
    for period in (SHORT, SHORT, nominal_clocks(Robot.load())):
        controller = TwoProcessors(Robot.load(), moves_of(trajectory, QUICK), period)
        recording = closed_loop.run(Robot.load(), path, controller, lambda n: None)
        system = controller.system
        runs.append(
            (
                recording.ticks.outputs.tobytes(),
                recording.ticks.cycles.tolist(),
                made(controller, 31).tobytes(),
                [system.read(f"{core}_MAX") for core in ("TRAJECTORY", "TRACKING", "COPY")],
            )
        )
        assert system.read("LEFT_MIN") == period - system.read("USED_MAX")
    assert runs[0] == runs[1] == runs[2]


def test_closed_loop__every_period_takes_the_same_cycles(closed):
    controller, recording, _ = closed
    read = controller.system.read
    assert read("TRAJECTORY_MIN") == read("TRAJECTORY_MAX")
    assert read("TRACKING_MIN") == read("TRACKING_MAX")
    assert len(set(recording.ticks.cycles.tolist())) == 1
    assert read("USED_MAX") < nominal_clocks(Robot.load())


# ---------------------------------------------------------------------- faults


def test_refused_move__holds_the_last_set_point_and_stops(trajectory):
    good, *rest_of = moves_of(trajectory, QUICK)
    bad = dataclasses.replace(rest_of[0], vm=0.0)
    robot = Robot.load()
    controller = TwoProcessors(Robot.load(), [good, bad], SHORT)
    plant = Plant(robot, HOME[:3], HOME[3:])
    seen = plant.counts()
    controller.prime(set_points(trajectory, 1).words()[0], seen)
    with pytest.raises(
        ControllerFault, match=r"tick \d+: no new command or set-point; flags: .*stop.*"
    ):
        for _ in range(good.duration + 2):
            seen = plant.step(controller.step(None, seen).outputs[0].tolist())
    for _ in range(50):
        record = controller.periods([seen])
        assert record["updates"][0] == 1
        seen = plant.step(record["commands"][0].view(np.float32).tolist())
    flags = controller.system.flags()
    assert flags["trajectory_fault"] and flags["hold"] and not flags["tracking_fault"]
    assert np.linalg.norm(np.array(plant.tool) - HOME[:3]) < 1e-6


def test_no_move__the_system_stops_before_it_tracks():
    controller = TwoProcessors(Robot.load(), [], SHORT)
    controller.start()
    controller.periods(COUNTS * 2)
    flags = controller.system.flags()
    assert flags["trajectory_fault"] and not flags["valid"]


# ---------------------------------------------------------------------- refusals


def test_moves__a_path_without_stops_is_refused_by_line():
    program = parse("G17 G21 G90\nG1 X1 F600\nG1 X2\nM2\n", "two.ngc")
    joined = generate(program, QUICK)
    with pytest.raises(PathNotSuitedError, match=r"line 3: error: .*got 'G1 X2'; expected"):
        moves_of(joined, QUICK)


@pytest.mark.full
def test_cli__writes_figures_and_tables(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("sim.bench.dual.__main__.SINGLE", tmp_path / "none.json")
    assert main([str(MOVES), "--ticks", "1400", "--short-only", "--output", str(tmp_path)]) == 0
    data = json.loads((tmp_path / "results.json").read_text())
    assert data["ticks"] == 1400
    assert data["clocks"]["periods"] == 1401  # the first makes the set-point to begin with
    assert data["complete"] and not data["whole_path"]
    assert data["ticks_done"] == 1400 and data["clocks"]["overruns"] == 0
    assert (
        data["periods"]["left"]["min"] == nominal_clocks(Robot.load()) - data["clocks"]["used_max"]
    )
    assert data["one_core"] == {"ticks": 1400, "ticks_equal": 1400}
    assert data["repeated"]["ticks"] == 0
    assert data["set_point_error"]["x"] > 0  # it has begun to move
    assert data["tracking_single_core"]["tool"] > 0
    assert "left of 100 us" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["none.ngc"], 1, "none.ngc"),
        (["--ticks", "0"], 2, "--ticks 0 is not positive"),
        (["--every", "0"], 2, "--every 0 is not positive"),
        (["--period", "70000"], 2, "--period 70000 is not in 1..65535"),
        (
            [str(MOVES), "--ticks", "50", "--period", "100"],
            1,
            "no new command or set-point; flags: ",
        ),
    ],
)
def test_cli__refuses_without_a_traceback(arguments, code, text, capsys, tmp_path):
    try:
        got = main([*arguments, "--output", str(tmp_path)])
    except SystemExit as exit_:
        got = exit_.code
    out = capsys.readouterr()
    assert got == code
    assert text in " ".join((out.out + out.err).split())


@pytest.mark.full
@pytest.mark.parametrize("configuration", ["fast", "small"])
def test_small_cores__same_bits(configuration, trajectory, closed):
    """Both programs on the small cores, or one of them, compute the same words."""
    controller = TwoProcessors(
        Robot.load(), moves_of(trajectory, QUICK), 1000, trajectory=configuration, tracking="small"
    )
    path = set_points(trajectory, 400)
    recording = closed_loop.run(Robot.load(), path, controller, lambda n: None)
    words = made(closed[0], 400)
    assert np.array_equal(made(controller, 400), words)
    assert np.array_equal(recording.ticks.outputs, closed[1].ticks.outputs[:400])


def test_system__out_of_reset_has_no_period():
    system = DualRtl()
    system.clock(2000)
    assert system.read("PERIODS") == 0
