# SPDX-License-Identifier: Apache-2.0
"""Drive and feed-forward study: figures 10 and 11 of the CNC paper, its other tests, and

the same cases on our robot. Numbers come next to the paper's, or next to a goal of our own where
the paper has none.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from asip_asm.files import write_text
from sim.bench.cnc import robot as robot_study
from sim.bench.cnc import servo
from sim.bench.cnc.position_loop import (
    CASES,
    Case,
    Drive,
    Response,
    ThereAndBack,
    greatest_acceleration,
    simulate,
)
from sim.motion.gcode.interpreter import parse_file
from sim.motion.geometry.moves import Motion
from sim.motion.planner.figures import Result
from sim.motion.trajectory.exact_stop import MotionSettings, generate
from sim.motion.trajectory.program import AGH, set_points
from sim.report import pictures
from sim.robot.parameters import Robot

JERK_TIME = 0.02  # s, of the S-curve moves
LOOPS = {"1st-order loop": Drive(), "2nd-order loop": Drive(damping=math.sqrt(0.5))}
PROFILES = {"trapezoid": 0.0, "S-curve": JERK_TIME}
FIG_10, FIG_11 = "cnc_fig10.svg", "cnc_fig11.svg"
SERVO_FILE, ROBOT_FILE = "cnc_servo.svg", "robot_feed_forward.svg"
RESULTS_FILE = "drive_figures.json"
PUBLISHED_TRANSIENT = 103 / servo.LOAD_COUNTS * servo.PITCH  # m
# First blocks of letters that the quick run takes on the robot, by index into the blocks of AGH.
STROKES = {"A, left leg": 2, "G, back": 12, "H, left stroke": 19}


def responses() -> dict[tuple[str, str, str], Response]:
    """Runs by loop, profile and case."""
    return {
        (loop, profile, case.name): simulate(
            drive, ThereAndBack(jerk_time=jerk_time), *case.gains(drive)
        )
        for loop, drive in LOOPS.items()
        for profile, jerk_time in PROFILES.items()
        for case in CASES
    }


def _result(
    figure: str, name: str, unit: str, ours: float, file: str, source: str = "stated", **limit
) -> Result:
    """`below` a bound, `above` one, `near` a figure within a factor, or `like` one as printed;
    without any of them a figure of ours alone."""
    text, agrees = "", True
    if "near" in limit:
        value, factor = limit["near"]
        text, agrees = f"{value:.2f}", value / factor <= ours <= value * factor
    elif "like" in limit:
        value, digits = limit["like"]
        text, agrees = f"{value:.{digits}f}", round(ours, digits) == round(value, digits)
    elif "above" in limit:
        text, agrees = f">= {limit['above']:g}", ours >= limit["above"]
    elif "below" in limit:
        text, agrees = f"< {limit['below']:g}", ours < limit["below"]
    return Result(figure, name, unit, text, source if text else "", float(ours), bool(agrees), file)


def following_results(runs: dict[tuple[str, str, str], Response]) -> list[Result]:
    """Following errors at 15 m/min and 5 m/s2 [mm], the check by theory, slopes of the current."""
    found = []
    none, velocity, both = (case.name for case in CASES)
    for loop, drive in LOOPS.items():
        peak = {
            (profile, case): runs[loop, profile, case].peak_error * 1e3
            for profile in PROFILES
            for case in (none, velocity, both)
        }

        def add(figure: str, name: str, unit: str, ours: float, loop: str = loop, **limit) -> None:
            found.append(_result(figure, f"{loop}: {name}", unit, ours, FIG_11, **limit))

        fast = peak["trapezoid", velocity]
        add("11a", none, "mm", peak["trapezoid", none], like=(2.5, 1))
        add("11b", velocity, "mm", fast, below=0.1)
        add("11c", both, "mm", peak["trapezoid", both], below=0.025, source="goal")
        add("11c", f"{both}, S-curve", "mm", peak["S-curve", both], below=0.01, source="goal")
        theory = fast / (drive.residual(ThereAndBack().acceleration, 1.0, 0.0) * 1e3)
        name, agrees = f"{loop}: velocity, over a lag / kp", abs(theory - 1.0) < 0.005
        found.append(Result("11b", name, "", "1.00", "theory", theory, agrees, FIG_11))
        kept = greatest_acceleration(drive, 1e-4)
        add("11b", "acceleration up to which velocity keeps 0.1 mm", "m/s2", kept)
        ratio = runs[loop, "trapezoid", both].peak_jerk / runs[loop, "S-curve", both].peak_jerk
        add("11c", "peak dI/dt, trapezoid over S-curve", "", ratio, above=5.0, source="goal")
    return found


def servo_results() -> list[Result]:
    """Load step of 1.8 N m [um] in every reading of the bandwidth; positioning by one increment."""
    found = []
    near = (PUBLISHED_TRANSIENT * 1e6, 2.0)
    for reading in servo.READINGS:
        ours = servo.transient(servo.load_step(servo.Servo(reading=reading))) * 1e6
        name = f"load step {servo.LOAD_TORQUE} N m; 160 Hz read as {reading}"
        found.append(_result("table", name, "um", ours, SERVO_FILE, near=near))
    for load in (0.0, servo.LOAD_TORQUE):
        rests = servo.rests(servo.increments(servo.Servo(), load))
        worst = max(abs(count) for rest in rests for count in rest.motor)
        reached = sum(rest.load == (rest.wanted,) for rest in rests)
        name, right = f"+-1 of 144 000 counts under {load} N m: targets met", reached == len(rests)
        found.append(
            Result("table", name, "", str(len(rests)), "stated", reached, right, SERVO_FILE)
        )
        name = f"of 1 280 000 motor counts off at rest under {load} N m"
        found.append(
            Result("table", name, "", "<= 2", "stated", float(worst), worst <= 2, SERVO_FILE)
        )
    return found


def figures(output: Path) -> list[Result]:
    """Draw figures 10 and 11 and the servo tests into `output`, write their numbers as JSON."""
    output.mkdir(parents=True, exist_ok=True)
    runs = responses()
    results = [*following_results(runs), *servo_results()]
    _draw_10(output)
    _draw_11(runs, output)
    _draw_servo(output)
    document = [asdict(result) for result in results]
    write_text(output / RESULTS_FILE, json.dumps(document, indent=2) + "\n")
    return results


def robot_figures(
    output: Path, full: bool, progress: Callable[[str, int, int], None], robot: Robot
) -> list[Result]:
    """The three drive cases and the computed-torque law on the robot, AGH at 2 m/min.

    full: the whole path, else the STROKES. progress gets the name of a case, ticks done and in all.
    """
    output.mkdir(parents=True, exist_ok=True)
    trajectory = generate(parse_file(AGH, robot=robot), MotionSettings(robot))
    path = set_points(trajectory, None)
    if full:
        parts = {"AGH": path}
    else:
        feeds = [trajectory.blocks[block].move.motion for block in STROKES.values()]
        if Motion.RAPID in feeds:
            raise ValueError("a stroke of the quick run is a rapid move; correct STROKES")
        parts = {
            name: robot_study.stroke(robot, path, *trajectory.first_ticks[block : block + 2])
            for name, block in STROKES.items()
        }
    total = sum(map(len, parts.values()))
    cases: dict[str, Case | None] = {f"drives, {case.name}": case for case in CASES}
    cases[robot_study.COMPUTED_TORQUE] = None
    limits = dict(zip(cases, (1000.0, 10.0, 10.0, 10.0), strict=True))  # of the tool error [um]
    results, curves = [], {}
    where = "AGH" if full else f"{len(parts)} strokes of AGH"
    for name, case in cases.items():
        done = 0

        def advance(ticks: int, name: str = name) -> None:
            nonlocal done
            done += ticks
            progress(name, done, total)

        runs = {
            part: robot_study.simulate(robot, points, case, progress=advance)
            for part, points in parts.items()
        }
        curves[name] = next(iter(runs.values()))
        worst = max(run.tracking.tool for run in runs.values())
        used = max(float(np.abs(run.force).max()) for run in runs.values()) / robot.F_max
        settled = round(robot_study.LEAD_IN / 2 / robot.T_s)
        jumps = max(
            float(np.abs(np.diff(run.force[settled:], axis=0)).max()) for run in runs.values()
        )
        step = f"force step of a leg in {robot.T_s * 1e6:g} us"
        for what, unit, ours, limit in (
            (f"tool error, {where}", "um", worst * 1e6, {"below": limits[name]}),
            ("greatest force of a leg, by its limit", "", used, {"below": 1.0}),
            (step, "N", jumps, {}),
        ):
            label = f"{name}: {what}"
            results.append(_result("robot", label, unit, ours, ROBOT_FILE, source="goal", **limit))
    _draw_robot(robot, curves, next(iter(parts)), output)
    return results


def _draw_10(output: Path) -> None:
    plt = pictures.pyplot("drive")
    figure, rows = plt.subplots(2, 1, figsize=(8, 5), sharex=True)
    for profile, jerk_time in PROFILES.items():
        move = ThereAndBack(jerk_time=jerk_time)
        t = np.linspace(0.0, move.total_time, 4001)
        desired = move.sample(t)
        rows[0].plot(t, desired.velocity * 60, label=profile)
        rows[1].plot(t, desired.acceleration, label=profile)
    rows[0].set(ylabel="speed [m/min]", title="Test move of the drive (its shape is our choice)")
    rows[1].set(ylabel="acceleration [m/s²]", xlabel="time [s]")
    for axis in rows:
        axis.grid(alpha=0.3)
        axis.legend()
    pictures.save(figure, output / FIG_10)


def _draw_11(runs: dict[tuple[str, str, str], Response], output: Path) -> None:
    plt = pictures.pyplot("drive")
    figure, rows = plt.subplots(4, 1, figsize=(9, 11), sharex=True)
    for (loop, profile, case), run in runs.items():
        if loop != next(iter(LOOPS)):
            continue
        row = [c.name for c in CASES].index(case)
        rows[row].plot(run.t, run.error * 1e3, lw=0.9, label=profile)
        rows[row].set(ylabel="error [mm]", title=f"{'abc'[row]}) {case} feed-forward")
        if row == 2:
            rows[3].plot(run.t, run.jerk, lw=0.8, label=profile)
    rows[0].set_title("Figure 11 of the CNC paper, first-order loop: a) no feed-forward")
    rows[3].set(
        ylabel="jerk [m/s³]",
        title="slope of the current in case c), as the jerk of the drive",
        xlabel="time [s]",
    )
    for axis in rows:
        axis.grid(alpha=0.3)
    rows[0].legend(loc="upper right")
    pictures.save(figure, output / FIG_11)


def _draw_servo(output: Path) -> None:
    plt = pictures.pyplot("drive")
    figure, rows = plt.subplots(2, 1, figsize=(8, 6))
    for reading in servo.READINGS:
        run = servo.load_step(servo.Servo(reading=reading))
        way = run.angle / servo.TURN * servo.PITCH * 1e6
        rows[0].plot(run.t * 1e3, way, lw=0.9, label=reading)
    rows[0].axhline(
        -PUBLISHED_TRANSIENT * 1e6, color="0.5", ls="--", lw=0.8, label="published, peak"
    )
    rows[0].set(xlabel="time [ms]", ylabel="deviation [µm]", title="Load step of 1.8 N·m")
    run = servo.increments(servo.Servo(), servo.LOAD_TORQUE)
    per_load = servo.MOTOR_COUNTS / servo.LOAD_COUNTS
    rows[1].plot(run.t, run.motor / per_load, lw=0.8, label="motor encoder, 1 280 000")
    rows[1].plot(run.t, run.load, lw=0.8, label="load encoder, 144 000")
    rows[1].set(
        xlabel="time [s]",
        ylabel="increments of 144 000",
        title="Targets of +1, 0, -1, 0 increment under 1.8 N·m",
    )
    for axis in rows:
        axis.grid(alpha=0.3)
        axis.legend(loc="lower right")
    pictures.save(figure, output / SERVO_FILE)


def _draw_robot(
    robot: Robot, curves: dict[str, robot_study.RobotRun], part: str, output: Path
) -> None:
    plt = pictures.pyplot("drive")
    figure, rows = plt.subplots(len(curves), 1, figsize=(9, 9), sharex=True)
    for (name, run), axis in zip(curves.items(), rows, strict=True):
        step = max(1, len(run.leg_error) // 8000)
        error = run.leg_error[::step] * 1e6
        axis.plot(np.arange(len(error)) * step * robot.T_s, error, lw=0.6)
        axis.set(ylabel="error [µm]", title=name)
        axis.grid(alpha=0.3)
    rows[0].legend(("leg 1", "leg 2", "leg 3"), loc="upper right")
    figure.suptitle(f"Leg errors on {part} at 2 m/min, friction and payload error")
    rows[-1].set_xlabel("time [s]")
    pictures.save(figure, output / ROBOT_FILE)
