# SPDX-License-Identifier: Apache-2.0
"""Drilling, boring and tapping cycles G73 G74 G81-G85 G89: LinuxCNC's moves, in all planes."""

from __future__ import annotations

from collections.abc import Iterator

from sim.motion.gcode.block import TAPS
from sim.motion.gcode.state import State
from sim.motion.gcode.targets import add_polar
from sim.motion.gcode.words import Word
from sim.motion.geometry.moves import AXES, Motion, Plane, Pose, pose_of

# LinuxCNC's G83_RAPID_DELTA: the rapid back into the hole ends so far above its bottom, and G73
# breaks the chip by so much.
PECK_CLEARANCE_MM = 0.254

MAX_STEPS = 99_000  # moves and rests of one block

_LETTERS = AXES[:3]
_PECKING = ("G73", "G83")
_NEEDED = {"G82": "P", "G89": "P", **dict.fromkeys(_PECKING, "Q")}
Step = tuple[Motion, Pose] | float
"""A motion and its end in programmed coordinates, or a rest [s]."""


def drill(state: State, values: dict[str, Word], at: Word) -> Iterator[Step]:
    """Steps of a block with the cycle state.motion in force; none after a mistake.

    values: words of the block by letter; at: word at which mistakes of the block are reported.
    Each step starts at the end of the previous one. Numbers are stored in state.sticky.
    """
    modes = state.modes
    first, second = modes.plane.axes
    axis = 3 - first - second
    if not _accepted(state, values, axis, at):
        return
    retract, bottom = state.sticky["R"], state.sticky[_LETTERS[axis]]
    if modes.incremental:
        retract += state.initial_level  # one level for the whole series, as in rs274
        bottom += retract
    if bottom > retract:
        state.report(
            values.get("R") or at,
            "the retract plane is below the bottom of the hole",
            f"R of at least {_LETTERS[axis]}",
            "R is the height from which the feed begins",
        )
        return
    if not _few_steps(state, values, retract - bottom, at):
        return
    place = list(state.programmed())
    level = place[axis]
    if level < retract:
        level = place[axis] = retract
        yield Motion.RAPID, pose_of(place)
    clear = retract
    if not modes.retract_to_r:
        clear = max(state.initial_level, retract)
        place[axis] = max(level, clear)  # as LinuxCNC: the move to the hole is at that level too
    given = [(index, value) for index, value in state.axis_values(values) if index != axis]
    repeats = values.get("L")
    for _ in range(int(repeats.value) if repeats else 1):
        for index, value in given:
            place[index] = place[index] + value if modes.incremental else value
        if "@" in values or "^" in values:
            add_polar(state, values, place)
        yield from _hole_steps(state, place, axis, (retract, bottom, clear))


def _few_steps(state: State, values: dict[str, Word], depth: float, at: Word) -> bool:
    """Whether the holes of a block have at most MAX_STEPS moves; depth [mm] of each."""
    pecks = depth / state.sticky["Q"] if state.motion in _PECKING else 0.0
    repeats = values["L"].value if "L" in values else 1.0
    if (3.0 + 3.0 * pecks) * repeats <= MAX_STEPS:
        return True
    word = values.get("Q") if pecks > repeats else values.get("L")
    state.report(
        word or at,
        f"the block makes more than {MAX_STEPS} moves",
        f"L times depth / Q of at most {MAX_STEPS // 3}",
        "check L and Q, or divide the block",
    )
    return False


def _accepted(state: State, values: dict[str, Word], axis: int, at: Word) -> bool:
    """Whether the words of the block make a cycle; its numbers are then stored."""
    cycle = state.motion
    if state.modes.inverse_time:
        state.report(at, f"{cycle} with G93", "feed per minute (G94)", "write G94 before")
        return False
    if cycle in TAPS and state.modes.plane is not Plane.XY:
        state.report(
            at,
            f"{cycle} in {state.modes.plane.value}",
            "G17",
            "LinuxCNC exchanges the axes of a tap in G18 and G19; use G33.1 with K there",
        )
        return False
    turning = TAPS.get(cycle or "", state.modes.turning)
    if turning != state.modes.turning:
        now = f"after {state.modes.turning}" if state.modes.turning else "that does not turn"
        state.report(
            at, f"{cycle} with a spindle {now}", f"{turning} before", f"write {turning} before"
        )
        return False
    needed = (_LETTERS[axis], "R", *_NEEDED.get(cycle or "", ""))
    for letter in needed:
        if letter in values:
            scale = 1.0 if letter == "P" else state.modes.mm_per_unit
            state.sticky[letter] = values[letter].value * scale
        elif letter not in state.sticky:
            state.report(
                at,
                f"{cycle} without {letter}",
                f"{letter} in the first block of the cycle",
                "write for instance G81 X10 Y10 Z-5 R2",
            )
            return False
    if cycle in TAPS and "P" in values:
        state.sticky["P"] = values["P"].value
    repeats = values.get("L")
    if repeats is not None and (repeats.value < 1 or not repeats.value.is_integer()):
        state.report(repeats, "the number of repeats", "an integer of at least 1", "L3")
        return False
    if state.sticky.get("Q", 1.0) <= 0.0 or state.sticky.get("P", 0.0) < 0.0:
        state.report(
            values.get("Q") or values.get("P") or at,
            "the number is too small for the cycle",
            "Q greater than 0, P of at least 0",
            "write for instance G83 Z-5 R2 Q1",
        )
        return False
    return True


def _hole_steps(
    state: State, place: list[float], axis: int, heights: tuple[float, float, float]
) -> Iterator[Step]:
    """One hole; place, changed on the way, ends at the last of the heights along the axis [mm]:
    where the feed begins, bottom, and where the next way to a hole begins."""
    retract, bottom, clear = heights

    def to(motion: Motion, height: float) -> Step:
        place[axis] = height
        return motion, pose_of(place)

    yield Motion.RAPID, pose_of(place)
    yield to(Motion.RAPID, retract)
    cycle = state.motion
    if cycle in _PECKING:
        depth = retract - state.sticky["Q"]
        while depth > bottom:
            yield to(Motion.LINEAR, depth)
            if cycle == "G83":
                yield to(Motion.RAPID, retract)
            yield to(Motion.RAPID, depth + PECK_CLEARANCE_MM)
            depth -= state.sticky["Q"]
    yield to(Motion.LINEAR, bottom)
    if cycle in ("G82", "G89"):
        yield state.sticky["P"]
    if cycle in TAPS:  # the spindle turns back on this way
        yield state.sticky.get("P", 0.0)
    if cycle == "G85":
        yield to(Motion.LINEAR, retract)
    yield to(Motion.LINEAR if cycle in ("G89", *TAPS) else Motion.RAPID, clear)
