# SPDX-License-Identifier: Apache-2.0
"""Centres of arcs (NISTIR 6556, 3.5.3): from I J K, as distances or coordinates, or from R."""

from __future__ import annotations

import math

from sim.motion.gcode.state import State
from sim.motion.gcode.words import OFFSETS, Word, WordReport
from sim.motion.geometry.curves import MISSES
from sim.motion.geometry.moves import MM_PER_INCH, Motion, Pose

Centre = tuple[float, float]
"""In the order of plane.axes [mm]."""

# NISTIR 6556, 3.5.3.2: largest difference between the radii at both ends of an arc. The same
# distance is allowed between an R-format chord and the diameter.
ARC_TOLERANCE_MM = 0.002
ARC_TOLERANCE_INCH = 0.0002
# Difference of the radii at both ends that LinuxCNC's rs274 accepts at every size, in the centre
# format; of larger arcs RELATIVE of the radius, up to 100 times this. The arc is then a spiral.
CENTRE_TOLERANCE_MM = 0.02 * math.sqrt(2)
CENTRE_TOLERANCE_INCH = 0.002 * math.sqrt(2)
RELATIVE = 0.001
WHOLE = 1e-4  # distance from a whole number within which a number is one, as in rs274
MAX_TURNS = 1000
LARGEST_GROWTH = 0.1  # of the smaller radius: the end of a spiral shall not be its centre


def arc_centre(
    state: State, motion: Motion, end: Pose, values: dict[str, Word], at: Word
) -> Centre | None:
    """Centre of an arc to `end` in coordinates of the program, None after a mistake.

    values: words of the block by letter; at: word that mistakes of the whole arc are reported at.
    """
    report, start, plane = state.report, state.programmed(), state.modes.plane
    mm_per_unit = state.modes.mm_per_unit
    first, second = plane.axes
    offsets = {letter: values[letter] for letter in OFFSETS if letter in values}
    chord = (end[first] - start[first], end[second] - start[second])
    tolerance = ARC_TOLERANCE_MM
    if mm_per_unit == MM_PER_INCH:
        tolerance = ARC_TOLERANCE_INCH * MM_PER_INCH
    if "R" in values:
        for word in offsets.values():
            report(
                word,
                f"{word.letter} together with R",
                "either the radius R or centre offsets",
                f"remove {word.text} or {values['R'].text}",
            )
        if offsets:
            return None
        radius, here = values["R"].value * mm_per_unit, (start[first], start[second])
        return _centre_from_radius(motion, here, chord, radius, values["R"], tolerance, report)
    names = OFFSETS[first], OFFSETS[second]
    wrong = [word for letter, word in offsets.items() if letter not in names]
    for word in wrong:
        report(
            word,
            f"{word.letter} is not in the plane {plane.value}",
            f"offsets {names[0]} and {names[1]}",
            f"remove {word.text} or select another plane",
        )
    if wrong:
        return None
    dx, dy = (offsets[name].value * mm_per_unit if name in offsets else 0.0 for name in names)
    if state.modes.absolute_centres:  # G90.1: I J K are coordinates
        dx = dx - start[first] if names[0] in offsets else 0.0
        dy = dy - start[second] if names[1] in offsets else 0.0
    if dx == 0.0 and dy == 0.0:
        report(
            at,
            "the arc has no centre",
            f"{names[0]} or {names[1]} different from 0, or R",
            "give the distance from the start of the arc to its centre",
        )
        return None
    scale = state.modes.mm_per_unit
    radii = math.hypot(dx, dy) / scale, math.hypot(chord[0] - dx, chord[1] - dy) / scale
    if not radii_fit(state, *radii, at):
        return None
    return start[first] + dx, start[second] + dy


def radii_fit(state: State, at_start: float, at_end: float, at: Word) -> bool:
    """Whether the radii at both ends of an arc, in the unit of the program, are as good as equal;
    reports the word if not."""
    mm_per_unit = state.modes.mm_per_unit
    radius, end_radius = at_start * mm_per_unit, at_end * mm_per_unit
    most = CENTRE_TOLERANCE_MM
    if mm_per_unit == MM_PER_INCH:
        most = CENTRE_TOLERANCE_INCH * MM_PER_INCH
    greatest, least = max(radius, end_radius), min(radius, end_radius)
    tolerance = min(max(most, RELATIVE * greatest), 100 * most, LARGEST_GROWTH * least)
    if abs(radius - end_radius) > max(tolerance, MISSES * 1e3):
        state.report(
            at,
            f"the end of the arc is not on its circle: radius {radius:.4f} mm at the start, "
            f"{end_radius:.4f} mm at the end",
            f"a difference of at most {tolerance:.4f} mm",
            "check the end point and the offsets from the start to the centre",
        )
        return False
    return True


def turns_of(state: State, word: Word | None) -> int:
    """P of G2 and G3: how many times the arc reaches its end; 1 without the word."""
    if word is None:
        return 1
    turns = round(word.value)
    if abs(word.value - turns) > WHOLE or not 1 <= turns <= MAX_TURNS:
        state.report(
            word,
            "the number of turns is not valid",
            f"a whole P from 1 to {MAX_TURNS}",
            "P2 is the arc and a full turn more",
        )
        return 1
    return turns


def _centre_from_radius(
    motion: Motion,
    start: Centre,
    chord: Centre,
    signed_radius: float,
    word: Word,
    tolerance: float,
    report: WordReport,
) -> Centre | None:
    """R format: a positive R is the arc of at most half a turn, a negative R the longer one."""
    radius, distance = abs(signed_radius), math.hypot(*chord)
    if distance == 0.0:
        report(
            word,
            "an arc with R ends where it starts",
            "an end point different from the start",
            "write a full turn with I, J, K",
        )
        return None
    if distance / 2 > radius + tolerance:
        report(
            word,
            f"the radius is too small for the distance {distance:.4f} mm from start to end",
            f"a radius of at least {distance / 2:.4f} mm",
            "check the end point and R",
        )
        return None
    height = math.sqrt(max(0.0, radius**2 - (distance / 2) ** 2)) / distance
    if (motion is Motion.ARC_CCW) != (signed_radius > 0.0):
        height = -height  # centre to the right of the way from start to end
    return (
        start[0] + chord[0] / 2 - height * chord[1],
        start[1] + chord[1] / 2 + height * chord[0],
    )
