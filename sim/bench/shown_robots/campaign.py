# SPDX-License-Identifier: Apache-2.0
"""Every URDF of the package example-robot-data: inverse dynamics on the exact model of the core
against pinocchio's own reading of the file, over twice the stated range of revolute joints.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.machine import load_machine
from asip_asm.model.compiler import Compiled, Options
from asip_asm.model.expand import expand_functions
from asip_asm.model.law import Law, build_graph
from asip_asm.model.simplify import simplify
from asip_asm.model.sine import angles, replace_sines
from asip_asm.model.sums import SumBuilder
from sim.laws.catalogue import data_folder
from sim.laws.description import Description, read_description
from sim.laws.elements import RobotError
from sim.laws.laws import LAWS, Settings
from sim.laws.prove_program import Proof, compare, draw, exact_results, rounded_sine
from sim.laws.reference import LawReference, PinocchioRobot
from sim.laws.stated import Stated
from sim.laws.tree import tree_of
from sim.report.goals import Goal, at_most, depth, exactly, paced

LAW = "inverse_dynamics"
INPUTS = 500
SEED = 1
UNLIMITED = 1e9
"""Effort that no torque reaches [N m, N]: at a limit an output is a constant."""
STATED_RANGE, STATED_SPEED = (-3.0, 3.0), 3.0
"""Stated where a file states none, or a range beyond the core's angles [rad, m, rad/s, m/s]."""
QUICK = 9
"""A quick run takes every so many-th file."""
REASONS = {
    "no joint moves": "no joint moves", "no link": "no link", "mimics": "follows a missing joint"
}  # fmt: skip
ROBOTS_LOADED = 65
"""Files of the package that a law can be made for."""


@dataclass(frozen=True)
class Tried:
    """One file: `refused` says why there is no law, else the proof."""

    file: Path
    axes: int = 0
    refused: str = ""
    proof: Proof | None = None
    difference: str = ""

    @property
    def passed(self) -> bool:
        return self.proof is not None and self.proof.passed and not self.difference


def robot_files() -> list[Path]:
    """All URDFs of the package."""
    return sorted(data_folder().rglob("*.urdf"))


def statements(description: Description) -> Stated:
    """What the files leave open, and efforts that no torque reaches."""
    leaders = [j for j in description.joints if j.kind != "fixed" and j.mimic is None]
    unknown = [
        j.name
        for j in leaders
        if j.kind != "continuous" and (j.lower is None or max(-j.lower, j.upper or 0.0) > 256)
    ]
    return Stated(
        effort={j.name: UNLIMITED for j in leaders},
        range=dict.fromkeys(unknown, STATED_RANGE),
        velocity={j.name: STATED_SPEED for j in leaders if j.velocity is None},
    )


def try_file(file: Path, inputs: int = INPUTS, seed: int = SEED) -> Tried:
    """Law of a file on the exact model of the core, with sines as polynomials."""
    try:
        description = read_description(file)
        stated = statements(description)
        tree = tree_of(description, stated)
    except RobotError as error:
        return Tried(file, refused=str(error))
    settings = Settings()
    law = LAWS[LAW](tree, settings)
    reference = LawReference(PinocchioRobot(description.text, stated), LAW, settings)
    compiled = core_operations_of(law)
    rng = np.random.default_rng(seed)
    words = {port.name: draw(port, inputs, rng) for port in law.of_kind("input")}
    got = exact_results(compiled, words, rounded_sine)
    proof = compare(compiled, words, got, seed, rounded_sine, reference)
    return Tried(file, len(tree.axes), "", proof, reference.difference(law))


def core_operations_of(law: Law) -> Compiled:
    """Operations of the core for a law of any size: what `compile_law` makes before it is placed in
    registers and memory, which the largest robots exceed.
    """
    options = Options(sine="pipes")
    real = expand_functions(simplify(build_graph(law)))
    real = replace_sines(real, angles(real, law))
    graph = SumBuilder(real, load_machine(options.configuration), False).run()
    return Compiled(law, options, graph, "")


def run_campaign(files: Sequence[Path], inputs: int = INPUTS) -> Iterator[Tried]:
    """The files one after another."""
    for file in paced(files, "URDF files"):
        yield try_file(file, inputs)


def rows(full: bool) -> Iterator[Goal]:
    """Goals of the campaign."""
    files = robot_files()
    chosen = files if full else files[::QUICK]
    found = list(run_campaign(chosen))
    tried = [one for one in found if not one.refused]
    failed = [one for one in tried if not one.passed]
    note = "; ".join(f"{one.file.name}: {_why(one)}" for one in failed)
    deeper = "" if full else "make goals T=robots RUN=full tries all files"
    yield depth("URDF files tried", len(chosen), len(files), "files", deeper)
    yield exactly("URDF files that load, beyond the bound of their error", len(failed), 0, "files",
                  note)  # fmt: skip
    shares = [one.proof.worst_fraction_of_bound for one in tried if one.proof]
    yield at_most(
        "largest error of a URDF file's inverse dynamics by its bound", max(shares), 1, ""
    )
    axes = max(one.axes for one in tried)
    yield depth("axes of the largest robot tried", axes, 101, "axes", deeper)
    if full:
        yield exactly("URDF files that load", len(tried), ROBOTS_LOADED, "files")
        reasons = "; ".join(
            f"{one.file.name}: {_reason(one.refused)}" for one in found if one.refused
        )
        refused = [one for one in found if one.refused and not _reason(one.refused)]
        yield exactly("URDF files refused without a reason", len(refused), 0, "files", reasons)


def _reason(text: str) -> str:
    return next((reason for words, reason in REASONS.items() if words in text), "")


def _why(one: Tried) -> str:
    assert one.proof is not None
    return one.difference or one.proof.first_difference or (
        f"error {one.proof.worst_fraction_of_bound:.3g} of its bound ({one.proof.worst_result}), "
        f"{one.proof.unbounded} without a bound"
    )  # fmt: skip
