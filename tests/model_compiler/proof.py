# SPDX-License-Identifier: Apache-2.0
"""A law as a program that is proved: bits of the interpreter, errors within the bound."""

from __future__ import annotations

from pathlib import Path

from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.law import Law
from asip_asm.model.program import Built, build
from sim.laws.prove_program import Proof, prove

FAST = Options(reassociate=True, reciprocal=True)


def proved(
    law: Law, folder: Path, options: Options | None = None, count: int = 100, **more
) -> tuple[Built, Proof]:
    """Program and proof for `count` inputs; more: of `prove`, by default on the model of the core.

    Raises AssertionError where it is not passed.
    """
    built = build(compile_law(law, options or Options()), folder / "law.s")
    proof = prove(built.compiled, built.image, count=count, **({"backend": "iss"} | more))
    assert proof.passed, (proof.first_difference, proof.worst_fraction_of_bound, proof.worst_result)
    return built, proof
