# SPDX-License-Identifier: Apache-2.0
"""The tracking law of the project's five-axis robot, written in Python (docs/law.md gives the
equations).

Two forms of one law: `printed` evaluates the paper's equations one by one, `optimised` uses closed
forms: statics without a system of equations, masses by the squared sine between two legs, one
reciprocal for each length, integrators that hold K_I s_c. Speeds are differences of counts, taken
as integers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from asip_asm.model.law import Law, Port
from sim.laws.closed_loop import Values
from sim.robot import kinematics
from sim.robot.parameters import Robot
from sim.robot.plant import Plant
from sim.robot.records import OUTPUTS, POSITIONS

SET_POINTS = (
    "x y z vx vy vz ax ay az alpha gamma w_alpha w_gamma eps_alpha eps_gamma".split()
)  # in the order of the paper
LEGS = range(3)
AXES = range(5)
GRID = 2.0**-11
"""Squares and sums of multiples of it below 4 are exact in binary32 [m]."""
TO_GRID = 1.5 * 2**23 * GRID
"""Adding it rounds a binary32 number to a multiple of GRID."""
Legs = list[ca.SX]


def _offsets(robot: Robot, place: Legs) -> list[tuple[ca.SX, ca.SX]]:
    return [(place[0] - xp, place[1] - yp) for xp, yp in robot.legs]


def _others(i: int) -> tuple[int, int]:
    j, k = (n for n in LEGS if n != i)
    return j, k


def printed_kinematics(
    robot: Robot, place: Legs, v: Legs, a: Legs, counts: Legs
) -> tuple[list[Legs], Legs, Legs, Legs]:
    """Errors of the legs as terms to add, (28); speeds (8), accelerations (9)-(11), and numbers
    with the signs of the speeds.
    """
    lengths, speeds, accelerations = [], [], []
    for dx, dy in _offsets(robot, place):
        q = dx * dx + dy * dy + place[2] * place[2]
        s = 2 * dx * v[0] + 2 * dy * v[1] + 2 * place[2] * v[2]
        second = 2 * (v[0] ** 2 + dx * a[0] + v[1] ** 2 + dy * a[1] + v[2] ** 2 + place[2] * a[2])
        root = ca.sqrt(q)
        lengths.append(root)
        speeds.append(0.5 * (s / root))
        accelerations.append(-0.25 * (s * s / (q * root)) + 0.5 * (second / root))
    return length_errors(robot, place, lengths, counts), speeds, accelerations, speeds


def printed_dynamics(robot: Robot, legs: Legs) -> tuple[Legs, Legs]:
    """Reduced masses (23) and gravity (24), (25) by Cramer's rule."""
    l1, l2, l3 = legs
    r = robot.R
    x = -math.sqrt(3.0) * (l2 * l2 - l3 * l3) / (6 * r)
    y = -(2 * (l1 * l1) - l2 * l2 - l3 * l3) / (6 * r)
    d, s = l2 * l2 - l3 * l3, (2 * (l1 * l1) - l2 * l2 - l3 * l3) / (6 * r) + r
    z = ca.sqrt(l1 * l1 - d * d / (12 * r * r) - s * s)
    masses = []
    for i in LEGS:
        total = ca.SX(robot.m_s + robot.m_p)
        for j in _others(i):
            c = (legs[i] ** 2 + legs[j] ** 2 - 3 * r * r) / (2 * legs[i] * legs[j])
            swing = robot.J_a + robot.m_s * (legs[j] - robot.l_c) ** 2
            total += robot.m_s * c * c + swing * (1 - c * c) / (legs[j] * legs[j])
        masses.append(total)
    m_z = ca.SX(robot.m_p)
    for leg in legs:
        m_z += (robot.m_s * (leg - robot.l_c) - robot.mr_c) / leg
    w = [
        (dx / leg, dy / leg, z / leg)
        for (dx, dy), leg in zip(_offsets(robot, [x, y]), legs, strict=True)
    ]
    cofactors = []
    for i in LEGS:
        (xj, yj, _), (xk, yk, _) = w[(i + 1) % 3], w[(i + 2) % 3]
        cofactors.append(xj * yk - xk * yj)
    det = sum(w[i][2] * cofactors[i] for i in LEGS)
    return masses, [m_z * robot.g * cofactor / det for cofactor in cofactors]


@contextmanager
def as_written() -> Iterator[None]:
    """CasADi leaves expressions as they are: in numbers with roundings, a root's square is not what
    the root was taken of.
    """
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        ca.GlobalOptions.setSimplificationOnTheFly(True)


def rounded_to(value: float, bits: float) -> tuple[float, float]:
    """The nearest multiple of `bits`, a power of two, and the rest."""
    high = round(value / bits) * bits
    return high, value - high


def single(value: float) -> tuple[float, float]:
    """The nearest binary32 number, and the rest."""
    high = float(np.float32(value))
    return high, value - high


def residuals(robot: Robot, place: Legs, lengths: Legs) -> list[tuple[ca.SX, ca.SX]]:
    """Q - l^2 of each leg as two terms, Q = l_d^2 by (7) and l its rounded root.

    Set-points and constants are multiples of `GRID` and rests. Products and sums of the multiples
    are exact; so is their difference from l^2, except for the rounding of the rest. Legs 2 and 3:
    Q_1 + 3Ry -+ 2 x_p x.
    """
    x, y, z = place
    xh, yh, zh = ((value + TO_GRID) - TO_GRID for value in place)
    xl, yl, zl = x - xh, y - yh, z - zh
    (rh, rl), (r3h, r3l) = rounded_to(robot.R, GRID), rounded_to(3 * robot.R, GRID)
    xph, xpl = rounded_to(2 * robot.legs[1][0], GRID)
    dy, dyh, dyl = y - robot.R, yh - rh, yl - rl
    high = xh * xh + zh * zh + dyh * dyh
    low = xl * (x + xh) + zl * (z + zh) + dyl * (dy + dyh)
    high23, low23 = high + yh * r3h, low + y * r3l + yl * r3h
    x2h, x2l = xh * xph, x * xpl + xl * xph
    # A maximum is no term of a sum: the squares are complete before l^2 is taken off them.
    squares = (high, ca.fmax(high23 - x2h, 0), ca.fmax(high23 + x2h, 0))
    rests = (low, low23 - x2l, low23 + x2l)
    return [(h - ln * ln, rest) for h, ln, rest in zip(squares, lengths, rests, strict=True)]


def length_errors(robot: Robot, place: Legs, lengths: Legs, counts: Legs) -> list[Legs]:
    """l_d - l of each leg as terms to add.

    The rounded root alone has an error of 3e-8 m, a constant one where the tool rests, which the
    integrator sums up. So the first term is l_d - q n, exact except for one rounding of the small
    difference, and apart from it there is a step of Newton's with the residual of the root (the
    measured length serves for so small a step) and with the rest of the resolution q. Two readers
    keep the two apart.
    """
    errors = []
    high, low = single(robot.encoder_legs)
    with as_written():
        steps = residuals(robot, place, lengths)
        for length, (rest, more), n in zip(lengths, steps, counts, strict=True):
            half = 0.5 * (1 / (robot.encoder_legs * n))
            errors.append([length - n * high, rest * half + more * half - n * low])
    return errors


def short_kinematics(
    robot: Robot, place: Legs, v: Legs, a: Legs, counts: Legs
) -> tuple[list[Legs], Legs, Legs, Legs]:
    """The same with a = (v.v + r.a - (dl/dt)^2)/l."""
    lengths, speeds, accelerations, towards = [], [], [], []
    common = v[0] ** 2 + v[1] ** 2 + v[2] ** 2 + place[2] * a[2]
    for dx, dy in _offsets(robot, place):
        length = ca.sqrt(dx * dx + dy * dy + place[2] * place[2])
        inverse = 1 / length
        product = dx * v[0] + dy * v[1] + place[2] * v[2]
        towards.append(product)
        speed = product * inverse
        lengths.append(length)
        speeds.append(speed)
        accelerations.append((common + dx * a[0] + dy * a[1] - speed * speed) * inverse)
    return length_errors(robot, place, lengths, counts), speeds, accelerations, towards


def short_dynamics(robot: Robot, legs: Legs) -> tuple[Legs, Legs]:
    """M_ii = m_p + 3 m_s - D_j sin^2(i,j) - D_k sin^2(i,k), D = m_s - J/l^2; statics in closed
    form.
    """
    r2 = robot.R**2
    p = [leg * leg for leg in legs]
    w = [1 / leg for leg in legs]
    total = p[0] + p[1] + p[2]
    deviation = (p[0] - p[1]) * (p[0] - p[2]) + (p[1] - p[2]) ** 2
    z = ca.sqrt(total * (1 / 3) - r2 - deviation * (1 / (9 * r2)))
    weight = robot.g * (robot.m_p + 3 * robot.m_s) - robot.g * (
        robot.m_s * robot.l_c + robot.mr_c
    ) * (w[0] + w[1] + w[2])
    press = weight / z
    share = total * (1 / (9 * r2)) + 1 / 3
    gravity = [(share - p[i] * (1 / (3 * r2))) * legs[i] * press for i in LEGS]
    inertia = robot.J_a + robot.m_s * robot.l_c**2
    relief = [(2 * robot.m_s * robot.l_c - inertia * w[i]) * w[i] for i in LEGS]
    masses = [ca.SX(robot.m_p + 3 * robot.m_s)] * 3
    for i in LEGS:
        for j in _others(i):
            third = 3 - i - j
            c = (total - 3 * r2 - p[third]) * 0.5 * (w[i] * w[j])
            masses[i] = masses[i] - relief[j] * (1 - c * c)
    return masses, gravity


def table_errors(robot: Robot, desired: ca.SX, count: ca.SX) -> Legs:
    """Error of a table axis as a term; its resolution is a binary32 number and a rest."""
    high, low = single(robot.encoder_table)
    return [desired - count * high - count * low]


def law(
    robot: Robot,
    kinematics_of: Callable,
    dynamics_of: Callable,
    integrate: Callable,
    title: str,
) -> Law:
    """(28), (36) around the given kinematics, dynamics and integrators."""
    inputs = {name: ca.SX.sym(name) for name in SET_POINTS}
    place, v, a = ([inputs[n] for n in SET_POINTS[k : k + 3]] for k in (0, 3, 6))
    count, rate = ca.SX.sym("count", 5), ca.SX.sym("count_rate", 5)
    state = {name: ca.SX.sym(name, 5) for name in ("integral", "sign", "ticks")}
    errors, speeds, accelerations, towards = kinematics_of(
        robot, place, v, a, [count[i] for i in LEGS]
    )
    for i, name in ((3, "alpha"), (4, "gamma")):
        errors.append(table_errors(robot, inputs[name], count[i]))
    towards = [*towards, inputs["w_alpha"], inputs["w_gamma"]]
    speeds = [*speeds, inputs["w_alpha"], inputs["w_gamma"]]
    accelerations = [*accelerations, inputs["eps_alpha"], inputs["eps_gamma"]]
    masses, gravity = dynamics_of(robot, [robot.encoder_legs * count[i] for i in LEGS])
    masses += [robot.J_44, robot.J_55]
    gravity += [robot.r_4 * robot.m_4 * robot.g * ca.sin(robot.encoder_table * count[3]), 0]
    outputs: list[ca.SX] = []
    integrals: list[ca.SX] = []
    signs: list[ca.SX] = []
    ticks: list[ca.SX] = []
    for i in AXES:
        e, e_v = sum(errors[i][1:], errors[i][0]), speeds[i] - rate[i]
        sign = ca.sign(towards[i])
        old = [state[name][i] for name in ("integral", "sign", "ticks")]
        total, n = integrate(robot, i, sign, e, *old)
        spring = sum(robot.K_P[i] * term for term in errors[i])
        ahead = masses[i] * (accelerations[i] + robot.K_V[i] * e_v) + gravity[i]
        outputs.append(masses[i] * (spring + total) + ahead)
        for kept, value in ((integrals, total), (signs, sign), (ticks, n)):
            kept.append(value)
    arguments = {**inputs, "count": count, "count_rate": rate, **state}
    results = {f"{n}": o for n, o in zip(OUTPUTS, outputs, strict=True)}
    results |= {
        "integral_next": ca.vertcat(*integrals), "sign_next": ca.vertcat(*signs),
        "ticks_next": ca.vertcat(*ticks),
    }  # fmt: skip
    function = ca.Function(
        "tracking",
        list(arguments.values()),
        list(results.values()),
        list(arguments),
        list(results),
    )
    return Law(title, function, _ports(robot), title, 1 / robot.T_s)


def _most(robot: Robot, axis: int) -> float:
    return robot.K_I[axis] * robot.s_max[axis]


def _saturated(robot: Robot, axis: int, total: ca.SX) -> ca.SX:
    return ca.fmax(ca.fmin(total, _most(robot, axis)), -_most(robot, axis))


def printed_integrator(
    robot: Robot, axis: int, sign: ca.SX, e: ca.SX, total: ca.SX, last: ca.SX, ticks: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """K_I s_c of (29)-(35), and ticks since the reversal: phi_c is 1, xi_c after a reversal, a ramp
    for large errors.
    """
    end, most = robot.boost_ticks, robot.xi_c - 1
    n = ca.fmin(ca.if_else(sign == last, ticks + 1, 0), end)
    late = ca.if_else(n < end, 2 * most * (1 - n * (1 / end)), 0)
    early = ca.if_else(n <= 0, 0, most)
    small = ca.if_else(n <= end // 2, early, 0)
    large = ca.if_else(n <= end // 2, early, late)
    gain = robot.K_I[axis] * robot.T_s
    phi = ca.if_else(ca.fabs(e) >= robot.e_c[axis], gain * (1 + large), gain * (1 + small))
    return _saturated(robot, axis, total + phi * e), n


def short_integrator(
    robot: Robot, axis: int, sign: ca.SX, e: ca.SX, total: ca.SX, last: ca.SX, ticks: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """The same with one line, saturated to 1 .. xi_c, for the cases; ticks count on."""
    end, most = robot.boost_ticks, robot.xi_c - 1
    same = sign == last
    counted = same * ticks + same
    n = ca.if_else(counted, counted, end)
    gain = robot.K_I[axis] * robot.T_s
    line = gain * (1 + 2 * most) - (gain * 2 * most / end) * n
    phi = ca.fmax(ca.fmin(line, gain * robot.xi_c), gain)
    threshold = ca.fmin(n - (end / 2 + 0.25), robot.e_c[axis])
    fast, slow = total + phi * e, total + gain * e
    return _saturated(robot, axis, ca.if_else(threshold <= ca.fabs(e), fast, slow)), counted


def _ports(robot: Robot) -> list[Port]:
    limits = dict.fromkeys(SET_POINTS, 1.0) | {"x": 0.1, "y": 0.1, "alpha": 0.5, "gamma": 3.0}
    ports = [
        Port("input", n, "SI", limits=(0.5, 0.7) if n == "z" else (-limits[n], limits[n]))
        for n in SET_POINTS
    ]
    for i in AXES:
        unit = "m" if i < 3 else "rad"
        scale = robot.resolution[i]
        low, high = (0.7, 0.9) if i < 3 else (-3.0, 3.0)
        ports.append(
            Port("input", f"count{i}", "count", type="int", vector="count",
                 limits=(low / scale, high / scale))
        )  # fmt: skip
        ports.append(
            Port("rate", f"count_rate{i}", f"{unit}/s", vector="count_rate",
                 scale=scale / robot.T_s, rate_of=f"count{i}")
        )  # fmt: skip
    for i in AXES:
        most = _most(robot, i)
        ports.append(Port("state", f"integral{i}", vector="integral", limits=(-most, most)))
    for i in AXES:
        ports.append(Port("state", f"sign{i}", vector="sign", limits=(0.0, 0.0)))
    for i in AXES:
        end = float(robot.boost_ticks)
        ports.append(Port("state", f"ticks{i}", vector="ticks", limits=(end, end), initial=end))
    for name, limit in zip(OUTPUTS, robot.output_max, strict=True):
        unit = "N" if name[0] == "F" else "N m"
        ports.append(Port("output", name, unit, limits=(-limit, limit)))
    return ports


def printed(robot: Robot | None = None) -> Law:
    """The law as the paper prints it."""
    robot = robot or Robot.load()
    return law(
        robot, printed_kinematics, printed_dynamics, printed_integrator, "five axes, as printed"
    )


def optimised(robot: Robot | None = None) -> Law:
    """The law in shorter algebra."""
    robot = robot or Robot.load()
    return law(
        robot, short_kinematics, short_dynamics, short_integrator, "five axes, optimised algebra"
    )


def path(robot: Robot, ticks: int, rng: np.random.Generator | None = None) -> NDArray[np.float32]:
    """Set-points (ticks, 15): a circle with a shake in z and turning table, at random if asked."""
    t = np.arange(ticks) * robot.T_s
    scale = rng.uniform(0.3, 1.0, 5) if rng else np.ones(5)
    phase = rng.uniform(0, 6.28, 5) if rng else np.array([0.4, -1.17, 0.2, 0.7, 1.2])
    hertz = np.array([0.18, 0.18, 30.0, 12.0, 5.0])
    amplitude = np.array([0.03, 0.03, 0.25e-3, 5e-3, 20e-3]) * scale
    angle = 2 * np.pi * hertz * t[:, None] + phase
    rate = 2 * np.pi * hertz
    place = amplitude * np.sin(angle) + np.array([0, 0, robot.z_start, 0.3, 0])
    speed, turn = amplitude * rate * np.cos(angle), -amplitude * rate**2 * np.sin(angle)
    columns = [place[:, :3], speed[:, :3], turn[:, :3], place[:, 3:], speed[:, 3:], turn[:, 3:]]
    return np.concatenate(columns, axis=1).astype(np.float32)


def sample(robot: Robot, size: int, rng: np.random.Generator) -> dict[str, NDArray]:
    """Inputs of `size` ticks of a random motion: counts follow within some micrometres."""
    words = path(robot, size, rng)
    joints = np.concatenate(
        (kinematics.inverse(robot, words[:, :3].astype(float)), words[:, 9:11]), 1
    )
    t = np.arange(size)[:, None] * robot.T_s
    wave = np.sin(2 * np.pi * rng.uniform(5, 60, 5) * t + rng.uniform(0, 6, 5))
    joints = joints - wave * np.array([3e-6] * 3 + [8e-5] * 2)
    counts = np.rint(joints / np.array(robot.resolution)).astype(np.int32)
    values = {name: np.ascontiguousarray(words[:, k]) for k, name in enumerate(SET_POINTS)}
    return values | {f"count{i}": np.ascontiguousarray(counts[:, i]) for i in AXES}


class FiveAxes:
    """The rigid-body plant of the main job, friction included, along `path`."""

    axes = dict.fromkeys(POSITIONS[:3], "m") | dict.fromkeys(POSITIONS[3:], "rad")

    def __init__(self, robot: Robot, seconds: float) -> None:
        self.robot = robot
        self.ticks = round(seconds / self.robot.T_s)
        words = path(self.robot, self.ticks).astype(float)
        self.words = words
        self.goal = np.concatenate(
            (kinematics.inverse(self.robot, words[:, :3]), words[:, 9:11]), 1
        )
        self.start()

    def start(self) -> None:
        self.plant = Plant(self.robot, tuple(self.words[0, :3]), tuple(self.words[0, 9:11]))

    def inputs(self, tick: int) -> dict[str, float]:
        counts = self.plant.counts()
        values = dict(zip(SET_POINTS, self.words[tick].tolist(), strict=True))
        return values | {f"count{i}": counts[i] for i in AXES}

    def error(self, tick: int) -> NDArray[np.float64]:
        return self.goal[tick] - np.array(self.plant.joints)

    def step(self, outputs: Values) -> None:
        self.plant.step([outputs[name] for name in OUTPUTS])
