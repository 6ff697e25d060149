# SPDX-License-Identifier: Apache-2.0
"""Closed loop of a compiled law and a simulated machine: once with the program on the core, once
with the CasADi function in double precision, from the same start over the same set-points.

Each tick the machine's sensors are read, the law computes, and the machine moves on with the
outputs held (classical Runge-Kutta of order 4 in double precision).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from asip_asm.image import Image
from asip_asm.model.law import Law, before
from sim.core.api import Core
from sim.laws.laws import Settings, count_scale, position_limits, speed_limits
from sim.laws.reference import PinocchioRobot
from sim.laws.tree import Tree

Values = Mapping[str, float]


class Machine(Protocol):
    """What a law controls. ticks: length of the run; axes: unit of each tracking error by name."""

    ticks: int

    @property
    def axes(self) -> Mapping[str, str]: ...

    def start(self) -> None:
        """Back to the start state."""

    def inputs(self, tick: int) -> dict[str, float]:
        """Set-points and sensor values of the tick; encoder counts are integers."""

    def step(self, outputs: Values) -> None:
        """One tick with the outputs held."""

    def error(self, tick: int) -> NDArray[np.float64]:
        """Tracking errors at the tick, in the order of `axes`."""


@dataclass(frozen=True)
class Loop:
    """Errors (ticks, n) and outputs (ticks, m) of one run."""

    errors: NDArray[np.float64]
    outputs: NDArray[np.float64]


START = 0.25
"""Share of a run in which errors of the start fade; it is not checked."""


@dataclass(frozen=True)
class ClosedLoop:
    """Both runs. axes: unit of each error by name. saturated: ticks of the run in double precision
    with an output at its limit; the ratios say little if there are any.

    The measure of an axis is the root mean square of its error after the first `START` of the run.
    An encoder holds an axis within a fraction of a count, where the last bit of a torque decides at
    which tick the count changes: the largest error is one such tick, and differs from run to run in
    double precision too. The mean over thousands of ticks does not hang on one of them.
    """

    ticks: int
    core: Loop
    double: Loop
    axes: Mapping[str, str]
    saturated: int

    @property
    def ratios(self) -> dict[str, float]:
        """Error of each axis on the core by that in double precision, 1 where both are zero."""
        pairs = zip(self.axes, self.rms(self.core), self.rms(self.double), strict=True)
        return {name: _ratio(core, double) for name, core, double in pairs}

    @property
    def worst(self) -> str:
        """The axis with the largest ratio; one that is no number counts as the largest."""
        return max(self.ratios, key=lambda name: np.nan_to_num(self.ratios[name], nan=np.inf))

    @property
    def ratio(self) -> float:
        """Largest of the ratios."""
        return self.ratios[self.worst]

    def rms(self, loop: Loop) -> NDArray[np.float64]:
        """Root mean square of each error (n,) after the start."""
        return np.sqrt(np.mean(loop.errors[int(START * self.ticks) :] ** 2, axis=0))


def _ratio(core: float, double: float) -> float:
    if double == 0:
        return 1.0 if core == 0 else np.inf
    return float(core / double)


class DoubleLaw:
    """The law in double precision, tick by tick, with its states."""

    def __init__(self, law: Law) -> None:
        self.law = law
        self.function = law.in_casadi
        self.arguments = [ports for _, ports in law.arguments()]
        self.ports = [port for ports in self.arguments for port in ports]
        self.results = [port for _, ports in law.results() for port in ports]
        self.state = {port.name: port.initial for port in law.of_kind("state")}
        self.last: dict[str, int] = {}

    def tick(self, inputs: Values) -> dict[str, float]:
        """Outputs of a tick."""
        physical = {}
        for port in self.ports:
            if port.kind == "rate":
                count = inputs[port.rate_of]
                physical[port.name] = port.scale * (count - self.last.get(port.rate_of, count))
            elif port.kind == "state":
                physical[port.name] = self.state[port.name]
            elif port.kind == "parameter":
                physical[port.name] = port.initial
            else:
                value = inputs[port.name]
                scaled = port.type == "int"
                physical[port.name] = port.scale * value + port.offset if scaled else value
        self.last = {port.rate_of: int(inputs[port.rate_of]) for port in self.law.of_kind("rate")}
        arguments = [
            ca.reshape(ca.DM([physical[port.name] for port in ports]), self.function.size_in(i))
            for i, ports in enumerate(self.arguments)
        ]
        found = [v for r in self.function.call(arguments) for v in r.full().ravel(order="F")]
        outputs = {}
        for port, value in zip(self.results, found, strict=True):
            if port.kind == "state":
                self.state[port.name] = value
            else:
                low, high = port.limits or (-np.inf, np.inf)
                outputs[port.name] = min(max(value, low), high)
        return outputs


def close_loop(law: Law, image: Image, machine: Machine, backend: str = "rtl") -> ClosedLoop:
    """Run the machine with the program and with double precision. Raises CoreFault."""
    with Core(image, backend=backend) as core:
        first = {p.name for p in law.of_kind("rate")}

        def on_core(inputs: Values, tick: int) -> Values:
            if tick == 0 and first:
                core.preset(
                    {before(p.rate_of): int(inputs[p.rate_of]) for p in law.of_kind("rate")}
                )
            return core.tick(inputs)

        got = _run(machine, on_core)
    double = DoubleLaw(law)
    want = _run(machine, lambda inputs, _: double.tick(inputs))
    outputs = [port for port in double.results if port.kind != "state"]
    limits = np.array([port.limits or (-np.inf, np.inf) for port in outputs])
    at_limit = (want.outputs <= limits[:, 0]) | (want.outputs >= limits[:, 1])
    return ClosedLoop(machine.ticks, got, want, machine.axes, int(at_limit.any(axis=1).sum()))


def _run(machine: Machine, law: Callable[[Values, int], Values]) -> Loop:
    machine.start()
    errors, outputs = [], []
    for tick in range(machine.ticks):
        made = law(machine.inputs(tick), tick)
        errors.append(machine.error(tick))
        outputs.append(list(made.values()))
        machine.step(made)
    return Loop(np.array(errors), np.array(outputs))


class Arm:
    """A robot of a tree: axes follow sines within their limits; pinocchio's forward dynamics of the
    URDF is the plant, without friction. Inputs are those of `laws.computed_torque`.
    """

    SPEED, REACH = 0.5, 0.25
    """Shares of the speed limits, and of the range of positions, that the motion uses."""

    def __init__(self, tree: Tree, settings: Settings, seconds: float = 2.0) -> None:
        self.tree, self.settings = tree, settings
        self.ticks = round(seconds * settings.rate)
        self.axes = {j.name: "rad" if j.kind == "revolute" else "m" for j in tree.axes}
        self.plant = PinocchioRobot(tree.description.text, tree.stated)
        self.scales = [count_scale(joint, settings) for joint in tree.axes]
        t = np.arange(self.ticks + 1) / settings.rate
        columns = [self._motion(i, t) for i in range(len(tree.axes))]
        self.goal, self.speed, self.accel = (
            np.stack([c[k] for c in columns], axis=1).astype(np.float32) for k in range(3)
        )
        self.plant.check_movable(self.goal[0].astype(float))
        self.start()

    def _motion(self, i: int, t: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Position, speed and acceleration of joint i: a raised cosine, at rest at first."""
        low, high = position_limits(self.tree.axes[i])
        middle = min(max(0.0, low + 0.3 * (high - low)), high - 0.3 * (high - low))
        omega = 2 * np.pi * (0.5 + 0.07 * i)
        size = min(
            self.REACH * (high - low),
            self.SPEED * speed_limits(self.tree.axes[i])[1] / omega,
            self.settings.acceleration / 3 / omega**2,
        )
        phase = omega * t
        return (
            middle + size * (1 - np.cos(phase)) / 2,
            size * omega * np.sin(phase) / 2,
            size * omega**2 * np.cos(phase) / 2,
        )

    def start(self) -> None:
        self.q = self.goal[0].astype(float)
        self.v = np.zeros_like(self.q)

    def inputs(self, tick: int) -> dict[str, float]:
        values: dict[str, float] = {}
        for i, q in enumerate(self.q):
            values[f"goal{i}"] = self.goal[tick, i]
            values[f"speed{i}"] = self.speed[tick, i]
            values[f"accel{i}"] = self.accel[tick, i]
            values[f"q{i}"] = round((q - self.tree.axes[i].zero) / self.scales[i])
        return values

    def error(self, tick: int) -> NDArray[np.float64]:
        return self.goal[tick] - self.q

    def step(self, outputs: Values) -> None:
        tau = np.array([outputs[f"tau{i}"] for i in range(len(self.q))])
        h, q, v = 1 / self.settings.rate, self.q, self.v
        a1 = self.plant.forward(q, v, tau)
        v2 = v + h / 2 * a1
        a2 = self.plant.forward(q + h / 2 * v, v2, tau)
        v3 = v + h / 2 * a2
        a3 = self.plant.forward(q + h / 2 * v2, v3, tau)
        v4 = v + h * a3
        a4 = self.plant.forward(q + h * v3, v4, tau)
        self.q = q + h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        self.v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
