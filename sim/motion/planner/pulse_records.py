# SPDX-License-Identifier: Apache-2.0
"""Phase records for the velocity control (rtl/motion/velocity_control.sv) from planned phases.

Units and what the hardware makes of a record: sim/rtl/phase_record.py. Pulses come from exact
sums: a start velocity is chosen such that every phase ends on its planned displacement, and a
cruise is split where its rate is no whole unit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from sim.motion.planner.phases import Phase
from sim.rtl.phase_record import (
    BY_PULSES,
    COUNT_LIMIT,
    DIRECTION,
    FIRST,
    FRACTION,
    HIGHEST_RATE,
    LAST,
    SLOPE_LIMIT,
    TICK,
    UNITS_PER_HZ,
    UNITS_PER_PULSE,
    Record,
)


class PulseRecordError(ValueError):
    """A phase that the velocity control can't run; the message names it and the limit."""


def time_exact(
    phases: Sequence[Phase[Fraction]], pulses_per_unit: Fraction | int, negative: bool = False
) -> list[Record]:
    """Records of a move with exact duration and pulse count.

    `phases` follow one another (empty ones are skipped), their speeds are not negative. Times of
    phase ends are rounded to ticks, displacements are not rounded. Raises PulseRecordError.
    """
    records: list[Record] = []
    time, tick, position = Fraction(0), 0, Fraction(0)
    for number, phase in enumerate(phases, start=1):
        time += phase.duration
        ticks = round(time / TICK) - tick
        if ticks == 0:
            continue
        # From the phase's start to the first tick after it.
        late = tick * TICK - (time - phase.duration)
        end = phase.start.after(phase.duration, phase.jerk)
        whole = end if phase is phases[-1] else phase.start.after(late + ticks * TICK, phase.jerk)
        target = (whole.position - phases[0].start.position) * pulses_per_unit
        slope, jerk = _slopes(phase, late, pulses_per_unit)
        distance = (target - position) * UNITS_PER_PULSE * FRACTION
        velocity = (
            distance
            - slope * (ticks * (ticks - 1) // 2)
            - jerk * ((ticks - 1) * ticks * (ticks + 1) // 6)
        ) / ticks
        _check(number, ticks, velocity, slope, jerk)
        if slope == jerk == 0:
            records += _cruise(ticks, velocity)
        else:
            # Half a unit, because published rates are cut to whole ones.
            records.append(Record(0, ticks, round(velocity) + FRACTION // 2, slope, jerk))
        tick += ticks
        position = target
    return _flagged(records, DIRECTION if negative else 0)


def pulse_counted(
    phases: Sequence[Phase[Fraction]], pulses_per_unit: Fraction | int, negative: bool = False
) -> list[Record]:
    """Records that switch phases by pulse counts, as the S-curve paper does: a phase ends when its
    count reaches the displacement's ceiling, and rates change only after a pulse. Raises
    PulseRecordError, among others for a start speed of 0, from which this scheme never moves.
    """
    if phases and phases[0].start.speed == 0:
        raise PulseRecordError(
            "phase 1: start speed 0 never makes the first pulse when rates change only after "
            "a pulse; use the time-exact mode or a start speed above 0"
        )
    records: list[Record] = []
    sent = 0
    for number, phase in enumerate(phases, start=1):
        end = phase.start.after(phase.duration, phase.jerk)
        reach = math.ceil((end.position - phases[0].start.position) * pulses_per_unit)
        if reach == sent:
            continue
        slope, jerk = _slopes(phase, Fraction(0), pulses_per_unit)
        velocity = phase.start.speed * pulses_per_unit * UNITS_PER_HZ * FRACTION
        _check(number, reach - sent, velocity, slope, jerk)
        records.append(Record(BY_PULSES, reach - sent, round(velocity), slope, jerk))
        sent = reach
    return _flagged(records, DIRECTION if negative else 0)


def _slopes(phase: Phase[Fraction], late: Fraction, pulses_per_unit: Fraction | int):
    """Acceleration and jerk of a record that begins `late` [s] after its phase."""
    scale = pulses_per_unit * UNITS_PER_HZ * FRACTION
    acceleration = phase.start.acceleration + late * phase.jerk
    return round(acceleration * TICK * scale), round(phase.jerk * TICK * TICK * scale)


def _cruise(ticks: int, velocity: Fraction) -> list[Record]:
    """Constant rate: whole units, one more of them in the last ticks."""
    low = math.floor(velocity / FRACTION)
    more = round((velocity / FRACTION - low) * ticks)
    parts = ((ticks - more, low), (more, low + 1))
    return [Record(0, count, rate * FRACTION, 0, 0) for count, rate in parts if count]


def _flagged(records: list[Record], flags: int) -> list[Record]:
    if not records:
        raise PulseRecordError("a move of no ticks; it is shorter than half a microsecond")
    last = len(records) - 1
    ends = {0: FIRST} | {last: LAST if last else FIRST | LAST}
    return [
        replace(record, flags=record.flags | flags | ends.get(i, 0))
        for i, record in enumerate(records)
    ]


def _check(number: int, count: int, velocity: Fraction, slope: int, jerk: int) -> None:
    unit = UNITS_PER_HZ * FRACTION
    end = velocity + count * slope + Fraction(jerk * count * (count + 1), 2)
    highest = HIGHEST_RATE * unit
    if not 0 < count <= COUNT_LIMIT:
        raise PulseRecordError(f"phase {number}: count {count} is not within 1..{COUNT_LIMIT}")
    if velocity < -unit or velocity > highest or end > highest:
        fastest = float(max(velocity, end) / unit)
        raise PulseRecordError(
            f"phase {number}: rates from {float(velocity / unit):.6g} to {fastest:.6g} Hz are not "
            f"within 0..{HIGHEST_RATE} Hz; fewer pulses per unit or a lower speed would be"
        )
    if max(abs(slope), abs(jerk)) >= SLOPE_LIMIT:
        raise PulseRecordError(
            f"phase {number}: acceleration {slope / unit:.6g} Hz/us or jerk {jerk / unit:.6g} "
            f"Hz/us2 is not below {SLOPE_LIMIT / unit:.6g}; use a longer acceleration time"
        )
