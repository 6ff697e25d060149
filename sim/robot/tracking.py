# SPDX-License-Identifier: Apache-2.0
"""Tracking law (28)-(37) in double precision: the reference of every other implementation.

`Tracking.step` advances one tick in Python floats, for closed loops; `run` evaluates a recorded
path at once, for comparisons. Both start from the same state: s_c = 0, sign 0, previous counts
equal to the first counts. They agree up to rounding. speed: one of `observer.SPEEDS`; the paper's
law takes the difference of two counts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from sim.robot import dynamics, integrator, kinematics
from sim.robot.observer import Observer, checked_speed, observed
from sim.robot.parameters import Robot
from sim.robot.records import Counts, Floats, SetPoints, TrackingResult, checked_counts
from sim.robot.stamps import Stamps, slips


class Tracking:
    """The law with its state between ticks."""

    def __init__(self, robot: Robot, speed: str = "difference") -> None:
        """Raises ValueError for an unknown speed."""
        self._robot = robot
        self._observer = Observer(robot) if checked_speed(speed) == "observer" else None
        self._stamps = Stamps(robot) if speed == "stamps" else None
        self._integrators = [integrator.Integrator(robot, axis) for axis in range(5)]
        self._before: Sequence[int] | None = None

    def step(self, words: Floats, counts: Counts) -> TrackingResult:
        """One tick.

        words: the 15 set-points in the order of `SetPoints`, SI units; counts: five encoder counts,
        with stamps five of these more.
        Returns tuples of Python floats. Raises WorkspaceError if the measured legs meet nowhere.
        """
        robot = self._robot
        point, speed, acceleration = tuple(words[0:3]), tuple(words[3:6]), tuple(words[6:9])
        x_d, y_d, z_d = point
        legs_d = kinematics.lengths_of(robot, x_d, y_d, z_d, math.sqrt)
        speeds_d = kinematics.velocities_of(robot, point, speed, legs_d)
        position_d = (*legs_d, *words[9:11])
        velocity_d = (*speeds_d, *words[11:13])
        acceleration_d = (
            *kinematics.accelerations_of(robot, point, speed, acceleration, legs_d, speeds_d),
            *words[13:15],
        )

        stamps, counts = counts[5:], counts[:5]
        before = counts if self._before is None else self._before
        self._before = tuple(counts)
        scale = robot.resolution
        position = tuple(q * int(n) for q, n in zip(scale, counts, strict=True))
        previous = tuple(q * int(n) for q, n in zip(scale, before, strict=True))
        if self._observer is None:  # with stamps, until e is known
            velocity = tuple((p - b) / robot.T_s for p, b in zip(position, previous, strict=True))
        else:
            moved = [int(n) - int(b) for n, b in zip(counts, before, strict=True)]
            velocity = self._observer.correct(moved)
        legs = position[:3]
        x, y, z2 = kinematics.height2_of(robot, *legs)
        if z2 < 0.0:
            kinematics.forward(robot, legs)  # raises with the text of the workspace
        tool = (x, y, math.sqrt(z2))

        e = tuple(d - p for d, p in zip(position_d, position, strict=True))
        if self._stamps is not None:
            found = self._stamps.errors([int(n) for n in stamps], e, velocity_d, acceleration_d)
            velocity = tuple(d - slip for d, slip in zip(velocity_d, found, strict=True))
        e_v = tuple(d - v for d, v in zip(velocity_d, velocity, strict=True))
        s_c = tuple(
            axis.step(error, v)
            for axis, error, v in zip(self._integrators, e, velocity_d, strict=True)
        )

        m_z = dynamics.carried_mass_of(robot, *legs)
        mass = (*dynamics.reduced_masses_of(robot, *legs), robot.J_44, robot.J_55)
        tilt = robot.r_4 * robot.m_4 * robot.g * math.sin(position[3])
        gravity = (*dynamics.gravity_of(robot, tool, legs, m_z), tilt, 0.0)
        asked = [
            acceleration_d[i] + robot.K_P[i] * e[i] + robot.K_V[i] * e_v[i] + robot.K_I[i] * s_c[i]
            for i in range(5)
        ]
        if self._observer is not None:
            asked = [a - p for a, p in zip(asked, self._observer.taken_off, strict=True)]
            self._observer.predict(asked)
        demand = tuple(mass[i] * asked[i] + gravity[i] for i in range(5))
        output = tuple(
            min(max(d, -limit), limit) for d, limit in zip(demand, robot.output_max, strict=True)
        )
        return TrackingResult(
            position_d=position_d,
            velocity_d=velocity_d,
            acceleration_d=acceleration_d,
            position=position,
            velocity=velocity,
            tool=tool,
            e=e,
            e_v=e_v,
            sign=tuple(axis.sign for axis in self._integrators),
            ticks=tuple(axis.ticks for axis in self._integrators),
            phi_c=tuple(axis.phi_c for axis in self._integrators),
            s_c=s_c,
            m_z=m_z,
            mass=mass,
            gravity=gravity,
            demand=demand,
            output=output,
        )


def joint_path(robot: Robot, path: SetPoints) -> tuple[kinematics.Array, ...]:
    """Desired motion of the five axes: position, velocity, acceleration, each (N, 5).

    The table's joints move as the path says, (18)-(20).
    """
    place = path.position
    legs = (
        kinematics.inverse(robot, place),
        kinematics.inverse_velocity(robot, place, path.velocity),
        kinematics.inverse_acceleration(robot, place, path.velocity, path.acceleration),
    )
    table = (path.table_position, path.table_velocity, path.table_acceleration)
    return tuple(np.concatenate(both, axis=1) for both in zip(legs, table, strict=True))


def run(
    robot: Robot, path: SetPoints, counts: ArrayLike, speed: str = "difference"
) -> TrackingResult:
    """The law over a recorded path from the start state.

    path: N ticks of set-points; counts: encoder counts (N, 5), integers of 32 bits, with stamps
    (N, 10). Returns arrays.
    Raises ValueError for counts of another shape or type or an unknown speed, WorkspaceError naming
    the tick if the measured legs meet nowhere.
    """
    checked_speed(speed)
    counts = checked_counts(counts, len(path), 10 if speed == "stamps" else 5)
    stamps, counts = counts[:, 5:], counts[:, :5]
    position_d, velocity_d, acceleration_d = joint_path(robot, path)
    position = np.array(robot.resolution) * counts
    legs = position[:, :3]
    tool = kinematics.forward(robot, legs)

    e = position_d - position
    sign = integrator.signs(velocity_d)
    ticks = integrator.ticks_since_reversal(sign, robot.boost_ticks)
    phi_c = integrator.boosts(robot, ticks, e)
    s_c = integrator.integrate(phi_c * e * robot.T_s, robot.s_max)

    table_mass = np.broadcast_to((robot.J_44, robot.J_55), (len(path), 2))
    mass = np.concatenate((dynamics.reduced_masses(robot, legs), table_mass), axis=1)
    gravity = np.concatenate(
        (dynamics.gravity(robot, tool, legs), dynamics.table_gravity(robot, position[:, 3:])),
        axis=1,
    )
    k_p, k_v, k_i = (np.array(gain) for gain in (robot.K_P, robot.K_V, robot.K_I))
    if speed == "observer":
        at_rest = acceleration_d + k_p * e + k_v * velocity_d + k_i * s_c
        states = observed(robot, counts, at_rest)
        velocity, known = states.speed, acceleration_d - states.taken_off
    elif speed == "stamps":
        known = acceleration_d
        velocity = velocity_d - slips(robot, stamps, e, velocity_d, acceleration_d)
    else:
        velocity, known = np.zeros_like(position), acceleration_d
        velocity[1:] = np.diff(position, axis=0) / robot.T_s
    e_v = velocity_d - velocity
    demand = mass * (known + k_p * e + k_v * e_v + k_i * s_c) + gravity
    limit = np.array(robot.output_max)
    return TrackingResult(
        position_d=position_d,
        velocity_d=velocity_d,
        acceleration_d=acceleration_d,
        position=position,
        velocity=velocity,
        tool=tool,
        e=e,
        e_v=e_v,
        sign=sign,
        ticks=ticks,
        phi_c=phi_c,
        s_c=s_c,
        m_z=dynamics.carried_mass(robot, legs),
        mass=mass,
        gravity=gravity,
        demand=demand,
        output=np.clip(demand, -limit, limit),
    )
