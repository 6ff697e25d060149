# SPDX-License-Identifier: Apache-2.0
"""Random motors, each brought up from its file: the worst of what was found, as goals."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

from sim.bench.drive.axis.bench import BringUpError
from sim.bench.drive.axis.motor_file import load
from sim.bench.drive.axis.random_motors import SEED, motors
from sim.bench.drive.axis.result import (
    LEAST_BANDWIDTH,
    LEAST_MARGIN,
    MOST_ANGLE,
    MOST_FOLLOWING,
    WITHIN,
    bring_up,
)
from sim.report.goals import Goal, at_least, at_most, exactly
from sim.rtl.processes import processes

COUNT = 20
JOBS = 2
LEAST_SHARE = 0.8  # of the bandwidth that a file asks for


def one_result(file: str, angle: float) -> dict[str, float] | str:
    """Figures of one motor, or why its bring-up stopped; angle: electrical, at rest [rad]."""
    one = load(Path(file))
    try:
        result = bring_up(one, angle)
    except BringUpError as error:
        return f"{file}: {error}"
    found = {name: result.off(name) for name in WITHIN}
    found |= {name: math.degrees(abs(off)) for name, off in result.angles.items()}
    found["moved"] = math.degrees(result.found.moved)
    found["bandwidth"], found["margin"] = result.current.bandwidth, result.current.margin
    found["share"] = result.current.bandwidth / one.current_bandwidth
    found["velocity share"] = result.velocity.bandwidth / one.velocity_bandwidth
    found["velocity margin"] = result.velocity.margin
    found["stays away"] = result.stays_away
    force = one.motor.force_per_ampere * one.motor.i_max
    off = abs(result.found.coulomb - one.friction.coulomb)
    found["friction"] = 100 * off / force
    return found


def campaign(
    folder: Path, report: Callable[[str], None], count: int = COUNT, seed: int = SEED
) -> dict[str, dict[str, float] | str]:
    """File name -> figures or error of each motor."""
    report(f"{count} random motors, seed {seed}")
    files = [str(file) for file, _ in motors(folder, count, seed)]
    angles = np.random.default_rng(seed).uniform(-math.pi, math.pi, count).tolist()
    with processes(JOBS) as pool:
        work = [pool.submit(one_result, *pair) for pair in zip(files, angles, strict=True)]
        return {Path(file).name: one.result() for file, one in zip(files, work, strict=True)}


def goals(found: Mapping[str, dict[str, float] | str], seed: int = SEED) -> Iterator[Goal]:
    """The worst of all motors; a motor whose bring-up stopped is missed."""
    what = f"{len(found)} random motors of seed {seed}"
    stopped = [text for text in found.values() if isinstance(text, str)]
    note = stopped[0] if stopped else ""
    yield exactly(f"{what}: bring-up stopped", len(stopped), 0, "motors", note)
    figures = [row for row in found.values() if not isinstance(row, str)]
    if not figures:
        return

    def worst(name: str) -> float:
        return max(row[name] for row in figures)

    def least(name: str) -> float:
        return min(row[name] for row in figures)

    for name, most in WITHIN.items():
        yield at_most(f"{what}: {name}, identified from the start-up", worst(name), most, "%")
    name = f"{what}: Coulomb friction, identified, of the rated force"
    yield at_most(name, worst("friction"), 1.0, "%")
    for name in ("without motion", "with motion"):
        most = MOST_ANGLE[name]
        yield at_most(f"{what}: angle by alignment {name}", worst(name), most, "degrees")
    name = f"{what}: way of the rotor in the alignment without motion, electrical"
    yield at_most(name, worst("moved"), 15.0, "degrees")
    name = f"{what}: current loop by injection"
    yield at_least(f"{name}, -3 dB", least("bandwidth"), LEAST_BANDWIDTH, "Hz")
    yield at_least(f"{name}, -3 dB, of what the file asks", least("share"), LEAST_SHARE, "1")
    yield at_least(f"{name}, phase margin", least("margin"), LEAST_MARGIN, "degrees")
    name = f"{what}: velocity loop by injection"
    yield at_least(f"{name}, -3 dB, of what the file asks", least("velocity share"), 0.8, "1")
    yield at_least(f"{name}, phase margin", least("velocity margin"), LEAST_MARGIN, "degrees")
    name = f"{what}: position after a move, electrical"
    yield at_most(name, worst("stays away"), MOST_FOLLOWING, "degrees")


def rows(report: Callable[[str], None]) -> list[Goal]:
    """The goals of `COUNT` motors, some minutes."""
    with tempfile.TemporaryDirectory() as folder:
        return list(goals(campaign(Path(folder), report)))
