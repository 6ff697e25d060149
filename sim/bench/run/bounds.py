# SPDX-License-Identifier: Apache-2.0
"""Error bounds of the tracking programs, derived from the roundings that they make.

First-order rounding analysis with the unit roundoff u = 2^-24, evaluated at every tick from the
reference's own quantities, for any valid robot. The reference sees the same binary32 set-points and
counts as the program, so the bounds are about arithmetic alone. Two analyses: `printed`, for the
formulas of (7)-(37) as they are printed, with or without fused multiply-adds (the PC, FPGA1, FPGA2,
the as-printed program), and `optimised`, for asip_asm/programs/tracking_law.inc, with differences
of counts (tracking_optimised.s) or with observers (tracking_observer.s).

Numbers such as 5u count the roundings that a value goes through: one per operation, one per
constant that binary32 does not hold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.robot.observer import gains, observed
from sim.robot.parameters import Robot
from sim.robot.records import SetPoints, TrackingResult
from sim.robot.stamps import slips

U = 2.0**-24
GRID = 2.0**-11  # of the optimised program's number grid [m]
OTHERS = ((1, 2), (0, 2), (0, 1))  # legs besides leg i

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Bounds:
    """Error bounds of one program, each (N, 5): desired motion, e, mass, gravity, output."""

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    e: FloatArray
    mass: FloatArray
    gravity: FloatArray
    output: FloatArray


def bounds(
    robot: Robot,
    path: SetPoints,
    reference: TrackingResult,
    optimised: bool,
    counts: NDArray[np.integer] | None = None,
) -> Bounds:
    """First-order bounds on the rounding errors of one program.

    counts: those of the reference, for a program with observers (N, 5) or stamps (N, 10), which
    are optimised ones.

    v: constants and quotient 5u (|v| + |v_d|); as printed also 2u|l|/T_s for the two rounded
    lengths. Demand: 6u of the size of its terms; output: 3u of mass times that and of gravity.
    """
    desired = _desired_motion(robot, path, reference)
    length, base = reference.position_d[:, :3], desired.base
    measured, size = np.abs(reference.position), np.abs(reference.e)
    table = np.zeros((len(path), 2))
    if optimised:
        leg = _leg_error(robot, path, reference, desired.offset, base)
        position = np.hstack((U * length + leg, table))
        e = np.hstack((leg, 2 * U * U * measured[:, 3:])) + 3 * U * size
    else:
        position = np.hstack((base + 3 * U * length, table))
        e = position + 2 * U * measured + U * size
    velocity = np.hstack((desired.velocity, table))
    acceleration = np.hstack((desired.acceleration, table))
    v_d = np.abs(reference.velocity_d)
    e_v = velocity + 5 * U * (np.abs(reference.velocity) + v_d)
    if not optimised:
        e_v = e_v + 2 * U * measured / robot.T_s

    s_c = _integrator(robot, reference, e, velocity, optimised)
    k_p, k_v, k_i = (np.array(gain) for gain in (robot.K_P, robot.K_V, robot.K_I))
    terms = np.abs(reference.acceleration_d) + k_p * size + k_v * np.abs(reference.e_v)
    terms = terms + k_i * np.abs(reference.s_c)
    inner = acceleration + k_p * e + k_v * e_v + k_i * s_c + 6 * U * terms
    if counts is not None and counts.shape[1] > 5:
        inner = inner - k_v * e_v + k_v * _stamped(robot, reference, counts, velocity)
    elif counts is not None:
        off = _observer(robot, reference, counts, inner, terms)
        inner, terms = inner + off.error, terms + off.size
    leg_mass, leg_gravity = (_optimised_dynamics if optimised else _printed_dynamics)(
        robot, reference
    )
    mass = np.hstack((leg_mass, U * reference.mass[:, 3:]))
    gravity = np.hstack((leg_gravity, _table_gravity(robot, reference)))
    output = (reference.mass + mass) * inner + mass * terms + gravity
    output += 3 * U * (reference.mass * terms + np.abs(reference.gravity))
    return Bounds(position, velocity, acceleration, e, mass, gravity, output)


# ---------------------------------------------------------------- speeds from time stamps


def _stamped(
    robot: Robot, reference: TrackingResult, counts: NDArray[np.integer], velocity: FloatArray
) -> FloatArray:
    """Error of e_v, (N, 5): half clocks and counts are exact, so both take the same counts.

    The way of a tick, and that since a count: those of v_d, 4u of the parts. The way since the last
    count: those of its ticks and u of each sum; of the whole 2u of its three parts, over the time
    between the counts, and 3u of e_v. What stays has its own, or that of v_d and 3u of the limits.
    """
    period, v_d = robot.T_s, np.abs(reference.velocity_d)
    found = slips(robot, counts, reference.velocity_d, reference.acceleration_d)
    size = period * v_d + period**2 * np.abs(reference.acceleration_d)
    step, slip = period * velocity + 4 * U * size, np.abs(found.slip)
    before = np.abs(np.vstack((np.zeros(5), found.ahead[:-1])))
    way, error, rows = np.zeros(5), np.zeros(5), []
    for t, apart in enumerate(found.apart):
        run = way + step[t] + U * (before[t] + size[t])
        parts = 2 * (before[t] + 2 * size[t]) + slip[t] * apart
        fresh = (run + step[t] + 2 * U * parts) / np.where(apart > 0, apart, 1.0) + 3 * U * slip[t]
        stays = np.maximum(error, velocity[t] + 3 * U * (v_d[t] + slip[t]))
        error = np.where(apart > 0, fresh, stays)
        way = np.where(apart > 0, step[t], run)
        rows.append(error + 2 * U * (v_d[t] + slip[t]))
    return np.array(rows)


# ---------------------------------------------------------------- observers


@dataclass(frozen=True)
class _Off:
    """Of the acceleration that the law asks for, (N, 5): error by the observers' states, size of
    the pull that it takes off."""

    error: FloatArray
    size: FloatArray


def _observer(
    robot: Robot,
    reference: TrackingResult,
    counts: NDArray[np.integer],
    inner: FloatArray,
    terms: FloatArray,
) -> _Off:
    """inner, terms: error and size of what the law asks for, without the observers' states.

    Of a tick, r: u of the resolution and of the sum; u of each gain, product and sum. a + p: 2u of
    both; the prediction: 3u of its position, 2u of T a and u of the speed. Errors of the states go
    from tick to tick as the states do, with K_V v and the share of p in a: the bound is the sum of
    the sizes of the powers of that matrix, times the largest errors of a tick so far.
    """
    k_v, period = np.array(robot.K_V), robot.T_s
    at_rest = reference.acceleration_d + np.array(robot.K_P) * reference.e
    at_rest = at_rest + k_v * reference.velocity_d + np.array(robot.K_I) * reference.s_c
    states = observed(robot, counts, at_rest)
    moved = np.array(robot.resolution) * np.abs(np.diff(counts, axis=0, prepend=counts[:1]))
    less = np.array([period**2 / 2, period, 0.0])  # states of an acceleration
    error, size = np.empty_like(inner), np.abs(states.taken_off)
    for n, gain in enumerate(gains(robot)):
        speed, pull = np.abs(states.speed[:, n]), np.abs(states.pull[:, n])
        rest = np.abs(states.rest[:, n])
        correct = np.array([[gain.kept, 0, 0], [-gain.speed, 1, 0], [-gain.pull, 0, 1]])
        taken = np.array([0.0, k_v[n], gain.share])
        predict = np.array([[1, period, period**2 / 2], [0, 1, period], [0, 0, 1.0]])
        predict -= np.outer(less, taken)
        made = U * np.stack((rest, speed, pull))
        made += np.abs(correct[:, :1]) * U * (moved[:, n] + 3 * rest)
        a = terms[:, n] + size[:, n] + pull
        ahead = U * np.stack((3 * (rest + period * speed), 2 * period * a + speed, 0 * rest))
        ahead[0] += 3 * U * period**2 / 2 * a
        ahead += less[:, None] * (inner[:, n] + 2 * U * a) + np.abs(predict) @ made
        sizes, power = np.zeros(3), np.eye(3)
        while np.abs(power).max() > 1e-9:
            sizes += np.abs(taken @ correct @ power)
            power = predict @ correct @ power
        error[:, n] = taken @ made
        error[1:, n] += sizes @ np.maximum.accumulate(ahead, axis=1)[:, :-1]
    return _Off(error, size)


# ---------------------------------------------------------------- desired motion


@dataclass(frozen=True)
class _Desired:
    """d = (x - x_pi, y - y_pi, z), (N, 3, 3); the other errors (N, 3)."""

    offset: FloatArray
    base: FloatArray  # of l, from the errors of d alone
    velocity: FloatArray
    acceleration: FloatArray


def _starts(robot: Robot) -> FloatArray:
    """Start points of the legs, (3, 3)."""
    return np.concatenate((np.array(robot.legs), np.zeros((3, 1))), axis=1)


def _desired_motion(robot: Robot, path: SetPoints, reference: TrackingResult) -> _Desired:
    """(7)-(11). A coordinate of d carries u|x_pi| of the constant and u|d| of the subtraction, E.

    l: sum |d|E/l, then 3u l of squares, sums, root. v = sum d v/l: numerator E|v| + 4u|d v|, length
    and quotient 4u|v| more. a = (v.v + d.a - v^2)/l, in both forms: E|a| + 8u of the parts, 2|v|
    times the error of v's numerator over l, and 16u of v^2/l.
    """
    starts = _starts(robot)
    d = path.position[:, None, :] - starts
    error = U * (np.abs(starts) + np.abs(d))
    speed, change = np.abs(path.velocity[:, None, :]), np.abs(path.acceleration[:, None, :])
    l_d = reference.position_d[:, :3]
    v, a = np.abs(reference.velocity_d[:, :3]), np.abs(reference.acceleration_d[:, :3])
    base = np.sum(np.abs(d) * error, axis=2) / l_d
    moved = np.sum(error * speed + 4 * U * np.abs(d) * speed, axis=2)
    velocity = moved / l_d + v * (base / l_d + 4 * U)
    parts = np.sum(speed**2 + np.abs(d) * change, axis=2)
    acceleration = np.sum(error * change, axis=2) + parts * (12 * U + base / l_d)
    acceleration += 2 * v * moved / l_d + v**2 * (3 * base / l_d + 16 * U)
    return _Desired(d, base, velocity, acceleration / l_d + U * a)


def _leg_error(
    robot: Robot, path: SetPoints, reference: TrackingResult, d: FloatArray, base: FloatArray
) -> FloatArray:
    """Error of l_d in the optimised program's e, (N, 3).

    Coordinates and constants are split into multiples of the grid, whose products and sums are
    exact, and rests. Leg 1: Q - Qh = sum dl (d + dh); legs 2, 3 add 3Ry -+ 2x_p x less the products
    of the multiples: c_l y + c_h y_l. With A the sum of the magnitudes: u of the rests of
    constants, the errors E of leg 1's d times dl, and 8uA of products, sums and the fused
    Qh - l_0^2, over 2l.

    What is of second order: l_0 is off by w = base + 3ul, so u w from the last sum of the rest, the
    Newton step 2w (base/l + 5u) and, since it divides by the measured length, w|e|/l, three sums
    3u (w + ul) with the counts, and u^2 l of the resolution's second part.
    """
    length, measured = reference.position_d[:, :3], np.abs(reference.position[:, :3])
    start = np.array([0.0, robot.R, 0.0])  # of leg 1
    place = np.asarray(path.position, np.float64)
    low, start_low = _rest(place), _rest(start)
    both = 2 * np.abs(d[:, 0]) + low + start_low
    dl = low + start_low
    error = U * (start + np.abs(d[:, 0]))
    size = np.sum(dl * both, axis=1)
    constants = np.sum(U * start_low * both + dl * error, axis=1)
    linear = np.array([2 * abs(robot.legs[1][0]), 3 * robot.R])  # of x, of y
    linear_low = _rest(linear)
    more = np.sum(linear_low * np.abs(place[:, :2]) + linear * low[:, :2], axis=1)
    more_constants = U * np.sum(linear_low * np.abs(place[:, :2]), axis=1)
    others = np.array([0.0, 1.0, 1.0])
    first = constants[:, None] + others * more_constants[:, None]
    first += 8 * U * (size[:, None] + others * more[:, None])
    off = base + 3 * U * length
    second = 2 * U * off + 2 * off * (base / length + 5 * U) + 3 * U * (off + U * length)
    second += off * np.abs(reference.e[:, :3]) / measured + U * U * measured
    return first / (2 * length) + second


def _rest(values: FloatArray) -> FloatArray:
    """Distances from the nearest multiples of the number grid."""
    return np.abs(values - np.rint(values / GRID) * GRID)


# ---------------------------------------------------------------- integrator


def _integrator(
    robot: Robot, reference: TrackingResult, e: FloatArray, velocity: FloatArray, optimised: bool
) -> FloatArray:
    """Error of s_c, (N, 5): the errors of phi_c e T_s added up, and 3u s_max per tick.

    phi_c: at most 12u (xi_c - 1) from t_c/T_c and the ramp's factors, and 8u phi_c with the
    product. Where abs(e) is closer to e_c than the bound of e, the ramp may be switched the other
    way. As printed t_c <= T_c/2 is decided on rounded times: if n = T_c/(2 T_s) fails there, that
    tick belongs to the ramp. Where abs(v_d) is below its bound, its sign and so the start of the
    boost is in doubt for a boost's length. Both integrators are within +-s_max.
    """
    n, end, size = reference.ticks, robot.boost_ticks, np.abs(reference.e)
    threshold, gain = np.array(robot.e_c), robot.xi_c - 1.0
    greatest = size + e
    wrong = reference.phi_c * e + greatest * U * (12 * gain + 8 * reference.phi_c)
    ramp = np.where((2 * n > end) & (n < end), 2.0 * gain * (1.0 - n / end), 0.0)
    if not optimised and _half_time_fails(robot):
        ramp = np.where(2 * n == end, gain, ramp)
        below = size <= threshold + e + U * threshold
        wrong += np.where(2 * n == end, below * gain * greatest, 0.0)
    wrong += (np.abs(size - threshold) <= e + U * threshold) * ramp * greatest
    doubt = _after_doubt(velocity, np.abs(reference.velocity_d), end)
    wrong += doubt * gain * greatest
    ticks = np.arange(1, len(e) + 1)[:, None]
    s_c = np.cumsum(wrong, axis=0) * robot.T_s + 3 * U * ticks * np.array(robot.s_max)
    return np.minimum(s_c, 2.0 * np.array(robot.s_max))


def _half_time_fails(robot: Robot) -> bool:
    """Whether n T_s <= T_c/2 is false in binary32 although n = T_c/(2 T_s)."""
    if robot.boost_ticks % 2:
        return False
    time = np.float32(robot.boost_ticks // 2) * np.float32(robot.T_s)
    return bool(time > np.float32(robot.T_c / 2.0))


def _after_doubt(velocity: FloatArray, speed: FloatArray, ticks: int) -> NDArray[np.bool_]:
    """Ticks (N, 5) within a boost's length after one whose sign of speed is in doubt."""
    doubt = (speed <= velocity) & (velocity > 0.0)
    last = np.where(doubt, np.arange(len(doubt))[:, None], -ticks - 1)
    return np.arange(len(doubt))[:, None] - np.maximum.accumulate(last, axis=0) <= ticks


# ---------------------------------------------------------------- dynamics


def _printed_dynamics(robot: Robot, reference: TrackingResult) -> tuple[FloatArray, FloatArray]:
    """Errors of M_ii (23) and G_i (24), (25), each (N, 3), for measured lengths with errors 2u l.

    cos = (l_i^2 + l_j^2 - 3R^2)/(2 l_i l_j): 8u of the numerator's parts and 7u. J = J_a +
    m_s (l - l_c)^2: m_s 2|l - l_c| times u (2l + l_c + |l - l_c|), and 4u. J (1 - cos^2)/l^2: 8u
    more.

    Gravity by Cramer's rule: x and y off by 3u sum(l^2)/R + 5u|x|, z by the error of z^2 over 2z; a
    horizontal coordinate of d by that and u (|x_p| + |d|). Cofactors: products of two such
    coordinates, 10u each; det is z times their sum, for which 6u more; quotient and weight 12u.
    """
    l_m, R = reference.position[:, :3], robot.R
    square, all_squares = l_m**2, np.sum(l_m**2, axis=1, keepdims=True)
    reach = np.abs(l_m - robot.l_c)
    inertia = robot.J_a + robot.m_s * reach**2
    inertia_error = 2 * robot.m_s * reach * U * (2 * l_m + robot.l_c + reach) + 4 * U * inertia
    mass = 8 * U * reference.mass[:, :3]
    for i, others in enumerate(OTHERS):
        for j in others:
            cos, parts = _cosine(robot, square, i, j)
            cos_error = 8 * U * parts + 7 * U * np.abs(cos)
            cos2_error = 2 * np.abs(cos) * cos_error + 3 * U * cos**2
            swung = inertia_error[:, j] + inertia[:, j] * (cos2_error + 10 * U)
            mass[:, i] += robot.m_s * cos2_error + swung / square[:, j]

    tool = reference.tool
    plane = 3 * U * all_squares / R + 5 * U * np.abs(tool[:, :2])  # (N, 2)
    d = tool[:, None, :2] - np.array(robot.legs)
    error = plane[:, None, :] + U * (np.abs(np.array(robot.legs)) + np.abs(d))
    l_1 = l_m[:, 0]
    z_error = 8 * U * square[:, 0] + 2 * np.abs(tool[:, 0]) * plane[:, 0] + 3 * U * tool[:, 0] ** 2
    z_error += 2 * l_1 * (plane[:, 1] + 2 * U * l_1 + U * R)
    z_relative = z_error / (2 * tool[:, 2] ** 2) + U
    area, area_error = (np.empty_like(l_m) for _ in range(2))
    for i, (j, k) in enumerate(OTHERS):
        (xj, yj), (xk, yk) = d[:, j].T, d[:, k].T
        (exj, eyj), (exk, eyk) = error[:, j].T, error[:, k].T
        area[:, i] = np.abs(xj * yk - xk * yj)
        area_error[:, i] = 10 * U * (np.abs(xj * yk) + np.abs(xk * yj))
        area_error[:, i] += exj * np.abs(yk) + np.abs(xj) * eyk
        area_error[:, i] += exk * np.abs(yj) + np.abs(xk) * eyj
    whole = 1.5 * np.sqrt(3.0) * R**2  # twice the area of the triangle of start points
    det_relative = np.sum(area_error + 6 * U * area, axis=1) / whole
    load = np.abs(reference.m_z) * robot.g
    carried = robot.m_s * reach + robot.mr_c
    load_error = robot.m_s * (2 * U * l_m + U * robot.l_c + 4 * U * reach) + 4 * U * robot.mr_c
    load_error = np.sum((load_error + 7 * U * carried) / l_m, axis=1) + 4 * U * robot.m_p
    lever = l_m / tool[:, 2:]
    gravity = lever * load[:, None] * area_error / whole
    relative = det_relative + z_relative + 12 * U
    gravity += np.abs(reference.gravity[:, :3]) * relative[:, None]
    gravity += lever * (area / whole) * (load_error * robot.g)[:, None]
    return mass, gravity


def _cosine(robot: Robot, square: FloatArray, i: int, j: int) -> tuple[FloatArray, FloatArray]:
    """Cosine of the angle between two legs (N,), and the size of the parts of its numerator."""
    double = 2 * np.sqrt(square[:, i] * square[:, j])
    total = square[:, i] + square[:, j]
    return (total - 3 * robot.R**2) / double, (total + 3 * robot.R**2) / double


def _optimised_dynamics(robot: Robot, reference: TrackingResult) -> tuple[FloatArray, FloatArray]:
    """The same of the optimised program, whose measured lengths are exact.

    p = l^2 - 3R^2/2: E = u(|p| + 3R^2/2). 2cos = (p_i + p_j)/(l_i l_j): E of both and u of the sum,
    and 6u for the product with two reciprocals (2u each). 4 sin^2 = 4 - (2cos)^2: 4|cos| times that
    and 8u. D/4 has two terms, 7u each.

    With P = sum p: z^2 = R^2/2 + P/3 + P^2/(18R^2) - sum p^2/(6R^2): errors of P and p, and 5u of
    all parts. b_i = 1/3 + (P - 3p_i)/(9R^2): the same errors, and 3u of its terms. Weight: 2u and
    6u of its two terms. G: 4u more.
    """
    l_m, R = reference.position[:, :3], robot.R
    square = l_m**2 - 1.5 * R**2
    square_error = U * (np.abs(square) + 1.5 * R**2)
    total = np.sum(square, axis=1)
    total_error = np.sum(square_error, axis=1) + U * (np.abs(square[:, 0] + square[:, 1]))
    total_error += U * np.abs(total)
    own = robot.m_p + 3 * robot.m_s
    relief = robot.m_s * robot.l_c / (2 * l_m)
    relief += (robot.J_a + robot.m_s * robot.l_c**2) / (4 * l_m**2)
    mass = np.repeat((3 * U * (own + 4 * np.sum(relief, axis=1)))[:, None], 3, axis=1)
    for i, others in enumerate(OTHERS):
        for j in others:
            lengths, numerator = l_m[:, i] * l_m[:, j], square[:, i] + square[:, j]
            cos = np.abs(numerator / (2 * lengths))
            parts = square_error[:, i] + square_error[:, j] + U * np.abs(numerator)
            double_error = parts / lengths + 12 * U * cos
            mass[:, i] += relief[:, j] * (28 * U + 4 * cos * double_error + 8 * U)

    z = reference.tool[:, 2]
    squares = np.sum(square**2, axis=1) / (6 * R**2)
    z_error = (1 / 3 + np.abs(total) / (9 * R**2)) * total_error
    z_error += np.sum(np.abs(square) * square_error, axis=1) / (3 * R**2)
    z_error += 5 * U * (R**2 / 2 + np.abs(total) / 3 + total**2 / (18 * R**2) + squares)
    z_relative = z_error / (2 * z**2) + U
    share = 1 / 3 + np.abs(total)[:, None] / (9 * R**2) + np.abs(square) / (3 * R**2)
    share_error = total_error[:, None] / (9 * R**2) + square_error / (3 * R**2) + 3 * U * share
    carried = (robot.m_s * robot.l_c + robot.mr_c) * np.sum(1 / l_m, axis=1)
    load_error = U * robot.g * (2 * own + 6 * carried)
    lever = l_m / z[:, None]
    load = np.abs(reference.m_z) * robot.g
    gravity = lever * share_error * load[:, None]
    gravity += np.abs(reference.gravity[:, :3]) * (z_relative + 4 * U)[:, None]
    gravity += lever * share * load_error[:, None]
    return mass, gravity


def _table_gravity(robot: Robot, reference: TrackingResult) -> FloatArray:
    """r_4 m_4 g sin(theta_4), (N, 2): 2u of the angle, 2u (an ulp) of the sine, 2u of products."""
    theta, weight = reference.position[:, 3], robot.r_4 * robot.m_4 * robot.g
    tilt = weight * U * (2 * np.abs(theta * np.cos(theta)) + 4 * np.abs(np.sin(theta)))
    return np.stack((tilt, np.zeros_like(tilt)), axis=1)
