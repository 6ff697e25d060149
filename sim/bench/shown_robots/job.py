# SPDX-License-Identifier: Apache-2.0
"""The robots that `microtick robots` shows, and what it does with each."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from asip_asm.assemble import build_program
from asip_asm.isa import default_isa
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.law import Law
from asip_asm.model.program import Built, build
from asip_asm.project import ROOT
from asip_asm.report import report_program
from sim.bench.shown_robots.own_errors import ASSEMBLY, compare_with_assembly
from sim.laws import own, pendulum, quadrotor
from sim.laws.catalogue import robot
from sim.laws.closed_loop import Arm, ClosedLoop, Machine, close_loop
from sim.laws.laws import Settings, computed_torque, operations
from sim.laws.prove_program import COUNT, Proof, Sample, prove
from sim.laws.samples import near
from sim.report.goals import Goal, at_least, at_most, exactly
from sim.robot.parameters import Robot

OPTIONS = Options(reassociate=True, reciprocal=True)
ABOVE_BOUND = 5.0  # percent
COMPILE_SECONDS = 60.0
WITHIN = COUNT // 2  # inputs of the proof at which an output is inside its limits
SECONDS = 2.0  # of motion in closed loop, at least
RATIO = 1.05
PROGRAMS = ROOT / "asip_asm/programs"
HAND_WRITTEN = PROGRAMS / "tracking_optimised.s"
HAND_WRITTEN_CYCLES = 112
CYCLES = {"own_printed": 214, "own_optimised": 124, "iiwa14": 245, "panda": 310, "ur5": 225}
"""Cycles that are aimed at."""


@dataclass(frozen=True)
class Shown:
    """A robot's law, the machine that it controls for some seconds (None: its default), and inputs
    for the proof of the law.
    """

    law: Callable[[], Law]
    machine: Callable[[float | None], Machine]
    sample: Callable[[Law], Sample]


def _arm(name: str, counts: int = 1 << 20) -> Shown:
    settings = Settings(counts=counts, overshoot=1.0)  # cycles are those of the stated range
    return Shown(
        lambda: computed_torque(robot(name), settings),
        lambda seconds: Arm(robot(name), settings, seconds or SECONDS),
        near,
    )


def _own(law: Callable[[], Law]) -> Shown:
    robot = Robot.load()
    return Shown(
        law,
        lambda seconds: own.FiveAxes(robot, seconds or SECONDS),
        lambda _: functools.partial(own.sample, robot),
    )


SHOWN: dict[str, Shown] = {
    "own_printed": _own(own.printed),
    "own_optimised": _own(own.optimised),
    "iiwa14": _arm("iiwa14"),
    # One of 2^20 counts, as a step of speed, asks panda's second joint for more than its torque.
    "panda": _arm("panda", 1 << 21),
    **{name: _arm(name) for name in ("ur5", "xarm7", "scara", "so101")},
    "quadrotor": Shown(
        quadrotor.law,
        lambda seconds: quadrotor.Quadrotor(seconds or 4.0),
        quadrotor.near,
    ),
    "pendulum": Shown(
        lambda: pendulum.law(pendulum.tree()),
        lambda seconds: pendulum.Pendulum(pendulum.tree(), seconds=seconds or 4.0),
        pendulum.near,
    ),
}


@dataclass(frozen=True)
class Row:
    """What was found of one robot. plain_cycles: as written, None for a law without options.
    seconds: of compiling and assembling. beside_assembly: largest error of an output of the own
    robot's law, and of its assembly program. about: a sentence, empty for that of the law; outputs:
    names of those of the closed loop, empty for all of the law.
    """

    name: str
    built: Built
    plain_cycles: int | None
    seconds: float
    proof: Proof
    loop: ClosedLoop
    rate: float
    beside_assembly: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    about: str = ""
    outputs: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """Fields of build/shown_robots.json."""
        law = self.built.compiled.law
        return {
            "configuration": self.built.image.configuration,
            "cycles": self.built.cycles,
            "bound_cycles": self.built.bound_cycles,
            "cycles_as_written": self.plain_cycles,
            "microseconds": self.built.cycles / default_isa().clock_mhz,
            "law_operations": operations(law) if law.function else None,
            "core_operations": sum(each.operations for each in self.built.report.sections),
            "compile_seconds": round(self.seconds, 2),
            "worst_fraction_of_bound": self.proof.worst_fraction_of_bound,
            "worst_result": self.proof.worst_result,
            "unbounded": self.proof.unbounded,
            "largest_error": self.proof.largest_error,
            "bits_equal": self.proof.bits_equal,
            "inputs_tried": self.proof.inputs_tried,
            "inputs_within_limits": self.proof.within,
            "seed": self.proof.seed,
            "closed_loop": {
                "ticks": self.loop.ticks,
                "rate_hz": self.rate,
                "ratio_to_double": self.loop.ratio,
                "saturated_ticks": self.loop.saturated,
                "worst_axis": self.loop.worst,
                "axes": self._axes(),
            },
        }

    def _axes(self) -> dict[str, dict[str, Any]]:
        """Per axis: unit, ratio, on the core root mean square of the error after the start and
        largest error of all ticks.
        """
        loop = self.loop
        largest, rms = abs(loop.core.errors).max(axis=0), loop.rms(loop.core)
        return {
            name: {
                "unit": unit,
                "ratio_to_double": loop.ratios[name],
                "rms_error": float(rms[k]),
                "largest_error": float(largest[k]),
            }
            for k, (name, unit) in enumerate(loop.axes.items())
        }


def run_robot(name: str, folder: Path, inputs: int, seconds: float | None, seed: int) -> Row:
    """Compile, prove and simulate one robot. Raises ModelError, RobotError, CoreFault."""
    shown = SHOWN[name]
    law = shown.law()
    begin = time.monotonic()
    built = build(compile_law(law, OPTIONS), folder / f"{name}.s")
    passed = time.monotonic() - begin
    plain = build(compile_law(law, Options()), folder / f"{name}_as_written.s")
    proof = prove(built.compiled, built.image, count=inputs, seed=seed, sample=shown.sample(law))
    loop = close_loop(law, built.image, shown.machine(seconds))
    beside = compare_with_assembly(name, built.compiled) if name in ASSEMBLY else {}
    return Row(name, built, plain.cycles, passed, proof, loop, law.rate, beside)


def written_cycles(source: Path, configuration: str | None = None) -> int:
    """Cycles of a tick of a program in assembly; configuration: None for that of the file."""
    program, machine = build_program(source, configuration=configuration)
    return report_program(program, machine).sections[0].cycles


@functools.cache
def hand_written_cycles() -> int:
    """Cycles of a tick of the own robot's hand-written program, as assembled."""
    return written_cycles(HAND_WRITTEN)


def goals(rows: Sequence[Row]) -> list[Goal]:
    """Goals of the robots and of the hand-written program."""
    found: list[Goal] = []
    for row in rows:
        name, proof, loop = row.name, row.proof, row.loop
        if name in CYCLES:
            found.append(at_most(f"{name}, tick", row.built.cycles, CYCLES[name], "cycles"))
        above = 100 * (row.built.cycles / row.built.bound_cycles - 1)
        worst, least = proof.worst_fraction_of_bound, min(proof.within.values())
        what = "inputs with an output inside its limits, least"
        axis = f"{name}, tracking to double, worst axis {loop.worst}"
        found += [
            at_most(f"{name}, above bound", above, ABOVE_BOUND, "%"),
            at_most(f"{name}, compiled in", row.seconds, COMPILE_SECONDS, "s"),
            Goal(f"{name}, error/bound", worst, "", "< 1", worst < 1),
            exactly(f"{name}, without a bound", proof.unbounded, 0, "results"),
            at_least(f"{name}, inputs tried", proof.inputs_tried, COUNT, ""),
            at_least(f"{name}, {what}", least, WITHIN, ""),
            exactly(f"{name}, bits unequal", float(not proof.bits_equal), 0, ""),
            at_least(f"{name}, closed loop", loop.ticks / row.rate, SECONDS, "s"),
            at_most(axis, loop.ratio, RATIO, ""),
        ]
        for output, (error, target) in row.beside_assembly.items():
            unit = "N" if output[0] == "F" else "N m"
            what = f"{name}, error of {output}, whole path, three digits"
            found.append(at_most(what, error, target, unit))
    cycles = hand_written_cycles()
    found.append(at_most("own robot, hand-written, tick", cycles, HAND_WRITTEN_CYCLES, "cycles"))
    return found
