# SPDX-License-Identifier: Apache-2.0
"""Small laws for the tests of the compiler."""

from __future__ import annotations

import casadi as ca

from asip_asm.model.law import Law, Port

COUNT_SCALE = 6.283185307179586 / 65536
TURN_SCALE = 6.283185307179586 / 4096  # rad, of a count
RATE = 1e4  # ticks a second


def mixed() -> Law:
    """Division, sine, a choice, a state, saturation, a count and its rate."""
    x, y, s = ca.SX.sym("x", 3), ca.SX.sym("y"), ca.SX.sym("s")
    q, rate, gain = ca.SX.sym("q"), ca.SX.sym("q_rate"), ca.SX.sym("gain")
    chosen = ca.if_else(y > 0, ca.sin(x[0]) * x[1], x[2] / (y * y + 0.5))
    first = chosen - x[0] * x[1] * 3 - y * x[2] + gain * (x[0] - q) - 0.1 * rate
    second = ca.fmax(ca.fmin(x[0] * y - x[1] - x[2] * 2 - y, 5), -5)
    total = ca.fmin(ca.fmax(s + 0.01 * (x[0] - q), -1), 1)
    function = ca.Function(
        "mixed",
        [x, y, s, q, rate, gain],
        [first + total, second, total],
        ["x", "y", "s", "q", "q_rate", "gain"],
        ["a", "b", "s_next"],
    )
    vector = [Port("input", f"x{i}", vector="x") for i in range(3)]
    return Law(
        "mixed",
        function,
        [
            *vector,
            Port("input", "y", limits=(-2.0, 2.0)),
            Port("input", "q", "rad", type="int", scale=COUNT_SCALE, offset=0.25, limits=(-3, 3)),
            Port("rate", "q_rate", "rad/s", scale=1e4 * COUNT_SCALE, rate_of="q", limits=(-5, 5)),
            Port("state", "s", limits=(-1.0, 1.0)),
            Port("parameter", "gain", initial=12.5),
            Port("output", "a", "N m", limits=(-20.0, 20.0)),
            Port("output", "b", limits=(-3.0, 3.0)),
        ],
    )


def sample() -> Law:
    """Products, quotients, roots, choices, limits, a state, a count and its rate.

    The law of the committed image: its order of operations leaves the compiler no choice, and it
    has no sine, which the C library and the core round differently.
    """
    x, y, z = (ca.SX.sym(name) for name in ("x", "y", "z"))
    q, rate, total, gain = (ca.SX.sym(name) for name in ("q", "q_rate", "total", "gain"))
    product = x * y
    root = ca.sqrt(ca.fabs(product))
    quotient = x / (z * z + 0.5)
    chosen = ca.if_else(x < z, root, quotient)
    error = gain * (y - q)
    following = ca.fmax(ca.fmin(total + 1e-3 * error, 0.5), -0.5)
    function = ca.Function(
        "platforms",
        [x, y, z, q, rate, total, gain],
        [chosen - 3 * product, ca.fmin(x, ca.fmax(y, z)) * ca.sign(z), error - 0.01 * rate + total,
         ca.floor(4 * quotient), following],
        ["x", "y", "z", "q", "q_rate", "total", "gain"],
        ["mixed", "between", "torque", "steps", "total_next"],
    )  # fmt: skip
    unit = {"limits": (-2.0, 2.0)}
    return Law(
        "platforms",
        function,
        [
            Port("input", "x", **unit),
            Port("input", "y", **unit),
            Port("input", "z", **unit),
            Port("input", "q", "rad", type="int", scale=TURN_SCALE, offset=0.25, limits=(-3, 3)),
            Port("rate", "q_rate", "rad/s", scale=RATE * TURN_SCALE, rate_of="q", limits=(-50, 50)),
            Port("state", "total", limits=(-0.5, 0.5)),
            Port("parameter", "gain", initial=12.5),
            Port("output", "mixed"),
            Port("output", "between"),
            Port("output", "torque", "N m", limits=(-20.0, 20.0), safe=1.5),
            Port("output", "steps"),
        ],
        rate=RATE,
    )
