# SPDX-License-Identifier: Apache-2.0
"""The bring-up of one motor from its file to its moves, and how near it comes to the file."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.bench.drive.axis.alignment import wrapped
from sim.bench.drive.axis.bench import Bench, Record
from sim.bench.drive.axis.hall import LIMITS
from sim.bench.drive.axis.identify import Found, identify
from sim.bench.drive.axis.motor_file import ABSOLUTE, HALL, HALL_SPEED, SECTORS, SINCOS, OneMotor
from sim.bench.drive.axis.tuning import (
    Gains,
    close,
    current_response,
    frames_lost,
    gains_of,
    go,
    speed_step,
    turning_errors,
    velocity_response,
)
from sim.bench.drive.response import Response
from sim.laws.drive.clocks import CLOCK
from sim.report.goals import Goal, at_least, at_most

Report = Callable[[str], None]
WITHIN = {"R": 5.0, "L_d": 5.0, "L_q": 5.0, "flux": 3.0, "inertia": 10.0}  # percent
LEAST_BANDWIDTH, LEAST_MARGIN = 3000.0, 50.0
BY_ENCODER = "by the encoder"
MOST_ANGLE = {"without motion": 5.0, "with motion": 2.0, BY_ENCODER: 2.0}  # degrees, electrical
RESTS = 1.37  # electrical turns from position 0, where a motor with an absolute encoder begins
MOST_FOLLOWING = 5.0  # degrees, electrical: at the end of the move
ALL_MOTIONS = "in all motions"
HALL_SHARES = (0.25, HALL_SPEED, 1.0)  # of the fastest moves: speeds of Hall lines that are shown
MOST_SERIAL = 2.0  # degrees, electrical: of the angle without lines A and B, as MOST_ANGLE


@dataclass(frozen=True)
class Result:
    """found, tuned: what was identified, and the gains of it; angles: errors of both alignments
    [rad]; current, velocity: closed loops; move: record and wanted counts, none with Hall lines;
    step: actual and ordered speed, rise [s], overshoot; serial: of an encoder without lines A and
    B, by name the rms and largest error of the angle, electrical [degrees]."""

    one: OneMotor
    found: Found
    tuned: Gains
    angles: dict[str, float]
    current: Response
    velocity: Response
    move: tuple[Record, NDArray[np.float64]] | None
    step: tuple[NDArray[np.float64], NDArray[np.float64], float, float]
    simulated: float
    serial: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def compared(self) -> dict[str, tuple[float, float, str]]:
        """Found, in the file, unit."""
        one, found, motor = self.one, self.found, self.one.motor
        travel, force, mass = one.units
        return {
            "R": (found.R, motor.R, "ohm"),
            "L_d": (found.L_d, motor.L_d, "H"),
            "L_q": (found.L_q, motor.L_q, "H"),
            "flux": (found.psi, motor.psi, "V s"),
            "inertia": (found.inertia, one.inertia, mass),
            "friction": (found.coulomb, one.friction.coulomb, force),
            "viscous": (found.viscous, one.friction.viscous, f"{force} s/{travel}"),
        }

    def off(self, name: str) -> float:
        """Distance from the file in percent, of what the file has."""
        found, file, _ = self.compared[name]
        return 100 * abs(found / file - 1)

    @property
    def angle_by(self) -> str:
        """How the angle of the loops was found."""
        return "with motion" if self.one.encoder_offset is None else BY_ENCODER

    @property
    def not_done(self) -> dict[str, str]:
        """Steps that the encoder does not allow, and why."""
        return LIMITS if self.one.encoder == HALL else {}

    @property
    def stays_away(self) -> float:
        """From the end of the move, electrical [degrees]; of a start-up that makes one."""
        assert self.move is not None
        record, wanted = self.move
        per_count = self.one.motor.wave * self.one.resolution
        return float(np.degrees(abs(record.counts[-1] - wanted[-1]) * per_count))

    def goals(self) -> Iterator[Goal]:
        """Rows of one motor."""
        for name, most in WITHIN.items():
            yield at_most(f"{name}, identified against the file", self.off(name), most, "%")
        for name, angle in self.angles.items():
            off = float(np.degrees(abs(angle)))
            yield at_most(f"angle by alignment {name}", off, MOST_ANGLE[name], "degrees")
        bandwidth = min(LEAST_BANDWIDTH, 0.8 * self.one.current_bandwidth)
        yield at_least("current loop, -3 dB, by injection", self.current.bandwidth, bandwidth, "Hz")
        margin = self.current.margin
        yield at_least("current loop, phase margin", margin, LEAST_MARGIN, "degrees")
        bandwidth = 0.8 * self.one.velocity_bandwidth
        name = "velocity loop, -3 dB, by injection"
        yield at_least(name, self.velocity.bandwidth, bandwidth, "Hz")
        margin = self.velocity.margin
        yield at_least("velocity loop, phase margin", margin, LEAST_MARGIN, "degrees")
        if self.move is not None:
            name = "position after the move, electrical"
            yield at_most(name, self.stays_away, MOST_FOLLOWING, "degrees")
        if self.one.encoder == HALL:
            yield from self._hall_goals()
            return
        for name, (_, largest) in self.serial.items():
            source = "sine and cosine" if self.one.encoder == SINCOS else "the serial line"
            name = f"angle from {source}, largest error {name}"
            yield at_most(name, largest, MOST_SERIAL, "degrees")

    def _hall_goals(self) -> Iterator[Goal]:
        """The sector is right, so the angle is wrong by a sector and the error of an edge at most.
        At speeds at which the velocity loop is measured it is wrong by the error of an edge, and by
        what that makes of the sector's time."""
        edge = float(np.degrees(self.one.hall_error))
        bounds = [360 / SECTORS + edge, math.inf, 3 * edge, 3 * edge]
        for (name, (_, largest)), bound in zip(self.serial.items(), bounds, strict=True):
            if bound == math.inf:  # slower: shown alone
                continue
            most = MOST_SERIAL + bound
            yield at_most(f"angle from Hall lines, largest error {name}", largest, most, "degrees")

    def as_json(self) -> dict[str, Any]:
        """What the results file has besides the goals."""
        found, tuned = self.found, self.tuned
        k_p, k_i = tuned.velocity_gains

        def response(loop: Response) -> dict[str, Any]:
            return {
                "frequency_hz": loop.frequency.tolist(),
                "size": np.abs(loop.closed).tolist(),
                "phase_degrees": np.degrees(np.unwrap(np.angle(loop.closed))).tolist(),
                "bandwidth_hz": loop.bandwidth,
                "margin_degrees": loop.margin,
            }

        return {
            "identified": {
                name: {"found": value, "file": file, "unit": unit}
                for name, (value, file, unit) in self.compared.items()
            },
            "angle_rad": {self.angle_by: found.angle, "without motion": found.still},
            "not_done": self.not_done,
            "encoder_offset_rad": found.offset,
            "encoder_port": dict(self.one.port),
            "encoder_counter": dict(self.one.counter),
            "encoder_delay_s": self.one.frame_clocks * CLOCK,
            "encoder_error_degrees": {
                name: {"rms": rms, "largest": largest}
                for name, (rms, largest) in self.serial.items()
            },
            "moved_without_motion_degrees": float(np.degrees(found.moved)),
            "gains": {
                "current": {"K_p_d": tuned.k_d, "K_p_q": tuned.k_q, "K_i": tuned.k_i},
                "velocity": {"K_p": k_p, "K_i": k_i},
            },
            "current_loop": response(self.current),
            "velocity_loop": response(self.velocity),
            "speed_step": {"rise_s": self.step[2], "overshoot": float(self.step[3])},
            "simulated_s": self.simulated,
        }


def bring_up(
    one: OneMotor,
    angle: float = 0.7,
    report: Report = lambda text: None,
    bench: Bench | None = None,
) -> Result:
    """Bring up a motor at rest; angle: electrical, at its position 0 [rad], which nothing but the
    plant knows unless the file has it as `encoder_offset`. Raises BringUpError."""
    if one.encoder_offset is not None:
        angle = one.encoder_offset
    at = RESTS * one.motor.pole if one.encoder in ABSOLUTE else 0.0
    at = RESTS % 1 * one.motor.pole if one.encoder == HALL else at
    bench = bench or Bench(one, angle, at)
    report("alignment and identification")
    found = identify(bench)
    true = bench.truth["angle"]
    by = "with motion" if one.encoder_offset is None else BY_ENCODER
    angles = {} if found.still is None else {"without motion": wrapped(found.still - true)}
    angles[by] = wrapped(found.angle - true)
    tuned = gains_of(one, found)
    report("current loop by injection")
    current = current_response(bench, found, tuned)
    close(bench, found, tuned)
    bench.off()
    report(
        ("" if one.encoder == HALL else "a move, ")
        + "a step of the speed, velocity loop by injection"
    )
    now = float(bench.run(np.zeros((1, 5))).counts[0])
    end = (
        0.0
        if abs(now) * one.resolution * one.motor.wave > 3
        else now + 2 * one.motor.pole / one.resolution
    )
    move = None if one.encoder == HALL else go(bench, found, now, end)
    step = speed_step(bench, found, tuned)
    now = float(bench.run(np.zeros((1, 5))).counts[0])
    velocity = velocity_response(bench, found, tuned, now)
    serial = {}
    if one.counter or one.encoder == HALL:
        serial[ALL_MOTIONS] = bench.off()
    if one.encoder == HALL:
        serial |= turning_errors(bench, found, HALL_SHARES)
    if one.counter and one.encoder != SINCOS:  # a lost sample of sine and cosine trips
        serial["after a lost frame"] = frames_lost(bench, found, tuned, 1)
        allowed = one.counter["Periods"] - 1
        serial[f"after {allowed} lost frames"] = frames_lost(bench, found, tuned, allowed)
    simulated = bench.halves_run * one.setting().period
    return Result(one, found, tuned, angles, current, velocity, move, step, simulated, serial)
