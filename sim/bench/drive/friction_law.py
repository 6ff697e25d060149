# SPDX-License-Identifier: Apache-2.0
"""The optimised tracking law with LuGre friction in it: a feed-forward, and an adaptive one.

The feed-forward moves a bristle of its own by the desired speed v, exactly over a tick:
z -> z + (g sign(v) / s0 - z) (1 - exp(-s0 |v| T / g)), and adds s0 z + s1 dz/dt + s2 v to the
force. The adaptive law scales the bristle's part by an estimate between bounds. A force that is too
large or too small by a share of the bristle's makes an error that is this share times the bristle's
force with the closed loop, s / (m (s + w)^3), and the estimate follows the gradient of that
error's square: error times filtered force, a bounded gradient law [P. A. Ioannou, J. Sun, Robust
Adaptive Control, 1996, sections 4.3, 4.4; friction: C. Canudas de Wit et al., IEEE TAC 40(3),
1995]. The filtered force is a pulse after each reversal and nothing at rest or in a long move,
where the error has other causes and friction is the integrator's.

At rest an integrator works against a bristle that takes any force up to the static friction, on an
error that is a part of a count: it hunts, or bends the bristle against the next move [B. Armstrong,
B. Amin, PID control in the presence of static friction, Automatica 32(5), 1996]. On the table,
where a count is coarse, both laws therefore have a dead zone of half a count at rest, and begin a
move with the integral that the last one ended with, as far as friction can explain the difference.
"""

from __future__ import annotations

import functools
import math

import casadi as ca

from asip_asm.image import Image
from asip_asm.model.compiler import Compiled, Options, compile_law
from asip_asm.model.law import Law, Port
from asip_asm.model.program import build
from asip_asm.project import BUILD
from sim.laws import own
from sim.robot.drives import Drives, Friction
from sim.robot.parameters import Robot

OPTIONS = Options(configuration="fast", reassociate=True, reciprocal=True)
KINDS = ("none", "feed-forward", "adaptive")
BOUNDS = (0.5, 1.5)  # of the estimate
PEAK = (0.2, 0.0)  # of the Stribeck peak of a leg, a table axis: see docs/drive.md
LEARNED = (1.0, 0.3)  # by a reversal of a leg, a table axis, of what an estimate lacks; about half
# of it in a loop that boosts its integrator. A count of the table is more than friction errs there.
STAGES = ("slow", "rise", "pulse")  # of the filter of an estimate
TABLE = {3: "J_44", 4: "J_55"}  # axes whose integral knows rest from motion; their inertias


def bristle(friction: Friction, z: ca.SX, v: ca.SX, period: float) -> tuple[ca.SX, ca.SX, ca.SX]:
    """z after a tick [m or rad], force of the bristle, and the rest of the force [N or N m]."""
    ratio = v * (1 / friction.speed)
    fall = ca.exp(-ca.fmin(ratio * ratio, 80.0))
    level = friction.coulomb + (friction.static - friction.coulomb) * fall
    turns = ca.fmin((friction.stiffness * period) * ca.fabs(v) / level, 80.0)
    end = ca.sign(v) * level * (1 / friction.stiffness)
    after = z + (end - z) * (1 - ca.exp(-turns))
    rest = (friction.damping / period) * (after - z) + friction.viscous * v
    return after, friction.stiffness * after, rest


def resumed(integral: ca.SX, moving: ca.SX, hidden: float, v: ca.SX) -> ca.SX:
    """Integral to go on with [rad/s^2]: at rest that of the last tick; in motion `moving`, that of
    the last tick in motion, or what is nearest to it within `hidden` of the integral. Friction F
    at rest is -F_s .. F_s, in motion F_c sign(v), so it hides F_s + F_c over the inertia at most;
    a load that was added at rest stays, except that much.
    """
    kept = ca.fmax(ca.fmin(moving, integral + hidden), integral - hidden)
    return ca.if_else(v == 0, integral, kept)


def pulse_of(robot: Robot, n: int, states: list[ca.SX], signal: ca.SX) -> tuple[list[ca.SX], ca.SX]:
    """`STAGES` after a tick, and w^2 s / (s + w)^3 of the signal: w is the loop's bandwidth."""
    share = -math.expm1(-corner(robot, n) * robot.T_s)
    slow, rise, pulse = states
    after = [slow + share * (signal - slow), rise + share * (signal - slow - rise)]
    after.append(pulse + share * (rise - pulse))
    return after, pulse


def corner(robot: Robot, n: int) -> float:
    """w of K_P = 3 w^2, K_V = 3 w [rad/s]."""
    return robot.K_P[n] / robot.K_V[n]


def learning(robot: Robot, n: int, believed: Friction) -> float:
    """Of an estimate, a tick and an error of 1 m or rad times the pulse. A force F that the law
    lacks errs by F / (m w^2) times its pulse, and the pulse of a reversal, (w t)^2 exp(-w t), has
    the energy 3 / (4 w)."""
    w = corner(robot, n)
    mass = getattr(robot, TABLE[n]) if n in TABLE else robot.m_s + robot.m_p / 3
    return LEARNED[n in TABLE] * (4 / 3) * w * robot.T_s * mass * w * w / believed.coulomb


def friction_law(robot: Robot, drives: Drives, kind: str, share: float = 1.0) -> Law:
    """A law of these `KINDS`; share: of the true friction that the law believes in, coulomb,
    static and viscous. Raises ValueError for an unknown kind.
    """
    if kind not in KINDS:
        raise ValueError(f"friction law {kind!r}: must be one of {', '.join(KINDS)}")
    law = own.optimised(robot)
    if kind == "none":
        return law
    own_law = law.in_casadi
    names = [own_law.name_in(k) for k in range(own_law.n_in())]
    inputs = {name: ca.SX.sym(name, *own_law.size_in(name)) for name in names}
    out_names = [own_law.name_out(k) for k in range(own_law.n_out())]
    place, v, a = ([inputs[n] for n in own.SET_POINTS[k : k + 3]] for k in (0, 3, 6))
    counts = ca.vertsplit(inputs["count"])
    parts, speeds, *_ = own.short_kinematics(robot, place, v, a, counts[:3])
    parts += [
        own.table_errors(robot, inputs[name], count)
        for name, count in zip(("alpha", "gamma"), counts[3:], strict=True)
    ]
    errors = [sum(terms[1:], terms[0]) for terms in parts]
    speeds = [*speeds, inputs["w_alpha"], inputs["w_gamma"]]
    ports = list(law.ports)
    integrals = ca.vertsplit(inputs["integral"])
    moving = {n: ca.SX.sym(f"moving{n}") for n in TABLE}
    for n, inertia in TABLE.items():
        friction = drives.friction[n]
        hidden = share * (friction.static + friction.coulomb) / getattr(robot, inertia)
        integrals[n] = resumed(integrals[n], moving[n], hidden, speeds[n])
    arguments = inputs | {"integral": ca.vertcat(*integrals)}
    with own.as_written():
        results = own_law.call(list(arguments.values()))
    found = dict(zip(out_names, results, strict=True))
    for n, before in moving.items():
        inputs[f"moving{n}"] = before
        limits = law.port(f"integral{n}").limits
        ports.append(Port("state", f"moving{n}", "rad/s^2", limits=limits))
        after, rest = found["integral_next"][n], speeds[n] == 0
        unseen = ca.fabs(errors[n]) <= 0.5 * robot.resolution[n]
        held = ca.if_else(unseen, integrals[n], after)
        found["integral_next"][n] = ca.if_else(rest, held, after)
        found[f"moving{n}_next"] = ca.if_else(rest, before, after)
    for n, output in enumerate(own.OUTPUTS):
        true = drives.friction[n]
        peak = PEAK[n in TABLE] * (true.static - true.coulomb)
        believed = Friction(
            share * true.coulomb,
            share * (true.coulomb + peak),
            true.speed,
            true.stiffness,
            true.damping,
            share * true.viscous,
        )
        most = believed.static / believed.stiffness
        z = inputs[f"z{n}"] = ca.SX.sym(f"z{n}")
        ports.append(Port("state", f"z{n}", "m" if n < 3 else "rad", limits=(-most, most)))
        found[f"z{n}_next"], force, rest = bristle(believed, z, speeds[n], robot.T_s)
        if kind == "adaptive":
            estimate = inputs[f"share{n}"] = ca.SX.sym(f"share{n}")
            ports.append(Port("state", f"share{n}", limits=BOUNDS, initial=1.0))
            states = [ca.SX.sym(f"{name}{n}") for name in STAGES]
            inputs |= {state.name(): state for state in states}
            ports += [Port("state", state.name(), limits=(-2.0, 2.0)) for state in states]
            stages, pulse = pulse_of(robot, n, states, force * (1 / believed.coulomb))
            found |= {f"{s.name()}_next": v for s, v in zip(states, stages, strict=True)}
            step = learning(robot, n, believed) * errors[n] * pulse
            found[f"share{n}_next"] = ca.fmax(ca.fmin(estimate + step, BOUNDS[1]), BOUNDS[0])
            force = estimate * force
        found[output] = found[output] + force + rest
    function = ca.Function(
        "tracking", list(inputs.values()), list(found.values()), list(inputs), list(found)
    )
    title = f"five axes, friction {kind}"
    return Law(title, function, ports, title, law.rate)


def compiled(robot: Robot, drives: Drives, kind: str, share: float = 1.0) -> Compiled:
    """The program of a friction law."""
    return compile_law(friction_law(robot, drives, kind, share), OPTIONS)


@functools.cache
def image(robot: Robot, drives: Drives, kind: str) -> Image:
    """Its image for the tracking core, made once, with the true friction."""
    path = BUILD / f"servo/tracking_{kind}_1.s"
    path.parent.mkdir(parents=True, exist_ok=True)
    return build(compiled(robot, drives, kind), path).image
