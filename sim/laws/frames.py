# SPDX-License-Identifier: Apache-2.0
"""Frames of joints after Khalil and Kleinfinger (modified Denavit-Hartenberg)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sim.laws.description import JointRecord
from sim.laws.elements import Matrix

SNAP = 1e-9
"""Numbers of frames nearer than this to 0, 1 or -1 [1, m] are taken as exactly these."""
PARALLEL = 1e-9
"""Sine of the angle between axes below which they are parallel."""
FAR = 100.0
"""Distance to the common normal, by that of the joints, from which on it is not used: axes that are
nearly parallel would lose all digits there.
"""


@dataclass
class Body:
    """What moves with a joint, under construction; body 0 is the base. world, axis: frame (4, 4)
    and direction of the joint in base axes, all joints at 0. follows: leader, multiplier, shift.
    """

    record: JointRecord | None
    parent: int
    world: Matrix
    axis: Matrix
    follows: tuple[str, float, float]

    @property
    def kind(self) -> str:
        prismatic = self.record is not None and self.record.kind == "prismatic"
        return "prismatic" if prismatic else "revolute"


def frames_of(bodies: list[Body]) -> list[Matrix]:
    """Frame (4, 4) of every joint in base axes; the base has its own."""
    frames = [np.eye(4) for _ in bodies]
    below = [0] * len(bodies)
    children: list[list[int]] = [[] for _ in bodies]
    for i in range(len(bodies) - 1, 0, -1):
        below[bodies[i].parent] += below[i] + 1
        children[bodies[i].parent].insert(0, i)
    incoming: dict[int, tuple[Matrix, Matrix]] = {}
    for i, body in enumerate(bodies[1:], 1):
        main = max(children[i], key=lambda c: below[c], default=None)
        start = (body.world[:3, 3], _perpendicular(body.axis, body.world[:3, 0]))
        point, x = incoming.get(i, start)
        if body.kind == "prismatic":
            point = body.world[:3, 3]
        if main is not None:
            other = bodies[main]
            foot, end, normal = _normal(point, body.axis, other.world[:3, 3], other.axis)
            if body.kind != "prismatic":
                point = foot
            x = normal if normal is not None else x
            incoming[main] = (end, _perpendicular(other.axis, x))
        frames[i][:3, :3] = np.column_stack((x, np.cross(body.axis, x), body.axis))
        frames[i][:3, 3] = point
    return frames


def _perpendicular(axis: Matrix, wanted: Matrix) -> Matrix:
    """Unit vector across the axis, near `wanted` if that is not along it."""
    for direction in (wanted, *np.eye(3)):
        across = direction - axis * (axis @ direction)
        if np.linalg.norm(across) > 0.5:
            return across / np.linalg.norm(across)
    raise AssertionError("no direction is across the axis")


def _normal(
    point: Matrix, axis: Matrix, other_point: Matrix, other: Matrix
) -> tuple[Matrix, Matrix, Matrix | None]:
    """Feet of the common normal of two lines on both, and its direction (None: the lines are the
    same). Of parallel lines the normal goes through `point`.
    """
    cross = np.cross(axis, other)
    between = other_point - point
    if np.linalg.norm(cross) < PARALLEL:
        foot = point
        end = other_point - other * (other @ (other_point - point))
    else:
        matrix = np.column_stack((axis, -other, cross))
        along = np.linalg.solve(matrix, between)
        if max(abs(along[0]), abs(along[1])) > FAR * (1 + float(np.linalg.norm(between))):
            return point, other_point, None
        foot, end = point + along[0] * axis, other_point + along[1] * other
    distance = float(np.linalg.norm(end - foot))
    if distance > SNAP:
        return foot, end, (end - foot) / distance
    size = np.linalg.norm(cross)
    return foot, end, (cross / size if size >= PARALLEL else None)


def snapped(values: Matrix) -> Matrix:
    """Numbers next to 0, 1 and -1 replaced by these."""
    result = np.array(values, float)
    for exact in (0.0, 1.0, -1.0):
        result[np.abs(result - exact) < SNAP] = exact
    return result


def split(rotation: Matrix, root: bool) -> tuple[Matrix, float]:
    """Rotation as A Rz(offset): A turns z only, about the normal of both axes."""
    if root:
        return rotation, 0.0
    z = rotation[:, 2]
    normal = np.array([1.0, 0.0, 0.0])  # for a main child, x of the parent is the normal
    if abs(z[0]) >= PARALLEL:
        normal = np.cross([0.0, 0.0, 1.0], z)
        normal = normal / np.linalg.norm(normal)
    first = np.column_stack((normal, np.cross(z, normal), z))
    rest = first.T @ rotation
    return first, float(np.arctan2(rest[1, 0], rest[0, 0]))
