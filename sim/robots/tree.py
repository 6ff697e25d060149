# SPDX-License-Identifier: Apache-2.0
"""A robot read from a URDF as the tree that `dynamics` computes with.

Frames follow Khalil and Kleinfinger (modified Denavit-Hartenberg): z along the joint's axis, x
along the common normal to the axis of the child. Inertial parameters are regrouped to base
parameters (Gautier and Khalil, IEEE T-RA 6, 1990): what turns with a link without being felt at its
joint moves to the parent, which for a revolute joint takes mass, m c_z and one second moment out of
every link.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
SNAP = 1e-9
"""Numbers of frames nearer than this to 0, 1 or -1 [1, m] are taken for these."""
PARALLEL = 1e-9
"""Sine of the angle between axes below which they are parallel."""


class RobotError(ValueError):
    """A robot description that no law can be made for; the text says which joint and why."""


@dataclass(frozen=True)
class Joint:
    """Joint and link. parent: index of the parent joint, -1 for the base.

    rotation, position: the joint's frame at the angle `-offset` in the parent's frame (3, 3), (3,)
    [m]; the rotation behind it is about z by q + offset (prismatic: q [m] along z, offset 0).
    pseudo: pseudo-inertia (4, 4) after regrouping, [[sum r r^T, m c], [m c^T, m]], [kg m^2, kg m,
    kg]. effort, velocity, lower, upper: limits; damping, friction: of the URDF. SI units.
    """

    name: str
    kind: str
    parent: int
    rotation: Matrix
    position: Matrix
    offset: float
    pseudo: Matrix
    lower: float
    upper: float
    effort: float
    velocity: float
    damping: float
    friction: float
    armature: float = 0.0


@dataclass(frozen=True)
class Tree:
    """A robot with a fixed base; joints in pinocchio's order. gravity: (3,) in base axes [m/s^2].

    model: pinocchio's, the reference. tip: frame of the last joint of the longest chain: index.
    """

    name: str
    joints: tuple[Joint, ...]
    gravity: Matrix
    model: pin.Model

    @property
    def chain(self) -> list[int]:
        """Joints from the base to the last one."""
        found = [len(self.joints) - 1]
        while self.joints[found[0]].parent >= 0:
            found.insert(0, self.joints[found[0]].parent)
        return found


NUMBERS = {
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "origin": ("xyz", "rpy"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "effort", "velocity"),
    "dynamics": ("damping", "friction"),
}
"""Attributes of a URDF's elements that the dynamics read."""


def check_numbers(path: Path) -> None:
    """Raises RobotError for a number of a URDF that is none: pinocchio's parser leaves such an
    element out, and the link is without its mass.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise RobotError(f"{path}: no XML file: {error}") from None
    for part in (*root.findall("link"), *root.findall("joint")):
        for element in part.iter():
            for name in NUMBERS.get(element.tag, ()):
                for word in element.get(name, "").split():
                    try:
                        good = math.isfinite(float(word))
                    except ValueError:
                        good = False
                    if not good:
                        raise RobotError(
                            f"{path}: {part.tag} {part.get('name')}: {element.tag} {name} "
                            f"'{word:.40}' is no number"
                        )


def load_tree(path: Path, locked: Sequence[str] = ()) -> Tree:
    """Tree of a URDF; joints in `locked` are fixed at their neutral position.

    Raises RobotError, OSError.
    """
    if not Path(path).is_file():
        raise RobotError(f"{path}: no such file")
    check_numbers(Path(path))
    try:
        model = pin.buildModelFromUrdf(str(path))
    except Exception as error:
        raise RobotError(f"{path}: no URDF that pinocchio reads: {error}") from None
    unknown = [name for name in locked if not model.existJointName(name)]
    if unknown:
        raise RobotError(f"{path}: no joint {', '.join(unknown)}; it has {_listed(model)}")
    if locked:
        held = [model.getJointId(name) for name in locked]
        model = pin.buildReducedModel(model, held, pin.neutral(model))
    try:
        return tree_of(model)
    except np.linalg.LinAlgError:
        raise RobotError(f"{path}: an axis or a place is too large or too small") from None


def _listed(model: pin.Model) -> str:
    return ", ".join(list(model.names)[1:])


def kind_of(model: pin.Model, index: int) -> str:
    """'revolute' or 'prismatic'. Raises RobotError for other joints."""
    name = model.joints[index].shortname()
    kind = {"R": "revolute", "P": "prismatic"}.get(name.removeprefix("JointModel")[:1])
    if kind is None or name in ("JointModelPlanar",):
        floating = " (a floating base)" if "FreeFlyer" in name else ""
        raise RobotError(
            f"{model.name}: joint {model.names[index]} is a {name}{floating}; "
            "revolute and prismatic joints on a fixed base are done"
        )
    return kind


def tree_of(model: pin.Model) -> Tree:
    """Tree of a pinocchio model. Raises RobotError."""
    kinds = ["", *(kind_of(model, i) for i in range(1, model.njoints))]
    data = model.createData()
    if model.nv == 0:
        raise RobotError(f"{model.name}: no joint moves")
    columns = np.reshape(pin.computeJointJacobians(model, data, pin.neutral(model)), (6, model.nv))
    world = [data.oMi[i].homogeneous for i in range(model.njoints)]
    axes = [np.array([0.0, 0.0, 1.0])] + [
        columns[3:, model.joints[i].idx_v]
        if kinds[i] == "revolute"
        else columns[:3, model.joints[i].idx_v]
        for i in range(1, model.njoints)
    ]
    for i in range(1, model.njoints):
        if not all(np.isfinite(a).all() for a in (world[i], axes[i], model.inertias[i].np)):
            raise RobotError(
                f"{model.name}: joint {model.names[i]} has an axis, a place or an inertia that is "
                "no number"
            )
    frames = _frames(model, kinds, world, axes)
    pseudo = [
        _moved(np.linalg.inv(frames[i]) @ world[i], model.inertias[i].toPseudoInertia().toMatrix())
        for i in range(model.njoints)
    ]
    joints: list[Joint] = []
    for i in range(model.njoints - 1, 0, -1):
        parent = model.parents[i]
        kept, moved = _regrouped(pseudo[i], kinds[i])
        pseudo[parent] = pseudo[parent] + _moved(np.linalg.inv(frames[parent]) @ frames[i], moved)
        joints.insert(0, _joint(model, i, kinds[i], frames, kept))
    return Tree(model.name, tuple(joints), model.gravity.linear.copy(), model)


def _frames(model: pin.Model, kinds: list[str], world: list[Matrix], axes: list[Matrix]) -> list:
    """Frame (4, 4) of every joint in base axes; the base keeps its own."""
    frames = [np.eye(4)] + [np.eye(4) for _ in range(model.njoints - 1)]
    incoming: dict[int, tuple[Matrix, Matrix]] = {}
    for i in range(1, model.njoints):
        children = list(model.children[i])
        main = max(children, key=lambda c: len(model.subtrees[c])) if children else None
        point, x = incoming.get(i, (world[i][:3, 3], _perpendicular(axes[i], world[i][:3, 0])))
        if kinds[i] == "prismatic":
            point = world[i][:3, 3]
        if main is not None:
            foot, other, normal = _normal(point, axes[i], world[main][:3, 3], axes[main])
            if kinds[i] != "prismatic":
                point = foot
            x = normal if normal is not None else x
            incoming[main] = (other, x)
        frames[i][:3, :3] = np.column_stack((x, np.cross(axes[i], x), axes[i]))
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
        foot, end = point + along[0] * axis, other_point + along[1] * other
    distance = float(np.linalg.norm(end - foot))
    if distance > SNAP:
        return foot, end, (end - foot) / distance
    size = np.linalg.norm(cross)
    return foot, end, (cross / size if size >= PARALLEL else None)


def _moved(transform: Matrix, pseudo: Matrix) -> Matrix:
    """Pseudo-inertia in another frame."""
    return transform @ pseudo @ transform.T


def _regrouped(pseudo: Matrix, kind: str) -> tuple[Matrix, Matrix]:
    """What the link keeps and what moves to its parent, in the link's frame."""
    moved = np.zeros((4, 4))
    if kind == "revolute":
        moved[2:, 2:] = pseudo[2:, 2:]
    else:
        moved[:3, :3] = pseudo[:3, :3]
    return pseudo - moved, moved


def snapped(values: Matrix) -> Matrix:
    """Numbers next to 0, 1 and -1 replaced by these."""
    result = np.array(values, float)
    for exact in (0.0, 1.0, -1.0):
        result[np.abs(result - exact) < SNAP] = exact
    return result


def _joint(model: pin.Model, i: int, kind: str, frames: list[Matrix], pseudo: Matrix) -> Joint:
    parent = model.parents[i]
    relative = np.linalg.inv(frames[parent]) @ frames[i]
    rotation, offset = relative[:3, :3], 0.0
    if kind == "revolute":
        rotation, offset = _split(rotation, root=parent == 0)
    v, q = model.joints[i].idx_v, model.joints[i].idx_q
    bounded = model.joints[i].nq == 1
    scale = float(np.abs(pseudo).max()) or 1.0
    cleaned = np.where(np.abs(pseudo) < SNAP * scale, 0.0, pseudo)
    return Joint(
        name=model.names[i],
        kind=kind,
        parent=parent - 1,
        rotation=snapped(rotation),
        position=snapped(relative[:3, 3]),
        offset=0.0 if abs(offset) < SNAP else offset,
        pseudo=cleaned,
        lower=float(model.lowerPositionLimit[q]) if bounded else -np.pi,
        upper=float(model.upperPositionLimit[q]) if bounded else np.pi,
        effort=float(model.effortLimit[v]),
        velocity=float(model.velocityLimit[v]),
        damping=float(model.damping[v]),
        friction=float(model.friction[v]),
        armature=float(model.armature[v]),
    )


def _split(rotation: Matrix, root: bool) -> tuple[Matrix, float]:
    """Rotation as A Rz(offset): A turns z only, about the normal of both axes."""
    if root:
        return rotation, 0.0
    z = rotation[:, 2]
    normal = np.array([1.0, 0.0, 0.0])  # of a main child x of the parent is the common normal
    if abs(z[0]) >= PARALLEL:
        normal = np.cross([0.0, 0.0, 1.0], z)
        normal = normal / np.linalg.norm(normal)
    first = np.column_stack((normal, np.cross(z, normal), z))
    rest = first.T @ rotation
    return first, float(np.arctan2(rest[1, 0], rest[0, 0]))
