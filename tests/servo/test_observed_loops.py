# SPDX-License-Identifier: Apache-2.0
"""Current loops with a disturbance observer: cycles, bits and bounds, and a load on an axis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from asip_asm.model.program import Built
from sim.bench.drive.current_loop import loop_program
from sim.bench.drive.load_step import load_step
from sim.bench.observer_goals import LASTING, LOOPS
from sim.laws.closed_loop import DoubleLaw
from sim.laws.drive.current_law import MAGIC, OBSERVER, current_law, observed
from sim.laws.prove_program import prove
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

DRIVES = Drives.load()
SETTING = observed(Robot.load())


@pytest.fixture(scope="module", params=LOOPS)
def built(request) -> Built:
    return loop_program(DRIVES, SETTING, request.param)


def test_five_loops__have_their_cycles_bits_and_bounds(built):
    assert built.cycles <= LOOPS[built.image.configuration]
    proof = prove(built.compiled, built.image, count=200)
    assert proof.bits_equal and not proof.unbounded and proof.worst_fraction_of_bound < 1, proof


def test_observer__finds_a_constant_load_with_its_bandwidth():
    """The motor accelerates by its force less the load. The force passes one lag, what it
    accelerates two.
    """
    axis, load, force = 0, 150.0, 400.0
    motor, mass = DRIVES.motors[axis], SETTING.moved[axis]
    law = DoubleLaw(current_law(DRIVES, SETTING, [axis]))
    scale = DRIVES.current_scale * SETTING.ampere_per_count
    i_q = force / motor.force_per_ampere
    travel = speed = 0.0
    found = []
    for _ in range(2000):
        speed += SETTING.period * (force - load) / mass
        travel += SETTING.period * speed
        angle = motor.wave * travel
        words = {
            f"q{axis}": travel / SETTING.resolution[axis],  # not rounded: the law alone
            f"ia{axis}": -i_q * np.sin(angle) / scale,
            f"ib{axis}": -i_q * np.sin(angle - 2 * np.pi / 3) / scale,
            f"age{axis}": 0.0,
            "bus": DRIVES.U_dc / SETTING.bus_scale,
        }
        law.tick({k: MAGIC + v for k, v in words.items()} | {f"force{axis}": 0.0})
        found.append(law.state[f"low{axis}"] - _push(law, axis))
    settled = np.array(found)
    time = SETTING.period * np.arange(len(found))
    late = OBSERVER * time
    want = force * -np.expm1(-late) - (force - load) * (1 - (1 + late) * np.exp(-late))
    assert np.abs(settled - want)[100:].max() < 0.05 * load
    assert abs(settled[-1] - load) < 0.05 * load


def _push(law: DoubleLaw, axis: int) -> float:
    gain = OBSERVER**2 * SETTING.moved[axis] * SETTING.resolution[axis]
    return gain * law.state[f"lag{axis}"]


def test_load__displaces_an_axis_for_a_while_alone(tmp_path):
    plain = replace(SETTING, observer=(0.0,) * 5)
    mass = SETTING.moved[0]
    with_it, without = (load_step(DRIVES, each, 0, mass) for each in (SETTING, plain))
    assert without.lasting > 50e-6
    assert 100 * with_it.lasting < LASTING * without.lasting
    assert with_it.peak < without.peak and len(with_it.cycles) == 1
