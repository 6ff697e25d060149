# SPDX-License-Identifier: Apache-2.0
"""The chain in closed loop: its plant against other models, RTL against the averaged inverters."""

from __future__ import annotations

import ctypes
from dataclasses import replace

import numpy as np
import pytest

from asip_asm.image import Image
from sim.bench.drive.averaged import AveragedPlant, at_joints, library, true_angles, true_zeros
from sim.bench.drive.chain import ORDER_FILTER
from sim.bench.drive.current_loop import rise_and_overshoot
from sim.bench.drive.draws import SEEDS, replay
from sim.bench.drive.friction_law import image
from sim.bench.drive.goals import DISTORTION, SAME_CURRENT
from sim.bench.drive.path import Chain
from sim.bench.drive.plant import Plant
from sim.bench.drive.recording import Recording
from sim.bench.drive.response import LARGE, analyse, averaged_responses, averaged_turn, harmonics
from sim.bench.drive.sample import BEFORE, SKIP, per_tick, same_currents
from sim.bench.drive.whole import FrictionController
from sim.bench.dual.moves import moves_of
from sim.laws.drive.current_law import Setting, gains
from sim.motion.gcode.interpreter import parse_file
from sim.motion.trajectory.exact_stop import MotionSettings, generate
from sim.motion.trajectory.program import AGH, set_points
from sim.robot import plant as rigid
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.robot.tracking import joint_path

ROBOT, DRIVES = Robot.load(), Drives.load()
SETTING = Setting(ROBOT.resolution)
SAME_IN_A_TICK = 0.01  # A, in the first ticks of a path


def test_mechanics__accelerations_are_those_of_the_rigid_body():
    random = np.random.default_rng(1)
    words = {f"angle{n}": 0.0 for n in range(5)}
    function = ctypes.CDLL(str(library(Plant(ROBOT, DRIVES), SETTING, words))).averaged_rates
    function.argtypes = [ctypes.c_void_p] * 5
    record, out = Plant(ROBOT, DRIVES).record(), np.zeros(5)
    smooth = replace(ROBOT, friction_legs=0.0, friction_table=0.0)
    for _ in range(20):
        q = np.array([0, 0, 0.6, 0, 0]) + random.uniform(-0.1, 0.1, 5)
        v, force = random.uniform(-1, 1, 5), random.uniform(-500, 500, 5)
        function(*(array.ctypes.data for array in (record, q, v, force, out)))
        want = (
            *rigid.tool_acceleration(smooth, tuple(q[:3]), tuple(v[:3]), tuple(force[:3])),
            *rigid.table_acceleration(smooth, q[3:], v[3:], force[3:]),
        )
        np.testing.assert_allclose(out, want, rtol=1e-12, atol=1e-11)


def test_averaged_inverter__step_of_the_current_with_dead_time():
    """All axes after 10 halves, brakes closed."""
    machine = AveragedPlant(Plant(ROBOT, DRIVES), SETTING, ROBOT.start)
    machine.brakes(0)
    orders = np.zeros((150, 5))
    orders[10:] = [0.03 * m.i_max * m.force_per_ampere for m in DRIVES.motors]
    found = machine.halves(orders)[:, 5:10]
    for n, motor in enumerate(DRIVES.motors):
        rise, overshoot = rise_and_overshoot(found[9:, n], SETTING.period)
        assert rise <= 100e-6 and overshoot <= 0.15
        assert found[-30:, n].mean() == pytest.approx(0.03 * motor.i_max, rel=0.02)


def chain(written: bool, program: str | Image) -> tuple[Chain, np.ndarray]:
    """Begun, with electrical angles written (the true ones) or aligned; the joints' path."""
    settings = MotionSettings(ROBOT)
    trajectory = generate(parse_file(AGH), settings)
    path = set_points(trajectory, 400)
    plant = Plant(ROBOT, DRIVES)
    at = (*path.position[0].tolist(), *path.table_position[0].tolist())
    angles = true_angles(plant, at_joints(plant, at)) if written else None
    machine = Chain(plant, path, moves_of(trajectory, settings), angles, program)
    machine.begin()
    return machine, joint_path(ROBOT, path)[0]


def test_chain__follows_from_encoder_edges_to_gate_edges():
    """Start-up, brakes open, 4 ms of the path, every clock; then a fault."""
    machine, desired = chain(True, "tracking_optimised")
    # Offsets of the currents, of 32 samples, within 2 counts (0.5 mA); brakes open, no trip.
    np.testing.assert_allclose(machine.zeros, true_zeros(machine.plant), atol=2)
    ticks = 40
    run = machine.advance(ticks)
    look = machine.system.look()
    assert look.released == 31 and look.shoot_through == 0
    error = run.joints - desired[:ticks]
    assert np.abs(error[:, :3]).max() < 2e-6 and np.abs(error[:, 3:]).max() < 5e-5
    resolution = np.array(ROBOT.resolution)
    assert (np.abs(run.counts * resolution - run.joints).max(axis=0) <= 0.6 * resolution).all()
    # The same commands on averaged inverters: the same currents. The record begins in the period
    # before, 11 half periods ahead.
    setting = replace(SETTING, order_filter=ORDER_FILTER)
    start = machine.plant, setting, machine.at, machine.angles, machine.zeros
    found = AveragedPlant(*start).halves(np.repeat(run.commands, 10, axis=0))
    means = np.stack([found[100 + 10 * k : 110 + 10 * k, 5:10].mean(0) for k in range(28)])
    rtl = np.stack([run.halves["i_q"][111 + 10 * k : 121 + 10 * k].mean(0) for k in range(28)])
    assert np.abs(means - rtl).max() < 0.03
    # And with the same motion; orders a control period late are seen.
    apart = same_currents(AveragedPlant(*start), run)
    assert np.abs(apart).max() < SAME_IN_A_TICK
    assert np.sqrt((apart**2).mean(axis=0)).max() < SAME_CURRENT
    # So does the RTL of the current loops once more, whatever the noise.
    none = [np.array(0)] * 3
    ran = run.joints, run.tool, run.commands, run.halves
    rtl = Recording(*ran, *none, machine.angles, machine.zeros, np.array(0))
    one, other = (replay(ROBOT, DRIVES, rtl, machine.at, ticks - 2, seed) for seed in SEEDS)
    same = per_tick(run.halves["i_q"][BEFORE:][: 10 * len(one)])
    assert np.abs(one - same)[SKIP:].max() < SAME_IN_A_TICK
    assert 0 < np.abs(one - other)[SKIP:].max() < SAME_IN_A_TICK
    late = replace(run, commands=np.roll(run.commands, 1, axis=0))
    apart = same_currents(AveragedPlant(*start), late)[:, :3]
    assert (np.abs(apart).max(axis=0) > SAME_IN_A_TICK).all()
    assert (np.sqrt((apart**2).mean(axis=0)) > SAME_CURRENT).all()
    # The bus falls: all gates off, all brakes closed, and the machine stays.
    machine.system.fault(300.0)
    machine.system.clock(20)
    status = machine.system.status()
    assert status["trip"] == 31 and status["undervoltage"] == 1
    assert machine.system.look().released == 0


@pytest.mark.full
def test_chain__from_its_own_alignment_with_friction_in_the_law():
    """Alignment, brakes open, 4 ms of the path; commands are those of the law, bit for bit."""
    machine, desired = chain(False, image(ROBOT, DRIVES, "feed-forward"))
    off = machine.angles - true_angles(machine.plant, at_joints(machine.plant, machine.at))
    off = (off + np.pi) % (2 * np.pi) - np.pi
    assert np.degrees(np.abs(off)).max() < 3.0
    ticks = 40
    run = machine.advance(ticks)
    # Opened brakes give the weight, and bristles that the alignment has bent, to the law.
    error = np.abs(run.joints - desired[:ticks])
    inertia = (ROBOT.m_s,) * 3 + (ROBOT.J_44, ROBOT.J_55)
    for n, friction in enumerate(DRIVES.friction):
        bent = friction.static / (ROBOT.K_P[n] * inertia[n])
        assert error[:, n].max() < bent + (4e-6 if n < 3 else 3 * ROBOT.resolution[n])
    law = FrictionController(ROBOT, DRIVES, "feed-forward")
    law.prime(machine.path.words()[0], machine.primed)
    words = machine.controller.set_points[:ticks]
    wanted = [law.step(*row).outputs[0] for row in zip(words, run.counts, strict=True)]
    wanted = np.array(wanted, dtype=np.float32)
    np.testing.assert_array_equal(wanted.view(np.uint32), run.commands.view(np.uint32))


def test_current_loops__bandwidth_and_margin_on_averaged_inverters():
    for loop in averaged_responses(ROBOT, DRIVES, SETTING):
        assert loop.bandwidth >= 5000 and loop.margin >= 45


def test_current_loops__dead_time_with_noise_and_errors_of_the_sensing():
    """Phases a and b read by 1 + g and 1 - g of their currents (legs 1 and 3): a vector of length I
    that turns is read as one more that turns back, of 2/sqrt(3) g I, and the loop, to which that
    is still, makes its opposite."""
    found = averaged_turn(ROBOT, DRIVES, SETTING)
    without = averaged_turn(ROBOT, DRIVES, replace(SETTING, compensation=0.0))
    ratio = harmonics(without, SETTING.period) / harmonics(found, SETTING.period)
    assert (ratio >= DISTORTION).all(), ratio
    lines = np.abs(np.fft.fft(found, axis=0)) / len(found)
    error = 2 / np.sqrt(3) * DRIVES.current_gain_error
    # The compensation takes the sign of what is read, so an angle of `error` it has the wrong one:
    # a square wave against the loop's gain. And noise, as on lines that nothing makes.
    lost = (DRIVES.dead_time + DRIVES.delay_on - DRIVES.delay_off) * DRIVES.f_pwm * DRIVES.U_dc
    noise = np.sqrt((lines[[k for k in range(20, 400) if k % 6]] ** 2).mean(axis=0))
    for n, motor in enumerate(DRIVES.motors):
        wrong = 4 / np.pi * (lost + DRIVES.drop) * error / gains(motor, SETTING.period)[0]
        want = error * LARGE * motor.i_max
        assert lines[-2, n] == pytest.approx(want, rel=0, abs=wrong + 3 * noise[n])


def test_margin__of_a_loop_that_is_known():
    """An integrator with a crossover of 5 kHz after a delay of 15 us: 90 - 27 degrees."""
    frequency = np.linspace(200, 20000, 100)
    s = 2j * np.pi * frequency
    loop = 2 * np.pi * 5000 / s * np.exp(-15e-6 * s)
    found = analyse(frequency, loop / (1 + loop))
    assert found.margin == pytest.approx(90 - 360 * 5000 * 15e-6, abs=0.5)
