# SPDX-License-Identifier: Apache-2.0
"""A URDF read strictly: what dynamics, limits and kinematics need is taken or refused with file,
line and cure; all other elements and attributes are listed as not used.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asip_asm.diagnostics import closest
from sim.laws.elements import SHOWN, Element, Matrix, Reader, RobotError, read_elements

MOVING = ("revolute", "continuous", "prismatic")
TYPES = (*MOVING, "fixed")


@dataclass(frozen=True)
class Inertial:
    """Mass [kg], its centre (3,) [m] and second moments (3, 3) about it [kg m^2], link axes."""

    mass: float
    centre: Matrix
    moments: Matrix


@dataclass(frozen=True)
class Mimic:
    """position = multiplier * position of the joint `leader` + offset."""

    leader: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Transmission:
    """Between an actuator and a joint. kind: text of its type. reduction: motor turns per turn of
    the joint; offset: joint position at motor position 0; rotor: inertia of the rotor [kg m^2].
    """

    name: str
    kind: str
    line: int
    joints: tuple[str, ...]
    reduction: float = 1.0
    offset: float = 0.0
    rotor: float = 0.0


@dataclass(frozen=True)
class JointRecord:
    """A joint as the file has it. origin: (4, 4) in the parent link's axes at position 0. lower,
    upper, effort, velocity: None where the file states none.
    """

    name: str
    kind: str
    line: int
    parent: str
    child: str
    origin: Matrix
    axis: Matrix
    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    mimic: Mimic | None = None

    @property
    def limits(self) -> tuple[float, float] | None:
        """Lower and upper limit of the position; a file states both or none."""
        return None if self.lower is None or self.upper is None else (self.lower, self.upper)


@dataclass(frozen=True)
class Description:
    """A URDF. joints: depth first from the root, siblings by name. links: inertial of every link by
    name, None without. unused: number of elements and attributes that nothing reads, by name.
    """

    file: str
    name: str
    root: str
    links: dict[str, Inertial | None]
    joints: tuple[JointRecord, ...]
    transmissions: tuple[Transmission, ...]
    unused: dict[str, int]
    warnings: tuple[str, ...]
    text: str


def read_description(path: Path) -> Description:
    """The description in a file. Raises RobotError, OSError."""
    root, text = read_elements(path)
    return _Robot(str(path)).robot(root, text)


def rotation_of(roll: float, pitch: float, yaw: float) -> Matrix:
    """Rotation (3, 3) of fixed-axis angles about x, y, z."""
    (sx, sy, sz), (cx, cy, cz) = np.sin((roll, pitch, yaw)), np.cos((roll, pitch, yaw))
    return np.array(
        [
            [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx],
        ]
    )


class _Robot(Reader):
    """Takes a <robot> apart."""

    KNOWN_UNUSED = frozenset(
        "calibration collision collision_checking command_effort contact current flexJoint "
        "gap_joint gazebo gear_velocity gravity hardwareInterface kinematic material passive_joint "
        "role ros2_control safety_controller self_filter sensor surface visual".split()
    )
    REFUSED = {
        "loop_joint": "closes a loop of links; only trees are done",
        "include": "is not read; insert the text of that file",
    }

    def robot(self, root: Element, text: str) -> Description:
        if root.tag != "robot":
            self.fail(root, f"the root element is <{root.tag:.{SHOWN}}>, that of a URDF is <robot>")
        self._attributes(root, ("name", "version"), "robot")
        links: dict[str, Inertial | None] = {}
        joints: dict[str, JointRecord] = {}
        transmissions: list[Transmission] = []
        for element in root.children:
            if element.tag == "link":
                name = self._name(element, "link")
                if name in links:
                    self.fail(element, f"a second link '{name}'; rename one")
                links[name] = self._link(element, name)
            elif element.tag == "joint":
                name = self._name(element, "joint")
                if name in joints:
                    self.fail(element, f"a second joint '{name}'; rename one")
                joints[name] = self._joint(element, name)
            elif element.tag == "transmission":
                transmissions.append(self._transmission(element))
            else:
                self._other(element, ("link", "joint", "transmission"), "")
        if not links:
            self.fail(root, "no link")
        base, order = self._tree(root, links, joints)
        self._mimics(joints)
        for one in transmissions:
            lost = [name for name in one.joints if name not in joints]
            if lost:
                at = f"{self.file}:{one.line}: transmission '{one.name}'"
                self.warnings.append(f"{at}: no joint {', '.join(lost)}; it is not used")
        name = root.attributes.get("name", "") or Path(self.file).stem
        name = self._plain(root, name, "name of the robot")
        return Description(
            self.file, name, base, links, order, tuple(transmissions), dict(self.unused),
            tuple(self.warnings), text,
        )  # fmt: skip

    def _origin(self, element: Element | None, where: str) -> Matrix:
        """Placement (4, 4) of an <origin>."""
        placement = np.eye(4)
        if element is None:
            return placement
        self._attributes(element, ("xyz", "rpy"), where)
        if "xyz" in element.attributes:
            placement[:3, 3] = self._numbers(element, "xyz", 3, where)
        if "rpy" in element.attributes:
            placement[:3, :3] = rotation_of(*self._numbers(element, "rpy", 3, where))
        return placement

    def _link(self, element: Element, name: str) -> Inertial | None:
        where = f"link '{name}'"
        self._attributes(element, ("name",), where)
        inertial = self._parts(element, ("inertial",), where).get("inertial")
        if inertial is None:
            return None
        self._attributes(inertial, (), where)
        parts = self._parts(inertial, ("origin", "mass", "inertia"), where)
        for tag in ("mass", "inertia"):
            if tag not in parts:
                self.fail(inertial, f"{where}: <inertial> has no <{tag}>; state it, or delete the "
                                    "whole <inertial> of a link without mass")  # fmt: skip
        self._attributes(parts["mass"], ("value",), where)
        self._attributes(parts["inertia"], ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), where)
        mass = self._number(parts["mass"], "value", where)
        if mass < 0:
            self.fail(parts["mass"], f"{where}: the mass {mass:g} is negative")
        xx, xy, xz, yy, yz, zz = (
            self._number(parts["inertia"], key, where)
            for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        )
        moments = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        self._check_moments(parts["inertia"], moments, mass, where)
        placement = self._origin(parts.get("origin"), where)
        turned = placement[:3, :3] @ moments @ placement[:3, :3].T
        return Inertial(mass, placement[:3, 3], turned)

    def _check_moments(self, element: Element, moments: Matrix, mass: float, where: str) -> None:
        """Refuses negative moments; warns of others that no body has, which published robots do."""
        if min(np.diag(moments)) < -1e-12:
            self.fail(
                element, f"{where}: a moment of inertia is negative: {min(np.diag(moments)):g}"
            )
        low, middle, high = np.linalg.eigvalsh(moments)
        at = f"{self.file}:{element.line}: {where}: no body has these moments:"
        if low < -1e-6 * high - 1e-20:
            self.warnings.append(
                f"{at} the inertia is not positive definite, {low:g} kg m^2 at least"
            )
        elif low + middle < (1 - 1e-3) * high:
            self.warnings.append(
                f"{at} the largest, {high:g}, is more than the sum of the others, {low:g} and "
                f"{middle:g} kg m^2"
            )
        if mass == 0 and high > 0:
            self.warnings.append(f"{self.file}:{element.line}: {where} has moments without a mass")

    def _joint(self, element: Element, name: str) -> JointRecord:
        where = f"joint '{name}'"
        self._attributes(element, ("name", "type"), where)
        kind = element.attributes.get("type", "")
        if kind not in TYPES:
            reason = {
                "": "has no type",
                "floating": "is of type floating (a floating base), which is not done",
                "planar": "is of type planar, which is not done; use two prismatic joints and a "
                "revolute one",
            }.get(kind, f"has an unknown type '{kind[:SHOWN]}'")
            self.fail(element, f"{where} {reason}; types are {', '.join(TYPES)}")
        known = ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic")
        parts = self._parts(element, known, where)
        ends = {}
        for tag in ("parent", "child"):
            if tag not in parts:
                self.fail(element, f"{where} has no <{tag}>")
            self._attributes(parts[tag], ("link",), where)
            ends[tag] = self._name(parts[tag], where, "link")
        record: dict[str, Any] = {
            "name": name, "kind": kind, "line": element.line, "parent": ends["parent"],
            "child": ends["child"],
            "origin": self._origin(parts.get("origin"), where),
            "axis": np.array([1.0, 0.0, 0.0]),
        }  # fmt: skip
        if kind == "fixed":
            for tag in ("axis", "limit", "dynamics", "mimic"):
                if tag in parts:
                    self.unused[f"{tag} of a fixed joint"] += 1
            return JointRecord(**record)
        if "axis" in parts:
            record["axis"] = self._axis(parts["axis"], where)
        record |= self._limit(parts.get("limit"), element, kind, where)
        if "dynamics" in parts:
            self._attributes(parts["dynamics"], ("damping", "friction"), where)
            for key in ("damping", "friction"):
                record[key] = self._optional(parts["dynamics"], key, where, 0.0)
                if record[key] < 0:
                    self.fail(parts["dynamics"], f"{where}: {key} {record[key]:g} is negative")
        if "mimic" in parts:
            mimic = parts["mimic"]
            self._attributes(mimic, ("joint", "multiplier", "offset"), where)
            record["mimic"] = Mimic(
                self._name(mimic, where, "joint"),
                self._optional(mimic, "multiplier", where, 1.0),
                self._optional(mimic, "offset", where, 0.0),
            )
        return JointRecord(**record)

    def _axis(self, element: Element, where: str) -> Matrix:
        self._attributes(element, ("xyz",), where)
        if "xyz" not in element.attributes:
            self.fail(element, f"{where}: <axis> has no attribute xyz")
        axis = self._numbers(element, "xyz", 3, where)
        size = float(np.linalg.norm(axis))
        if size < 1e-9:
            self.fail(element, f"{where}: the axis is zero; state its direction")
        return axis / size

    def _limit(self, element: Element | None, joint: Element, kind: str, where: str) -> dict:
        """lower, upper, effort, velocity; None where the file states none."""
        if element is None:
            if kind != "continuous":
                self.fail(joint, f"{where}: a {kind} joint needs <limit lower= upper= effort= "
                                 "velocity=>")  # fmt: skip
            return {}
        self._attributes(element, ("lower", "upper", "effort", "velocity"), where)
        found: dict[str, float | None] = {}
        for key in ("effort", "velocity"):
            value = self._number(element, key, where)
            if value < 0:
                self.fail(element, f"{where}: {key} {value:g} is negative")
            found[key] = value or None
        low, high = (self._optional(element, key, where, 0.0) for key in ("lower", "upper"))
        if kind == "continuous":
            if low or high:
                self.unused["limit lower, upper of a continuous joint"] += 1
            return {key: value for key, value in found.items() if value}
        if low > high:
            self.fail(element, f"{where}: lower {low:g} is above upper {high:g}")
        if low < high:
            found |= {"lower": low, "upper": high}
        return found

    def _transmission(self, element: Element) -> Transmission:
        self._attributes(element, ("name", "type"), "transmission")
        name = element.attributes.get("name", "")[:SHOWN]
        where = f"transmission '{name}'"
        kind = element.attributes.get("type", "")
        joints: list[str] = []
        numbers: dict[str, list[float]] = {"reduction": [], "offset": [], "rotor": []}
        keys = {
            "mechanicalReduction": "reduction", "drake:gear_ratio": "reduction",
            "offset": "offset", "rotorInertia": "rotor", "drake:rotor_inertia": "rotor",
        }  # fmt: skip

        def number(part: Element) -> None:
            text = part.attributes.get("value", part.text).strip()
            copy = Element(part.tag, {"value": text}, part.line)
            numbers[keys[part.tag]].append(self._number(copy, "value", where))

        for part in element.children:
            if part.tag == "type":
                kind = part.text.strip()
            elif part.tag in keys:
                number(part)
            elif part.tag in ("joint", "actuator", "leftActuator", "rightActuator", "rollJoint"):
                if part.tag in ("joint", "rollJoint"):
                    joints.append(self._name(part, where))
                if "mechanicalReduction" in part.attributes:
                    numbers["reduction"].append(self._number(part, "mechanicalReduction", where))
                for inner in part.children:
                    if inner.tag in keys:
                        number(inner)
                    else:
                        self._other(inner, tuple(keys), where)
            else:
                self._other(part, ("type", "joint", "actuator", "mechanicalReduction"), where)
        chosen = {}
        for key, values in numbers.items():
            stated = {value for value in values if value != (1.0 if key == "reduction" else 0.0)}
            if len(stated) > 1 and len(joints) == 1:
                self.fail(element, f"{where}: two values of {key}: {sorted(stated)}; state one")
            if stated and len(stated) == 1:
                chosen[key] = stated.pop()
        if chosen.get("reduction") == 0:
            self.fail(element, f"{where}: the reduction is zero")
        if chosen.get("rotor", 0.0) < 0:
            self.fail(element, f"{where}: the rotor's inertia is negative")
        kind = kind.removeprefix("transmission_interface/").rpartition("/")[2]
        return Transmission(name, kind[:SHOWN], element.line, tuple(joints), **chosen)

    # The tree.

    def _tree(
        self, root: Element, links: dict[str, Inertial | None], joints: dict[str, JointRecord]
    ) -> tuple[str, tuple[JointRecord, ...]]:
        """Root link, and the joints depth first."""
        above: dict[str, JointRecord] = {}
        below: dict[str, list[JointRecord]] = {name: [] for name in links}
        for joint in sorted(joints.values(), key=lambda joint: joint.name.encode()):
            at = f"{self.file}:{joint.line}: joint '{joint.name}'"
            for end in (joint.parent, joint.child):
                if end not in links:
                    near = closest(end, links)
                    raise RobotError(f"{at}: no link '{end[:SHOWN]}'; {near or 'add it'}")
            if joint.child in above:
                raise RobotError(
                    f"{at}: link '{joint.child}' is already the child of joint "
                    f"'{above[joint.child].name}': a loop of links; only trees are done"
                )
            above[joint.child] = joint
            below[joint.parent].append(joint)
        bases = [name for name in links if name not in above]
        if not bases:
            self.fail(root, "the joints form a loop without a root; only trees are done")
        if len(bases) > 1:
            self.fail(root, f"{len(bases)} root links, {', '.join(bases[:8])}; join them by fixed "
                            "joints, or delete all but one")  # fmt: skip
        order: list[JointRecord] = []
        waiting = list(reversed(below[bases[0]]))
        while waiting:
            joint = waiting.pop()
            order.append(joint)
            waiting.extend(reversed(below[joint.child]))
        lost = [joint.name for joint in joints.values() if joint not in order]
        if lost:
            self.fail(root, f"joints {', '.join(lost[:8])} form a loop; only trees are done")
        return bases[0], tuple(order)

    def _mimics(self, joints: dict[str, JointRecord]) -> None:
        """Refuses followers of joints that are not there, and followers that follow themselves."""
        for joint in joints.values():
            seen = [joint.name]
            while joint.mimic is not None:
                at = f"{self.file}:{joint.line}: joint '{joint.name}'"
                leader = joint.mimic.leader
                if leader not in joints:
                    near = closest(leader, joints)
                    raise RobotError(f"{at}: mimics a joint '{leader}' that is not there; "
                                     f"{near or 'name another'}")  # fmt: skip
                if leader in seen:
                    raise RobotError(f"{at}: mimics itself through {' -> '.join(seen)}")
                seen.append(leader)
                joint = joints[leader]
