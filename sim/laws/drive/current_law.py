# SPDX-License-Identifier: Apache-2.0
"""Field-oriented current loops of all axes as one program, from samples to compare values.

Words in and out are those of rtl/drive/servo_link.sv: 1.5 * 2^23 + integer. Per axis: electrical
angle from counts, Clarke, Park, PI in d and q with decoupling, the voltage circle with d first and
anti-windup by back-calculation, the angle ahead by the delay, dead time compensated by the sign
that the phase currents have then, with a smooth zone, space vectors by the mean of the extreme
phases. Sine and cosine are those of the last angle, turned by the counts since; the first run only
sets them. What a start-up finds are parameters: angle0 .. [rad] at count 0, zero_a0, zero_b0 .. of
the currents.

Equations: D. W. Novotny, T. A. Lipo, Vector Control and Dynamics of AC Drives, 1996; gains by the
magnitude optimum for a delay of 1.5 periods: K_p = L / (2 * 1.5 T), K_i = R K_p / L.

With a disturbance observer (K. Ohnishi, M. Shibata, T. Murakami, Motion Control for Advanced
Mechatronics, IEEE/ASME Transactions on Mechatronics 1(1), 1996) each axis adds to its order what
its motor's force did not accelerate: d = w - g M v, w' = g (F + g M v - w). The speed v comes from
the counts through a lag of the same bandwidth g, so what accelerates passes two lags.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from asip_asm.model.law import Law, Port
from sim.laws.drive.clocks import HALF_PERIOD, LOOP_PERIOD
from sim.robot.drives import Inverter, Motor
from sim.robot.parameters import Robot

AXES = tuple(range(5))
PHASES = "abc"
MAGIC = 1.5 * 2**23
LARGEST = 2**22 - 1
SLOW_RATE = 64  # of the current filters
DELAY = 1.5  # periods from the samples to the middle of the voltage
FASTEST = 1e3  # rad/s, electrical
SPEED_FILTER = 0.05  # share of a new speed
JUMP_SPEED = 500.0  # electrical, by which the angle follows a jump of the count [rad/s]
MOST_D = 0.95  # of the voltage circle for d; the root of what is left is well conditioned
LEAST_VOLTAGE = 20.0  # of the bus, for the division [V]
SMOOTH = 0.4  # of a phase current's largest ripple: there the effect of the dead time turns


@dataclass(frozen=True)
class Setting:
    """What the program is made for besides the motors.

    resolution: travel of a count [m or rad], per axis; offset: electrical angle at count 0 [rad],
    until a start-up writes another; period: of the loop [s]; half: compare value of full duty;
    observer: bandwidth [rad/s] of the disturbance observer of each axis, 0: none; moved: its mass
    or inertia [kg or kg m^2]; compensated: the most that it adds, as a share of the greatest force.
    bus_scale: volts of a count of the bus; compensation: of the dead time, as a share of what the
    parameters ask for; order_filter: time constant [s] of a low-pass in front of each axis' loop,
    0: none. A coarse encoder makes a tracking law order pulses beyond the slope that the bus
    voltage allows, and their mean would be lost. crossover: of the open loop of each axis [rad/s],
    0: that of the magnitude optimum. coarse: 1 of an axis whose count jumps by whole steps, as that
    of Hall lines does: a jump is no speed, and the angle follows it at `JUMP_SPEED`.
    """

    resolution: tuple[float, ...]
    offset: tuple[float, ...] = (0.0,) * 5
    period: float = LOOP_PERIOD
    half: int = HALF_PERIOD
    bus_scale: float = 0.05
    compensation: float = 1.0
    order_filter: tuple[float, ...] = (0.0,) * 5
    observer: tuple[float, ...] = (0.0,) * 5
    moved: tuple[float, ...] = (0.0,) * 5
    compensated: float = 0.3
    crossover: tuple[float, ...] = (0.0,) * 5
    coarse: tuple[float, ...] = (0.0,) * 5

    @property
    def ampere_per_count(self) -> float:
        return 2.0 / SLOW_RATE**3


OBSERVER = 300.0  # rad/s


def observed(robot: Robot) -> Setting:
    """The setting with a disturbance observer in every axis, which moves the mass of its own."""
    legs, table = (robot.m_s + robot.m_p,) * 3, (robot.J_44, robot.J_55)
    return Setting(robot.resolution, observer=(OBSERVER,) * 5, moved=(*legs, *table))


def gains(motor: Motor, period: float, crossover: float = 0.0) -> tuple[float, float, float]:
    """K_p of d and q [V/A], share of R K_p / L a period that an error adds to the integral.

    crossover: of the open loop [rad/s], 0: that of the magnitude optimum.
    """
    time = 1 / crossover if crossover else 2 * DELAY * period
    return motor.L_d / time, motor.L_q / time, motor.R / time * period


def current_law(drives: Inverter, setting: Setting, axes: Sequence[int] = AXES) -> Law:
    """The law of these axes; inputs force0 .. force4 [N, N m] are what the tracking law orders."""
    inputs, ports, results = [], [], []

    def source(
        kind: str, name: str, unit: str, limits: tuple[float, float], meaning: str, **rest: Any
    ) -> ca.SX:
        symbol = ca.SX.sym(name)
        inputs.append(symbol)
        ports.append(Port(kind, name, unit, meaning, limits=limits, **rest))
        return symbol

    def result(kind: str, name: str, value: ca.SX, **rest) -> None:
        results.append((name, value))
        if kind == "output":
            ports.append(Port(kind, name, **rest))

    def word(name: str, most: int, meaning: str, **rest: float) -> ca.SX:
        limits = (MAGIC - most, MAGIC + most)
        return source("input", name, "count", limits, f"{meaning}, 1.5 2^23 more", **rest)

    def parameter(name: str, unit: str, value: float, meaning: str) -> ca.SX:
        ports.append(Port("parameter", name, unit, meaning, initial=value))
        inputs.append(ca.SX.sym(name))
        return inputs[-1]

    samples = {}
    for n in axes:  # in the order of the link
        motor = drives.motors[n]
        scale = drives.current_scale * setting.ampere_per_count
        far = min(LARGEST, int(40 * motor.pole / setting.resolution[n]))
        most = int(1.5 * motor.i_max / scale)
        step = FASTEST * setting.period / (motor.wave * setting.resolution[n])
        most_change = math.inf if setting.coarse[n] else max(1, int(step))
        counts = word(f"q{n}", far, "position", change=most_change) - MAGIC
        currents = [word(f"i{k}{n}", most, f"current of phase {k}") for k in "ab"]
        zeros = [
            parameter(f"zero_{k}{n}", "count", MAGIC, f"word of phase {k} without current")
            for k in "ab"
        ]
        i_a, i_b = ((word - zero) * scale for word, zero in zip(currents, zeros, strict=True))
        word(f"age{n}", LARGEST, "clocks since the last count; not used")
        samples[n] = counts, i_a, i_b
    bus = word("bus", int(1.2 * drives.U_dc / setting.bus_scale), "bus voltage") - MAGIC
    bus = bus * setting.bus_scale
    bus = ca.fmax(bus, LEAST_VOLTAGE)
    circle = bus / math.sqrt(3.0)
    most_d, square = MOST_D * circle, circle * circle
    clocks = setting.half / bus
    lost = drives.dead_time + drives.delay_on - drives.delay_off
    dead = setting.compensation * (bus * (lost * drives.f_pwm) + drives.drop)
    for n in axes:
        motor = drives.motors[n]
        counts, i_a, i_b = samples[n]
        strongest = motor.force_per_ampere * motor.i_max
        force = source(
            "input", f"force{n}", "N", (-strongest, strongest), "ordered force or torque"
        )
        before = source("state", f"before{n}", "count", (-LARGEST, LARGEST), "position before")
        speed = source(
            "state", f"speed{n}", "rad/s", (-FASTEST, FASTEST), "electrical speed, filtered"
        )
        cosine = source("state", f"cosine{n}", "1", (-1, 1), "of the angle before")
        sine = source("state", f"sine{n}", "1", (-1, 1), "of the angle before")
        x_d = source("state", f"xd{n}", "V", (-drives.U_dc, drives.U_dc), "integral of d")
        x_q = source("state", f"xq{n}", "V", (-drives.U_dc, drives.U_dc), "integral of q")

        change = counts - before
        turned, shown = change, counts
        if setting.coarse[n]:
            behind = source("state", f"behind{n}", "count", (-LARGEST, LARGEST),
                            "counts of jumps that the angle has not followed yet")  # fmt: skip
            per_speed = setting.period / (motor.wave * setting.resolution[n])
            fastest, reach = FASTEST * per_speed, JUMP_SPEED * per_speed
            jump = change - ca.fmax(ca.fmin(change, fastest), -fastest)
            follow = ca.fmax(ca.fmin(behind + jump, reach), -reach)
            after = behind + jump - follow
            result("state", f"behind{n}_next", after)
            change, turned, shown = change - jump, change - jump + follow, counts - after
        turns = shown * (setting.resolution[n] / motor.pole)
        angle = (turns - ca.floor(turns + 0.5)) * (2 * math.pi) + parameter(
            f"angle{n}", "rad", setting.offset[n], "electrical angle at count 0"
        )
        result("state", f"cosine{n}_next", ca.cos(angle))
        result("state", f"sine{n}_next", ca.sin(angle))
        # Sine and cosine of the last angle, turned by the counts since then: a small angle.
        moved = turned * (motor.wave * setting.resolution[n])
        c, s = cosine - moved * sine, sine + moved * cosine
        if setting.coarse[n]:
            moved = change * (motor.wave * setting.resolution[n])
        w = speed + SPEED_FILTER * (moved * (1 / setting.period) - speed)

        beta = (i_a + 2 * i_b) * (1 / math.sqrt(3.0))
        i_d, i_q = i_a * c + beta * s, beta * c - i_a * s
        if setting.order_filter[n]:
            filtered = source("state", f"order{n}", "N", (-strongest, strongest), "filtered order")
            share = -math.expm1(-setting.period / setting.order_filter[n])
            force = filtered + share * (force - filtered)
            result("state", f"order{n}_next", force)
        if setting.observer[n]:
            band, mass = setting.observer[n], setting.moved[n]
            reach = FASTEST / (motor.wave * setting.resolution[n] * band)
            lag = source(
                "state", f"lag{n}", "count", (-reach, reach), "counts beyond the slow position"
            )
            share = -math.expm1(-band * setting.period)
            after = ca.fmax(ca.fmin((1 - share) * (lag + (counts - before)), reach), -reach)
            strength = setting.compensated * strongest
            momentum = band * mass * reach * band * setting.resolution[n]
            low = source("state", f"low{n}", "N", (-momentum - strength, momentum + strength),
                         "force and momentum, filtered")  # fmt: skip
            push = (band * band * mass * setting.resolution[n]) * after
            low = low + share * (motor.force_per_ampere * i_q + push - low)
            result("state", f"lag{n}_next", after)
            result("state", f"low{n}_next", low)
            force = force + ca.fmax(ca.fmin(low - push, strength), -strength)
        wanted = ca.fmax(ca.fmin(force * (1 / motor.force_per_ampere), motor.i_max), -motor.i_max)
        e_d, e_q = -i_d, wanted - i_q
        k_d, k_q, k_i = gains(motor, setting.period, setting.crossover[n])
        u_d = k_d * e_d + x_d - w * (motor.L_q * i_q)
        u_q = k_q * e_q + x_q + w * (motor.L_d * i_d + motor.psi)
        v_d = ca.fmax(ca.fmin(u_d, most_d), -most_d)
        rest = ca.sqrt(square - v_d * v_d)
        v_q = ca.fmax(ca.fmin(u_q, rest), -rest)
        result("state", f"before{n}_next", counts)
        result("state", f"speed{n}_next", w)
        result("state", f"xd{n}_next", x_d + k_i * e_d + (k_i / k_d) * (v_d - u_d))
        result("state", f"xq{n}_next", x_q + k_i * e_q + (k_i / k_q) * (v_q - u_q))

        ahead = w * (DELAY * setting.period)  # a small angle
        c, s = c - ahead * s, s + ahead * c
        alpha, beta = v_d * c - v_q * s, v_d * s + v_q * c
        across = beta * (math.sqrt(3.0) / 2)
        phases = [alpha, across - 0.5 * alpha, -across - 0.5 * alpha]
        middle = 0.5 * (
            ca.fmax(ca.fmax(phases[0], phases[1]), phases[2])
            + ca.fmin(ca.fmin(phases[0], phases[1]), phases[2])
        )
        i_alpha, i_beta = i_d * c - i_q * s, i_d * s + i_q * c
        across = i_beta * (math.sqrt(3.0) / 2)
        currents = [i_alpha, across - 0.5 * i_alpha, -across - 0.5 * i_alpha]
        zone = SMOOTH * drives.U_dc * setting.period / (8 * motor.L_q)
        for name, u, i in zip(PHASES, phases, currents, strict=True):
            sign = ca.fmax(ca.fmin(i * (1 / zone), 1.0), -1.0)
            value = (u - middle + dead * sign) * clocks + (MAGIC + setting.half / 2)
            result(
                "output",
                f"pwm{n}{name}",
                value,
                unit="count",
                meaning=f"compare value of phase {name}, 1.5 2^23 more",
                limits=(MAGIC, MAGIC + setting.half),
                safe=MAGIC,
            )
    function = ca.Function(
        "current_loops",
        inputs,
        [value for _, value in results],
        [symbol.name() for symbol in inputs],
        [name for name, _ in results],
    )
    number = {1: "one axis", len(AXES): "five axes"}.get(len(axes), f"{len(axes)} axes")
    doc = f"field-oriented current loops of {number}: samples of the servo link to compare values"
    return Law("current loops", function, ports, doc, 1 / setting.period)
