# SPDX-License-Identifier: Apache-2.0
"""Goals of the G-code reader and of the look-ahead planner."""

from __future__ import annotations

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
from sim.bench.motion.goals_planner import FULL
from sim.motion.geometry.moves import Motion, Move
from sim.motion.lookahead import figures as lookahead_figures
from sim.motion.lookahead import paths as lookahead_paths
from sim.motion.lookahead import stress
from sim.motion.lookahead.limits import MachineLimits
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import DEPTH, LookaheadSettings
from sim.report.goals import Goal, at_least, at_most, depth, exactly, not_measured

LONG_PART = 1_000_000
"""Moves of the part of the goal."""
WANTED_TIMES = (
    ("A-G-H", 0.01, 11.93),
    ("raster, 12 lines of 20 mm, 2 mm apart", 0.05, 6.90),
    ("circle, chords of 1 and 0.02 mm", 0.02, 1.75),
)
"""Path, tolerance P [mm], most time [s]."""


def paths(full: bool) -> Iterator[Goal]:
    """The look-ahead planner on the examples of a paper and on given paths."""
    yield from times()
    yield corners()
    yield corner_speed()
    yield from never_longer()
    yield from path_times()
    yield from against_optimum(full)
    yield short_chords()
    yield derivatives()


def random_paths(full: bool) -> Iterator[Goal]:
    """The look-ahead planner on random programs and on odd moves."""
    yield from random_programs(10_000 if full else 60)
    yield odd(1000 if full else 1)


def parts(full: bool) -> Iterator[Goal]:
    """A long part, and how fast the look-ahead planner is."""
    yield from long_part(LONG_PART if full else 20_000)
    yield from throughput()


def times() -> Iterator[Goal]:
    """Times of the CNC paper's figure 5."""
    with tempfile.TemporaryDirectory() as folder:
        found = lookahead_figures.figures(Path(folder))["figures 4 and 5"]
    blended, stops = found["with blending [s]"], found["without blending [s]"]
    steps, smooth = blended["steps of acceleration"], blended["jerk limited"]
    yield at_most("84 chords, G64, steps of acceleration", steps, 1.52, "s", "published: 1.5 s")
    yield at_most("84 chords, G64, limited jerk", smooth, 1.60, "s")
    stopping = stops["steps of acceleration"]
    yield at_most("84 chords, G61, steps of acceleration", stopping, 5.15, "s", "published: 5 s")


def corners() -> Goal:
    """90 degrees for P of 1 to 100 um: apex of the set-points by P."""
    worst = 0.0
    for tolerance in (0.001, 0.005, 0.010, 0.025, 0.1):
        program = lookahead_figures.corner_program(f"G64 P{tolerance}")
        moves = lookahead_figures.without_approach(program)
        points = lookahead_figures.run(moves, LookaheadSettings(only_blends=True))[0]
        near = np.linalg.norm(points - np.array(moves[0].end[:3]), axis=1).min()
        worst = max(worst, float(near) / tolerance)
    return at_most("corner of 90 degrees, P of 1 to 100 um: apex by P", worst, 1.0, "")


def corner_speed() -> Goal:
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
    return at_least("corner of 90 degrees, P 0.1 mm, 4.8 m/s2", min(found), 31.6, "mm/s")


def never_longer() -> Iterator[Goal]:
    """Every path of sim/motion/lookahead/paths.py at every P: the largest loss by stops."""
    found = list(lookahead_paths.losses())
    longer = sum(more > 0.0 for _, _, more in found)
    names = len({name for name, _, _ in found})
    saved = -sum(more for _, _, more in found) / len(found)
    note = f"of {len(found)}, P from 1 um to 1 mm; {saved:.3f} s saved on average"
    yield exactly("paths that take longer with G64 P than with G61", longer, 0, "", note)
    yield at_least("paths compared", names, 20, "")


def path_times() -> Iterator[Goal]:
    """Times of three paths of sim/motion/lookahead/paths.py."""
    for name, p, most in WANTED_TIMES:
        yield at_most(
            f"{name}, P {p:g} mm", lookahead_paths.path_time(name, f"G64 P{p}"), most, "s"
        )


def against_optimum(full: bool) -> Iterator[Goal]:
    """Times of the planner against those of IPOPT in sim/motion/lookahead/optimum.py."""
    if not full:
        for name, p, _ in WANTED_TIMES:
            yield not_measured(f"{name}, P {p:g} mm: above the least of IPOPT", "<= 3", "%", FULL)
        return
    from sim.motion.lookahead import optimum  # it needs CasADi, and the other rows do not

    for name, p in optimum.WANTED:
        more = 100 * optimum.compare(name, p).more
        yield at_most(f"{name}, P {p:g} mm: above the least of IPOPT", more, 3.0, "%")


def short_chords() -> Goal:
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
        round((lookahead_paths.path_time(name, f"G64 P{p}", settings) - approach) / least, 4)
        for name in lookahead_paths.CHORDS
    ]
    note = f"chords of 1 and 0.02, of 0.1, of 0.3, 2 and 0.05 mm: {found}"
    return at_most(
        "circles of 10 mm in chords, P 0.02: time by the least", max(found), 1.03, "", note
    )


def random_programs(count: int) -> Iterator[Goal]:
    """Random programs: set-points above a limit, distance of path and corners beyond P."""
    found = list(stress.programs(stress.FIRST, count))
    over = sum(outcome.worst > stress.VIOLATION for outcome in found)
    ticks, worst = sum(outcome.ticks for outcome in found), stress.greatest(found, "worst")
    note = f"of {count}, {ticks} set-points, half in five axes; greatest use {worst:.4f}"
    yield exactly("random programs above a limit of tool, leg or table", over, 0, "", note)
    beyond = max(stress.greatest(found, name) for name in ("path", "corner"))
    yield at_most("random programs: path and corners beyond P", beyond, stress.ROUNDING, "m")
    yield depth("random programs planned", count, 10_000, "", FULL)


def odd(blocks: int) -> Goal:
    """Paths of tiny, empty, repeated and reversed moves, tiny P: stalls."""
    settings = LookaheadSettings()
    for block in range(blocks):
        stress.odd_block(block, settings)
    # A stall raises an error, which is a goal that is missed.
    what = "paths of tiny, empty and repeated moves without a stall"
    return depth(what, blocks * stress.BLOCK, 1_000_000, "", FULL)


def derivatives() -> Goal:
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
    what = "speeds and accelerations of set-points: off their differences by Taylor's bound"
    return at_most(what, worst, 1.0, "", f"every {period * 1e6:.0f} us; published: every 1 ms")


def spiral(count: int | None) -> Iterator[Move]:
    """Segments of some 0.3 mm, with a turn of the table; None: without end."""
    place = (30.0, 0.0, 600.0, 0.0, 0.0)
    for k in itertools.count(1) if count is None else range(1, count + 1):
        radius = 30 + 10 * math.sin(k * 0.003)
        end = (radius * math.cos(k * 0.01), radius * math.sin(k * 0.01), 600.0, 0.0, k * 0.01)
        yield Move(k, "", Motion.LINEAR, place, end, 15000.0, tolerance=0.01)
        place = end


def long_part(count: int) -> Iterator[Goal]:
    """The plan of the main job: processor time and peak memory of its process."""
    with tempfile.TemporaryDirectory() as folder:
        part = Path(folder) / "part.ngc"
        part.write_text("".join(lookahead_paths.cam_part(count)), encoding="utf-8")
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
    what, note = "part of 10^6 moves in five axes", f"{text.count('window of')} windows of it found"
    yield depth(f"{what}: moves planned, every tick", moves, LONG_PART, "", FULL)
    if moves < LONG_PART:
        yield not_measured(f"{what}: time of a core", "<= 600", "s", FULL)
        yield not_measured(f"{what}: memory", "<= 500", "MB", FULL)
        return
    yield at_most(f"{what}: time of a core", time_s, 600, "s", note)
    yield at_most(f"{what}: memory", memory, 500, "MB")


def throughput() -> Iterator[Goal]:
    """Segments planned per second of processor time, and cells planned per cell read."""
    count = 4000
    run = Lookahead(spiral(count), LookaheadSettings())
    begin = time.process_time()
    run.duration()
    rate = count / (time.process_time() - begin)
    work = run.planned / run.summary.cells
    yield at_least("look-ahead: depth", DEPTH, 256, "segments")
    yield at_least("look-ahead: segments of a second", rate, 2000, "")
    yield at_most("look-ahead: plans of a cell", work, 4, "")
