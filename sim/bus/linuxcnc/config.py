# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC's folder for a run: configuration by the robot's parameters, component, program, pipes."""

from __future__ import annotations

import contextlib
import json
import math
import os
import shutil
import signal
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, TextIO

from asip_asm.files import write_text
from sim.bus.linuxcnc.link import FROM_MASTER, TO_MASTER
from sim.robot.parameters import Robot

HERE = Path(__file__).parent
MODULES = Path("/usr/lib/linuxcnc/modules")
COMPONENT = "microtick_bus"
FILES = ("microtick.hal", "screen.py")
PROGRAM = "program.ngc"
MM, DEGREE = 1e3, 180 / math.pi
TABLE_AXES = 3  # index of the first one
FETCH = "scripts/debian_tool.sh linuxcnc"
SERVO_S = 1e-3
# LinuxCNC sees a position 3.6 periods after its target at the most, and allows twice that distance.
ALLOWED_LAG_S = 7.2e-3
LEAST_ERROR = (0.2, 0.05)  # at rest: mm, degrees


class LinuxcncError(RuntimeError):
    """LinuxCNC is not there, or it does not do what it should; the text says what to do."""


def missing() -> str:
    """What LinuxCNC's run lacks here; empty if nothing."""
    for tool in ("linuxcnc", "halcompile", "unshare"):
        if shutil.which(tool) is None:
            return f"{tool} is not installed; {FETCH} gets it, as root"
    return ""


def acceleration(most: float, jerk: float) -> float:
    """LinuxCNC 2.9 has no limit of the jerk: its acceleration changes within a servo period. So it
    gets the robot's acceleration only as far as such a change keeps to the robot's jerk."""
    return min(most, jerk * SERVO_S)


def axes(robot: Robot) -> Iterator[dict[str, float | str]]:
    """Name, kind, limits, home [mm, degrees] and rates of x, y, z, a, c.

    A straight line along all three axes of the tool has the robot's speed and `acceleration`.
    """
    share = MM / math.sqrt(3)
    tool = {
        "TYPE": "LINEAR",
        "MAX_VELOCITY": robot.v_max_tool * share,
        "MAX_ACCELERATION": acceleration(robot.a_max_tool, robot.j_max_tool) * share,
    }
    table = {
        "TYPE": "ANGULAR",
        "MAX_VELOCITY": robot.v_max_table * DEGREE,
        "MAX_ACCELERATION": acceleration(robot.a_max_table, robot.j_max_table) * DEGREE,
    }
    x, y = robot.x_max * MM, robot.y_max * MM
    tilt = (robot.tilt_min * DEGREE, robot.tilt_max * DEGREE)
    rotation = (robot.rotation_min * DEGREE, robot.rotation_max * DEGREE)
    rows = (
        ("X", tool, -x, x, 0.0),
        ("Y", tool, -y, y, 0.0),
        ("Z", tool, robot.z_min * MM, robot.z_max * MM, robot.z_start * MM),
        ("A", table, *tilt, 0.0),
        ("C", table, *rotation, 0.0),
    )
    for name, kind, least, most, home in rows:
        yield {"name": name, **kind, "MIN_LIMIT": least, "MAX_LIMIT": most, "home": home}


def ini(robot: Robot) -> str:
    """The whole microtick.ini."""
    turning = acceleration(robot.a_max_table, robot.j_max_table)
    lines = [
        (HERE / "microtick.ini").read_text(encoding="utf-8"),
        "[TRAJ]\nCOORDINATES = XYZAC\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree",
        f"MAX_LINEAR_VELOCITY = {robot.v_max_tool * MM:g}",
        f"DEFAULT_LINEAR_VELOCITY = {robot.v_max_tool * MM / 10:g}",
        f"MAX_LINEAR_ACCELERATION = {acceleration(robot.a_max_tool, robot.j_max_tool) * MM:g}",
        f"MAX_ANGULAR_VELOCITY = {robot.v_max_table * DEGREE:.6f}",
        f"MAX_ANGULAR_ACCELERATION = {turning * DEGREE:.6f}",
    ]
    for n, axis in enumerate(axes(robot)):
        keys = ("MIN_LIMIT", "MAX_LIMIT", "MAX_VELOCITY", "MAX_ACCELERATION")
        both = [f"{key} = {axis[key]:.6f}" for key in keys]
        lines += [f"[AXIS_{axis['name']}]", *both, f"[JOINT_{n}]", f"TYPE = {axis['TYPE']}", *both]
        lines += [
            f"FERROR = {float(axis['MAX_VELOCITY']) * ALLOWED_LAG_S:.6f}",
            f"MIN_FERROR = {LEAST_ERROR[n >= TABLE_AXES]}",
            *(f"{key} = {axis['home']}" for key in ("HOME", "HOME_OFFSET")),
            # Homing without a motion: the drives have homed before, by method 37.
            *(f"{key} = 0" for key in ("HOME_SEARCH_VEL", "HOME_LATCH_VEL", "HOME_SEQUENCE")),
        ]
    return "\n".join(lines) + "\n"


def compile_component(folder: Path) -> Path:
    """The component for LinuxCNC's real-time part. Raises LinuxcncError with the compiler's words."""
    shutil.copy(HERE / f"{COMPONENT}.comp", folder)
    job = subprocess.run(
        ["halcompile", "--compile", f"{COMPONENT}.comp"], cwd=folder, capture_output=True, text=True
    )
    if job.returncode:
        raise LinuxcncError(f"halcompile: {(job.stderr or job.stdout).strip()}")
    return folder / f"{COMPONENT}.so"


def prepare(
    folder: Path, robot: Robot, program: Path, periods: int, fault: str, fault_after: int
) -> None:
    """Fill an empty folder. periods: after which the program is cut, 0: never; fault: one of
    `run.FAULTS` or empty, so many servo periods after the program's begin."""
    shutil.copytree(MODULES, folder / "modules")
    shutil.move(compile_component(folder), folder / "modules")
    for name in FILES:
        shutil.copy(HERE / name, folder)
    (folder / "screen.py").chmod(0o755)
    write_text(folder / "microtick.ini", ini(robot))
    for name in ("microtick.var", "tool.tbl"):
        (folder / name).touch()
    shutil.copyfile(program, folder / PROGRAM)
    task = {"program": PROGRAM, "periods": periods, "fault": fault, "fault_after": fault_after}
    write_text(folder / "task.json", json.dumps(task))
    for name in (TO_MASTER, FROM_MASTER):
        os.mkfifo(folder / name, 0o600)


@contextlib.contextmanager
def group(words: Sequence[str | Path], **options: Any) -> Iterator[subprocess.Popen]:
    """A program that ends here with all that it has started."""
    job = subprocess.Popen(words, start_new_session=True, **options)
    try:
        yield job
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(job.pid, signal.SIGKILL)
        job.wait()


def started(folder: Path, log: TextIO) -> AbstractContextManager[subprocess.Popen]:
    """LinuxCNC in a filled folder."""
    return group([HERE / "start.sh", folder], stdin=subprocess.DEVNULL, stdout=log, stderr=log)
