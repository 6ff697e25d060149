# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC's folder for a run: configuration by the robot's parameters, component and program."""

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
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

from asip_asm.files import write_text
from sim.bus.linuxcnc.link import FROM_MASTER, TO_MASTER
from sim.robot.parameters import Robot
from sim.rtl.gen.motion_regmap import REGMAP

HERE = Path(__file__).parent
MODULES = Path("/usr/lib/linuxcnc/modules")
BUS, STEPS = "microtick_bus", "microtick_steps"  # components
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
    for tool in ("linuxcnc", "halcompile"):
        if shutil.which(tool) is None:
            return f"{tool} is not installed; {FETCH} gets it, as root"
    if subprocess.run(["sh", HERE / "start.sh", "--try"], capture_output=True).returncode:
        return "LinuxCNC runs in namespaces of its own, which this machine does not allow: unshare"
    return ""


def acceleration(most: float, jerk: float) -> float:
    """LinuxCNC 2.9 has no limit of the jerk: its acceleration changes within a servo period. So it
    gets the robot's acceleration only as far as such a change keeps to the robot's jerk."""
    return min(most, jerk * SERVO_S)


@dataclass(frozen=True)
class Axis:
    """What LinuxCNC has to know of an axis, in mm or degrees."""

    name: str
    kind: str
    least: float
    most: float
    velocity: float
    acceleration: float
    home: float

    @property
    def limits(self) -> str:
        """Lines of the section of an axis, and of its joint."""
        return (
            f"MIN_LIMIT = {self.least:.6f}\nMAX_LIMIT = {self.most:.6f}\n"
            f"MAX_VELOCITY = {self.velocity:.6f}\nMAX_ACCELERATION = {self.acceleration:.6f}\n"
        )


def axes(robot: Robot) -> list[Axis]:
    """X, Y, Z, A, C. A straight line along all three axes of the tool has the robot's speed and
    `acceleration`."""
    share = MM / math.sqrt(3)
    a_tool = acceleration(robot.a_max_tool, robot.j_max_tool)
    a_table = acceleration(robot.a_max_table, robot.j_max_table)
    tool = (MM, robot.v_max_tool * share, a_tool * share)
    table = (DEGREE, robot.v_max_table * DEGREE, a_table * DEGREE)
    rows = (
        ("X", "LINEAR", -robot.x_max, robot.x_max, tool),
        ("Y", "LINEAR", -robot.y_max, robot.y_max, tool),
        ("Z", "LINEAR", robot.z_min, robot.z_max, tool),
        ("A", "ANGULAR", robot.tilt_min, robot.tilt_max, table),
        ("C", "ANGULAR", robot.rotation_min, robot.rotation_max, table),
    )
    return [
        Axis(name, kind, least * unit, most * unit, velocity, rate, home * unit)
        for (name, kind, least, most, (unit, velocity, rate)), home in zip(
            rows, robot.start, strict=True
        )
    ]


def ini(robot: Robot) -> str:
    """The whole microtick.ini."""
    found = axes(robot)
    tool, table = found[0], found[TABLE_AXES]
    text = (HERE / "microtick.ini").read_text(encoding="utf-8")
    text += (
        "[TRAJ]\nCOORDINATES = XYZAC\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree\n"
        f"MAX_LINEAR_VELOCITY = {math.sqrt(3) * tool.velocity:.6f}\n"
        f"DEFAULT_LINEAR_VELOCITY = {tool.velocity / 10:.6f}\n"
        f"MAX_LINEAR_ACCELERATION = {math.sqrt(3) * tool.acceleration:.6f}\n"
        f"MAX_ANGULAR_VELOCITY = {table.velocity:.6f}\n"
        f"MAX_ANGULAR_ACCELERATION = {table.acceleration:.6f}\n"
    )
    for n, axis in enumerate(found):
        text += (
            f"[AXIS_{axis.name}]\n{axis.limits}[JOINT_{n}]\nTYPE = {axis.kind}\n{axis.limits}"
            f"FERROR = {axis.velocity * ALLOWED_LAG_S:.6f}\n"
            f"MIN_FERROR = {LEAST_ERROR[n >= TABLE_AXES]}\n"
            f"HOME = {axis.home:.6f}\nHOME_OFFSET = {axis.home:.6f}\n"
            # Homing without a motion: the drives have homed before, by method 37.
            "HOME_SEARCH_VEL = 0\nHOME_LATCH_VEL = 0\nHOME_SEQUENCE = 0\n"
        )
    return text


def compile_component(folder: Path, name: str) -> Path:
    """A component for LinuxCNC's servo thread. Raises LinuxcncError with the compiler's words."""
    shutil.copy(HERE / f"{name}.comp", folder)
    lines = [f"#define MOTION_REG_{name} {REGMAP.address(name)}u" for name in REGMAP.registers]
    write_text(folder / "motion_regmap.h", "\n".join(lines) + "\n")
    command = ["halcompile", "--compile", f"{name}.comp"]
    job = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, "EXTRA_CFLAGS": f"-I{folder}"},
        capture_output=True,
        text=True,
    )
    if job.returncode:
        raise LinuxcncError(f"halcompile: {(job.stderr or job.stdout).strip()}")
    return folder / f"{name}.so"


def prepare(
    folder: Path,
    robot: Robot,
    program: Path,
    periods: int = 0,
    fault: str = "",
    fault_after: int = 0,
    component: str = BUS,
) -> None:
    """Fill an empty folder. periods: after which the program is cut, 0: never; fault: one of
    `FAULTS` of the command or empty, so many servo periods after the program's begin; component:
    BUS or STEPS, with the HAL file of its name."""
    shutil.copytree(MODULES, folder / "modules")
    shutil.move(compile_component(folder, component), folder / "modules")
    shutil.copy(HERE / "screen.py", folder)
    shutil.copy(HERE / f"{component}.hal", folder / "microtick.hal")
    (folder / "screen.py").chmod(0o755)
    write_text(folder / "microtick.ini", ini(robot))
    for name in ("microtick.var", "tool.tbl"):
        (folder / name).touch()
    shutil.copyfile(program, folder / PROGRAM)
    task = {
        "program": PROGRAM,
        "periods": periods,
        "fault": fault,
        "fault_after": fault_after,
        "pins": f"{component.replace('_', '-')}.0.",
        "drives_home": component == BUS,
    }
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
    return group(
        ["sh", HERE / "start.sh", folder], stdin=subprocess.DEVNULL, stdout=log, stderr=log
    )
