# SPDX-License-Identifier: Apache-2.0
"""Runs of the instruction-set model: bundles, branches, memory, state, outputs, faults."""

from __future__ import annotations

import pytest
import softfloatpy as sf

from asip_asm.image import ImageError
from sim.core.iss import Fault, Iss
from tests.asip.iss_image import NOP, TO_OUTPUT, bundle, image, immediate, source, word

HALT = bundle(halt=True)


def aux(operation: int, halt: bool = False) -> str:
    """Bundle with an operation in the auxiliary slot."""
    return bundle(NOP, NOP, operation, halt=halt)


def constant(index: int, bits: int) -> dict:
    return {"name": f"v{index}", "index": index, "type": "int", "bits": f"{bits:08x}"}


def test_all_operations_of_a_bundle_read_before_any_writes():
    swap = bundle(
        word("fadd", 0, "b0", c="zero"),
        word("fadd", 0, "a0", c="zero"),
        word("mov", 0, "a0"),
    )
    program = image([bundle(word("fadd", 0, "k0"), word("fadd", 0, "k1")), swap, HALT])
    iss = Iss(program)
    iss.set_inputs({"p": 1.5, "q": -2.0})
    assert iss.run().bundles == 3
    assert (iss.read("a0"), iss.read("b0"), iss.read("c0")) == (-2.0, 1.5, 1.5)


def test_small_configuration_has_one_slot_for_every_operation():
    bundles = [
        bundle(word("fmul", 1, "k0", "k1"), width=1),
        bundle(word("fdiv", TO_OUTPUT, "a1", "k2"), width=1, halt=True),
    ]
    iss = Iss(image(bundles, configuration="small", output_mask=1))
    iss.set_inputs({"p": 3.0, "q": 4.0, "r": 8.0})
    result = iss.run()
    assert result.outputs == {"F": 1.5} and result.output_bits == {"F": 0x3FC00000}
    assert result.table1 == dict(add_sub=0, mul=1, div=1, sqrt=0, sin=0, float_int=0, sat=0)


def test_loop_counts_executed_operations_and_keeps_flags_until_the_end():
    one = constant(5, 1)
    bundles = [
        aux(word("mov", 0, "k3")),
        aux(word("isub", 0, "c0", "k5")),  # loop:
        aux(word("fdiv", 1, "k0", "k1")),
        aux(word("i2f", 2, "c0")),
        aux(immediate("bnz", 1, a="c2")),
        HALT,
    ]
    iss = Iss(image(bundles, constants=[one]))
    iss.set_inputs({"p": 1.0, "q": 3.0, "n": 4})
    result = iss.run()
    assert result.counts == {"mov": 1, "isub": 4, "fdiv": 4, "i2f": 4, "bnz": 4}
    assert result.table1["div"] == 4 and result.table1["float_int"] == 4
    assert result.flags == 1 and result.bundles == 18


@pytest.mark.parametrize(
    ("branch", "value", "taken"),
    [
        ("bz", 0.0, True),
        ("bz", -0.0, True),
        ("bz", 1e-45, False),
        ("bz", float("nan"), False),
        ("bnz", -0.0, False),
        ("bnz", float("nan"), True),
        ("jmp", 0.0, True),
    ],
)
def test_branch_decides_on_zero_of_either_sign(branch, value, taken):
    a = "zero" if branch == "jmp" else "k0"
    bundles = [aux(immediate(branch, 2, a=a)), HALT, aux(word("mov", 7, "k1"), halt=True)]
    iss = Iss(image(bundles))
    iss.set_inputs({"p": value, "q": 9.0})
    iss.run()
    assert iss.read("c7") == (9.0 if taken else 0.0)


def test_memory_is_addressed_by_register_plus_immediate_and_keeps_its_words():
    index = constant(5, -2 & 0xFFFFFFFF)
    bundles = [
        aux(immediate("ld", 1 + 2, dst=0, b="k5")),
        aux(immediate("st", 1023, a="c0")),
        aux(immediate("ld", 1023, dst=1), halt=True),
    ]
    iss = Iss(image(bundles, constants=[index], data=["deadbeef", "41200000"]))
    iss.run()
    assert (iss.read("c1"), iss.read_data(1023)) == (10.0, 0x41200000)
    iss.reset()
    assert iss.read_data(0) == 0xDEADBEEF


def test_state_and_registers_persist_between_runs_and_can_be_preset():
    states = [
        {"name": "total", "register": "a9", "type": "float", "bits": "3f800000"},
        {"name": "tick", "register": "c3", "type": "int", "bits": "fffffffe"},
    ]
    bundles = [
        bundle(word("fadd", 9, "a9", c="k0"), NOP, word("iadd", 3, "c3", "k5"), halt=True),
    ]
    exports = [{"name": "sum", "register": "a9"}, {"name": "p", "register": "k0"}]
    iss = Iss(image(bundles, states=states, exports=exports, constants=[constant(5, 1)]))
    assert iss.state == {"total": 1.0, "tick": -2}
    iss.set_inputs({"p": 0.25})
    for _ in range(3):
        iss.run()
    assert iss.state == {"total": 1.75, "tick": 1}
    assert (iss.read("sum"), iss.read("p"), iss.read("tick")) == (1.75, 0.25, 1)
    iss.set_state({"total": -1.0, "tick": 7})
    iss.run()
    assert iss.state == {"total": -0.75, "tick": 8}
    iss.reset()
    assert iss.state == {"total": 1.0, "tick": -2}


def test_trace_holds_the_words_written_to_each_register_and_output_in_order():
    bundles = [
        bundle(word("fadd", 2, "k0", c="k0"), word("fmul", 3, "k0", "k0")),
        aux(word("mov", TO_OUTPUT, "a2")),
        bundle(word("fadd", 2, "a2", c="k0"), halt=True),
    ]
    iss = Iss(image(bundles), trace=True)
    iss.set_inputs({"p": 1.0})
    assert iss.run().writes == {
        "a2": [0x40000000, 0x40400000],
        "b3": [0x3F800000],
        "o0": [0x40000000],
    }


FMA_IN_AUX = bundle(NOP, NOP, word("fadd", 0, "k0"))
AUX_IN_FMA = bundle(word("mov", 0, "k0"))
OUTPUT_OF_FMA = bundle(word("fadd", TO_OUTPUT, "k0"))
OUTPUT_32 = bundle(NOP, NOP, word("mov", TO_OUTPUT | 32, "k0"))
BANK_6 = bundle(NOP, NOP, word("mov", 0) | 6 << 24)
ZERO_1 = bundle(NOP, NOP, word("mov", 0) | 1 << 18)
RESERVED = bundle(control=2)
EMPTY = "0" * 32
HALT_AND_BRANCH = bundle(NOP, NOP, word("jmp"), halt=True)
UNUSED_BANK_7 = bundle(NOP, NOP, word("mov", 0) | 7 << 15)
NOP_BANK_6 = bundle(NOP | 6 << 6)


@pytest.mark.parametrize(
    "text",
    [FMA_IN_AUX, AUX_IN_FMA, OUTPUT_OF_FMA, OUTPUT_32, BANK_6, ZERO_1, RESERVED, EMPTY]
    + [HALT_AND_BRANCH, UNUSED_BANK_7, NOP_BANK_6],
    ids="fma-in-aux aux-in-fma output-of-fma output-32 bank-6 zero-1 reserved empty".split()
    + "halt-and-branch unused-bank-7 nop-bank-6".split(),
)
def test_illegal_bundle_stops_the_run_before_it_writes(text):
    writes = int(text, 16) | (word("mov", 5, "k0") << 80 if text == AUX_IN_FMA else 0)
    iss = Iss(image([aux(word("mov", 4, "k0")), f"{writes:032x}", HALT]))
    iss.set_inputs({"p": 2.0})
    result = iss.run()
    assert (result.fault, result.fault_bundle) == (Fault.ILLEGAL, 1)
    assert (iss.read("c4"), iss.read("c5")) == (2.0, 0.0)
    assert result.outputs == {"F": 7.0}


def test_bank_b_does_not_exist_in_the_small_configuration():
    program = image([bundle(word("mov", 0, "b1"), width=1)], configuration="small")
    assert Iss(program).run().fault is Fault.ILLEGAL


def test_running_past_the_program_is_illegal_and_past_the_memory_an_address_fault():
    assert Iss(image([bundle()])).run().fault is Fault.ILLEGAL
    result = Iss(image([aux(immediate("jmp", 1024))])).run()
    assert (result.fault, result.fault_bundle) == (Fault.ADDRESS, 1024)


@pytest.mark.parametrize("index", [-1, 1024, 0x7FFFFFFF])
@pytest.mark.parametrize("operation", ["ld", "st"])
def test_data_address_outside_the_memory_is_a_fault(operation, index):
    text = bundle(word("fadd", 0, "k0"), NOP, immediate(operation, 0, a="zero", b="k3"))
    iss = Iss(image([text, HALT]))
    iss.set_inputs({"p": 2.0, "n": index})
    result = iss.run()
    assert (result.fault, result.fault_bundle) == (Fault.ADDRESS, 0)
    assert iss.read("a0") == 0.0


def test_watchdog_stops_an_endless_loop():
    result = Iss(image([aux(immediate("jmp", 0))], watchdog=50)).run()
    assert (result.fault, result.bundles) == (Fault.WATCHDOG, 50)


@pytest.mark.parametrize("value", [float("inf"), float("-inf"), float("nan")])
def test_value_that_is_not_finite_leaves_the_safe_values(value):
    iss = Iss(image([aux(word("mov", TO_OUTPUT, "k0")), HALT], output_mask=1))
    iss.set_inputs({"p": 3.0})
    assert iss.run().outputs == {"F": 3.0}
    iss.set_inputs({"p": value})
    result = iss.run()
    assert (result.fault, result.fault_bundle) == (Fault.NOT_FINITE, 0)
    assert result.outputs == {"F": 7.0}


def test_halt_without_a_demanded_output_is_a_fault():
    bundles = [aux(immediate("bz", 2, a="k0")), aux(word("mov", TO_OUTPUT, "k1")), HALT]
    iss = Iss(image(bundles, output_mask=1))
    iss.set_inputs({"p": 1.0, "q": 4.0})
    assert iss.run().fault is Fault.NONE
    iss.set_inputs({"p": 0.0})
    result = iss.run()
    assert (result.fault, result.outputs) == (Fault.OUTPUT_MISSING, {"F": 7.0})


def test_unknown_names_and_formats_are_refused():
    iss = Iss(image([HALT]))
    with pytest.raises(KeyError, match="speed: the program has no such input"):
        iss.set_inputs({"speed": 1.0})
    with pytest.raises(KeyError, match="total: the program has no such state"):
        iss.set_state({"total": 1.0})
    with pytest.raises(KeyError, match="a64"):
        iss.read("a64")
    with pytest.raises(ImageError, match="image version 1, this tool reads 2"):
        Iss(image([HALT], version=1))


def test_modes_and_flags_of_softfloat_are_restored_after_a_run():
    sf.set_rounding_mode(sf.RoundingMode.MAX)
    sf.set_exception_flags(2)
    try:
        iss = Iss(image([bundle(word("fadd", 0, "k0", c="k1"), halt=True)]))
        iss.set_inputs({"p": 1.0, "q": 2.0**-30})
        assert iss.run().flags == 1 and iss.read("a0") == 1.0
        assert sf.get_rounding_mode() == sf.RoundingMode.MAX and sf.get_exception_flags() == 2
    finally:
        sf.set_rounding_mode(sf.RoundingMode.NEAR_EVEN)
        sf.set_exception_flags(0)


def test_operand_codes_of_both_halves_of_bank_k():
    assert source("k64") == 0b101_000000
    iss = Iss(
        image([aux(word("mov", 0, "k127"), halt=True)], constants=[constant(127, 0x40000000)])
    )
    iss.run()
    assert iss.read("c0") == 2.0 and iss.read("k127") == 2.0


def test_words_keep_their_bits_a_signalling_nan_too():
    program = image([bundle(NOP, NOP, word("mov", 5, "k0"), halt=True)])
    iss = Iss(program)
    iss.set_words({"p": 0xFF800001})
    iss.run()
    assert iss.read_bits("c5") == 0xFF800001
    with pytest.raises(KeyError, match="no such input or state"):
        iss.set_words({"F": 0})
