# SPDX-License-Identifier: Apache-2.0
"""Robots at hand by name: where their description is, and which joints are held."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from pathlib import Path

import cmeel

from sim.laws.elements import RobotError
from sim.laws.stated import Stated
from sim.laws.tree import Tree, load_tree

OWN = Path(__file__).with_name("urdf")


def data_folder() -> Path:
    """Folder of the robots in the package example-robot-data. Raises RobotError."""
    for root in cmeel.__path__:
        folder = Path(root).parent / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
        if folder.is_dir():
            return folder
    raise RobotError("the package example-robot-data is missing; pip install 'microtick[model]'")


@dataclass(frozen=True)
class Entry:
    """A URDF: own, in sim/laws/urdf, or in example-robot-data; and what is stated besides."""

    path: str
    own: bool = False
    stated: Stated = field(default_factory=Stated)

    def file(self) -> Path:
        return (OWN if self.own else data_folder()) / self.path


ROBOTS: dict[str, Entry] = {
    "iiwa14": Entry("iiwa14.urdf", own=True),
    # The second finger follows the first one.
    "panda": Entry(
        "panda_description/urdf/panda.urdf",
        stated=Stated(locked={"panda_finger_joint1": 0.0}, tip="panda_hand_tcp"),
    ),
    "ur5": Entry("ur_description/urdf/ur5_robot.urdf", stated=Stated(tip="tool0")),
    "xarm7": Entry("xarm_description/urdf/xarm7.urdf"),
    "scara": Entry("scara.urdf", own=True),
    "so101": Entry("so_arm_description/urdf/so101.urdf", stated=Stated(tip="gripper_frame_link")),
    "solo": Entry("solo_description/robots/solo.urdf", stated=Stated(tip="FL_FOOT")),
}


@functools.cache
def robot(name: str) -> Tree:
    """Tree of a robot of the catalogue. Raises RobotError."""
    if name not in ROBOTS:
        raise RobotError(f"no robot '{name}'; there are {', '.join(ROBOTS)}")
    return load_tree(ROBOTS[name].file(), ROBOTS[name].stated)
