# SPDX-License-Identifier: Apache-2.0
"""Currents and voltages in the stator's frame, for the start-up of one motor nobody knows yet.

A PI controller for each axis of the stator, its gains inputs, and ordered voltages added: with
gains of 0 the program orders voltages, else currents. Rotor angle, resistance and flux are not
needed, and no dead time is compensated: a recorded voltage is what was ordered.
"""

from __future__ import annotations

import math

import casadi as ca

from asip_asm.model.law import Law, Port
from sim.laws.drive.current_law import LARGEST, LEAST_VOLTAGE, MAGIC, PHASES, Setting
from sim.robot.drives import Inverter

ORDERS = ("i_alpha", "i_beta", "u_alpha", "u_beta", "gain", "share", "zero_a", "zero_b")
"""Words of a row: currents [A], voltages [V] to add, K_p [V/A], what an error adds to the integral
[V/A], samples without current [counts]."""
TITLE = "start up"
MOST = 0.4  # of the bus, for each axis: a square inside of the voltage circle


def start_up_law(inverter: Inverter, setting: Setting) -> Law:
    """Inputs: words of the link, then `ORDERS`; outputs: the compare values of one axis."""
    scale = inverter.current_scale * setting.ampere_per_count
    bus_most = 1.2 * inverter.U_dc / setting.bus_scale
    most, volts = inverter.current_scale, inverter.U_dc
    words = {"q0": LARGEST, "ia0": LARGEST, "ib0": LARGEST, "age0": LARGEST, "bus": int(bus_most)}
    ports = [
        Port("input", name, "count", "of the link", limits=(MAGIC - size, MAGIC + size))
        for name, size in words.items()
    ]
    limits = {"i": most, "u": volts, "g": 1e4, "s": 1e3, "z": LARGEST}
    ports += [
        Port("input", name, "1", "ordered by the host", limits=(-limits[name[0]], limits[name[0]]))
        for name in ORDERS
    ]
    ports += [
        Port("state", f"x_{axis}", "V", f"integral of {axis}", limits=(-volts, volts))
        for axis in ("alpha", "beta")
    ]
    at = {port.name: ca.SX.sym(port.name) for port in ports}
    bus = ca.fmax((at["bus"] - MAGIC) * setting.bus_scale, LEAST_VOLTAGE)
    i_a = (at["ia0"] - MAGIC - at["zero_a"]) * scale
    i_b = (at["ib0"] - MAGIC - at["zero_b"]) * scale
    sensed = {"alpha": i_a, "beta": (i_a + 2 * i_b) * (1 / math.sqrt(3.0))}
    circle = MOST * bus
    results, ordered = [], {}
    for axis, current in sensed.items():
        error = at[f"i_{axis}"] - current
        integral = at[f"x_{axis}"]
        asked = at["gain"] * error + integral + at[f"u_{axis}"]
        ordered[axis] = ca.fmax(ca.fmin(asked, circle), -circle)
        after = integral + at["share"] * error
        results.append((f"x_{axis}_next", ca.fmax(ca.fmin(after, circle), -circle)))
    across = ordered["beta"] * (math.sqrt(3.0) / 2)
    phases = [ordered["alpha"], across - 0.5 * ordered["alpha"], -across - 0.5 * ordered["alpha"]]
    middle = 0.5 * (
        ca.fmax(ca.fmax(phases[0], phases[1]), phases[2])
        + ca.fmin(ca.fmin(phases[0], phases[1]), phases[2])
    )
    for name, u in zip(PHASES, phases, strict=True):
        value = (u - middle) * (setting.half / bus) + (MAGIC + setting.half / 2)
        results.append((f"pwm0{name}", value))
        ports.append(
            Port(
                *("output", f"pwm0{name}", "count", f"compare value of phase {name}"),
                limits=(MAGIC, MAGIC + setting.half),
                safe=MAGIC,
            )
        )
    function = ca.Function(
        "start_up",
        list(at.values()),
        [value for _, value in results],
        list(at),
        [name for name, _ in results],
    )
    doc = "currents and voltages in the stator's frame, for the start-up of one motor"
    return Law(TITLE, function, ports, doc, 1 / setting.period)
