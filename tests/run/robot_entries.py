# SPDX-License-Identifier: Apache-2.0
"""What each command computes from the robot's file below the RTL, as one digest for each part.

A small and slow robot runs a short program that reaches every limit, so that a part takes less
than a second. What a command refuses is a result too: the text of the error.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cache

import numpy as np

from asip_asm.assemble import parse_program
from sim.bench.drive import hardware
from sim.bench.drive.friction_law import KINDS, friction_law
from sim.bench.drive.plant import Plant as DrivesPlant
from sim.bench.drive.start_up import dead_clocks, least_clocks, trip_size
from sim.bench.dual.report import nominal_clocks
from sim.bench.dual.system import PROGRAMS, TRAJECTORY_PROGRAM
from sim.bench.motion.step_stream import Steps, joints
from sim.laws.drive.current_law import Setting, current_law
from sim.motion.gcode.interpreter import parse
from sim.motion.geometry.moves import GcodeProgram
from sim.motion.geometry.override import overridden_program
from sim.motion.lookahead.planner import Lookahead
from sim.motion.lookahead.settings import LookaheadSettings
from sim.motion.trajectory.exact_stop import MotionSettings, generate
from sim.motion.trajectory.program import plan
from sim.robot.drives import Drives
from sim.robot.float32 import Constants
from sim.robot.parameters import ParameterError, Robot
from sim.robot.plant import Plant

ENTRIES = tuple(dict.fromkeys(f.name for f in (*fields(Robot), *fields(Drives))))
SMALL = {
    **{"x_max": 0.004, "y_max": 0.004, "z_min": 0.597, "z_max": 0.603},
    **{"tilt_min": -0.02, "tilt_max": 0.02, "rotation_min": -0.02, "rotation_max": 0.02},
    **{"v_max_tool": 0.05, "v_max_leg": 0.042, "a_max_leg": 3.5, "j_max_leg": 700.0},
    **{"v_max_table": 0.3, "a_max_table": 1.0, "j_max_table": 200.0, "friction_speed_table": 0.01},
}
BOUNDS = {  # the share of a bound of the workspace that makes it narrower, by less than it is wide
    **{"x_max": 0.98, "y_max": 0.98, "z_min": 1.0002, "z_max": 0.9998, "z_start": 1.0002},
    **dict.fromkeys(("tilt_min", "tilt_max", "rotation_min", "rotation_max"), 0.98),
}
_TURN = 0.019999 * 180 / np.pi
MOVES = (
    "G1 F2900 X3.9999", "Y3.9999", "X-3.9999 Y-3.9999", "X0 Y0 Z602.9999", "Z597.0001",
    f"G0 A{_TURN:.6f}", f"A{-_TURN:.6f}", f"C{_TURN:.6f}", f"C{-_TURN:.6f}", "C0", "C0.05",
    "A0 C0 Z600",
    "G43.4", "G1 F2000 X1 A0.5", "X0 A0", "G49", "G0 X0 Y0 Z600",
)  # fmt: skip


@dataclass(frozen=True)
class Machine:
    robot: Robot
    drives: Drives

    @classmethod
    def small(cls) -> Machine:
        return cls(replace(Robot.load(), **SMALL), Drives.load())

    def value(self, name: str) -> float:
        return getattr(self.robot if hasattr(self.robot, name) else self.drives, name)

    def moved(self, name: str) -> Machine:
        """The machine with another value of an entry that the file's reader accepts."""
        for value in self._others(name):
            try:
                return Machine(
                    *(
                        replace(record, **{name: value}) if hasattr(record, name) else record
                        for record in (self.robot, self.drives)
                    )
                )
            except ParameterError:
                continue
        raise AssertionError(f"{name}: no other value is accepted")

    def _others(self, name: str) -> tuple[float, ...]:
        value = self.value(name)
        if name == "T_s":
            return (value / 2,)
        if name == "v_max_leg":  # beyond what the motors' current loops follow
            return (1e4 * value,)
        if name == "T_c":
            return (value + self.robot.T_s,)
        if name in BOUNDS:
            return (value * BOUNDS[name],)
        return (value * 1.02, value * 0.98)


def _digest(*parts: object) -> str:
    found = hashlib.sha256()
    for part in parts:
        found.update(part.tobytes() if isinstance(part, np.ndarray) else repr(part).encode())
    return found.hexdigest()


def _program(head: str, robot: Robot, override: float = 200.0) -> GcodeProgram:
    text = "\n".join((head, *MOVES, "M2"))
    return overridden_program(parse(text, "part.ngc", robot=robot), override, robot.v_max_tool)


def _exact_stops(robot: Robot, override: float = 200.0) -> str:
    settings = MotionSettings(robot, acceleration_time=0.02, jerk_time=0.01)
    found = generate(_program("G61.1", robot, override), settings)
    return _digest(found.position, found.velocity)


def _as_programmed(robot: Robot) -> str:
    return _exact_stops(robot, 100.0)


def _look_ahead(robot: Robot) -> str:
    found = plan(_program("G64 P0.01", robot), robot)
    return _digest(found.position, found.velocity)


def _pulses(robot: Robot) -> str:
    settings = LookaheadSettings(robot=robot)
    moves = iter(_program("G64 P0.01", robot).moves)
    parts = [joints(robot, p, Steps()) for p in Lookahead(moves, settings).setpoints()]
    return _digest(*(values for part in parts for values in part))


def _tracking(robot: Robot) -> str:
    """The program before it is scheduled: its constants have the values of the file."""
    source = PROGRAMS / "tracking_optimised.s"
    return _digest(parse_program(source, defines=robot.values()).constants)


def _nios(robot: Robot) -> str:
    block = Constants(robot).block()
    return _digest([(name, np.asarray(values).tolist()) for name, values in block.items()])


def _trajectory_program(robot: Robot) -> str:
    source = PROGRAMS / f"{TRAJECTORY_PROGRAM}.s"
    program = parse_program(source, defines={"T_s": robot.T_s})
    return _digest(program.constants, nominal_clocks(robot))


def _forces(robot: Robot) -> str:
    plant = Plant(robot, (0.01, 0.02, robot.z_start), (0.3, 0.1))
    counts = [plant.step((30.0, -20.0, 10.0, 5.0, -3.0)) for _ in range(40)]
    return _digest(counts, plant.tool, plant.table)


def _law(law) -> list:
    """Everything of a law that decides about its program: graph, constants, limits."""
    return [law.function.serialize(), law.ports, law.rate]


def _drives(robot: Robot, drives: Drives) -> str:
    hardware.check(robot, drives)
    setting = Setting(robot.resolution)
    laws = [friction_law(robot, drives, kind) for kind in KINDS]
    registers = (dead_clocks(drives), least_clocks(drives), trip_size(drives), drives.U_dc)
    record = DrivesPlant(robot, drives).record()
    return _digest(*map(_law, laws), _law(current_law(drives, setting)), registers, record)


COMMANDS: dict[str, tuple[Callable[..., str], ...]] = {
    "run": (_look_ahead, _tracking, _nios, _forces),
    "dual": (_exact_stops, _trajectory_program, _tracking, _forces),
    "drive": (_as_programmed, _tracking, _drives),
    "bus": (_as_programmed, _tracking, _forces),
    "motion": (_pulses, _as_programmed, _nios, _forces),
    "lookahead": (_look_ahead,),
    "trajectory": (_exact_stops,),
}
PARTS = tuple(dict.fromkeys(part for parts in COMMANDS.values() for part in parts))


def _result(part: Callable[..., str], machine: Machine) -> str:
    try:
        return part(machine.robot, machine.drives) if part is _drives else part(machine.robot)
    except ValueError as error:
        return re.sub(r"\s+", " ", str(error))


@cache
def acting() -> dict[str, dict[str, bool]]:
    """Of each entry, whether each part's result changes with it."""
    machine = Machine.small()
    before = {part: _result(part, machine) for part in PARTS}
    assert all(re.fullmatch(r"[0-9a-f]{64}", text) for text in before.values()), before
    found: dict[str, dict[str, bool]] = {}
    for name in ENTRIES:
        other = machine.moved(name)
        parts = PARTS if other.robot != machine.robot else (_drives,)
        found[name] = {part.__name__: _result(part, other) != before[part] for part in parts}
    return found


def unused(command: str) -> set[str]:
    """Entries that change nothing that the command computes."""
    parts = [part.__name__ for part in COMMANDS[command]]
    return {
        name for name, acts in acting().items() if not any(acts.get(part, False) for part in parts)
    }
