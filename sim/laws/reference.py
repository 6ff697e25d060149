# SPDX-License-Identifier: Apache-2.0
"""The independent reference of a robot and its laws: pinocchio on the URDF as its own parser reads
it, with its own limits, in double precision.

Nothing here comes from `description`, `tree`, `dynamics` or `laws`, which make the program: the
file and what the user stated are read a second time, and the laws are written as their equations.
So a joint, limit, frame or sign that the program has wrong shows as an error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from asip_asm.model.law import Law
from sim.laws.elements import RobotError
from sim.laws.stated import ALL, Stated

Real = NDArray[np.float64]
OWN = 4e-9
"""Largest error of this reference by the largest result of its kind in a tick: numbers of frames
within 1e-9 of 0 and 1 are exact in the program.
"""
SEVERAL_TURNS = 4 * math.pi
"""A continuous joint is right at least as far as this to either side [rad]."""
MOST = 256.0
"""Largest angle of the core [rad]."""
SINGULAR = 1e-12
"""Least principal value of a mass matrix that can be solved, by the largest."""


class PinocchioRobot:
    """A robot of the text of a URDF. names: of the axes, in the order of their coordinates.

    A follower of <mimic> is a joint of pinocchio's model; `ratio` (joints, axes) and `shift`
    (joints,) give all joints of the axes, and forces go back by the transpose.
    """

    def __init__(self, text: str, stated: Stated) -> None:
        root = ElementTree.fromstring(text)
        body = ElementTree.tostring(root, encoding="unicode")
        try:
            whole = pin.buildModelFromXML(body)
        except Exception as error:
            raise RobotError(f"pinocchio does not read the URDF: {error}") from None
        self.stated = stated
        self.elements = {joint.get("name", ""): joint for joint in root.findall("joint")}
        followed = {name: self._followed(name) for name in list(whole.names)[1:]}
        held = {name: shift for name, (leader, _, shift) in followed.items() if leader is None}
        q = pin.neutral(whole)
        for name, value in held.items():
            joint = whole.joints[whole.getJointId(name)]
            q[joint.idx_q : joint.idx_q + joint.nq] = _coordinates(joint, value)
        locked = [whole.getJointId(name) for name in held]
        self.model = pin.buildReducedModel(whole, locked, q) if held else whole
        self.data = self.model.createData()
        joints = list(self.model.names)[1:]
        self.names = [name for name in joints if followed[name][0] == name]
        self.ratio = np.zeros((len(joints), len(self.names)))
        self.shift = np.array([followed[name][2] for name in joints])
        for i, name in enumerate(joints):
            leader, ratio, _ = followed[name]
            self.ratio[i, self.names.index(leader)] = ratio
        at = [joints.index(name) for name in self.names]
        moves = list(self.model.joints)[1:]
        self.revolute = ["P" not in moves[i].shortname().removeprefix("JointModel")[:1] for i in at]
        self.effort = np.array(
            [self._word("effort", self.model.effortLimit, joints, i) for i in at]
        )
        self.damping, self.friction = self._rubbing(joints)
        self._drives(root)

    def _followed(self, name: str) -> tuple[str | None, float, float]:
        """Leader, ratio and shift of a joint; without a leader the shift is where it is held."""
        ratio, shift = 1.0, 0.0
        while name not in self.stated.locked:
            element = self.elements[name]
            mimic = element.find("mimic")
            if element.get("type") == "fixed":
                return None, 0.0, shift
            if mimic is None:
                return name, ratio, shift
            shift += ratio * float(mimic.get("offset", "0"))
            ratio *= float(mimic.get("multiplier", "1"))
            name = mimic.get("joint", "")
        return None, 0.0, shift + ratio * self.stated.locked[name]

    def _word(self, option: str, own: Real, joints: list[str], i: int) -> float:
        """Stated value of a joint, that of the file, that stated for all joints."""
        words = getattr(self.stated, option)
        value = float(own[list(self.model.joints)[1 + i].idx_v])
        return words.get(joints[i], value or words.get(ALL, 0.0))

    def _rubbing(self, joints: list[str]) -> tuple[Real, Real]:
        """Viscous and Coulomb friction of all joints, of their elements."""
        found = []
        for key in ("damping", "friction"):
            parts = [self.elements[name].find("dynamics") for name in joints]
            found.append(
                np.array([0.0 if part is None else float(part.get(key, "0")) for part in parts])
            )
        return found[0], found[1]

    def _drives(self, root: ElementTree.Element) -> None:
        """Encoder turns per turn of the joint, positions at count 0, inertias of rotors."""
        joints, stated = list(self.model.names)[1:], self.stated
        self.armature = np.zeros(len(joints))
        self.gear = np.array(
            [stated.sign.get(name, stated.sign.get(ALL, 1.0)) for name in self.names], float
        )
        self.zero = np.array(
            [stated.zero.get(name, stated.zero.get(ALL, 0.0)) for name in self.names], float
        )
        for part in root.findall("transmission"):
            of = part.find("joint")
            name = None if of is None else of.get("name")
            if name not in joints:
                continue
            values: dict[str, float] = {}
            for element in part.iter():
                tag = element.tag.rpartition("}")[2]
                word = (element.get("value") or element.text or "").strip()
                if tag in ("mechanicalReduction", "gear_ratio") and float(word) != 1:
                    values["reduction"] = float(word)
                if tag in ("rotorInertia", "rotor_inertia"):
                    values["rotor"] = float(word)
                if tag == "offset":
                    values["offset"] = float(word) or values.get("offset", 0.0)
            reduction = values.get("reduction", 1.0)
            self.armature[joints.index(name)] += values.get("rotor", 0.0) * reduction**2
            if stated.motor_encoders and name in self.names:
                self.gear[self.names.index(name)] *= reduction
                self.zero[self.names.index(name)] += values.get("offset", 0.0)

    def positions(self, counts: Real, per_turn: int) -> Real:
        """Positions (N, n) of counts."""
        return counts * self.scale(per_turn) + self.zero

    def scale(self, per_turn: int) -> Real:
        """Position of a count (n,)."""
        words = self.stated.counts
        turn = np.where(self.revolute, 2 * math.pi, 0.1)
        return turn / (np.array([words.get(name, per_turn) for name in self.names]) * self.gear)

    def range(self) -> Real:
        """Lower and upper ends (n, 2) of the positions: stated, or pinocchio's own limits."""
        joints, names = list(self.model.joints)[1:], list(self.model.names)[1:]
        lower, upper = self.model.lowerPositionLimit, self.model.upperPositionLimit
        found = []
        for name in self.names:
            joint = joints[names.index(name)]
            own = (-SEVERAL_TURNS, SEVERAL_TURNS)
            if joint.nq == 1:
                own = (float(lower[joint.idx_q]), float(upper[joint.idx_q]))
            if own[0] == own[1]:
                own = self.stated.range.get(ALL, own)
            found.append(self.stated.range.get(name, own))
        return np.array(found)

    def configuration(self, q: Real) -> Real:
        """Pinocchio's coordinates of the axes' positions (n,)."""
        values = self.ratio @ q + self.shift
        joints = list(self.model.joints)[1:]
        return np.concatenate([_coordinates(j, v) for j, v in zip(joints, values, strict=True)])

    def inverse(self, q: Real, v: Real, a: Real) -> Real:
        """Forces (n,) of a motion of the axes."""
        all_a = self.ratio @ a
        tau = pin.rnea(self.model, self.data, self.configuration(q), self.ratio @ v, all_a)
        return self.ratio.T @ (tau + self.armature * all_a)

    def forward(self, q: Real, v: Real, tau: Real) -> Real:
        """Accelerations (n,) of the axes."""
        if self.plain:
            return pin.aba(self.model, self.data, self.configuration(q), v, tau).copy()
        rest = self.inverse(q, v, np.zeros(len(v)))
        return np.asarray(np.linalg.solve(self.mass_matrix(q), tau - rest), np.float64)

    @property
    def plain(self) -> bool:
        """Whether no joint follows another one, and no rotor has an inertia."""
        square = self.ratio.shape[0] == self.ratio.shape[1]
        return square and not self.shift.any() and not self.armature.any()

    def mass_matrix(self, q: Real) -> Real:
        """Mass matrix (n, n) of the axes."""
        upper = np.triu(pin.crba(self.model, self.data, self.configuration(q)))
        whole = upper + np.triu(upper, 1).T + np.diag(self.armature)
        return self.ratio.T @ whole @ self.ratio

    def check_movable(self, q: Real) -> None:
        """Raises RobotError for a robot whose forward dynamics has no solution."""
        with np.errstate(all="ignore"):
            values, vectors = np.linalg.eigh(self.mass_matrix(q))
        if not values[0] > SINGULAR * values[-1]:
            joint = self.names[int(np.argmax(np.abs(vectors[:, 0])))]
            raise RobotError(
                f"joint {joint} moves no mass, so the closed loop has no motion; state the "
                f"inertial of the links that it moves, or hold it: --lock {joint}"
            )

    def rubbing(self, v: Real, creep: float) -> Real:
        """Friction (n,) of the axes at their speeds."""
        rates = self.ratio @ v
        dry = self.friction * np.clip(rates / creep, -1, 1)
        return self.ratio.T @ (self.damping * rates + dry)

    def tip(self, q: Real, v: Real) -> tuple[Real, Real, Real]:
        """Origin (3,), rotation (3, 3) and velocity (6,) of the tip's frame, base axes."""
        model, data = self.model, self.data
        pin.forwardKinematics(model, data, self.configuration(q), self.ratio @ v)
        frame = model.getFrameId(self._tip_link(), pin.FrameType.BODY)
        place = pin.updateFramePlacement(model, data, frame)
        rate = pin.getFrameVelocity(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        return place.translation.copy(), place.rotation.copy(), rate.vector.copy()

    def _tip_link(self) -> str:
        """The stated link, or the only one that moves and that no joint starts from."""
        if self.stated.tip is not None:
            return self.stated.tip
        parents = [joint.find("parent") for joint in self.elements.values()]
        starts = {parent.get("link") for parent in parents if parent is not None}
        ends = [
            frame.name
            for frame in self.model.frames
            if frame.type == pin.FrameType.BODY and frame.parentJoint and frame.name not in starts
        ]
        if len(ends) != 1:
            raise RobotError(f"several links end a chain: {', '.join(ends)}")
        return ends[0]


def _coordinates(joint: pin.JointModel, value: float) -> list[float]:
    return [value] if joint.nq == 1 else [math.cos(value), math.sin(value)]


@dataclass(frozen=True)
class LawReference:
    """Results of a named law of a robot, by its equations. settings: fields of `laws.Settings`."""

    robot: PinocchioRobot
    name: str
    settings: Any

    def __call__(self, words: Mapping[str, NDArray]) -> dict[str, tuple[Real, Real]]:
        """Outputs and next states (`<state>_next`) of words of the program, arrays (N,) by name,
        each with its own largest error. Raises KeyError for a law without an equation here.
        """
        settings, n = self.settings, len(self.robot.names)
        if self.name == "inverse_dynamics":
            given = [self._vector(words, name) for name in ("pos", "speed", "accel")]
            return self._forces(self._each(self.robot.inverse, *given))
        counts = self._vector(words, "q")
        q, v = self.robot.positions(counts, settings.counts), np.zeros((len(counts), n))
        if "q0_before" in words:
            moved = counts - self._vector(words, "q", "_before")
            v = moved * self.robot.scale(settings.counts) * settings.rate
        if self.name in ("forward_kinematics", "tip_speed"):
            return self._tip(q, v)
        if self.name == "gravity_compensation":
            return self._forces(self._weight(q) + self._vector(words, "extra"))
        if self.name == "joint_impedance":
            return self._forces(self._impedance(words, q, v))
        if self.name != "computed_torque":
            raise KeyError(f"law {self.name} has no equation in {__name__}")
        total = None
        if settings.integral:
            error = self._vector(words, "goal") - q
            most = settings.windup
            total = np.clip(self._vector(words, "s") + error / settings.rate, -most, most)
        found = self._forces(self._computed_torque(words, q, v, total))
        if total is not None:
            found |= {f"s{i}_next": (total[:, i], OWN * np.abs(total[:, i])) for i in range(n)}
        return found

    def difference(self, law: Law) -> str:
        """What the signals of a law have otherwise than the file: text, empty if nothing."""
        robot, ports = self.robot, {port.name: port for port in law.ports}
        first = "pos" if self.name == "inverse_dynamics" else "q"
        for i, (name, own) in enumerate(zip(robot.names, robot.range(), strict=True)):
            port = ports.get(f"{first}{i}")
            if port is None:
                return f"no signal {first}{i} of joint {name}"
            if port.meaning and first == "q" and port.meaning != f"encoder of {name}":
                return f"{first}{i} is the {port.meaning}, it belongs to joint {name}"
            middle, half = own.mean(), (own[1] - own[0]) / 2
            half *= self.settings.overshoot if robot.revolute[i] else 1.0
            low, high = np.clip((middle - half, middle + half), -MOST, MOST)
            limits = port.limits or (-math.inf, math.inf)
            if limits[0] > low + 1e-9 or limits[1] < high - 1e-9:
                return f"{port.name} is from {limits[0]:g}, joint {name} from {low:g} to {high:g}"
            effort = ports.get(f"tau{i}")
            if effort is not None and effort.limits != (-robot.effort[i], robot.effort[i]):
                return f"tau{i} is limited to {effort.limits}, joint {name} to {robot.effort[i]:g}"
        return ""

    def _vector(self, words: Mapping[str, NDArray], name: str, suffix: str = "") -> Real:
        axes = range(len(self.robot.names))
        return np.stack([words[f"{name}{i}{suffix}"].astype(float) for i in axes], axis=1)

    def _weight(self, q: Real) -> Real:
        still = np.zeros_like(q)
        return self._each(self.robot.inverse, q, still, still)

    def _friction(self, v: Real) -> Real:
        if not self.settings.friction:
            return np.zeros_like(v)
        return self._each(lambda rate: self.robot.rubbing(rate, self.settings.creep), v)

    def _impedance(self, words: Mapping[str, NDArray], q: Real, v: Real) -> Real:
        stiff = np.minimum(self.settings.stiffness, self.robot.effort)
        ratio = self.settings.damping / self.settings.stiffness
        spring = stiff * (self._vector(words, "goal") - q - ratio * v)
        return self._weight(q) + spring + self._friction(v)

    def _computed_torque(
        self, words: Mapping[str, NDArray], q: Real, v: Real, total: Real | None
    ) -> Real:
        settings, omega = self.settings, 2 * math.pi * self.settings.bandwidth
        speed = self._vector(words, "speed")
        demand = self._vector(words, "accel") + omega**2 * (self._vector(words, "goal") - q)
        demand += 2 * settings.damping_ratio * omega * (speed - v)
        if total is not None:
            demand += omega**3 / 10 * total
        return self._each(self.robot.inverse, q, v, demand) + self._friction(speed)

    def _each(self, function: Callable[..., Real], *rows: Real) -> Real:
        return np.array([function(*row) for row in zip(*rows, strict=True)])

    def _forces(self, tau: Real) -> dict[str, tuple[Real, Real]]:
        own = OWN * np.abs(tau).max(axis=1)
        limits = enumerate(self.robot.effort)
        return {f"tau{i}": (np.clip(tau[:, i], -e, e), own) for i, e in limits}

    def _tip(self, q: Real, v: Real) -> dict[str, tuple[Real, Real]]:
        tips = [self.robot.tip(*row) for row in zip(q, v, strict=True)]
        if self.name == "tip_speed":
            names, rows = "vx vy vz wx wy wz".split(), np.array([rate for _, _, rate in tips])
        else:
            names = "x y z zx zy zz xx xy xz".split()
            rows = np.array([[*o, *turned[:, 2], *turned[:, 0]] for o, turned, _ in tips])
        own = OWN * np.abs(rows).max(axis=1)
        return {f"tip_{name}": (rows[:, k], own) for k, name in enumerate(names)}
