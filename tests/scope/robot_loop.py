# SPDX-License-Identifier: Apache-2.0
"""A closed loop of the robot with the RTL core for a scope to look at, in a thread."""

from __future__ import annotations

import threading
from dataclasses import replace
from functools import cache

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.image import Image
from sim.bench.run import scoped
from sim.bench.run.job import PROGRAMS
from sim.core import closed_loop
from sim.core.controller import AsipController, ControllerFault
from sim.debug.scope.source import Description
from sim.debug.scope.tap import Place
from sim.robot.parameters import ROBOT_TOML, Robot
from sim.robot.records import SetPoints

SOURCE = PROGRAMS / "tracking_optimised.s"
# Linear, so that textbooks know the response: no friction, no boost, fine encoders.
ROBOT = replace(
    Robot.load(),
    **{"friction_legs": 0.0, "friction_table": 0.0, "xi_c": 1.0, "turn_table": 2.0**22},
    **{"rotation_min": -25.0, "rotation_max": 25.0},
)


@cache
def image() -> Image:
    return assemble(SOURCE, configuration="fast", defines=ROBOT.values())


def path(ticks: int, reach: float = 0.0) -> SetPoints:
    """A circle of that radius [m] once a second; at rest without."""
    turn = 2 * np.pi * np.arange(ticks) * ROBOT.T_s
    zero = np.zeros(ticks)
    sine, cosine = reach * np.sin(turn), reach * np.cos(turn)
    omega = 2 * np.pi
    position = np.stack([cosine - reach, sine, zero + 0.6], axis=1)
    velocity = omega * np.stack([-sine, cosine, zero], axis=1)
    acceleration = omega**2 * np.stack([-cosine, -sine, zero], axis=1)
    table = np.zeros((3, ticks, 2))
    return SetPoints(position, velocity, acceleration, *table)


def described(wanted: SetPoints) -> tuple[Description, scoped.RobotTuner]:
    tuner = scoped.RobotTuner(ROBOT, SOURCE, image())
    about = scoped.description("test", ROBOT, ROBOT_TOML, wanted, image(), tuner)
    return about, tuner


class Loop(threading.Thread):
    """Runs the path; afterwards `recording`, or `stopped` with the text of the fault."""

    def __init__(self, wanted: SetPoints, place: Place | None) -> None:
        super().__init__(daemon=True)
        self.wanted, self.place = wanted, place
        self.recording: closed_loop.Recording | None = None
        self.stopped = ""
        self.touched: tuple[str, ...] = ()

    def run(self) -> None:
        watched = scoped.watched(image()) if self.place else ()
        controller = AsipController(image(), watched=watched)
        tap = scoped.LoopTap(self.place, self.wanted, controller) if self.place else None
        try:
            self.recording = closed_loop.run(ROBOT, self.wanted, controller, lambda _: None, tap)
        except ControllerFault as error:
            self.stopped = str(error)
        self.touched = tap.end() if tap else ()
