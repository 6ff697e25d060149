# SPDX-License-Identifier: Apache-2.0
"""Control laws of a tree, by name: `LAWS`. Each makes a `Law` that asip-model compiles.

Inputs common to all: encoder counts `q0`, `q1`, ... of the axes, joints that follow no other one
(int32; position = scale * count + offset), speeds by the difference of successive counts. Outputs
`tau0`, ...: forces of the axes, saturated to their efforts, 0 after a fault. A number that neither
the URDF nor an option states is an error. A law of one's own is a function of the same form.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from asip_asm.model.law import Law, Port
from sim.laws.dynamics import (
    axis_forces,
    gravity_forces,
    inverse_dynamics,
    jacobian,
    joint_values,
    tip_placement,
)
from sim.laws.elements import RobotError
from sim.laws.tree import MOST_ANGLE, Joint, Tree

Limits = Callable[[Joint], tuple[float, float]]

ACCELERATION = 15.0
"""Largest set-point acceleration, unless stated [rad/s^2, m/s^2]."""
OVERSHOOT = 2.0
"""Range of a revolute joint's encoder, as a multiple of the stated range of positions: a joint that
is moved beyond its limits is computed as exactly as inside of them.
"""


@dataclass(frozen=True)
class Settings:
    """What a law is made with besides the robot.

    rate: ticks per second. counts: encoder counts per turn (prismatic: per 0.1 m). bandwidth: of
    the position loop [Hz]; its gains are omega^2, 2 damping omega and integral omega^3 / 10 on the
    acceleration. integral: PID instead of PD; windup: largest integral [rad s, m s]. friction:
    viscous and Coulomb terms of the URDF, smoothed over `creep` [rad/s, m/s]. stiffness, damping:
    of the joint impedance [N m/rad, N m s/rad]. acceleration: largest of the set-points [rad/s^2,
    m/s^2]. overshoot: range of revolute encoders by the stated range.
    """

    rate: float = 10_000.0
    counts: int = 1 << 20
    bandwidth: float = 20.0
    damping_ratio: float = 1.0
    integral: bool = False
    windup: float = 1e-3
    friction: bool = False
    creep: float = 0.02
    stiffness: float = 200.0
    damping: float = 20.0
    acceleration: float = ACCELERATION
    overshoot: float = OVERSHOOT

    @property
    def omega(self) -> float:
        return 2 * math.pi * self.bandwidth


@dataclass
class _Parts:
    """Symbols and ports of a law under construction."""

    tree: Tree
    settings: Settings

    def __post_init__(self) -> None:
        n = len(self.tree.axes)
        self.q, self.dq = ca.SX.sym("q", n), ca.SX.sym("q_rate", n)
        self.arguments: dict[str, ca.SX] = {"q": self.q}
        self.results: dict[str, ca.SX] = {}
        self.ports: list[Port] = []

    def vector(self, kind: str, name: str, then: str, fields: Callable[[int, Joint], dict]) -> None:
        """Ports of one kind for all joints; then: text after a position's unit; fields: others."""
        for i, joint in enumerate(self.tree.axes):
            unit = ("rad" if joint.kind == "revolute" else "m") + then
            self.ports.append(Port(kind, f"{name}{i}", unit, vector=name, **fields(i, joint)))

    def target(self, name: str, meaning: str, limits: Limits, then: str = "") -> ca.SX:
        """Set-point inputs of one kind for all joints."""
        self.arguments[name] = ca.SX.sym(name, len(self.tree.axes))
        self.vector(
            "input", name, then, lambda i, joint: {"meaning": meaning, "limits": limits(joint)}
        )
        return self.arguments[name]

    def encoders(self, speeds: bool = True) -> None:
        """Counts of all joints, and their speeds."""

        def position(i: int, joint: Joint) -> dict:
            fields = {"scale": count_scale(joint, self.settings), "offset": joint.zero}
            limits = encoder_limits(joint, self.settings)
            return {"meaning": f"encoder of {joint.name}", "type": "int", "limits": limits} | fields

        def speed(i: int, joint: Joint) -> dict:
            scale = count_scale(joint, self.settings) * self.settings.rate
            return {"scale": scale, "rate_of": f"q{i}", "limits": speed_limits(joint)}

        self.vector("input", "q", "", position)
        if speeds:
            self.arguments["q_rate"] = self.dq
            self.vector("rate", "q_rate", "/s", speed)

    def accelerations(self, joint: Joint) -> tuple[float, float]:
        """Limits of the set-points, the same for all joints."""
        return -self.settings.acceleration, self.settings.acceleration

    def torques(self, tau: ca.SX) -> None:
        """Saturated outputs."""
        self.results["tau"] = tau
        for i, joint in enumerate(self.tree.axes):
            unit, limits = "N m" if joint.kind == "revolute" else "N", effort_limits(joint)
            self.ports.append(
                Port("output", f"tau{i}", unit, joint.name, vector="tau", limits=limits)
            )

    def law(self, name: str, doc: str) -> Law:
        function = ca.Function(
            name,
            list(self.arguments.values()),
            list(self.results.values()),
            list(self.arguments),
            list(self.results),
        )
        title = f"{self.tree.name} {name.replace('_', ' ')}"
        return Law(title, function, self.ports, f"{title}: {doc}", self.settings.rate)


def count_scale(joint: Joint, settings: Settings) -> float:
    """Position of one count [rad, m]; negative where counts fall as the joint turns forwards."""
    turn = 2 * math.pi if joint.kind == "revolute" else 0.1
    return turn / ((joint.counts or settings.counts) * joint.gear)


def position_limits(joint: Joint) -> tuple[float, float]:
    """Stated range of positions. Raises RobotError."""
    if joint.lower is None or joint.upper is None:
        raise _unstated(joint, "range of positions", "range", "LOW:HIGH")
    return joint.lower, joint.upper


def encoder_limits(joint: Joint, settings: Settings) -> tuple[float, float]:
    """Range of the encoder: beyond the stated one for revolute joints."""
    low, high = position_limits(joint)
    if joint.kind != "revolute":
        return low, high
    middle, half = (low + high) / 2, (high - low) / 2 * settings.overshoot
    return max(middle - half, -MOST_ANGLE), min(middle + half, MOST_ANGLE)


def speed_limits(joint: Joint) -> tuple[float, float]:
    """Largest speeds. Raises RobotError."""
    if joint.velocity is None:
        raise _unstated(joint, "velocity above 0", "velocity", "SPEED")
    return -joint.velocity, joint.velocity


def effort_limit(joint: Joint) -> float:
    """Largest joint force. Raises RobotError."""
    if joint.effort is None:
        raise _unstated(joint, "effort above 0", "effort", "FORCE")
    return joint.effort


def effort_limits(joint: Joint) -> tuple[float, float]:
    """Largest joint forces. Raises RobotError."""
    return -effort_limit(joint), effort_limit(joint)


def _unstated(joint: Joint, what: str, option: str, value: str) -> RobotError:
    return RobotError(
        f"joint {joint.name}: the URDF states no {what}; state it: --{option} "
        f"{joint.name}={value}, or --{option} {value} for all joints without one"
    )


def friction(tree: Tree, dq: ca.SX, creep: float) -> ca.SX:
    """Viscous and Coulomb friction of the URDF at the axes; Coulomb friction rises over `creep`."""
    rates = joint_values(tree, dq, shifted=False)
    return axis_forces(
        tree,
        [
            joint.damping * rate + joint.friction * ca.fmax(ca.fmin(rate * (1 / creep), 1.0), -1.0)
            for joint, rate in zip(tree.joints, rates, strict=True)
        ],
    )


def computed_torque(tree: Tree, settings: Settings) -> Law:
    """tau = ID(q, dq, ddq_d + Kp e + Kv de [+ Ki s]) [+ friction(dq_d)], e = q_d - q."""
    parts = _Parts(tree, settings)
    goal = parts.target("goal", "desired position", position_limits)
    speed = parts.target("speed", "desired speed", speed_limits, "/s")
    acceleration = parts.target("accel", "desired acceleration", parts.accelerations, "/s^2")
    parts.encoders()
    omega, ratio = settings.omega, settings.damping_ratio
    e, de = goal - parts.q, speed - parts.dq
    demand = acceleration + omega**2 * e + 2 * ratio * omega * de
    if settings.integral:
        s = parts.arguments["s"] = ca.SX.sym("s", len(tree.axes))
        limit = settings.windup
        following = ca.fmax(ca.fmin(s + e * (1 / settings.rate), limit), -limit)
        demand += omega**3 / 10 * following
        parts.results["s_next"] = following
        fields = {"meaning": "integral", "limits": (-limit, limit)}
        parts.vector("state", "s", " s", lambda i, joint: fields)
    tau = inverse_dynamics(tree, parts.q, parts.dq, demand)
    if settings.friction:
        tau += friction(tree, speed, settings.creep)
    parts.torques(tau)
    return parts.law("computed_torque", "inverse dynamics at the measured state")


def gravity_compensation(tree: Tree, settings: Settings) -> Law:
    """tau = g(q) + hand guidance force per joint."""
    parts = _Parts(tree, settings)
    extra = parts.target("extra", "added joint force", effort_limits, " N m")
    parts.encoders(speeds=False)
    parts.torques(gravity_forces(tree, parts.q) + extra)
    return parts.law("gravity_compensation", "holds the arm's weight")


def joint_impedance(tree: Tree, settings: Settings) -> Law:
    """tau = K (q_d - q) - D dq + g(q) [+ friction(dq)]."""
    parts = _Parts(tree, settings)
    goal = parts.target("goal", "rest of the spring", position_limits)
    parts.encoders()
    count = range(len(tree.axes))
    spring = [min(settings.stiffness, effort_limit(joint)) for joint in tree.axes]
    ratio = settings.damping / settings.stiffness
    tau = gravity_forces(tree, parts.q) + ca.vertcat(
        *(spring[i] * (goal[i] - parts.q[i] - ratio * parts.dq[i]) for i in count)
    )
    if settings.friction:
        tau += friction(tree, parts.dq, settings.creep)
    parts.torques(tau)
    return parts.law("joint_impedance", "a spring and a damper at every joint")


def forward_kinematics(tree: Tree, settings: Settings) -> Law:
    """Origin [m] and axes z, x of the tip's frame: of the link that is named, or the only leaf."""
    parts = _Parts(tree, settings)
    parts.encoders(speeds=False)
    rows, origin = tip_placement(tree, parts.q, tree.tip)
    names = ("x", "y", "z", "zx", "zy", "zz", "xx", "xy", "xz")
    values = [*origin, *(row[2] for row in rows), *(row[0] for row in rows)]
    for name, value in zip(names, values, strict=True):
        parts.results[f"tip_{name}"] = ca.SX(value)
        unit = "m" if len(name) == 1 else "1"
        parts.ports.append(Port("output", f"tip_{name}", unit))
    return parts.law("forward_kinematics", f"where the frame of link {tree.tip.link} is")


def tip_speed(tree: Tree, settings: Settings) -> Law:
    """Velocity of the tip's frame, Jacobian times joint speeds [m/s, rad/s], base axes."""
    parts = _Parts(tree, settings)
    parts.encoders()
    velocity = jacobian(tree, parts.q, tree.tip) @ parts.dq
    for k, name in enumerate(("vx", "vy", "vz", "wx", "wy", "wz")):
        parts.results[f"tip_{name}"] = velocity[k]
        unit = "m/s" if k < 3 else "rad/s"
        parts.ports.append(Port("output", f"tip_{name}", unit))
    return parts.law("tip_speed", f"velocity of the frame of link {tree.tip.link}")


def inverse_dynamics_law(tree: Tree, settings: Settings) -> Law:
    """tau = ID(q, dq, ddq), all given as floats."""
    parts = _Parts(tree, settings)
    q = parts.target("pos", "position", lambda joint: encoder_limits(joint, settings))
    dq = parts.target("speed", "speed", speed_limits, "/s")
    ddq = parts.target("accel", "acceleration", parts.accelerations, "/s^2")
    del parts.arguments["q"]
    parts.torques(inverse_dynamics(tree, q, dq, ddq))
    return parts.law("inverse_dynamics", "joint forces of a motion")


LAWS: dict[str, Callable[[Tree, Settings], Law]] = {
    "computed_torque": computed_torque,
    "gravity_compensation": gravity_compensation,
    "joint_impedance": joint_impedance,
    "forward_kinematics": forward_kinematics,
    "tip_speed": tip_speed,
    "inverse_dynamics": inverse_dynamics_law,
}


def operations(law: Law) -> int:
    """Operations of the law's function as CasADi lists them, less inputs, outputs and constants."""
    function = law.in_casadi
    skipped = (ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST)
    return sum(function.instruction_id(i) not in skipped for i in range(function.n_instructions()))
