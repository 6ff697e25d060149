# SPDX-License-Identifier: Apache-2.0
"""Cycles and proofs of laws made of matrix products on `fast`: rows of `make goals T=matrix`."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from asip_asm.model.certificate import certify
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.law import Law
from asip_asm.model.program import build
from sim.laws.matrix_laws import lqg, policy
from sim.laws.prove_program import COUNT, prove
from sim.report.goals import Goal, at_most, depth, exactly

LAWS: dict[str, tuple[Callable[[], Law], int]] = {
    "LQG 12/4/6": (lqg, 230),
    "policy 12-16-16-4 tanh": (policy, 560),
}
"""Laws on `fast` as it is, and the most cycles of a tick."""
QUICK = 200
MILLION = 1_000_000


def rows(full: bool) -> Iterator[Goal]:
    """Cycles of each law, its bits, and its errors as parts of their bounds."""
    count = COUNT if full else QUICK
    for name, (law, most) in LAWS.items():
        with tempfile.TemporaryDirectory() as folder:
            built = build(compile_law(law(), Options(reassociate=True)), Path(folder) / "law.s")
        yield at_most(f"{name}, tick on fast", built.cycles, most, "cycles")
        compiled = built.compiled
        certificate = certify(compiled.graph, compiled.law, MILLION)
        proof = prove(compiled, built.image, count=count, certificate=certificate)
        yield exactly(f"{name}, bits differ from the interpreter", not proof.bits_equal, 0, "1")
        worst = max((c.share for c in proof.checks.values()), default=0.0)
        yield at_most(
            f"{name}, error as a fraction of its certified bound", worst, 1, "1",
            "" if certificate.finite else "a result has no finite bound",
        )  # fmt: skip
        cure = "make goals T=matrix RUN=full"
        yield depth(f"{name}, inputs tried", proof.inputs_tried, COUNT, "1", cure)
