# SPDX-License-Identifier: Apache-2.0
"""The tracking programs on the instruction-set model against the reference in double precision.

Error bounds are those of `sim.bench.run.bounds`, evaluated at every tick.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from asip_asm.assemble import assemble
from asip_asm.isa import default_isa
from sim.bench.run.bounds import bounds
from sim.core.iss import Fault, Iss, RunResult, run_path
from sim.core.iss.path import preset
from sim.robot import float32, tracking
from sim.robot.published import Published
from sim.robot.records import ACCELERATIONS, OUTPUTS, POSITIONS, SET_POINTS, TABLE_3, VELOCITIES
from tests.asip.tracking_path import reversing_path

ROOT = Path(__file__).parents[2]
PROGRAMS = {
    name: ROOT / "asip_asm" / "programs" / f"tracking_{name}.s"
    for name in ("as_printed", "optimised", "observer")
}
TICKS = 600
ERRORS = ("e1", "e2", "e3", "e4", "e5")
MASSES = ("M1", "M2", "M3")
GRAVITIES = ("G1", "G2", "G3", "G4")


@pytest.fixture(params=PROGRAMS)
def program(request) -> str:
    """Name of each tracking program."""
    return request.param


@pytest.fixture(scope="module")
def motion(robot):
    return reversing_path(robot, TICKS)


@pytest.fixture(scope="module")
def reference(robot, motion):
    return tracking.run(robot, *motion)


def speed_of(program: str) -> str:
    """Where a program takes speeds from."""
    return "observer" if program == "observer" else "difference"


@pytest.fixture(scope="module")
def images():
    """Program name -> image, one operation per bundle in the order written."""
    return {name: assemble(path, optimise=False).to_json() for name, path in PROGRAMS.items()}


@pytest.fixture(scope="module")
def runs(robot, motion, images):
    """Program name -> run over the motion."""
    exports = (*ERRORS, *MASSES, *GRAVITIES)
    return {name: run_path(image, robot, *motion, exports) for name, image in images.items()}


def assert_within(name: str, got: np.ndarray, want: np.ndarray, bound: np.ndarray) -> None:
    ratio = np.abs(got - want) / np.maximum(bound, 1e-300)
    worst = int(np.argmax(ratio))
    assert ratio[worst] <= 1.0, (
        f"{name}, tick {worst}: {got[worst]:.9g}, reference {want[worst]:.9g}, error "
        f"{abs(got[worst] - want[worst]):.3g} exceeds the bound {bound[worst]:.3g}"
    )


def test_motion_shows_every_branch_of_the_integrator_and_no_doubtful_sign(robot, motion, reference):
    velocity = bounds(robot, motion[0], reference, optimised=False).velocity
    half, end = robot.boost_ticks // 2, robot.boost_ticks
    for axis in range(5):
        n, size = reference.ticks[:, axis], np.abs(reference.e[:, axis])
        ramp = (n > half) & (n < end)
        large = size >= robot.e_c[axis]
        for part in (n == 0, (0 < n) & (n <= half), ramp & large, ramp & ~large):
            assert part.any(), f"axis {axis + 1}"
        assert np.count_nonzero(n == 0) >= 2
        assert np.all(np.abs(reference.velocity_d[:, axis]) > velocity[:, axis])
    assert (reference.ticks == end).any()
    assert np.all(np.abs(reference.demand) < np.array(robot.output_max))


def assert_run_within_bounds(robot, motion, rows, program: str) -> None:
    speed = speed_of(program)
    reference = tracking.run(robot, *motion, speed)
    counts = motion[1] if speed == "observer" else None
    limit = bounds(robot, motion[0], reference, program != "as_printed", counts)
    for names, want, bound in (
        (POSITIONS, reference.position_d, limit.position),
        (VELOCITIES, reference.velocity_d, limit.velocity),
        (ACCELERATIONS, reference.acceleration_d, limit.acceleration),
        (ERRORS, reference.e, limit.e),
        (MASSES, reference.mass, limit.mass),
        (GRAVITIES, reference.gravity, limit.gravity),
        (OUTPUTS, reference.output, limit.output),
    ):
        for axis, name in enumerate(names):
            assert_within(name, rows[name], want[:, axis], bound[:, axis])


def test_every_tick_agrees_with_the_reference_within_the_derived_bounds(
    robot, motion, runs, program
):
    assert_run_within_bounds(robot, motion, runs[program].rows, program)


def test_another_robot_needs_only_other_parameters(robot, program):
    other = {"R": 0.4321, "l_c": 0.31, "m_s": 9.7, "encoder_legs": 0.3e-6, "g": 3.7, "xi_c": 4.2}
    changed = replace(robot, **other)
    motion = reversing_path(changed, 120)
    image = assemble(PROGRAMS[program], optimise=False, defines=other).to_json()
    exports = (*ERRORS, *MASSES, *GRAVITIES)
    rows = run_path(image, changed, *motion, exports).rows
    assert_run_within_bounds(changed, motion, rows, program)


def test_as_printed_gives_the_bits_of_the_pc_in_every_derivative(robot, motion, runs):
    pc = float32.run(robot, *motion)
    for name in set(TABLE_3) - {"l1", "l2", "l3"}:
        got, want = runs["as_printed"].rows[name], pc.row(name).astype(np.float64)
        assert np.array_equal(got, want), f"{name}, tick {int(np.argmax(got != want))}"


def test_outputs_are_no_worse_than_the_pc_as_printed_and_ten_times_better_optimised(
    robot, motion, reference, runs
):
    pc = float32.run(robot, *motion)
    for name in OUTPUTS:
        want = reference.row(name)
        of_pc = np.max(np.abs(pc.row(name) - want))
        as_printed, optimised = (
            np.max(np.abs(runs[program].rows[name] - want))
            for program in ("as_printed", "optimised")
        )
        assert as_printed <= of_pc, name
        assert optimised <= of_pc / 10, name


def test_as_printed_executes_at_least_the_published_operations_in_every_class(runs):
    names = {"float_of_int": "float_int", "saturate": "sat"}
    operations = Published.load().operations
    published = {names.get(name, name): count for name, count in operations.items()}
    assert published.keys() == runs["as_printed"].table1.keys()
    executed = runs["as_printed"].table1
    assert all(executed[name] >= count for name, count in published.items()), executed


def test_inverse_kinematics_as_printed_take_the_operations_of_the_printed_formulas(images):
    total: Counter[str] = Counter()
    for bundle in images["as_printed"]["sources"]:
        for entry in bundle:
            if entry["equation"] in ("7", "8", "9"):
                total.update(default_isa().operations[entry["op"]].counts)
    # Two products and sums more: x_p2 and x_p3 of (7) are subtracted in two parts.
    assert total == Counter(mul=123 + 2, add_sub=89 + 2, div=9, sqrt=12)


def test_every_operation_names_its_equation(images, program):
    for bundle in images[program]["sources"]:
        for entry in bundle:
            assert entry["equation"], f"line {entry['line']}: {entry['text']}"


def test_schedule_and_configuration_do_not_change_a_bit(
    robot, motion, runs, program, configuration
):
    path, counts = motion
    ticks = 40
    image = assemble(PROGRAMS[program], configuration=configuration).to_json()
    short = type(path).from_words(path.words()[:ticks])
    got = run_path(image, robot, short, counts[:ticks], exports=ERRORS)
    for name, values in got.rows.items():
        assert np.array_equal(values, runs[program].rows[name][:ticks]), name
    assert got.operations == runs[program].operations


def one_tick(iss: Iss, words: np.ndarray, counts: np.ndarray) -> RunResult:
    """A run with these set-points and encoder counts."""
    iss.set_inputs(dict(zip(SET_POINTS, words, strict=True)))
    iss.set_inputs({f"count{i + 1}": int(count) for i, count in enumerate(counts)})
    return iss.run()


def test_trace_holds_one_write_per_operation_and_changes_no_result(
    robot, motion, images, runs, program
):
    path, counts = motion
    iss = Iss(images[program], trace=True)
    iss.set_state(preset(images[program], robot, counts[0].tolist()))
    for tick in range(3):
        result = one_tick(iss, path.words()[tick], counts[tick])
        assert result.outputs == {name: runs[program].rows[name][tick] for name in OUTPUTS}
        assert sum(map(len, result.writes.values())) == sum(result.counts.values())
        assert result.writes["o3"] == [result.output_bits["tau4"]]


def test_outputs_saturate_at_the_limits_of_the_drives(robot, motion, images, program):
    path, counts = motion
    limits = dict(zip(OUTPUTS, robot.output_max, strict=True))
    for sign in (1, -1):
        iss = Iss(images[program])
        away = counts[0] - sign * np.array((40000, 40000, 40000, 9000, 9000))
        iss.set_state(preset(images[program], robot, away.tolist()))
        result = one_tick(iss, path.words()[0], away)
        assert result.fault is Fault.NONE
        assert result.outputs == {name: sign * limit for name, limit in limits.items()}


def test_integrators_saturate_at_their_bounds(robot, motion, images, program):
    path, counts = motion
    name = "s_c" if program == "as_printed" else "integral"
    for sign in (1, -1):
        iss = Iss(images[program])
        away = counts[0] - sign * np.array((400, 400, 400, 400, 400))
        iss.set_state(preset(images[program], robot, away.tolist()))
        bound = {}
        for axis in range(5):
            scale = 1.0 if program == "as_printed" else robot.K_I[axis]
            bound[f"{name}{axis + 1}"] = sign * float(np.float32(scale * robot.s_max[axis]))
        iss.set_state({key: 0.9999 * value for key, value in bound.items()})
        assert one_tick(iss, path.words()[0], away).fault is Fault.NONE
        assert {key: iss.state[key] for key in bound} == bound


def test_lengths_that_meet_nowhere_leave_the_safe_values(robot, motion, images, program):
    path, _ = motion
    short = np.array((1.6e6, 1.6e6, 1.6e6, 0, 0))  # 0.4 m legs on a circle of 0.5 m
    result = one_tick(Iss(images[program]), path.words()[0], short)
    assert result.fault is Fault.NOT_FINITE
    z = (robot.z_min + robot.z_max) / 2
    length = np.hypot(robot.R, z)
    mass = robot.m_p + 3 * (robot.m_s * (length - robot.l_c) - robot.mr_c) / length
    hold = float(np.float32(length * mass * robot.g / (3 * z)))
    assert result.outputs == dict(zip(OUTPUTS, (hold,) * 3 + (0.0, 0.0), strict=True))


def test_optimised_program_is_short(runs):
    """180 multiply-adds and 78 auxiliary operations fit 90 cycles of two pipes and one slot."""
    slots: Counter[bool] = Counter()
    for mnemonic, count in runs["optimised"].operations.items():
        slots[default_isa().operations[mnemonic].unit == "fma"] += count
    assert slots[True] <= 180 and slots[False] <= 78


def test_observers_cost_fifty_operations(runs):
    """Ten of each axis: three of the correction, one of the pull, one less of the speed's error."""
    more, less = (sum(runs[name].operations.values()) for name in ("observer", "optimised"))
    assert more - less == 50
