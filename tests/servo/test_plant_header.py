# SPDX-License-Identifier: Apache-2.0
"""The plant in C++ (plant.h) against its models in Python, which test_plant.py holds to Radau."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np
import pytest

from asip_asm.project import ROOT
from sim.harness import runtime
from sim.model.drives import Drives
from sim.model.parameters import Robot
from sim.servo import lugre
from sim.servo.motor import Windings, phase_currents
from sim.servo.plant import Plant

DRIVES = Drives.load()
RECORD = Plant(Robot.load(), DRIVES).record()
AXES = {"leg": 0, "tilt": 3, "rotation": 4}
PER_AXIS = pytest.mark.parametrize("axis", AXES.values(), ids=AXES)


@pytest.fixture(scope="module")
def header(tmp_path_factory) -> ctypes.CDLL:
    folder = tmp_path_factory.mktemp("plant")
    source, library = Path(__file__).with_name("plant_header.cpp"), folder / "libplant.so"
    flags = ["-std=c++17", "-O2", "-fPIC", "-shared", f"-I{ROOT / 'sim/servo'}"]
    runtime.run([runtime.compiler(), *flags, source, "-o", library], folder)
    found, number, pointer = ctypes.CDLL(str(library)), ctypes.c_double, ctypes.c_void_p
    found.windings_advance.argtypes = [pointer, pointer, *[number] * 5]
    found.windings_force.argtypes = [pointer, pointer, number, pointer]
    found.friction_step.argtypes = [pointer, pointer, number, number]
    found.windings_force.restype = found.friction_step.restype = number
    return found


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
