# SPDX-License-Identifier: Apache-2.0
"""Every operation of the instruction-set model against values worked out by hand."""

from __future__ import annotations

import tomllib
from pathlib import Path

import mpmath
import numpy as np
import pytest

from sim.core.iss import Fault, Iss
from tests.asip.iss_image import MULTIPLY_ADD, OPCODES, SECOND_IS_C, bundle, image, word
from tests.asip.operation_cases import CASES, NX


def execute(mnemonic: str, operands: tuple[int, ...]) -> tuple[int, int]:
    """Result bits and flags of one operation whose operands are in k0, k1, k2."""
    names = [f"k{i}" for i in range(len(operands))]
    if mnemonic in SECOND_IS_C:
        names.insert(1, "zero")
    operation = word(mnemonic, 5, *names)
    slots = (operation,) if mnemonic in MULTIPLY_ADD else (word("nop"), word("nop"), operation)
    constants = [
        {"name": f"v{i}", "index": i, "type": "int", "bits": f"{bits:08x}"}
        for i, bits in enumerate(operands)
    ]
    iss = Iss(image([bundle(*slots, halt=True)], inputs=[], constants=constants))
    result = iss.run()
    assert result.fault is Fault.NONE and result.counts == {mnemonic: 1}
    return iss.read_bits("a5" if mnemonic in MULTIPLY_ADD else "c5"), result.flags


@pytest.mark.parametrize(
    ("mnemonic", "operands", "bits", "flags"),
    CASES,
    ids=[f"{m}-{'-'.join(f'{o:x}' for o in ops)}" for m, ops, _, _ in CASES],
)
def test_operation_gives_the_bits_and_flags_of_the_standard(mnemonic, operands, bits, flags):
    got, raised = execute(mnemonic, operands)
    assert (f"{got:08x}", raised) == (f"{bits:08x}", flags)


def test_every_operation_of_the_instruction_set_has_a_case():
    isa = tomllib.loads((Path(__file__).parents[2] / "asip_asm" / "isa.toml").read_text())
    # of test_iss_runs.py, test_streams.py, test_loops.py, test_lanes.py
    elsewhere = {"nop", "jmp", "bz", "bnz", "ld", "st", "seek", "loop"}
    elsewhere |= {name for name, op in isa["op"].items() if op["unit"] == "lanes"}
    assert {case[0] for case in CASES} == set(isa["op"]) - elsewhere
    encodings = {name: int(op["encoding"], 2) for name, op in isa["op"].items()}
    assert encodings | OPCODES == encodings  # what was published stays


def test_sine_and_cosine_are_correctly_rounded():
    rng = np.random.default_rng(20260701)
    arguments = np.concatenate(
        (rng.uniform(-256, 256, 60), 10.0 ** rng.uniform(-20, 0, 60))
    ).astype(np.float32)
    with mpmath.workprec(200):
        for argument in arguments:
            for mnemonic, function in (("fsin", mpmath.sin), ("fcos", mpmath.cos)):
                got, _ = execute(mnemonic, (int(argument.view(np.uint32)),))
                value = np.uint32(got).view(np.float32)
                exact = function(mpmath.mpf(float(argument)))
                below, above = (np.nextafter(value, np.float32(side)) for side in (-2, 2))
                distance = abs(mpmath.mpf(float(value)) - exact)
                for neighbour in (below, above):
                    assert distance <= abs(mpmath.mpf(float(neighbour)) - exact), (
                        f"{mnemonic}({float(argument)!r}) = {float(value)!r}"
                    )


def test_another_sine_can_be_substituted():
    def one_ulp_high(bits: int, cosine: bool) -> tuple[int, int]:
        return 0x3F000001, NX

    program = image([bundle(word("nop"), word("nop"), word("fsin", 0, "k0"), halt=True)])
    iss = Iss(program, sincos=one_ulp_high)
    assert iss.run().flags == NX
    assert iss.read_bits("c0") == 0x3F000001
