# SPDX-License-Identifier: Apache-2.0
"""Goals of the certificates of the laws shown: which have a bound, and how far above the errors."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from asip_asm.files import write_text
from asip_asm.model.certificate import EFFORT, certify
from asip_asm.model.compiler import compile_law
from asip_asm.model.law import Law
from asip_asm.project import BUILD
from sim.bench import law_results
from sim.bench.shown_robots.job import OPTIONS, SHOWN
from sim.laws.certificate_errors import largest_errors
from sim.laws.drive.current_law import AXES, Setting, current_law
from sim.laws.prove_program import SEED, Sample
from sim.report.goals import Goal, at_most, exactly
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

LOOSEST = 100.0
INPUTS = 1_000_000
QUICK_INPUTS = 5_000
QUICK_EFFORT = 1_000_000
FILE = BUILD / "certificates.json"
CURE = "make goals T=robots RUN=full tries 10^6 inputs of every law"


@dataclass(frozen=True)
class Subject:
    """A law that the project shows, and inputs of it that belong together."""

    law: Callable[[], Law]
    sample: Callable[[Law], Sample] | None = None


def subjects() -> dict[str, Subject]:
    """The robots shown, the own robot's two laws among them, and the current loop of each axis."""
    found = {name: Subject(shown.law, shown.sample) for name, shown in SHOWN.items()}
    drives, setting = Drives.load(), Setting(Robot.load().resolution)
    for axis in AXES:
        found[f"current loop {axis}"] = Subject(partial(current_law, drives, setting, [axis]))
    return found


@dataclass(frozen=True)
class Row:
    """One law. looseness: bound by largest error seen, of each output; finite: of all results."""

    name: str
    finite: bool
    looseness: dict[str, float]

    @property
    def middle(self) -> float:
        return float(np.median(list(self.looseness.values()))) if self.finite else math.inf


def measure(law_name: str, effort: int, inputs: int) -> dict[str, Any]:
    """The certificate of a law and its largest errors: whether it is finite, the looseness of each
    output, and the content of its file.
    """
    subject = subjects()[law_name]
    law = subject.law()
    compiled = compile_law(law, OPTIONS)
    certificate = certify(compiled.graph, law, effort)
    sample = subject.sample(law) if subject.sample else None
    errors = largest_errors(compiled, certificate, inputs, SEED, sample)
    outputs = [port.name for port in law.ports if port.kind in ("output", "export")]
    loose = {
        output: certificate.bounds[output].bound / errors[output]
        for output in outputs
        if errors[output] > 0
    }
    content = certificate.as_json() | {"largest_errors": errors, "looseness": loose}
    return {"finite": certificate.finite, "looseness": loose, "content": content}


def rows(full: bool) -> Iterator[Goal]:
    """Goals of all laws; build/certificates.json has the certificates."""
    numbers = (EFFORT, INPUTS) if full else (QUICK_EFFORT, QUICK_INPUTS)
    results = law_results.results(f"{__name__}:measure", list(subjects()), *numbers)
    found = [Row(name, each["finite"], each["looseness"]) for name, each in results.items()]
    content = {name: each["content"] for name, each in results.items()}
    write_text(FILE, json.dumps(content, indent=1) + "\n")
    share = 100 * sum(row.finite for row in found) / len(found)
    without = ", ".join(row.name for row in found if not row.finite)
    yield exactly("certificate: laws with a bound over their whole box", share, 100, "%", without)
    each = ", ".join(f"{row.name} {row.middle:.3g}" for row in found)
    middle = float(np.median([row.middle for row in found]))
    goal = at_most("certificate: median of bound / largest error", middle, LOOSEST, "", each)
    yield goal if full else replace(goal, met=None, note=f"{CURE}; {each}")
