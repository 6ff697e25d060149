# SPDX-License-Identifier: Apache-2.0
"""The current loops as a program: cycles, bits, words of the link, a motor in closed loop."""

from __future__ import annotations

import functools
import math
from pathlib import Path

import numpy as np
import pytest

from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.program import Built, build
from asip_asm.project import BUILD
from sim.core import Core
from sim.model.drives import Drives
from sim.model.parameters import Robot
from sim.prove_program import prove
from sim.servo.current_law import AXES, DELAY, HALF_PERIOD, MAGIC, Setting, current_law, gains
from sim.servo.motor import Windings, phase_currents, space_vector

DRIVES = Drives.load()
SETTING = Setting(Robot.load().resolution)
CYCLES = {"small": 700, "fast": 220}
SETTLED = 200  # periods before the step: the speed is filtered, the back EMF met


@functools.cache
def program(configuration: str, axes: tuple[int, ...] = AXES) -> Built:
    options = Options(configuration=configuration, reassociate=True, reciprocal=True)
    name = f"{configuration}_{len(axes)}"
    path = BUILD / "servo" / f"{name}.s"
    path.parent.mkdir(parents=True, exist_ok=True)
    return build(compile_law(current_law(DRIVES, SETTING, axes), options), Path(path))


@pytest.mark.parametrize("configuration", CYCLES)
def test_five_axes__within_their_cycles(configuration):
    assert program(configuration).cycles <= CYCLES[configuration]


def test_words__stand_where_the_link_writes_and_reads_them():
    image = program("small").image
    at = {entry.name: entry.index for entry in image.inputs}
    for n in AXES:
        assert [at[f"{name}{n}"] for name in ("q", "ia", "ib", "age")] == list(
            range(4 * n, 4 * n + 4)
        )
    assert at["bus"] == 20
    outputs = {entry.name: entry.index for entry in image.outputs}
    assert [outputs[f"pwm{n}{phase}"] for n in AXES for phase in "abc"] == list(range(15))


@pytest.mark.parametrize("configuration", CYCLES)
def test_proof__bits_on_the_core_and_distance_from_double_precision(configuration):
    built = program(configuration)
    proof = prove(built.compiled, built.image, count=500)
    assert proof.passed, proof


def loop(axis: int, force: float, periods: int, speed: float = 0.0) -> np.ndarray:
    """(i_d, i_q) at the end of each period [A]: the program on the instruction-set model, an ideal
    inverter that holds the mean voltage ordered, a rotor at constant speed [rad or m per s].
    """
    motor = DRIVES.motors[axis]
    period = SETTING.period
    setting = Setting(SETTING.resolution, compensation=0.0)
    options = Options(reassociate=True, reciprocal=True)
    path = BUILD / "servo" / f"loop_{axis}.s"
    path.parent.mkdir(parents=True, exist_ok=True)
    built = build(compile_law(current_law(DRIVES, setting, (axis,)), options), path)
    scale = DRIVES.current_scale * setting.ampere_per_count
    windings, travel, found = Windings(motor), 0.0, []
    waiting = (0.0, 0.0)  # in force in the next period
    with Core(built.image, backend="iss") as core:
        for number in range(SETTLED + periods):
            angle = motor.wave * travel
            a, b, _ = phase_currents(windings.i_d, windings.i_q, angle)
            words = {
                f"q{axis}": round(travel / setting.resolution[axis]),
                f"ia{axis}": round(a / scale),
                f"ib{axis}": round(b / scale),
                f"age{axis}": 0,
                "bus": round(DRIVES.U_dc / setting.bus_scale),
            }
            values = {name: MAGIC + word for name, word in words.items()}
            order = force if number >= SETTLED else 0.0
            out = core.tick(**values, **{f"force{axis}": order})
            duties = [(out[f"pwm{axis}{phase}"] - MAGIC) / HALF_PERIOD for phase in "abc"]
            volts = space_vector(*(DRIVES.U_dc * duty for duty in duties))
            windings.advance(*waiting, angle, motor.wave * speed, period)
            waiting = volts
            travel += speed * period
            found.append((windings.i_d, windings.i_q))
    return np.array(found[SETTLED:])


@pytest.mark.parametrize(("axis", "speed"), [(0, 0.0), (0, 0.5), (3, 0.0), (4, 1.5)])
def test_step_of_current__rises_in_100_us_with_little_overshoot(axis, speed):
    motor = DRIVES.motors[axis]
    wanted = 0.03 * motor.i_max  # beyond 5 % the bus voltage over L limits the rise
    found = loop(axis, wanted * motor.force_per_ampere, 300, speed)
    i_q = found[:, 1] - found[0, 1]
    final = i_q[-50:].mean()
    assert found[-50:, 1].mean() == pytest.approx(wanted, rel=0.02)
    rise = np.argmax(i_q > 0.9 * final) - np.argmax(i_q > 0.1 * final)
    assert rise * SETTING.period <= 100e-6
    assert i_q.max() <= 1.15 * final
    assert np.abs(found[-50:, 0]).max() < 0.1 * wanted


def test_gains__give_the_magnitude_optimum():
    """K_p / (s L) with 1.5 periods of delay crosses at 1 / (2 delay), 61 degrees of margin."""
    motor = DRIVES.motors[0]
    k_d, _, k_i = gains(motor, 1e-5)
    crossover = k_d / motor.L_d
    assert crossover == pytest.approx(1 / (2 * DELAY * 1e-5))
    margin = 90 - math.degrees(crossover * DELAY * 1e-5)
    assert margin > 60 and k_i == pytest.approx(k_d * motor.R / motor.L_d * 1e-5)
