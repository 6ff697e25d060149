# SPDX-License-Identifier: Apache-2.0
"""STATUS of the drives' front-end in words: which axes have tripped, why, and what to do."""

from __future__ import annotations

from collections.abc import Mapping

from sim.bench.drive.plant import AXES, NAMES

COMMON = {
    "late": "a run of the current loops was still at work when the next one had to begin; let the "
    "link's processor run nothing else",
    "fault": "a run of the current loops ended with a fault or beyond its watchdog; read that "
    "processor's STATUS, and look for a loop that is unstable with these R, L_d, L_q",
    "undervoltage": "the bus was below GUARD.bus; check the supply and U_dc",
    "overvoltage": "the bus was above BUS_LIMIT; check the brake resistor, its chopper, and how "
    "fast the axes slow down",
    "stop": "a processor that orders, tracking or trajectory, has faulted; clear its fault first",
}
"""Flags of STATUS that trip every axis: cause and cure."""
ENCODER = "encoder, both lines changed at once; check its cable, and its speed against ENCODER"
PLAUSIBLE = (
    "a phase had voltage and no current; check the cable of the motor, its fuses and the current "
    "sensors"
)
SUM = "the sum of its currents was not 0; check the current sensors, and for a short to earth"
INDEX = (
    "its encoder's index was elsewhere or missing; check cable and shield for glitches, its speed "
    "against ENCODER, and INDEX_DISTANCE"
)
OF_AXES = {"illegal": ENCODER, "plausible": PLAUSIBLE, "sum": SUM, "index_lost": INDEX}
"""Flags of STATUS and CAUSE with a bit for each axis: cause and cure."""
OWN = (
    "overcurrent or power stage; check winding and electrical angle, R, L_d, L_q of the file, and "
    "whether the tracking law is stable"
)


def named(axes: int) -> str:
    """Axes of a word with a bit for each."""
    return ", ".join(NAMES[n] for n in range(AXES) if axes >> n & 1)


def told(status: Mapping[str, int]) -> str:
    """Axes that have tripped, causes and cures; '' without a fault. status: fields of STATUS and
    CAUSE.

    A cause of all axes hides what else an axis may have, except `OF_AXES`. Overcurrent and power
    stage of an axis set no flag: they are what is left.
    """
    trip, flagged = status["trip"], 0
    causes = [f"{name}: {text}" for name, text in COMMON.items() if status[name]]
    common = bool(causes)
    for name, text in OF_AXES.items():
        if status[name]:
            causes.append(f"{named(status[name])}: {text}")
            flagged |= status[name]
    own = 0 if common else trip & ~flagged
    if own:
        causes.append(f"{named(own)}: {OWN}")
    if not causes:
        return ""
    tripped = f"tripped: {named(trip)}" if trip else "no axis has tripped"
    return f"{tripped} ({'; '.join(causes)}); when that is mended, `recover` and start up again"
