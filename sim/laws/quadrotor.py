# SPDX-License-Identifier: Apache-2.0
"""Attitude and position law of a quadrotor, and the quadrotor as a plant.

Geometric control on SE(3) (Lee, Leok, McClamroch, CDC 2010) without the desired body rate: force
from position and speed errors, attitude error 1/2 vee(Rd^T R - R^T Rd), moments, rotor thrusts by
the inverse of the mixing matrix. The plant is a free body in pinocchio's articulated-body
algorithm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import casadi as ca
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from asip_asm.model.exact import Array
from asip_asm.model.law import Law, Port
from sim.laws.closed_loop import Values
from sim.laws.prove_program import CORNERS, Sample, draw, inside

RATE = 1000.0
MASS, ARM, DRAG = 0.8, 0.17, 0.016  # kg, m, m: moment of a rotor by its thrust
INERTIA = (0.0053, 0.0055, 0.0098)  # kg m^2
GRAVITY = 9.81
KP, KV = 9.0, 5.0  # 1/s^2, 1/s
KR, KW = 180.0, 26.0  # 1/s^2, 1/s
THRUST = 6.0  # N, of a rotor
INPUTS = {
    "goal": (3, "m", 5.0), "goal_v": (3, "m/s", 3.0), "goal_a": (3, "m/s^2", 4.0),
    "heading": (2, "1", 1.0), "p": (3, "m", 5.0), "v": (3, "m/s", 3.0), "r": (9, "1", 1.0),
    "w": (3, "rad/s", 6.0),
}  # fmt: skip
"""Arguments: size, unit, limit. heading: cosine and sine of the yaw; r: rotation, row by row."""


def law() -> Law:
    """Rotor thrusts [N] from set-points and the measured state."""
    args = _symbols()
    pull, rows, errors = _attitude(args)
    thrust = MASS * ca.dot(pull, rows[:, 2])
    w = args["w"]
    moments = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        gyro = (INERTIA[j] - INERTIA[i]) * w[i] * w[j]
        moments.append(-INERTIA[k] * KR * errors[k] - INERTIA[k] * KW * w[k] + gyro)
    mixing = np.linalg.inv(mixer())
    rotors = ca.mtimes(ca.SX(mixing), ca.vertcat(thrust, *moments))
    function = ca.Function("law", list(args.values()), [rotors], list(args), ["rotor"])
    ports = [
        Port("input", f"{name}{i}", unit, vector=name, limits=(-limit, limit))
        for name, (size, unit, limit) in INPUTS.items()
        for i in range(size)
    ]
    ports += [
        Port("output", f"rotor{i}", "N", vector="rotor", limits=(0.0, THRUST)) for i in range(4)
    ]
    return Law("quadrotor", function, ports, "attitude and position of a quadrotor", RATE)


def _symbols() -> dict[str, ca.SX]:
    return {name: ca.SX.sym(name, size) for name, (size, _, _) in INPUTS.items()}


def _attitude(args: Mapping[str, ca.SX]) -> tuple[ca.SX, ca.SX, list[ca.SX]]:
    """Wanted acceleration with that of gravity [m/s^2], rotation (3, 3), attitude errors [rad]."""
    rows = ca.reshape(args["r"], 3, 3).T
    up = ca.SX([0, 0, GRAVITY])
    pull = KP * (args["goal"] - args["p"]) + KV * (args["goal_v"] - args["v"]) + args["goal_a"] + up
    b3 = pull / ca.sqrt(ca.dot(pull, pull) + 1e-6)
    heading = ca.vertcat(args["heading"], 0)
    side = ca.cross(b3, heading)
    b2 = side / ca.sqrt(ca.dot(side, side) + 1e-6)
    desired = ca.horzcat(ca.cross(b2, b3), b2, b3)
    product = ca.mtimes(desired.T, rows)
    errors = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        errors.append(0.5 * (product[j, i] - product[i, j]))
    return pull, rows, errors


def mixer() -> NDArray[np.float64]:
    """Thrust and moments (4,) of rotor thrusts (4,), rotors on a cross, turning alternately."""
    return np.array(
        [[1, 1, 1, 1], [0, ARM, 0, -ARM], [-ARM, 0, ARM, 0], [DRAG, -DRAG, DRAG, -DRAG]], float
    )


def near(made: Law) -> Sample:
    """Set-points near the measured state, by a share of their limits over three decades, which is
    the rotation away from the heading too; a tenth are drawn apart, the nine words of the rotation
    among them.
    """
    ports = {port.name: port for port in made.of_kind("input")}

    def sample(size: int, rng: np.random.Generator) -> dict[str, Array]:
        apart = {name: draw(port, size, rng).astype(float) for name, port in ports.items()}
        share = 10.0 ** rng.uniform(-3.0, 0.0, size)
        yaw = rng.uniform(-math.pi, math.pi, size)
        tilts = rng.normal(0, 0.3, (size, 3)) * share[:, None]
        turned = [
            pin.exp3(np.array([0, 0, angle])) @ pin.exp3(tilt)
            for angle, tilt in zip(yaw, tilts, strict=True)
        ]
        values = dict(apart)
        for name, (count, _, _) in INPUTS.items():
            for i in range(count):
                if name in ("goal", "goal_v"):
                    at = apart[f"{name.replace('goal_', '').replace('goal', 'p')}{i}"]
                    values[f"{name}{i}"] = at + share * (apart[f"{name}{i}"] - at)
                elif name in ("goal_a", "w"):
                    values[f"{name}{i}"] = share * apart[f"{name}{i}"]
        values |= {f"r{i}": np.array([turn.ravel()[i] for turn in turned]) for i in range(9)}
        values |= {"heading0": np.cos(yaw), "heading1": np.sin(yaw)}
        wide = rng.random(size) < CORNERS
        return {
            name: inside(port, np.where(wide, apart[name], values[name]))
            for name, port in ports.items()
        }

    return sample


class Quadrotor:
    """The plant: it flies a circle that climbs, nose along a slow yaw.

    Errors are those of the place, and of the attitude against the one that the law in double
    precision wants at the plant's own state.
    """

    axes = dict.fromkeys("xyz", "m") | dict.fromkeys(("roll", "pitch", "yaw"), "rad")

    def __init__(self, seconds: float = 4.0) -> None:
        self.ticks = round(seconds * RATE)
        self.model = pin.Model()
        inertia = pin.Inertia(MASS, np.zeros(3), np.diag(INERTIA))
        joint = self.model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
        self.model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        self.data = self.model.createData()
        args = _symbols()
        errors = ca.vertcat(*_attitude(args)[2])
        self.attitude = ca.Function("attitude", list(args.values()), [errors])
        self.start()

    def start(self) -> None:
        self.q, self.v = pin.neutral(self.model), np.zeros(6)

    def goal(self, tick: int) -> NDArray[np.float64]:
        """Position, speed, acceleration (3, 3); starts at rest."""
        t, w = tick / RATE, 1.2
        ramp = min(t / 2, 1.0)
        rising = 0.5 if t < 2 else 0.0
        angle, size = w * t, 1.0
        s, c = math.sin(angle), math.cos(angle)
        circle = size * np.array(
            [[c - 1, s, 0.3 * t], [-w * s, w * c, 0.3], [-w * w * c, -w * w * s, 0]]
        )
        return np.array(
            [ramp * circle[0], ramp * circle[1] + rising * circle[0],
             ramp * circle[2] + 2 * rising * circle[1]]
        )  # fmt: skip

    def _state(self, tick: int) -> dict[str, NDArray[np.float64]]:
        """Arguments of the law at the tick."""
        rotation = pin.Quaternion(self.q[3:]).toRotationMatrix()
        yaw = 0.3 * tick / RATE
        goal = self.goal(tick)
        return {
            "goal": goal[0], "goal_v": goal[1], "goal_a": goal[2],
            "heading": np.array([math.cos(yaw), math.sin(yaw)]), "p": self.q[:3],
            "v": rotation @ self.v[:3], "r": rotation.ravel(), "w": self.v[3:],
        }  # fmt: skip

    def inputs(self, tick: int) -> dict[str, float]:
        return {
            f"{name}{i}": float(np.float32(x))
            for name, v in self._state(tick).items()
            for i, x in enumerate(v)
        }

    def error(self, tick: int) -> NDArray[np.float64]:
        state = self._state(tick)
        attitude = self.attitude(*(state[name] for name in INPUTS)).full().ravel()
        return np.concatenate((state["goal"] - state["p"], attitude))

    def step(self, outputs: Values) -> None:
        wrench = mixer() @ [outputs[f"rotor{i}"] for i in range(4)]
        force = np.array([0, 0, wrench[0], *wrench[1:]])
        h = 1 / RATE
        a = pin.aba(self.model, self.data, self.q, self.v, force).copy()
        v = self.v + h / 2 * a
        q = pin.integrate(self.model, self.q, h / 2 * self.v)
        a = pin.aba(self.model, self.data, q, v, force).copy()
        self.q = pin.integrate(self.model, self.q, h * v)
        self.v = self.v + h * a
