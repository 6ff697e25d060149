# SPDX-License-Identifier: Apache-2.0
"""Flight of the quadrotor under its MPC: a figure eight that is cut by a box, and a gust.

The plant is the nonlinear one of `sim.laws.quadrotor`, in double precision, 1 ms steps. The
reference of y leaves the box. The core's program and the solver in double precision fly alone, each
with its own plant.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.model.mpc_problem import Problem, load_problem
from sim.core.api import Core
from sim.laws.mpc_reference import Reference
from sim.laws.quadrotor import GRAVITY, MASS, RATE, Quadrotor

PROBLEM = Path(__file__).with_name("quadrotor_mpc.toml")
HOVER = MASS * GRAVITY / 4  # N of a rotor
SIZE, PERIOD = (1.5, 1.0), 10.0  # m, s of the figure eight
BEGIN, SECONDS = 1.0, 12.0  # s
GUST, FROM, TO = (0.6, 0.6, 0.0), 6.0, 6.5  # N, s
Controller = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class Flight:
    """Places (ticks, 3) [m]; thrusts (ticks, 4) [N] less hover; distance from the reference where
    it is inside the box, root mean square [m]; largest excess over the box of y [m].
    """

    places: NDArray[np.float64]
    thrusts: NDArray[np.float64]
    error: float
    beyond: float


def quadrotor_problem() -> Problem:
    """The problem that is shown."""
    return load_problem(PROBLEM)


def eight(seconds: float) -> NDArray[np.float64]:
    """Reference of the state (12,); at rest until `BEGIN`."""
    wanted = np.zeros(12)
    t = seconds - BEGIN
    if t > 0:
        w = 2 * math.pi / PERIOD
        wanted[0], wanted[1] = SIZE[0] * math.sin(w * t), SIZE[1] * math.sin(2 * w * t)
        wanted[6], wanted[7] = SIZE[0] * w * math.cos(w * t), 2 * SIZE[1] * w * math.cos(2 * w * t)
    return wanted


def fly(problem: Problem, controller: Controller, seconds: float = SECONDS) -> Flight:
    """The flight under a controller of measured state and reference of the horizon's end."""
    plant = Quadrotor()
    steps = round(problem.sample_time * RATE)
    places, thrusts, wanted = [], [], []
    for tick in range(round(seconds / problem.sample_time)):
        now = tick * problem.sample_time
        ahead = eight(now + problem.horizon * problem.sample_time)
        u = controller(state_of(plant), ahead)
        places.append(plant.q[:3].copy())
        thrusts.append(u)
        wanted.append(eight(now)[:3])
        outputs = {f"rotor{i}": HOVER + each for i, each in enumerate(u)}
        for step in range(steps):
            plant.step(outputs)
            if FROM <= now + step / RATE < TO:
                rotation = pin.Quaternion(plant.q[3:]).toRotationMatrix()
                plant.v[:3] += rotation.T @ np.array(GUST) / MASS / RATE
    at, reference = np.array(places), np.array(wanted)
    low, high = problem.state_box[:, :3]
    inside = ((reference >= low) & (reference <= high)).all(axis=1)
    error = float(np.sqrt(((at - reference)[inside] ** 2).sum(axis=1).mean()))
    beyond = float(np.maximum(low - at, at - high)[:, 1].max())
    return Flight(at, np.array(thrusts), error, max(0.0, beyond))


def state_of(plant: Quadrotor) -> NDArray[np.float64]:
    """Place, attitude (roll, pitch, yaw), speed in the world, rates of the body (12,)."""
    rotation = pin.Quaternion(plant.q[3:]).toRotationMatrix()
    attitude = pin.rpy.matrixToRpy(rotation)
    return np.concatenate((plant.q[:3], attitude, rotation @ plant.v[:3], plant.v[3:]))


def fly_core(problem: Problem, image: Image, backend: str = "rtl") -> tuple[Flight, set[int]]:
    """The flight under the program, and the cycles of its ticks. Raises CoreFault."""
    cycles: set[int] = set()
    with Core(image, backend=backend) as core:

        def controller(x: NDArray[np.float64], ahead: NDArray[np.float64]) -> NDArray[np.float64]:
            values = dict(zip(problem.states, x, strict=True))
            values |= {f"{n}_ref": v for n, v in zip(problem.states, ahead, strict=True)}
            found = core.tick(**{name: float(np.float32(v)) for name, v in values.items()})
            if core.cycles is not None:
                cycles.add(core.cycles)
            return np.array([found[name] for name in problem.inputs])

        return fly(problem, controller), cycles


def fly_reference(problem: Problem) -> Flight:
    """The flight under the solver in double precision."""
    solver = Reference(problem, 1)
    return fly(problem, lambda x, ahead: solver.tick(x[None], ahead[None])["u"][0])
