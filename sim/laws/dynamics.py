# SPDX-License-Identifier: Apache-2.0
"""Symbolic dynamics of a tree with base parameters, for CasADi.

Recursion of Newton and Euler in link axes with U = [w']x + [w]x[w]x, which every product of a link
with its motion shares: acceleration of a point r is a + U r, the force on a link m a + U mc, the
moment vee(U J) + mc x a with the second moments J (Khalil and Dombre, Modeling, Identification and
Control of Robots, 2002, chapter 9). CasADi folds zeros and ones while the expressions are made.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np

from sim.laws.tree import Joint, Tip, Tree

Vector = list[ca.SX]
QUARTER = math.pi / 2


def _dot(row: np.ndarray | Vector, vector: Vector | list[float]) -> ca.SX:
    return sum((row[k] * vector[k] for k in range(3)), ca.SX(0))


def _cross(a: Vector, b: Vector) -> Vector:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


@dataclass(frozen=True)
class Turn:
    """Sine and cosine of a joint's angle (0, 1 for a prismatic joint)."""

    joint: Joint
    sine: ca.SX
    cosine: ca.SX

    def inwards(self, v: Vector) -> Vector:
        """A vector of the parent's axes in the joint's axes: Rz^T A^T v."""
        x, y, z = (_dot(self.joint.rotation[:, k], v) for k in range(3))
        return [self.cosine * x + self.sine * y, self.cosine * y - self.sine * x, z]

    def outwards(self, v: Vector) -> Vector:
        """A vector of the joint's axes in the parent's: A Rz v."""
        turned = [
            self.cosine * v[0] - self.sine * v[1],
            self.sine * v[0] + self.cosine * v[1],
            v[2],
        ]
        return [_dot(self.joint.rotation[k, :], turned) for k in range(3)]


def turn(joint: Joint, q: ca.SX) -> Turn:
    """Sine and cosine of q + offset; quarter turns of the offset swap them."""
    if joint.kind == "prismatic":
        return Turn(joint, ca.SX(0), ca.SX(1))
    quarters = round(joint.offset / QUARTER)
    rest = joint.offset - quarters * QUARTER
    angle = q if abs(rest) < 1e-9 else q + rest
    s, c = ca.sin(angle), ca.cos(angle)
    sine, cosine = ((s, c), (c, -s), (-s, -c), (-c, s))[quarters % 4]
    return Turn(joint, sine, cosine)


def joint_values(tree: Tree, q: ca.SX, shifted: bool = True) -> list[ca.SX]:
    """Value of every joint of those of the axes (n,): a follower's is its leader's times its
    multiplier, plus its shift for positions.
    """
    found = []
    for joint, axis in zip(tree.joints, tree.axis_of, strict=True):
        value = q[axis] if joint.multiplier == 1.0 else joint.multiplier * q[axis]
        found.append(value + joint.shift if shifted and joint.shift else value)
    return found


def axis_forces(tree: Tree, forces: list[ca.SX]) -> ca.SX:
    """Forces of the axes (n,): a follower's acts at its leader, times its multiplier."""
    found: dict[int, ca.SX] = {}
    for joint, axis, force in zip(tree.joints, tree.axis_of, forces, strict=True):
        part = force if joint.multiplier == 1.0 else joint.multiplier * force
        found[axis] = found[axis] + part if axis in found else part
    return ca.vertcat(*(found[axis] for axis in range(len(tree.axes))))


def turns(tree: Tree, q: list[ca.SX]) -> list[Turn]:
    """Turn of every joint."""
    return [turn(joint, q[i]) for i, joint in enumerate(tree.joints)]


def reach(joint: Joint, q: ca.SX) -> Vector:
    """Origin of the joint's frame in the parent's."""
    base = [ca.SX(value) for value in joint.position]
    if joint.kind == "revolute":
        return base
    return [base[k] + float(joint.rotation[k, 2]) * q for k in range(3)]


@dataclass(frozen=True)
class Motion:
    """Angular velocity, its derivative, and acceleration of the origin less gravity, link axes."""

    w: Vector
    alpha: Vector
    a: Vector

    @property
    def u(self) -> list[Vector]:
        """[alpha]x + [w]x[w]x."""
        x, y, z = self.w
        p, q, r = self.alpha
        xy, xz, yz = x * y, x * z, y * z
        return [
            [-(y * y + z * z), xy - r, xz + q],
            [xy + r, -(x * x + z * z), yz - p],
            [xz - q, yz + p, -(x * x + y * y)],
        ]


def inverse_dynamics(tree: Tree, q: ca.SX, dq: ca.SX, ddq: ca.SX) -> ca.SX:
    """Forces of the axes (n,) [N m, N] of their positions, velocities, accelerations (n,); no
    friction.
    """
    n = len(tree.joints)
    at = joint_values(tree, q)
    acceleration = joint_values(tree, ddq, shifted=False)
    rotation = turns(tree, at)
    motions = _outwards(tree, rotation, at, joint_values(tree, dq, shifted=False), acceleration)
    force: list[Vector] = [[ca.SX(0)] * 3 for _ in range(n)]
    moment: list[Vector] = [[ca.SX(0)] * 3 for _ in range(n)]
    result = [ca.SX(0)] * n
    for i in reversed(range(n)):
        joint = tree.joints[i]
        own_force, own_moment = _wrench(joint, motions[i])
        f = [a + b for a, b in zip(force[i], own_force, strict=True)]
        m = [a + b for a, b in zip(moment[i], own_moment, strict=True)]
        result[i] = (m if joint.kind == "revolute" else f)[2] + joint.armature * acceleration[i]
        if joint.parent >= 0:
            at_parent = rotation[i].outwards(f)
            lever = _cross(reach(joint, at[i]), at_parent)
            p = joint.parent
            force[p] = [a + b for a, b in zip(force[p], at_parent, strict=True)]
            turned = rotation[i].outwards(m)
            moment[p] = [a + (b + c) for a, b, c in zip(moment[p], turned, lever, strict=True)]
    return axis_forces(tree, result)


def _outwards(
    tree: Tree, rotation: list[Turn], q: list[ca.SX], dq: list[ca.SX], ddq: list[ca.SX]
) -> list[Motion]:
    """Motion of every link, from the base on; values of every joint."""
    still = [ca.SX(0)] * 3
    base = Motion(still, still, [ca.SX(-value) for value in tree.gravity])
    motions: list[Motion] = []
    for i, joint in enumerate(tree.joints):
        parent = motions[joint.parent] if joint.parent >= 0 else base
        w, alpha = rotation[i].inwards(parent.w), rotation[i].inwards(parent.alpha)
        u, t = parent.u, reach(joint, q[i])
        a = rotation[i].inwards([parent.a[k] + _dot(u[k], t) for k in range(3)])
        x, y, z = w
        if joint.kind == "revolute":
            alpha = [alpha[0] + y * dq[i], alpha[1] - x * dq[i], alpha[2] + ddq[i]]
            w = [x, y, z + dq[i]]
        else:
            twice = 2 * dq[i]
            a = [a[0] + y * twice, a[1] - x * twice, a[2] + ddq[i]]
        motions.append(Motion(w, alpha, a))
    return motions


def _wrench(joint: Joint, motion: Motion) -> tuple[Vector, Vector]:
    """Force, and moment about the origin, that the link's motion takes."""
    u, a, w = motion.u, motion.a, motion.w
    j, mc, mass = joint.pseudo, [float(v) for v in joint.pseudo[:3, 3]], float(joint.pseudo[3, 3])
    force = [_dot(u[k], mc) + mass * a[k] for k in range(3)]
    square = [w[k] * w[k] for k in range(3)]
    # r x U r summed over the link: entries of U in pairs, differences of its diagonal as squares.
    x = (
        j[0, 1] * u[2][0] + j[1, 1] * u[2][1] - j[0, 2] * u[1][0] - j[2, 2] * u[1][2]
        + j[1, 2] * (square[2] - square[1])
    )  # fmt: skip
    y = (
        j[1, 2] * u[0][1] + j[2, 2] * u[0][2] - j[0, 0] * u[2][0] - j[0, 1] * u[2][1]
        + j[0, 2] * (square[0] - square[2])
    )  # fmt: skip
    z = (
        j[0, 0] * u[1][0] + j[0, 2] * u[1][2] - j[1, 1] * u[0][1] - j[1, 2] * u[0][2]
        + j[0, 1] * (square[1] - square[0])
    )  # fmt: skip
    lever = _cross([ca.SX(v) for v in mc], a)
    return force, [p + r for p, r in zip((x, y, z), lever, strict=True)]


def gravity_forces(tree: Tree, q: ca.SX) -> ca.SX:
    """Forces of the axes (n,) that hold the robot at rest."""
    still = ca.SX.zeros(len(tree.axes))
    return inverse_dynamics(tree, q, still, still)


def placements(tree: Tree, q: ca.SX) -> list[tuple[list[Vector], Vector]]:
    """Rotation (rows) and origin of every joint's frame in base axes."""
    found: list[tuple[list[Vector], Vector]] = []
    at = joint_values(tree, q)
    for i, (joint, rotation) in enumerate(zip(tree.joints, turns(tree, at), strict=True)):
        columns = [rotation.outwards([ca.SX(float(k == c)) for k in range(3)]) for c in range(3)]
        t = reach(joint, at[i])
        if joint.parent >= 0:
            rows, origin = found[joint.parent]
            columns = [[_dot(row, column) for row in rows] for column in columns]
            t = [origin[k] + _dot(rows[k], t) for k in range(3)]
        found.append(([[columns[c][k] for c in range(3)] for k in range(3)], t))
    return found


def tip_placement(tree: Tree, q: ca.SX, tip: Tip) -> tuple[list[Vector], Vector]:
    """Rotation (rows) and origin of a link's frame in base axes."""
    rows, origin = placements(tree, q)[tip.joint]
    turned, place = tip.placement[:3, :3], tip.placement[:3, 3]
    columns = [[_dot(turned[:, c], row) for row in rows] for c in range(3)]
    return (
        [[columns[c][k] for c in range(3)] for k in range(3)],
        [origin[k] + _dot(place, rows[k]) for k in range(3)],
    )


def jacobian(tree: Tree, q: ca.SX, tip: Tip) -> ca.SX:
    """Geometric Jacobian (6, n) of a link's frame, linear over angular, base axes."""
    frames = placements(tree, q)
    _, target = tip_placement(tree, q, tip)
    columns = [ca.SX.zeros(6)] * len(tree.axes)
    for i in tree.chain(tip.joint):
        rows, origin = frames[i]
        axis = [rows[k][2] for k in range(3)]
        joint, column = tree.joints[i], ca.vertcat(*axis, 0, 0, 0)
        if joint.kind == "revolute":
            lever = [target[k] - origin[k] for k in range(3)]
            column = ca.vertcat(*_cross(axis, lever), *axis)
        columns[tree.axis_of[i]] += column if joint.multiplier == 1.0 else joint.multiplier * column
    return ca.horzcat(*columns)
