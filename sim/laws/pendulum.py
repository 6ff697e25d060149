# SPDX-License-Identifier: Apache-2.0
"""A pendulum on a cart with a linear-quadratic regulator and a Kalman filter (LQG), as one law.

The model is linearised about the upright position from pinocchio's derivatives of the forward
dynamics and discretised by zero-order hold; gains solve the discrete Riccati equations (scipy).
State of the filter: cart position [m], angle [rad], their speeds.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are

from asip_asm.model.law import Law, Port
from sim.laws.catalogue import OWN
from sim.laws.closed_loop import Arm, Values
from sim.laws.laws import Settings, count_scale
from sim.laws.prove_program import CORNERS, Sample, draw
from sim.laws.reference import PinocchioRobot
from sim.laws.tree import Tree, load_tree

SETTINGS = Settings(rate=1000.0, counts=1 << 16)
STATE_WEIGHTS = (400.0, 100.0, 20.0, 5.0)
FORCE_WEIGHT = 0.05
PROCESS_NOISE = (1e-8, 1e-8, 1e-3, 1e-3)
FORCE_LIMIT = 40.0  # N
DECADES = 5.0  # decades below the limits, over which the inputs of a proof are random


def tree() -> Tree:
    """The cart and the pole."""
    return load_tree(OWN / "pendulum.urdf")


def gains(robot: Tree, settings: Settings) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """A (4, 4), B (4,) of a tick, feedback K (4,), filter L (4, 2)."""
    plant = PinocchioRobot(robot.description.text, robot.stated)
    model, data = plant.model, plant.data
    zero = np.zeros(2)
    pin.computeABADerivatives(model, data, zero, zero, zero)
    slope, damping, mass = data.ddq_dq, data.ddq_dv, data.Minv
    continuous = np.zeros((5, 5))
    continuous[:2, 2:4] = np.eye(2)
    continuous[2:4, :2], continuous[2:4, 2:4] = slope, damping
    continuous[2:4, 4] = np.array(mass)[:, 0]
    step = expm(continuous / settings.rate)
    a, b = step[:4, :4], step[:4, 4]
    q, r = np.diag(STATE_WEIGHTS), np.array([[FORCE_WEIGHT]])
    p = solve_discrete_are(a, b[:, None], q, r)
    feedback = np.linalg.solve(r + b[None] @ p @ b[:, None], b[None] @ p @ a)[0]
    c = np.eye(2, 4)
    noise = np.diag([count_scale(joint, settings) ** 2 / 12 for joint in robot.axes])
    s = solve_discrete_are(a.T, c.T, np.diag(PROCESS_NOISE), noise)
    kalman = s @ c.T @ np.linalg.inv(c @ s @ c.T + noise)
    return a, b, feedback, kalman


def law(robot: Tree, settings: Settings = SETTINGS) -> Law:
    """force = -K (x - goal), x the filter's state corrected by both encoders."""
    a, b, feedback, kalman = gains(robot, settings)
    x, q, goal = ca.SX.sym("x", 4), ca.SX.sym("q", 2), ca.SX.sym("goal")
    corrected = x + ca.mtimes(ca.SX(kalman), q - x[:2])
    target = ca.vertcat(goal, 0, 0, 0)
    force = ca.fmax(ca.fmin(-ca.dot(feedback, corrected - target), FORCE_LIMIT), -FORCE_LIMIT)
    following = ca.mtimes(ca.SX(a), corrected) + b * force
    function = ca.Function(
        "lqg", [goal, q, x], [force, following], ["goal", "q", "x"], ["force", "x_next"]
    )
    ports = [Port("input", "goal", "m", "where the cart shall be", limits=(-0.3, 0.3))]
    for i, (unit, joint) in enumerate(zip(("m", "rad"), robot.axes, strict=True)):
        scale = count_scale(joint, settings)
        ports.append(
            Port("input", f"q{i}", unit, type="int", vector="q", scale=scale, limits=(-0.5, 0.5))
        )
    for i, (unit, limit) in enumerate((("m", 0.5), ("rad", 0.5), ("m/s", 2.0), ("rad/s", 6.0))):
        ports.append(Port("state", f"x{i}", unit, vector="x", limits=(-limit, limit)))
    ports.append(Port("output", "force", "N", "on the cart", limits=(-FORCE_LIMIT, FORCE_LIMIT)))
    return Law("pendulum LQG", function, ports, "pendulum on a cart, LQG", settings.rate)


def near(made: Law) -> Sample:
    """Inputs, and the filter's state before them: a tenth of the starts are anywhere inside the
    limits, the others near the upright pole by a share of them: there the force is no constant.
    """
    ports = (*made.of_kind("input"), *made.of_kind("state"))

    def sample(size: int, rng: np.random.Generator) -> dict[str, NDArray]:
        share = 1.0 if rng.random() < CORNERS else 10.0 ** rng.uniform(-DECADES, 0.0)
        drawn = {port.name: draw(port, 1 if port.kind == "state" else size, rng) for port in ports}
        return {name: (share * values).astype(values.dtype) for name, values in drawn.items()}

    return sample


class Pendulum(Arm):
    """The pendulum as a plant: the cart follows a slow sine while the pole stays up."""

    def __init__(self, robot: Tree, settings: Settings = SETTINGS, seconds: float = 4.0) -> None:
        super().__init__(robot, settings, seconds)
        t = np.arange(self.ticks + 1) / settings.rate
        self.path = (0.1 * (1 - np.cos(2 * np.pi * 0.25 * t))).astype(np.float32)

    def start(self) -> None:
        self.q, self.v = np.array([0.0, 0.05]), np.zeros(2)

    def inputs(self, tick: int) -> dict[str, float]:
        counts = {f"q{i}": round(q / self.scales[i]) for i, q in enumerate(self.q)}
        return {"goal": self.path[tick], **counts}

    def error(self, tick: int) -> NDArray[np.float64]:
        return np.array([self.path[tick] - self.q[0], self.q[1]])

    def step(self, outputs: Values) -> None:
        super().step({"tau0": outputs["force"], "tau1": 0.0})
