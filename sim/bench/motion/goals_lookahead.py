# SPDX-License-Identifier: Apache-2.0
"""Goals of the G-code reader and of the look-ahead planner."""

from __future__ import annotations

import functools
import itertools
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from asip_asm.project import ROOT
from sim.bench.motion.goal import FULL, Counts, Features, Measured, Rows
from sim.motion.gcode.oracle import compare_samples
from sim.motion.geometry.moves import Motion, Move
from sim.motion.lookahead import figures as lookahead_figures
from sim.motion.lookahead import paths as lookahead_paths
from sim.motion.lookahead import stress
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import DEPTH, LookaheadSettings

FEATURES = Features()


@FEATURES.feature(
    "G-code: LinuxCNC's samples, equal moves",
    "LinuxCNC",
    "at least 22 of 24 equal, none different",
    ".venv/bin/python -m sim.motion.gcode.oracle --samples",
)
def compare_goal(counts: Counts, rows: Rows) -> Measured:
    """LinuxCNC's sample programs through both interpreters."""
    found = compare_samples()
    return found.text, found.goal_met


@FEATURES.feature(
    "84 chords, G64 steps; G64 smooth; G61",
    "1.5 s; -; 5 s",
    "<= 1.52 s; <= 1.60 s; 5.1 s",
    "make test T=test_chords",
)
def times(counts: Counts, rows: Rows) -> Measured:
    """Times of the CNC paper's figure 5, as `microtick motion` has measured them."""
    steps, smooth, stops = (
        float(rows[name]["ours"])
        for name in (
            "with blending, trapezoid",
            "with blending, jerk-limited",
            "without blending, trapezoid",
        )
    )
    met = steps <= 1.52 and smooth <= 1.60 and round(stops, 1) <= 5.1
    return f"{steps:.3f} s; {smooth:.3f} s; {stops:.3f} s", met


@FEATURES.feature(
    "G64 P: 1, 5, 10, 25, 100 um",
    "not exceeded",
    "apex <= P at 10 kHz",
    "make test T=test_corner",
)
def corners(counts: Counts, rows: Rows) -> Measured:
    """90 degrees for P of 1 to 100 um: apex of the set-points by P."""
    worst = 0.0
    for tolerance in (0.001, 0.005, 0.010, 0.025, 0.1):
        program = lookahead_figures.corner_program(f"G64 P{tolerance}")
        moves = lookahead_figures.without_approach(program)
        points = lookahead_figures.run(moves, LookaheadSettings(only_blends=True))[0]
        near = np.linalg.norm(points - np.array(moves[0].end[:3]), axis=1).min()
        worst = max(worst, float(near) / tolerance)
    return f"{worst:.4f} P at most", worst <= 1.0


@FEATURES.feature(
    "corner of 90 degrees, P 0.1 mm, 4.8 m/s2",
    "-",
    ">= 31.6 mm/s",
    "make test T=test_corner",
)
def corner_speed(counts: Counts, rows: Rows) -> Measured:
    """90 degrees, P = 0.1 mm, 4.8 m/s2: speed of the set-point next to the corner."""
    base = LookaheadSettings(only_blends=True)
    found = []
    for jerk_limited in (True, False):
        limits = MachineLimits.of(base.robot, jerk_limited)
        moves = lookahead_figures.without_approach(lookahead_figures.corner_program("G64 P0.1"))
        blocks = list(Lookahead(moves, replace(base, limits=limits)).setpoints())
        tool = np.concatenate([block.position[:, :3] for block in blocks])
        speed = np.concatenate([block.velocity[:, :3] for block in blocks])
        corner = np.array(moves[0].end[:3]) / 1e3
        near = np.linalg.norm(tool - corner, axis=1).argmin()
        found.append(float(np.linalg.norm(speed[near])) * 1e3)
    return f"{found[1]:.1f} mm/s; {found[0]:.1f} with limited jerk", min(found) >= 31.6


@FEATURES.feature(
    "time with G64 P against G61, 20 paths",
    "-",
    "never longer, P from 1 um to 1 mm",
    "make test T=test_paths",
)
def never_longer(counts: Counts, rows: Rows) -> Measured:
    """Every path of sim/motion/lookahead/paths.py at every P: the largest loss by stops."""
    found = list(lookahead_paths.losses())
    longer = sum(more > 0.0 for _, _, more in found)
    names = len({name for name, _, _ in found})
    saved = -sum(more for _, _, more in found) / len(found)
    return f"{longer} of {len(found)} runs longer, {names} paths; {saved:.3f} s saved on average", (
        longer == 0 and names >= 20
    )


@FEATURES.feature(
    "A-G-H P 0.01; raster P 0.05; chords of 1 and 0.02 mm P 0.02",
    "-",
    "<= 11.93 s; <= 6.90 s; <= 1.75 s",
    "make test T=test_paths",
)
def path_times(counts: Counts, rows: Rows) -> Measured:
    """Times of three paths of sim/motion/lookahead/paths.py."""
    wanted = (
        ("A-G-H", 0.01, 11.93),
        ("raster, 12 lines of 20 mm, 2 mm apart", 0.05, 6.90),
        ("circle, chords of 1 and 0.02 mm", 0.02, 1.75),
    )
    found = [lookahead_paths.path_time(name, f"G64 P{p}") for name, p, _ in wanted]
    met = all(time <= most for time, (*_, most) in zip(found, wanted, strict=True))
    return "; ".join(f"{time:.3f} s" for time in found), met


@FEATURES.feature(
    "time above the least of IPOPT: A-G-H P 0.01; raster P 0.05; mixed chords P 0.02",
    "-",
    "<= 3 %",
    "make goals T=motion RUN=full",
)
def against_optimum(counts: Counts, rows: Rows) -> Measured:
    """Times of the planner against those of sim/motion/lookahead/optimum.py."""
    if counts.programs < FULL.programs:
        return "", None
    from sim.motion.lookahead import optimum  # it needs CasADi, and the other rows do not

    found = [optimum.compare(name, tolerance) for name, tolerance in optimum.WANTED]
    text = "; ".join(f"{each.name.split(',')[0]} {100 * each.more:.1f} %" for each in found)
    return text, all(each.more <= 0.03 for each in found)


@FEATURES.feature(
    "circles of 10 mm in short chords, P 0.02: time by the least at the feed",
    "-",
    "<= 1.03, chords of 1 and 0.02, of 0.1, of 0.3, 2 and 0.05 mm",
    "make test T=test_paths",
)
def short_chords(counts: Counts, rows: Rows) -> Measured:
    """Path times of chords against a lower bound.

    The bound: the approach as it is, then the circle's length inside the tolerance at the feed with
    one rise and one fall of the speed, each under the limits of the tool alone.
    """
    settings, p = LookaheadSettings(), 0.02
    tool, feed = MachineLimits.of(settings.robot).tool, lookahead_paths.FEED / 60e3
    ramp = feed / tool.acceleration + tool.acceleration / tool.jerk  # with its jerk
    least = 2 * math.pi * (0.010 - p / 1e3) / feed + ramp
    approach = lookahead_paths.approach_time()
    found = [
        (lookahead_paths.path_time(name, f"G64 P{p}", settings) - approach) / least
        for name in lookahead_paths.CHORDS
    ]
    return "; ".join(f"{ratio:.4f}" for ratio in found), max(found) <= 1.03


@functools.cache
def _campaign(count: int) -> list[stress.Outcome]:
    """The random programs, run once for the rows that need them."""
    return list(stress.programs(stress.FIRST, count))


@FEATURES.feature(
    "limits of tool, legs, table; half in five axes",
    "XYZ only",
    "0 programs above 1.001",
    ".venv/bin/python -m sim.motion.lookahead.stress --count 10000",
)
def violations(counts: Counts, rows: Rows) -> Measured:
    """Random programs: set-points above a limit, and the worst ratio to one."""
    found = _campaign(counts.programs)
    over = sum(outcome.worst > stress.VIOLATION for outcome in found)
    ticks, worst = sum(outcome.ticks for outcome in found), stress.greatest(found, "worst")
    return f"{over} of {len(found)} programs, {ticks} set-points; worst {worst:.4f}", over == 0


@FEATURES.feature(
    "path and corners of random programs",
    "-",
    "within P",
    ".venv/bin/python -m sim.motion.lookahead.stress --count 10000",
)
def random_p(counts: Counts, rows: Rows) -> Measured:
    """The same programs: distance of path and corners beyond P."""
    found = _campaign(counts.programs)
    worst = max(stress.greatest(found, name) for name in ("path", "corner"))
    return f"{worst * 1e9:.3f} nm beyond P", worst <= stress.ROUNDING


@FEATURES.feature(
    "tiny, empty, repeated moves, tiny P",
    "-",
    "no stall",
    ".venv/bin/python -m sim.motion.lookahead.stress --odd --count 1000000",
)
def odd(counts: Counts, rows: Rows) -> Measured:
    """Paths of tiny, empty, repeated and reversed moves, tiny P: stalls."""
    settings = LookaheadSettings()
    for block in range(counts.odd):
        stress.odd_block(block, settings)
    return f"0 stalls in {counts.odd * stress.BLOCK} paths", True


@FEATURES.feature(
    "set-points: position, velocity, acceleration",
    "1 ms",
    "10 kHz, derivatives of each other",
    "make test T=test_set_points",
)
def derivatives(counts: Counts, rows: Rows) -> Measured:
    """Velocities and accelerations of set-points against differences of their positions.

    By Taylor a central difference misses a velocity by J T^2 / 6 at most, a second difference an
    acceleration by J T / 3; here as parts of these, J the limit of the jerk.
    """
    settings, worst = LookaheadSettings(), 0.0
    period, limits = settings.period, settings.limits
    jerk = np.array([limits.tool.jerk] * 3 + [limits.table.jerk] * 2)
    for seed in range(10):
        blocks = list(Lookahead(iter(stress.random_moves(seed, 20)), settings).setpoints())
        q, v, a = (
            np.concatenate([getattr(block, name) for block in blocks])
            for name in ("position", "velocity", "acceleration")
        )
        first = np.abs((q[2:] - q[:-2]) / (2 * period) - v[1:-1]) / (jerk * period**2 / 6)
        second = np.abs(np.diff(q, 2, axis=0) / period**2 - a[1:-1]) / (jerk * period / 3)
        worst = max(worst, float(first.max()), float(second.max()))
    return f"every {period * 1e6:.0f} us; {worst:.3f} of Taylor's bound", worst <= 1.0


def spiral(count: int | None) -> Iterator[Move]:
    """Segments of some 0.3 mm, with a turn of the table; None: without end."""
    place = (30.0, 0.0, 600.0, 0.0, 0.0)
    for k in itertools.count(1) if count is None else range(1, count + 1):
        radius = 30 + 10 * math.sin(k * 0.003)
        end = (radius * math.cos(k * 0.01), radius * math.sin(k * 0.01), 600.0, 0.0, k * 0.01)
        yield Move(k, "", Motion.LINEAR, place, end, 15000.0, tolerance=0.01)
        place = end


@FEATURES.feature(
    "part of 10^6 moves, five axes: every tick planned, windows of it found",
    "-",
    "<= 600 s of a core, <= 500 MB",
    "make goals T=motion RUN=full",
)
def long_part(counts: Counts, rows: Rows) -> Measured:
    """The plan of the main job: processor time and peak memory of its process."""
    with tempfile.TemporaryDirectory() as folder:
        part = Path(folder) / "part.ngc"
        part.write_text("".join(lookahead_paths.cam_part(counts.part)), encoding="utf-8")
        said = Path(folder) / "said"
        with said.open("w") as file:
            command = [sys.executable, "-m", "sim.bench.run", str(part), "--plan-only"]
            done = subprocess.Popen(command, cwd=ROOT, stdout=file)
            _, status, used = os.wait4(done.pid, 0)
        text = said.read_text(encoding="utf-8")
        done.returncode = os.waitstatus_to_exitcode(status)
    if done.returncode:
        raise RuntimeError(f"the plan of the part failed with status {done.returncode}")
    moves = int(text.split(" moves")[0].split()[-1])
    time_s, memory = used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3
    windows = text.count("window of")
    return (
        f"{moves} moves: {time_s:.0f} s; {memory:.0f} MB; {windows} windows",
        time_s <= 600 and memory <= 500 if moves >= 1e6 else None,
    )


@FEATURES.feature(
    "look-ahead",
    "n segments",
    ">= 256 segments, >= 2000/s, constant work",
    "make test T=test_stream",
)
def throughput(counts: Counts, rows: Rows) -> Measured:
    """Segments planned per second of processor time, and cells planned per cell read."""
    count = 4000
    run = Lookahead(spiral(count), LookaheadSettings())
    begin = time.process_time()
    run.duration()
    rate = count / (time.process_time() - begin)
    work = run.planned / run.summary.cells
    return (
        f"{DEPTH} segments; {rate:.0f} segments/s; {work:.2f} plans per cell",
        DEPTH >= 256 and rate >= 2000 and work <= 4,
    )
