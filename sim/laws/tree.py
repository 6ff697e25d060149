# SPDX-License-Identifier: Apache-2.0
"""A robot read from a URDF as the tree that `dynamics` computes with.

Frames follow Khalil and Kleinfinger (modified Denavit-Hartenberg): z along the joint's axis, x
along the common normal to the axis of the child. Inertial parameters are regrouped to base
parameters (Gautier and Khalil, IEEE T-RA 6, 1990): what turns with a link without being felt at its
joint moves to the parent, which for a revolute joint takes mass, m c_z and one second moment out of
every link. Nothing here is read by pinocchio, which is the reference (`sim.laws.reference`).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.diagnostics import closest
from sim.laws.description import Description, Inertial, JointRecord, read_description
from sim.laws.elements import SHOWN, Matrix, RobotError
from sim.laws.frames import SNAP, Body, frames_of, snapped, split
from sim.laws.stated import ALL, Stated, chosen

TURNS = 8
"""Turns of a continuous joint to either side, where no range is stated."""
MOST_ANGLE = 256.0
"""Largest angle of the sine unit [rad]."""
SIMPLE = ("SimpleTransmission",)
"""Types of transmissions whose reduction is the ratio of one motor and one joint."""


@dataclass(frozen=True)
class Joint:
    """Joint and link. parent: index of the parent joint, -1 for the base.

    rotation, position: the joint's frame at the angle `-offset` in the parent's frame (3, 3), (3,)
    [m]; then follows the rotation about z by q + offset (prismatic: q [m] along z, offset 0).
    pseudo: pseudo-inertia (4, 4) after regrouping, [[sum r r^T, m c], [m c^T, m]], [kg m^2, kg m,
    kg]. lower, upper, effort, velocity: limits, None where nobody states one. damping, friction: of
    the URDF. armature: inertia of the rotor at the joint. SI units.

    leader: index of the joint that this one follows, its own index for an independent joint;
    q = multiplier * q of the leader + shift. counts: per turn of the encoder, or per 0.1 m; None:
    as for all joints. gear: turns of the encoder per turn of the joint. zero: position at count 0.
    """

    name: str
    kind: str
    parent: int
    rotation: Matrix
    position: Matrix
    offset: float
    pseudo: Matrix
    lower: float | None
    upper: float | None
    effort: float | None
    velocity: float | None
    damping: float
    friction: float
    armature: float = 0.0
    leader: int = -1
    multiplier: float = 1.0
    shift: float = 0.0
    counts: float | None = None
    gear: float = 1.0
    zero: float = 0.0


@dataclass(frozen=True)
class Tip:
    """A link's frame: placement (4, 4) in the frame of a joint."""

    link: str
    joint: int
    placement: Matrix


@dataclass(frozen=True)
class Tree:
    """A robot with a fixed base. joints: depth first, siblings by name, as pinocchio has them.
    gravity: (3,) in base axes [m/s^2]. tips: frames of all links that move, by name; leaves: those
    without a joint to another link.
    """

    name: str
    joints: tuple[Joint, ...]
    gravity: Matrix
    tips: dict[str, Tip]
    leaves: tuple[str, ...]
    description: Description
    stated: Stated

    @functools.cached_property
    def axes(self) -> tuple[Joint, ...]:
        """Independent joints, one coordinate each."""
        return tuple(joint for i, joint in enumerate(self.joints) if joint.leader == i)

    @functools.cached_property
    def axis_of(self) -> list[int]:
        """Index of the coordinate of every joint."""
        names = [joint.name for joint in self.axes]
        return [names.index(self.joints[joint.leader].name) for joint in self.joints]

    @property
    def tip(self) -> Tip:
        """The named link, or the only leaf. Raises RobotError."""
        file, name = self.description.file, self.stated.tip
        if name is not None:
            if name in self.tips:
                return self.tips[name]
            if name in self.description.links:
                raise RobotError(f"{file}: --tip: no joint moves link {name}")
            near = closest(name, self.tips) or f"links are {', '.join(self.tips)}"
            raise RobotError(f"{file}: --tip: no link {name:.{SHOWN}}; {near}")
        if len(self.leaves) != 1:
            raise RobotError(
                f"{file}: several links end a chain: {', '.join(self.leaves)}; name one by --tip"
            )
        return self.tips[self.leaves[0]]

    def chain(self, joint: int) -> list[int]:
        """Joints from the base to the given one."""
        found = [joint]
        while self.joints[found[0]].parent >= 0:
            found.insert(0, self.joints[found[0]].parent)
        return found


def load_tree(path: Path, stated: Stated | None = None) -> Tree:
    """Tree of a URDF. Raises RobotError, OSError."""
    description = read_description(Path(path))
    try:
        with np.errstate(all="ignore"):
            return tree_of(description, stated or Stated())
    except np.linalg.LinAlgError:
        raise RobotError(f"{path}: an axis or a place is too large or too small") from None


def tree_of(description: Description, stated: Stated) -> Tree:
    """Tree of a description. Raises RobotError."""
    file = description.file
    records = {record.name: record for record in description.joints}
    moving = [name for name, record in records.items() if record.kind != "fixed"]
    mimics = {name: records[name].mimic for name in moving}
    followers = {name: mimic.leader for name, mimic in mimics.items() if mimic is not None}
    stated.check_names(file, moving, followers)
    held = {name: _held(file, records[name], at) for name, at in stated.locked.items()}
    bodies, links = _bodies(description, records, held)
    if len(bodies) == 1:
        raise RobotError(f"{file}: no joint moves")
    frames = frames_of(bodies)
    inverse = [np.linalg.inv(frame) for frame in frames]
    pseudo = [np.zeros((4, 4)) for _ in bodies]
    for name, inertial in description.links.items():
        if inertial is not None:
            body, world = links[name]
            pseudo[body] = pseudo[body] + _moved(inverse[body] @ world, _pseudo(inertial))
    joints: list[Joint] = []
    names = [body.record.name if body.record else "" for body in bodies]
    for i in range(len(bodies) - 1, 0, -1):
        parent = bodies[i].parent
        kept, moved = _regrouped(pseudo[i], bodies[i].kind)
        pseudo[parent] = pseudo[parent] + _moved(inverse[parent] @ frames[i], moved)
        joints.insert(0, _joint(description, stated, bodies[i], frames, i, kept, names))
    _check_used(file, stated, [record for record in records.values() if record.name in names])
    for joint in joints:
        if not all(np.isfinite(a).all() for a in (joint.rotation, joint.position, joint.pseudo)):
            raise RobotError(
                f"{file}: joint {joint.name} has an axis, a place or an inertia that is too large"
            )
    tips = {
        name: Tip(name, body - 1, snapped(inverse[body] @ world))
        for name, (body, world) in links.items()
        if body
    }
    parents = {record.parent for record in records.values()}
    leaves = tuple(name for name in tips if name not in parents)
    gravity = np.array([0.0, 0.0, -9.81])
    return Tree(description.name, tuple(joints), gravity, tips, leaves, description, stated)


def _check_used(file: str, stated: Stated, records: list[JointRecord]) -> None:
    """Raises RobotError for a value stated for all joints without one, where there is none."""
    stating = {
        "effort": [record.effort is not None for record in records],
        "velocity": [record.velocity is not None for record in records],
        "range": [record.lower is not None or record.kind == "continuous" for record in records],
    }
    for option, known in stating.items():
        if ALL in getattr(stated, option) and all(known):
            raise RobotError(
                f"{file}: --{option}: the URDF states it for every joint; name the joint for which "
                f"it shall be another: --{option} JOINT=VALUE"
            )


def _held(file: str, record: JointRecord, position: float) -> float:
    """Position of a locked joint, inside its limits."""
    own = record.limits
    if own is not None and not own[0] <= position <= own[1]:
        raise RobotError(
            f"{file}: --lock: position {position:g} of joint {record.name} is outside of its "
            f"limits {record.lower:g} to {record.upper:g}; state one: --lock {record.name}=POSITION"
        )
    return position


def _follows(
    record: JointRecord, records: dict[str, JointRecord], held: dict[str, float]
) -> tuple[str, float, float]:
    """Name of the leader ('' if it does not move), multiplier and shift through all between."""
    multiplier, shift = 1.0, 0.0
    while record.name not in held and record.kind != "fixed" and record.mimic is not None:
        shift += multiplier * record.mimic.offset
        multiplier *= record.mimic.multiplier
        record = records[record.mimic.leader]
    if record.kind == "fixed":
        return "", 0.0, shift
    if record.name in held:
        return "", 0.0, shift + multiplier * held[record.name]
    return record.name, multiplier, shift


def _bodies(
    description: Description, records: dict[str, JointRecord], held: dict[str, float]
) -> tuple[list[Body], dict[str, tuple[int, Matrix]]]:
    """Bodies, and body and frame in base axes of every link."""
    base = Body(None, 0, np.eye(4), np.array([0.0, 0.0, 1.0]), ("", 1.0, 0.0))
    bodies, links = [base], {description.root: (0, np.eye(4))}
    for record in description.joints:
        parent, world = links[record.parent]
        world = world @ record.origin
        if record.kind != "fixed":
            follows = _follows(record, records, held)
            if follows[0]:
                bodies.append(Body(record, parent, world, world[:3, :3] @ record.axis, follows))
                parent = len(bodies) - 1
            else:
                world = world @ _motion(record, follows[2])
        links[record.child] = (parent, world)
    return bodies, links


def _motion(record: JointRecord, position: float) -> Matrix:
    """Placement (4, 4) of a joint's child at a position."""
    moved = np.eye(4)
    x, y, z = record.axis
    if record.kind == "prismatic":
        moved[:3, 3] = position * record.axis
    else:
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        moved[:3, :3] += np.sin(position) * cross + (1 - np.cos(position)) * cross @ cross
    return moved


def _pseudo(inertial: Inertial) -> Matrix:
    """Pseudo-inertia (4, 4) in link axes."""
    found = np.zeros((4, 4))
    moments, mass, centre = inertial.moments, inertial.mass, inertial.centre
    found[:3, :3] = np.eye(3) * np.trace(moments) / 2 - moments + mass * np.outer(centre, centre)
    found[:3, 3] = found[3, :3] = mass * centre
    found[3, 3] = mass
    return found


def _moved(transform: Matrix, pseudo: Matrix) -> Matrix:
    """Pseudo-inertia in another frame."""
    return transform @ pseudo @ transform.T


def _regrouped(pseudo: Matrix, kind: str) -> tuple[Matrix, Matrix]:
    """What stays with the link and what moves to its parent, in the link's frame."""
    moved = np.zeros((4, 4))
    if kind == "revolute":
        moved[2:, 2:] = pseudo[2:, 2:]
    else:
        moved[:3, :3] = pseudo[:3, :3]
    return pseudo - moved, moved


def _joint(
    description: Description,
    stated: Stated,
    body: Body,
    frames: list[Matrix],
    i: int,
    pseudo: Matrix,
    names: list[str],
) -> Joint:
    record, file = body.record, description.file
    assert record is not None
    relative = np.linalg.inv(frames[body.parent]) @ frames[i]
    rotation, offset = relative[:3, :3], 0.0
    if body.kind == "revolute":
        rotation, offset = split(rotation, root=body.parent == 0)
    scale = float(np.abs(pseudo).max()) or 1.0
    cleaned = np.where(np.abs(pseudo) < SNAP * scale, 0.0, pseudo)
    leader, multiplier, shift = body.follows
    lower, upper = _range(file, record, stated)
    gear, zero, armature = _drive(description, stated, record)
    return Joint(
        name=record.name,
        kind=body.kind,
        parent=body.parent - 1,
        rotation=snapped(rotation),
        position=snapped(relative[:3, 3]),
        offset=0.0 if abs(offset) < SNAP else offset,
        pseudo=cleaned,
        lower=lower,
        upper=upper,
        effort=chosen(stated.effort, record.name, record.effort),
        velocity=chosen(stated.velocity, record.name, record.velocity),
        damping=record.damping,
        friction=record.friction,
        armature=armature,
        leader=names.index(leader) - 1,
        multiplier=multiplier,
        shift=shift,
        counts=chosen(stated.counts, record.name, None),
        gear=gear,
        zero=zero,
    )


def _range(file: str, record: JointRecord, stated: Stated) -> tuple[float | None, float | None]:
    own = record.limits
    if record.kind == "continuous":
        own = (-TURNS * 2 * np.pi, TURNS * 2 * np.pi)
    found = chosen(stated.range, record.name, own)
    if found is None:
        return None, None
    if record.kind != "prismatic" and max(map(abs, found)) > MOST_ANGLE:
        raise RobotError(
            f"{file}:{record.line}: joint {record.name}: limits beyond {MOST_ANGLE:g} rad, where "
            f"sines are not computed; state the range: --range {record.name}=LOW:HIGH"
        )
    return found


def _drive(
    description: Description, stated: Stated, record: JointRecord
) -> tuple[float, float, float]:
    """Turns of the encoder per turn of the joint, position at count 0, inertia of the rotor."""
    gear = float(chosen(stated.sign, record.name, None) or 1.0)
    zero, armature = float(chosen(stated.zero, record.name, None) or 0.0), 0.0
    for one in description.transmissions:
        if record.name not in one.joints:
            continue
        where = f"{description.file}:{one.line}: transmission '{one.name}'"
        simple = one.kind in SIMPLE and len(one.joints) == 1
        if not simple and (stated.motor_encoders or one.rotor):
            raise RobotError(
                f"{where}: type '{one.kind}' is not done; take the encoder to the joint (--encoder "
                "joint) and delete a rotor's inertia"
            )
        armature += one.rotor * one.reduction**2
        if stated.motor_encoders:
            gear *= one.reduction
            zero += one.offset
    return gear, zero, armature
