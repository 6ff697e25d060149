# SPDX-License-Identifier: Apache-2.0
"""Motor, inverter and friction against Radau on the continuous equations, and closed forms.

Motor and friction are models in Python; the plant in C++ (plant.h) is compared with them.
"""

from __future__ import annotations

import ctypes
import math
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from asip_asm.isa import default_isa
from asip_asm.project import ROOT
from sim.bench.drive import lugre
from sim.bench.drive.motor import Windings, phase_currents, space_vector
from sim.bench.drive.plant import Plant
from sim.laws.drive import clocks
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.robot.parameters import ParameterError, Robot
from sim.rtl import runtime
from sim.rtl.gen.drive_regmap import REGMAP

DRIVES = Drives.load()
RECORD = Plant(Robot.load(), DRIVES).record()
AXES = {"leg": 0, "tilt": 3, "rotation": 4}
PER_AXIS = pytest.mark.parametrize("axis", AXES.values(), ids=AXES)


@pytest.fixture(scope="module")
def header(tmp_path_factory) -> ctypes.CDLL:
    """Functions of plant.h (plant_header.cpp)."""
    folder = tmp_path_factory.mktemp("plant")
    source, library = Path(__file__).with_name("plant_header.cpp"), folder / "libplant.so"
    flags = ["-std=c++17", "-O2", "-fPIC", "-shared", f"-I{ROOT / 'sim/bench/drive'}"]
    runtime.run([runtime.compiler(), *flags, source, "-o", library], folder)
    found, number, pointer = ctypes.CDLL(str(library)), ctypes.c_double, ctypes.c_void_p
    found.windings_advance.argtypes = [pointer, pointer, *[number] * 5]
    found.windings_force.argtypes = [pointer, pointer, number, pointer]
    found.friction_step.argtypes = [pointer, pointer, number, number]
    found.terminal_voltage.argtypes = [pointer, *[ctypes.c_int] * 2, *[number] * 3]
    for function in (found.windings_force, found.friction_step, found.terminal_voltage):
        function.restype = number
    return found


@PER_AXIS
def test_locked_rotor__step_is_the_exponential(axis):
    motor = DRIVES.motors[axis]
    windings = Windings(motor)
    for n in range(1, 200):
        windings.advance(30.0, 0.0, 0.0, 0.0, 7.3e-6)
        want = 30.0 / motor.R * -math.expm1(-motor.R / motor.L_d * n * 7.3e-6)
        assert windings.i_d == pytest.approx(want, rel=1e-11) and windings.i_q == 0


@PER_AXIS
def test_turning_rotor_with_switched_voltages__as_radau(axis):
    motor = DRIVES.motors[axis]
    random = np.random.default_rng(axis)
    speed, windings, angle, now = 400.0, Windings(motor, 1.0, -2.0), 0.3, 0.0
    state = np.array([1.0, -2.0])
    for _ in range(60):
        alpha, beta = random.uniform(-300, 300, 2)
        time = random.uniform(1e-7, 2e-5)

        def slope(t, i, alpha=alpha, beta=beta, start=now):
            e = 0.3 + speed * (start + t)
            u_d = alpha * math.cos(e) + beta * math.sin(e)
            u_q = beta * math.cos(e) - alpha * math.sin(e)
            d = (u_d - motor.R * i[0] + speed * motor.L_q * i[1]) / motor.L_d
            q = (u_q - motor.R * i[1] - speed * (motor.L_d * i[0] + motor.psi)) / motor.L_q
            return [d, q]

        done = solve_ivp(slope, (0, time), state, method="Radau", rtol=1e-11, atol=1e-12)
        state = done.y[:, -1]
        windings.advance(alpha, beta, angle + speed * now, speed, time)
        now += time
        assert (windings.i_d, windings.i_q) == pytest.approx(tuple(state), rel=1e-8, abs=1e-9)


def test_steady_speed__currents_of_the_voltage_equations():
    motor = DRIVES.motors[4]
    speed, wanted = 50.0, (-0.7, 3.0)
    u_d = motor.R * wanted[0] - speed * motor.L_q * wanted[1]
    u_q = motor.R * wanted[1] + speed * (motor.L_d * wanted[0] + motor.psi)
    windings, angle = Windings(motor), 0.0
    for _ in range(4000):  # the voltage turns with the rotor, in steps with their middle on it
        middle = angle + speed * 2e-5 / 2
        c, s = math.cos(middle), math.sin(middle)
        windings.advance(u_d * c - u_q * s, u_d * s + u_q * c, angle, speed, 2e-5)
        angle += speed * 2e-5
    assert (windings.i_d, windings.i_q) == pytest.approx(wanted, rel=1e-4)


def test_force__3_2_of_the_flux_times_the_current_and_reluctance():
    motor = DRIVES.motors[0]
    assert motor.force(0, 1) == pytest.approx(1.5 * 2 * math.pi / 0.032 * 0.51)
    reluctance = motor.force(2.0, 3.0) - motor.force(0.0, 3.0)
    assert reluctance == pytest.approx(1.5 * motor.wave * (17e-3 - 19e-3) * 6)


def test_phase_currents__sum_to_nothing_and_turn_with_the_angle():
    for angle in np.linspace(0, 7, 50):
        a, b, c = phase_currents(2.0, -1.0, angle)
        assert a + b + c == pytest.approx(0, abs=1e-12)
        shifted = phase_currents(2.0, -1.0, angle - 2 * math.pi / 3)
        assert b == pytest.approx(shifted[0], abs=1e-12)


def terminal(
    header: ctypes.CDLL, high: bool, low: bool, current: float, time: float = 1e-9
) -> float:
    """Voltage of a phase whose switches conduct like this for a time."""
    inductance = DRIVES.motors[0].L_q
    return header.terminal_voltage(RECORD.ctypes.data, high, low, current, inductance, time)


def test_leg__diodes_carry_against_the_current_in_the_dead_time(header):
    """A diode has the drop of a switch, and its slope."""
    drop = DRIVES.drop + DRIVES.drop_resistance * 2
    assert terminal(header, True, False, 2.0) == 280 - drop
    assert terminal(header, False, True, 2.0) == -280 - drop
    assert terminal(header, False, False, 2.0) == -280 - drop
    assert terminal(header, False, False, -2.0) == 280 + drop
    assert terminal(header, False, False, 0.0) == 0
    # In a millisecond the current of 2 A is gone: what it takes is less than the bus.
    taken = 2.0 * DRIVES.motors[0].L_q / 1e-3
    assert terminal(header, False, False, 2.0, time=1e-3) == pytest.approx(-taken)


@pytest.mark.parametrize("current", [3.0, -3.0])
def test_mean_voltage__is_that_of_the_edges_over_a_period(header, current):
    """Twice a period the dead time adds to one side what the current's sign says."""
    period, step = 1 / DRIVES.f_pwm, 1e-9
    time = np.arange(0, 2 * period, step)
    place = np.abs((time / period) % 1 - 0.5) * 2  # triangle, 1 at the ends
    duty = 0.37
    ordered = place < duty
    last = np.full(len(time), -1.0)
    for at in np.flatnonzero(np.diff(ordered)) + 1:
        last[at:] = time[at]
    ready = time - last >= DRIVES.dead_time
    switches = []
    for gate in (ordered & ready, ~ordered & ready):
        switch = gate.copy()
        for at in np.flatnonzero(np.diff(gate)) + 1:
            delay = DRIVES.delay_on if gate[at] else DRIVES.delay_off
            switch[at : at + round(delay / step)] = not gate[at]
        switches.append(switch[len(time) // 2 :].tolist())
    values = [terminal(header, *pair, current) for pair in zip(*switches, strict=True)]
    lost = (DRIVES.dead_time + DRIVES.delay_on - DRIVES.delay_off) * DRIVES.f_pwm * DRIVES.U_dc
    want = (duty - 0.5) * DRIVES.U_dc - math.copysign(lost + DRIVES.drop, current)
    want -= DRIVES.drop_resistance * current
    assert np.mean(values) == pytest.approx(want, abs=0.3)
    assert space_vector(5.0, 5.0, 5.0) == (0, 0)


@pytest.mark.parametrize("axis", ["leg", "rotation"])
def test_friction__as_radau_over_reversals(axis):
    friction = DRIVES.friction[AXES[axis]]
    reach, period, step = 20 * friction.speed, 0.02, 1e-6

    def speed(t: float) -> float:
        return reach * math.sin(2 * math.pi * t / period)

    def slope(t, z):
        v = speed(t)
        return [v - friction.stiffness * abs(v) * z[0] / lugre.stribeck(friction, v)]

    steps = round(1.2 * period / step)
    ends = step * np.arange(1, steps + 1)
    done = solve_ivp(
        slope, (0, ends[-1]), [0.0], method="Radau", rtol=1e-8, atol=1e-16, t_eval=ends[::50]
    )
    z, found, forces = 0.0, [], []
    for n in range(steps):
        z, force = lugre.step(friction, z, speed((n + 0.5) * step), step)
        found.append(z)
        forces.append(force)
    size = friction.static / friction.stiffness
    np.testing.assert_allclose(found[::50], done.y[0], atol=2e-3 * size)
    z, v = done.y[0], np.array([speed(t) for t in done.t])
    bend = v - friction.stiffness * np.abs(v) * z / [lugre.stribeck(friction, each) for each in v]
    want = friction.stiffness * z + friction.damping * bend + friction.viscous * v
    np.testing.assert_allclose(forces[::50], want, atol=0.02 * friction.static)


def test_friction__long_step_ends_at_the_steady_force_and_rest_holds():
    friction = DRIVES.friction[0]
    for v in (0.3, -0.3, 1e-4):
        z, _ = lugre.step(friction, 0.0, v, 10.0)
        _, force = lugre.step(friction, z, v, 1e-5)
        assert force == pytest.approx(lugre.steady(friction, v), rel=1e-9)
    held, force = lugre.step(friction, 1e-6, 0.0, 1.0)
    assert held == 1e-6 and force == friction.stiffness * 1e-6


def test_parameters__of_the_file_reach_motor_and_friction():
    changed = replace(DRIVES, psi_tilt=0.5, lugre_static_legs=9.0)
    assert changed.motors[3].psi == 0.5 and changed.friction[1].static == 9.0
    assert changed.motors[3].force_per_ampere == pytest.approx(1.5 * 22 * 0.5)


# -------------------------------------------------------------------- the plant in C++


def parameters(axis: int) -> np.ndarray:
    """`struct Axis` of an axis."""
    return RECORD["axis"][axis : axis + 1].copy()


@PER_AXIS
def test_windings__currents_force_and_phases(header, axis):
    random, record = np.random.default_rng(axis), parameters(axis)
    motor = DRIVES.motors[axis]
    model, currents, phases = Windings(motor, 1.0, -2.0), np.array([1.0, -2.0]), np.zeros(3)
    for _ in range(300):
        alpha, beta = random.uniform(-370, 370, 2)
        angle, speed = random.uniform(-np.pi, np.pi), random.uniform(-600, 600)
        time = float(np.exp(random.uniform(np.log(1e-9), np.log(2e-5))))
        given = (alpha, beta, angle, speed, time)
        header.windings_advance(record.ctypes.data, currents.ctypes.data, *given)
        model.advance(*given)
        assert tuple(currents) == pytest.approx((model.i_d, model.i_q), rel=1e-9, abs=1e-12)
        force = header.windings_force(
            record.ctypes.data, currents.ctypes.data, angle, phases.ctypes.data
        )
        assert force == pytest.approx(motor.force(*currents), rel=1e-12, abs=1e-12)
        assert tuple(phases) == pytest.approx(phase_currents(*currents, angle), abs=1e-12)


@PER_AXIS
def test_friction__deflection_and_force(header, axis):
    """Speeds from creeping to fast, both ways, and rest; steps from a nanosecond to a second."""
    random, record = np.random.default_rng(axis), parameters(axis)
    friction, model, z = DRIVES.friction[axis], 0.0, np.zeros(1)
    signs, sizes = random.choice([-1, 0, 1], 500), np.exp(random.uniform(-14, 3, 500))
    for speed in signs * sizes * friction.speed:
        time = float(np.exp(random.uniform(np.log(1e-9), 0.0)))
        force = header.friction_step(record.ctypes.data, z.ctypes.data, speed, time)
        model, want = lugre.step(friction, model, float(speed), time)
        assert z[0] == pytest.approx(model, rel=1e-9, abs=1e-15)
        assert force == pytest.approx(want, rel=1e-9, abs=1e-9 * friction.static)


def test_coulomb_friction__one_entry_of_the_file__acts_in_both_plants():
    names = {"friction_legs": 9.0, "friction_table": 0.6}
    robot, drives = replace(Robot.load(), **names), replace(DRIVES, **names)
    assert Plant(robot, drives).record()["axis"]["coulomb"].tolist() == [9.0] * 3 + [0.6] * 2
    assert {"friction_legs", "friction_table"} <= {field.name for field in fields(Drives)}
    with pytest.raises(
        ParameterError, match=r"^lugre_static_table = 0.8 N m: must be >= friction_t"
    ):
        replace(DRIVES, friction_table=0.81)


def test_clock_and_half_period__have_the_registers_and_the_instruction_sets_values():
    assert clocks.HALF_PERIOD == REGMAP.registers["PWM"].reset
    assert clocks.CLOCK * default_isa().clock_mhz == pytest.approx(1e-6)
    assert Setting(Robot.load().resolution).period == clocks.HALF_PERIOD * clocks.CLOCK
    numbers = re.compile(r"\b(1250|8e-0?9|1e-0?5)\b")
    for file in sorted((ROOT / "sim/bench/drive").glob("*")):
        if file.suffix in (".py", ".cpp", ".h"):
            assert not numbers.search(file.read_text(encoding="utf-8")), file.name
