# SPDX-License-Identifier: Apache-2.0
"""Options of asip-model for robots: what a user states besides the URDF, and for which law."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from asip_asm.command import count
from asip_asm.model.law import Law
from sim.laws.laws import LAWS, Settings
from sim.laws.reference import LawReference, PinocchioRobot
from sim.laws.stated import ALL, Stated, direction, number, positive, span
from sim.laws.tree import Tree, load_tree

URDF = ".urdf"
SPEEDS = ("computed_torque", "joint_impedance", "tip_speed")
FORCES = ("computed_torque", "gravity_compensation", "joint_impedance", "inverse_dynamics")
TIPS = ("forward_kinematics", "tip_speed")
ENCODERS = tuple(law for law in LAWS if law != "inverse_dynamics")
USED_BY: dict[str, tuple[str, ...]] = {
    "rate": SPEEDS,
    "counts": ENCODERS,
    "sign": ENCODERS,
    "zero": ENCODERS,
    "encoder": ENCODERS,
    "bandwidth": ("computed_torque",),
    "integral": ("computed_torque",),
    "friction": ("computed_torque", "joint_impedance"),
    "acceleration": ("computed_torque", "inverse_dynamics"),
    "overshoot": tuple(LAWS),
    "effort": FORCES,
    "velocity": (*SPEEDS, "inverse_dynamics"),
    "range": tuple(LAWS),
    "lock": tuple(LAWS),
    "tip": TIPS,
    "loop": ("computed_torque",),
}
"""Laws that an option acts on."""


def add_robot_options(parser: argparse.ArgumentParser) -> None:
    """Options of the laws of URDFs; None or [] where they are not given."""
    group = parser.add_argument_group(
        "laws of a URDF",
        "JOINT= before a value is for that joint; a value without it is for every joint for which "
        "the URDF states none",
    )

    def per_joint(option: str, read: Callable[[str], Any], metavar: str, text: str) -> None:
        group.add_argument(
            option, action="append", default=[], type=_of_joint(read), metavar=metavar, help=text
        )

    group.add_argument("--law", choices=tuple(LAWS), help="which law (default: computed_torque)")
    group.add_argument("--rate", type=_value(positive), help="ticks per second (default: 10000)")
    per_joint("--counts", _counts, "[JOINT=]N", "encoder counts per turn or 0.1 m (default: 2^20)")
    per_joint("--sign", direction, "[JOINT=]SIGN", "-1: counts rise against the joint")
    per_joint("--zero", number, "[JOINT=]POSITION", "position at count 0 [rad, m]")
    group.add_argument(
        "--encoder",
        choices=("joint", "motor"),
        help="where the encoders are (default: joint); motor: reductions of <transmission> act",
    )
    per_joint("--effort", positive, "[JOINT=]FORCE", "largest joint force [N m, N]")
    per_joint("--velocity", positive, "[JOINT=]SPEED", "largest joint speed [rad/s, m/s]")
    per_joint("--range", span, "[JOINT=]LOW:HIGH", "positions of the joint [rad, m]")
    group.add_argument(
        "--acceleration", type=_value(positive), help="largest of the set-points (default: 15)"
    )
    group.add_argument(
        "--overshoot",
        type=_value(_at_least_one),
        help="range in which the law is right, by the stated range (default: 2)",
    )
    group.add_argument("--tip", metavar="LINK", help="link of the kinematics (default: only leaf)")
    group.add_argument(
        "--bandwidth", type=_value(positive), help="of the position loop [Hz] (default: 20)"
    )
    group.add_argument("--integral", action="store_true", help="PID in place of PD")
    group.add_argument("--friction", action="store_true", help="the URDF's friction in the law")
    group.add_argument(
        "--lock",
        action="append",
        default=[],
        type=_locked,
        metavar="JOINT[=POSITION]",
        help="a joint that does not move (default: at 0), and its followers",
    )


def check_robot_options(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """SystemExit(2) for an option that acts on nothing; sets the default law."""
    urdf = any(is_urdf(part[0]) for part in options.parts)
    given = [name for name in USED_BY if getattr(options, name)]
    if not urdf and (given or options.law):
        parser.error(f"--{(given or ['law'])[0]} is for URDFs, and no file is one")
    options.law = options.law or "computed_torque"
    for name in given if urdf else ():
        if options.law not in USED_BY[name]:
            laws = ", ".join(USED_BY[name])
            parser.error(f"--{name} does nothing for the law {options.law}; it is for {laws}")


def is_urdf(file: Path) -> bool:
    """Whether a file is a robot's, by its name."""
    return file.suffix.lower() == URDF


def settings_of(options: argparse.Namespace) -> Settings:
    """Settings of the law."""
    names = ("rate", "bandwidth", "integral", "friction", "acceleration", "overshoot")
    given = {name: getattr(options, name) for name in names if getattr(options, name)}
    counts = dict(options.counts)
    if ALL in counts:
        given["counts"] = counts[ALL]
    return Settings(**given)


def stated_of(options: argparse.Namespace) -> Stated:
    """What is stated of the robot."""
    return Stated(
        locked=dict(options.lock),
        tip=options.tip,
        effort=dict(options.effort),
        velocity=dict(options.velocity),
        range=dict(options.range),
        counts={name: n for name, n in options.counts if name != ALL},
        sign=dict(options.sign),
        zero=dict(options.zero),
        motor_encoders=options.encoder == "motor",
    )


def robot_law(options: argparse.Namespace, file: Path, settings: Settings) -> tuple[Law, Tree]:
    """The law of a URDF, and the robot. Raises RobotError, OSError."""
    tree = load_tree(file, stated_of(options))
    return LAWS[options.law](tree, settings), tree


def reference_of(options: argparse.Namespace, tree: Tree, settings: Settings) -> LawReference:
    """What the proof compares with: of the file's text and the options alone."""
    robot = PinocchioRobot(tree.description.text, stated_of(options))
    return LawReference(robot, options.law, settings)


def _value(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """Reader for argparse, which shows the message of this error only."""

    def value(text: str) -> Any:
        try:
            return read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return value


def _of_joint(read: Callable[[str], Any]) -> Callable[[str], tuple[str, Any]]:
    """Name, `ALL` without one, and value."""

    def pair(text: str) -> tuple[str, Any]:
        name, equals, value = text.rpartition("=")
        if equals and not name:
            raise argparse.ArgumentTypeError(f"'{text:.60}' has no name of a joint before '='")
        return name, _value(read)(value)

    return pair


def _locked(text: str) -> tuple[str, float]:
    name, equals, value = text.rpartition("=")
    return (name, _value(number)(value)) if equals else (text, 0.0)


def _counts(text: str) -> int:
    try:
        return count(text)
    except argparse.ArgumentTypeError as error:
        raise ValueError(str(error)) from None


def _at_least_one(text: str) -> float:
    if not number(text) >= 1:
        raise ValueError(f"'{text:.60}' is not 1 or more")
    return number(text)
