# SPDX-License-Identifier: Apache-2.0
"""Observer of a chain of twelve masses and springs: 24 states from five sensors and three forces.

The Kalman predictor x+ = A x + B u + L (y - C x) is one linear system with the inputs (u, y). Its
gain comes from the discrete Riccati equation in double precision (Anderson and Moore, Optimal
Filtering, chapter 4). The plant is nonlinear, in double precision: its springs harden with their
stretch, and sensors have noise and steps. Forces are sums of waves.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are

from asip_asm.image import Image
from asip_asm.model.law import check_limits
from asip_asm.model.linear_program import LinearSystem, linear_law, linear_plan, state_bounds
from asip_asm.model.options import compiled
from asip_asm.model.plan import stream_machine
from asip_asm.model.program import Built, build
from sim.core.api import Core
from sim.laws.mpc_proof import interpreted, on_core
from sim.laws.prove_program import draw

Matrix = NDArray[np.float64]
SEED = 24
MASSES = 12
SENSORS, FORCES = (0, 3, 6, 8, 11), (1, 5, 10)
"""Masses whose position is measured, and those that a force moves."""
PERIOD, FREQUENCY = 1e-3, 8.0  # s; Hz of a mass on its spring
DAMPING = 0.02
HARDENING = 0.3  # 1/m^2: share by which a spring is stiffer at a stretch of 1 m
NOISE, COUNT = 1e-3, 1e-4  # m: standard deviation, and a sensor's step
FORCE, PLACE = 1.0, 2.0  # limits of the inputs: force by stiffness [m], position [m]
STEPS = 10  # of the plant in a tick
RUN = 250
"""Ticks of a proof from a state of zero."""


@dataclass(frozen=True)
class Chain:
    """Stiffness of the springs (13,) and mass (12,), by the mean ones."""

    springs: Matrix
    masses: Matrix

    @classmethod
    def drawn(cls, seed: int = SEED) -> Chain:
        rng = np.random.default_rng(seed)
        return cls(rng.uniform(0.7, 1.3, MASSES + 1), rng.uniform(0.7, 1.3, MASSES))

    def rates(self, x: Matrix, u: Matrix, hardening: float = HARDENING) -> Matrix:
        """Rate of the state (24,): places [m], and speeds by 2 pi FREQUENCY [m]."""
        speed = 2 * np.pi * FREQUENCY
        place, moving = x[:MASSES], x[MASSES:]
        stretch = np.diff(place, prepend=0.0, append=0.0)
        pull = self.springs * (stretch + hardening * stretch**3)
        pull += DAMPING * self.springs * np.diff(moving, prepend=0.0, append=0.0)
        force = np.diff(pull)
        force[list(FORCES)] += u
        return speed * np.concatenate((moving, force / self.masses))

    def linear(self) -> tuple[Matrix, Matrix]:
        """A and B of a tick about rest."""
        n, m = 2 * MASSES, len(FORCES)
        whole = np.zeros((n + m, n + m))
        for k in range(n + m):
            unit = np.eye(n + m)[k]
            whole[:n, k] = self.rates(unit[:n], unit[n:], 0.0)
        step = expm(PERIOD * whole)
        return step[:n, :n], step[:n, n:]


def observer(chain: Chain | None = None) -> LinearSystem:
    """The predictor that is shown."""
    a, b = (chain or Chain.drawn()).linear()
    n = 2 * MASSES
    c = np.eye(n)[list(SENSORS)]
    process = 1e-5 * np.eye(n) + 1e-3 * b @ b.T
    noise = (NOISE**2 + COUNT**2 / 12) * np.eye(len(SENSORS))
    spread = solve_discrete_are(a.T, c.T, process, noise)
    gain = a @ spread @ c.T @ np.linalg.inv(c @ spread @ c.T + noise)
    limits = np.array([FORCE] * len(FORCES) + [PLACE] * len(SENSORS))
    return LinearSystem(
        "observer of 24 states", a - gain @ c, np.hstack((b, gain)),
        tuple(f"p{i}" for i in range(MASSES)) + tuple(f"v{i}" for i in range(MASSES)),
        tuple(f"u{i}" for i in FORCES) + tuple(f"y{i}" for i in SENSORS),
        limits, 1 / PERIOD, ("m",) * n, ("m",) * len(limits),
    )  # fmt: skip


def build_observer(system: LinearSystem, path: Path, configuration: str = "wide") -> Built:
    """The program, its source at `path`. Raises ModelError, OSError."""
    law, machine = linear_law(system), stream_machine(configuration)
    check_limits(law, machine)
    return build(compiled(linear_plan(system, machine), law), path)


@dataclass(frozen=True)
class ObserverProof:
    """Ticks tried; runs of other cycles than announced; words unlike the interpreter's; largest
    distance of an estimate from double precision [m], and as a share of its bound.
    """

    ticks: int
    other_cycles: int
    unequal: int
    error: float
    share: float

    @property
    def passed(self) -> bool:
        return not self.other_cycles and not self.unequal and self.share <= 1


def prove_observer(
    system: LinearSystem, built: Built, count: int, backend: str = "rtl", seed: int = SEED
) -> ObserverProof:
    """Run `count` ticks of drawn inputs, in runs from zero. Raises CoreFault if the core stops."""
    rng, law = np.random.default_rng(seed), built.compiled.law
    runs = max(1, count // RUN)
    ports = law.of_kind("input")
    given = {p.name: np.asarray(draw(p, runs * RUN, rng)).reshape(runs, RUN) for p in ports}
    names = list(system.states)
    got, cycles = on_core(built.image, given, names, backend)
    want = interpreted(built.compiled, given, names)
    unequal = sum(int((got[n].view(np.uint32) != want[n].view(np.uint32)).sum()) for n in names)
    double = in_doubles(
        system, np.stack([given[name] for name in system.inputs], axis=-1).astype(float)
    )
    _, bound = state_bounds(system)
    error = np.abs(np.stack([got[name] for name in names], axis=-1) - double)
    other = int((cycles != built.image.cycles).sum()) if cycles is not None else 0
    return ObserverProof(
        runs * RUN, other, unequal, float(error.max()), float((error / bound).max())
    )


def in_doubles(system: LinearSystem, w: Matrix) -> Matrix:
    """States (.., ticks, n) after each tick of inputs (.., ticks, m), from zero."""
    states = np.zeros((*w.shape[:-1], len(system.states)))
    x = np.zeros((*w.shape[:-2], len(system.states)))
    for tick in range(w.shape[-2]):
        x = x @ system.a.T + w[..., tick, :] @ system.b.T
        states[..., tick, :] = x
    return states


@dataclass(frozen=True)
class Watched:
    """Error of the estimated places and speeds after the start, root mean square [m]: by the core
    and in double precision; and largest distance of both [m].
    """

    core: float
    double: float
    apart: float


def recording(ticks: int, seed: int = SEED) -> tuple[Matrix, Matrix]:
    """True states (ticks, 24) after each tick, and inputs (ticks, 8) of the observer in it."""
    chain, rng = Chain.drawn(), np.random.default_rng(seed)
    waves = rng.uniform(0.3, 12.0, (4, len(FORCES)))
    phases = rng.uniform(0, 2 * np.pi, waves.shape)
    x, states, inputs = np.zeros(2 * MASSES), [], []
    step = PERIOD / STEPS
    for tick in range(ticks):
        u = 0.04 * np.sin(2 * np.pi * waves * tick * PERIOD + phases).sum(axis=0)
        y = x[list(SENSORS)] + rng.normal(scale=NOISE, size=len(SENSORS))
        inputs.append(np.concatenate((u, np.rint(y / COUNT) * COUNT)))
        for _ in range(STEPS):  # fourth order Runge and Kutta
            k1 = chain.rates(x, u)
            k2 = chain.rates(x + step / 2 * k1, u)
            k3 = chain.rates(x + step / 2 * k2, u)
            k4 = chain.rates(x + step * k3, u)
            x = x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        states.append(x)
    return np.array(states), np.array(inputs)


@dataclass(frozen=True)
class Followed:
    """Errors (ticks, 24) [m] of the estimates of a recorded plant, on the core and in double
    precision; the core's estimates (ticks, 24) [m].
    """

    core: Matrix
    double: Matrix
    estimates: Matrix


def follow(system: LinearSystem, image: Image, ticks: int, backend: str = "rtl") -> Followed:
    """Estimate the states of the nonlinear plant from its recorded inputs. Raises CoreFault."""
    true, w = recording(ticks)
    single = w.astype(np.float32)
    with Core(image, backend=backend) as core:
        found = core.batch({name: single[:, k] for k, name in enumerate(system.inputs)})
    got = np.stack([found[name] for name in system.states], axis=1).astype(float)
    double = in_doubles(system, single.astype(float))
    return Followed(got - true, double - true, got)


def watch(system: LinearSystem, image: Image, ticks: int, backend: str = "rtl") -> Watched:
    """Errors of the estimates of the nonlinear plant. Raises CoreFault."""
    found = follow(system, image, ticks, backend)
    core, double = (
        float(np.sqrt((each[ticks // 10 :] ** 2).mean())) for each in (found.core, found.double)
    )
    return Watched(core, double, float(np.abs(found.core - found.double).max()))
