# SPDX-License-Identifier: Apache-2.0
"""Landing of a rocket under its MPC: a point mass that burns fuel, in wind, with a thrust cone.

The plant is nonlinear, in double precision, 1 ms steps: gravity, quadratic drag against the wind
that grows with height, a gust, an engine that follows its order with a lag, and a mass that thrust
takes away. The controller orders thrust by mass less that of hover. The host multiplies it by the
mass that it estimates, which is heavier than the true one. The first tick begins from a plan of the
host: the references of the horizon. The core's program and the solver in double precision land
alone, each with its own plant.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.model.mpc_problem import Problem, load_problem
from asip_asm.model.mpc_warm import warm_words
from sim.core.api import Core
from sim.laws.mpc_reference import Reference

PROBLEM = Path(__file__).with_name("rocket_mpc.toml")
GRAVITY = 9.81  # m/s^2
STEP = 1e-3  # s of the plant
MASS, HEAVIER = 1200.0, 1.02  # kg at the start; the estimate by it
EXHAUST = 2500.0  # m/s
DRAG = 2.0  # kg/m: force by the square of the speed through the air
LAG = 0.06  # s of the engine
WIND, HEIGHT = (2.0, -1.0), 20.0  # m/s at this height [m]
GUST, FROM, TO = (8.0, -6.0), 5.0, 7.0  # m/s more, s
START = (30.0, -18.0, 40.0, -3.0, 2.0, -4.0)  # m, m/s
BESIDE = (-7.0, 5.0)  # m from the start to that of the reference
OVER, DOWN = 7.0, 11.0  # s until the reference is over the pad, and on it
SINK = 0.4  # m/s of the reference on the pad
LONGEST = 25.0  # s
Real = NDArray[np.float64]
Controller = Callable[[Real, Real], Real]


@dataclass(frozen=True)
class Landing:
    """Places and speeds (ticks, 6) [m, m/s]; inputs (ticks, 3) [m/s^2]. At touch-down: time [s],
    distance from the pad's middle [m], sink and horizontal speed [m/s]. cone: largest excess of an
    input over the thrust cone, by its largest radius; held: share of ticks at the cone's edge.
    """

    states: Real
    inputs: Real
    time: float
    miss: float
    sink: float
    drift: float
    cone: float
    held: float


def rocket_problem() -> Problem:
    """The problem that is shown."""
    return load_problem(PROBLEM)


def descent(seconds: float) -> Real:
    """Reference of the state (6,): cubics from the start, over the pad and then onto it."""
    wanted = np.zeros(6)
    for axis, (end, speed) in enumerate(((OVER, 0.0), (OVER, 0.0), (DOWN, -SINK))):
        place, first = START[axis] + (*BESIDE, 0.0)[axis], START[3 + axis]
        if seconds >= end:
            wanted[axis], wanted[3 + axis] = speed * (seconds - end), speed
            continue
        s = seconds / end
        wanted[axis] = (
            (1 + 2 * s) * (1 - s) ** 2 * place
            + s * (1 - s) ** 2 * end * first
            + s * s * (s - 1) * end * speed
        )
        wanted[3 + axis] = (
            6 * s * (s - 1) * place / end + (1 - s) * (1 - 3 * s) * first + s * (3 * s - 2) * speed
        )
    return wanted


def wind(height: float, seconds: float) -> Real:
    """Speed of the air (3,) [m/s]."""
    share = max(0.0, height) / HEIGHT
    found = np.array([*WIND, 0.0]) * share
    if FROM <= seconds < TO:
        found[:2] += GUST
    return found


def land(problem: Problem, controller: Controller) -> Landing:
    """The landing under a controller of measured state and reference of the horizon's end. Raises
    RuntimeError if the rocket does not come down.
    """
    state, mass, thrust = np.array(START), MASS, np.array([0.0, 0.0, MASS * GRAVITY])
    estimate = MASS * HEAVIER
    steps = round(problem.sample_time / STEP)
    states, inputs = [], []
    cone = problem.cone
    assert cone is not None
    for tick in range(round(LONGEST / problem.sample_time)):
        now = tick * problem.sample_time
        u = controller(state, descent(now + problem.horizon * problem.sample_time))
        states.append(state.copy())
        inputs.append(u)
        ordered = estimate * (u + [0.0, 0.0, GRAVITY])
        for step in range(steps):
            at = now + step * STEP
            thrust = thrust + (ordered - thrust) * -math.expm1(-STEP / LAG)
            burnt = float(np.linalg.norm(thrust)) / EXHAUST * STEP
            mass, estimate = mass - burnt, estimate - burnt
            through = state[3:] - wind(state[2], at)
            force = thrust - DRAG * np.linalg.norm(through) * through
            state[3:] += STEP * (force / mass - [0.0, 0.0, GRAVITY])
            state[:3] += STEP * state[3:]
            if state[2] <= 0:
                radius = cone.limit + cone.slope * np.array(inputs)[:, 2]
                size = np.linalg.norm(np.array(inputs)[:, :2], axis=1)
                return Landing(
                    np.array(states), np.array(inputs), at + STEP,
                    float(np.linalg.norm(state[:2])), -float(state[5]),
                    float(np.linalg.norm(state[3:5])),
                    float(cone.beyond(np.array(inputs)).max()),
                    float((size > 0.999 * radius).mean()),
                )  # fmt: skip
    raise RuntimeError(f"the rocket is {state[2]:.1f} m high after {LONGEST} s")


def window(problem: Problem) -> Real:
    """References (steps, 6) of the first plan."""
    return np.stack([descent(k * problem.sample_time) for k in range(1, problem.horizon + 1)])


def land_core(problem: Problem, image: Image, backend: str = "rtl") -> tuple[Landing, set[int]]:
    """The landing under the program, and the cycles of its ticks. Raises CoreFault,
    RuntimeError.
    """
    cycles: set[int] = set()
    plan = window(problem)
    still = np.zeros((problem.horizon, len(problem.inputs)))
    with Core(image, backend=backend) as core:
        core.preset_data(0, warm_words(problem, image.configuration, plan, still, plan))

        def controller(x: Real, ahead: Real) -> Real:
            values = dict(zip(problem.states, x, strict=True))
            values |= {f"{n}_ref": v for n, v in zip(problem.states, ahead, strict=True)}
            found = core.tick(**{name: float(np.float32(v)) for name, v in values.items()})
            if core.cycles is not None:
                cycles.add(core.cycles)
            return np.array([found[name] for name in problem.inputs])

        return land(problem, controller), cycles


def land_reference(problem: Problem) -> Landing:
    """The landing under the solver in double precision."""
    solver, plan = Reference(problem, 1), window(problem)
    states = np.clip(plan, *problem.state_box).ravel()
    solver.v[0, solver.inputs :] = states * solver.boxed[solver.inputs :]
    solver.window[0, 1:] = plan[:-1]
    return land(problem, lambda x, ahead: solver.tick(x[None], ahead[None])["u"][0])
