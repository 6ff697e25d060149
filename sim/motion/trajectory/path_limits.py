# SPDX-License-Identifier: Apache-2.0
"""What limits the speed along a path: at every tick the quantity that is nearest its limit."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.curves import FloatArray, feed_of
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.trajectory.program import ProgramPath
from sim.robot.kinematics import inverse_acceleration, inverse_velocity
from sim.robot.parameters import Robot

FEED = "programmed feed"
EXACT_STOP = "times of the S-curve (G61.1)"


def limited_by(path: ProgramPath, robot: Robot, limits: MachineLimits) -> dict[str, float]:
    """Share of the moving time that each limit bounds, largest first; the shares add up to 1.

    Under G61.1 the times of the S-curve bound a move. Elsewhere it is the greatest ratio of speed,
    acceleration or jerk of tool, legs or table axes to its limit, or of the speed to the feed.
    """
    moving = path.velocity.any(axis=1)
    if not moving.any():
        return {}
    tool, table = path.velocity[:, :3], path.velocity[:, 3:]
    legs = inverse_velocity(robot, path.position[:, :3], tool)
    leg_acceleration = inverse_acceleration(
        robot, path.position[:, :3], tool, path.acceleration[:, :3]
    )
    groups: dict[str, tuple[Callable[..., FloatArray], FloatArray, FloatArray]] = {
        "tool": (np.linalg.norm, tool, path.acceleration[:, :3]),
        "leg": (np.max, np.abs(legs), np.abs(leg_acceleration)),
        "table": (np.max, np.abs(table), np.abs(path.acceleration[:, 3:])),
    }
    names = [FEED]
    ratios = [_feed_ratio(path)]
    for group, (size, speed, acceleration) in groups.items():
        bound = getattr(limits, group)
        names += [f"{group} speed", f"{group} acceleration"]
        ratios += [size(speed, axis=1) / bound.speed]
        ratios += [size(acceleration, axis=1) / bound.acceleration]
        if limits.jerk_limited:
            change = np.diff(acceleration, axis=0, prepend=acceleration[:1]) / path.period
            names.append(f"{group} jerk")
            ratios.append(size(np.abs(change), axis=1) / bound.jerk)
    nearest = np.argmax(ratios, axis=0)
    nearest[path.exact_stop] = len(names)
    count = np.bincount(nearest[moving], minlength=len(names) + 1) / int(moving.sum())
    shares = dict(zip([*names, EXACT_STOP], count.tolist(), strict=True))
    found = {name: share for name, share in shares.items() if share > 0.0}
    return dict(sorted(found.items(), key=lambda entry: -entry[1]))


def _feed_ratio(path: ProgramPath) -> NDArray[np.float64]:
    """Speed of every tick by the feed of its move, 0 for rapid moves."""
    tool, table = (
        np.linalg.norm(part, axis=1) for part in (path.velocity[:, :3], path.velocity[:, 3:])
    )
    feed = np.array([feed_of(move) for move in path.moves])
    alone = np.array([move.turns_only_the_table for move in path.moves])
    return np.where(alone[path.move], table, tool) / feed[path.move]
