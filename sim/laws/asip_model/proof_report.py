# SPDX-License-Identifier: Apache-2.0
"""What `asip-model --prove` prints of a proof and its certificate, and the certificate's file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from asip_asm.files import open_output
from asip_asm.model.certificate import Certificate, json_number
from sim.laws.prove_program import Check, Proof

CERTIFICATE = ".certificate.json"
SELDOM = 0.1
"""Share of a proof's inputs below which an output is called seldom inside its limits."""


def write_certificate(file: Path, certificate: Certificate, proof: Proof | None) -> None:
    """The certificate, and of each result what the proof saw (docs/numerics.md has the fields)."""
    content = certificate.as_json()
    content["proved"] = proof is not None and proof.passed
    for name, check in proof.checks.items() if proof else ():
        content["results"][name] |= {
            "largest_error_seen": json_number(check.error),
            "share": json_number(check.share),
            "means_something": check.meaningful,
        }
    with open_output(file) as stream:
        stream.write(json.dumps(content, indent=1) + "\n")


def report(certificate: Certificate, proof: Proof | None) -> Iterator[str]:
    """Lines for the terminal."""
    if proof is not None:
        equal = "bits equal the interpreter's" if proof.bits_equal else proof.first_difference
        yield f"{proof.inputs_tried} inputs, seed {proof.seed}: {equal}"
        yield (
            f"largest error / bound at its own input {proof.worst_fraction_of_bound:.6f} "
            f"({proof.worst_result})"
        )
    if certificate.fault is not None:
        yield f"not proved: {certificate.fault.text()}"
        box = ", ".join(f"{n} {a:.6g} .. {b:.6g}" for n, (a, b) in certificate.fault.box.items())
        yield f"all such inputs are in the box {box}"
    if proof is None:
        return
    yield f"certificate for every input within the limits, {certificate.boxes} boxes:"
    yield f"  {'result':<16} {'largest error':>14} {'bound':>12}  {'unit':<8} error/bound"
    for name, check in proof.checks.items():
        yield _line(name, check)
    yield from _conditions(certificate)
    seldom = [name for name, n in proof.within.items() if n < SELDOM * proof.inputs_tried]
    if seldom:
        yield (
            f"inside their limits in less than {SELDOM:.0%} of the inputs, so little is shown of "
            f"them: {', '.join(seldom)}; narrow the limits of the inputs in the interface record"
        )
    if proof.unbounded:
        yield f"{proof.unbounded} results have no finite bound: keep divisors away from zero"


def _line(name: str, check: Check) -> str:
    text = f"  {name:<16} {check.error:>14.6g} {check.bound:>12.6g}  {check.unit:<8} "
    text += f"{check.share:.6f}"
    if not check.holds:
        return text + "  ERROR ABOVE THE BOUND"
    if not check.meaningful:
        text += (
            f"  not proved: the bound is at least half of the range of the result, "
            f"{check.low:.4g} .. {check.high:.4g}"
        )
    return text


def _conditions(certificate: Certificate) -> Iterator[str]:
    if certificate.assumed:
        names = ", ".join(certificate.assumed)
        yield f"no limits are stated of {names}: -1 .. 1 is taken; state them"
    if certificate.open_states:
        names = ", ".join(certificate.open_states)
        yield (
            f"for a tick that begins with {names} inside the stated limits: the program may leave "
            "them in the next one"
        )
