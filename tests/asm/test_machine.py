# SPDX-License-Identifier: Apache-2.0
"""Timing model of the core: its sources, and every interlock rule on small programs."""

import pytest

from asip_asm.ir import Bundle, Operation, Output, Register
from asip_asm.machine import MachineError, fp_latencies, load_machine

FAST = load_machine("fast")
SMALL = load_machine("small")
FMA = FAST.units["fma"].latency
CMP = FAST.units["cmp"].latency
DIV = FAST.units["divsqrt"].latency
SINCOS = FAST.units["sincos"].interval


def a(i):
    return Register("A", i)


def c(i):
    return Register("C", i)


def fast(fma0=None, fma1=None, aux=None):
    return Bundle([fma0, fma1, aux])


def mov(dst, source=None):
    return Operation("mov", dst, source or Register("K", 0))


def cycles(bundles, machine=FAST):
    return [issue.cycle for issue in machine.issue_cycles(bundles)]


def test_divider__differs_between_configurations__spaces_divisions_in_small_only():
    divisions = [
        Bundle([Operation("fdiv", c(i), Register("K", 0), Register("K", 1))]) for i in (0, 1)
    ]
    interval = SMALL.units["divsqrt"].interval
    assert interval > 1 and FAST.units["divsqrt"].interval == 1
    assert cycles(divisions, SMALL) == [0, interval]
    assert SMALL.issue_cycles(divisions)[1].unit == interval - 1
    assert cycles([fast(aux=bundle.slots[0]) for bundle in divisions]) == [0, 1]


def test_latencies__are_those_of_the_rtl_package():
    assert FAST.units["fma"].latency == fp_latencies()["FP_FMA_LATENCY"]
    assert FAST.units["sincos"].latency == fp_latencies()["FP_SINCOS_OVERLAPPED_LATENCY"]
    assert SMALL.units["sincos"].latency == fp_latencies()["FP_SINCOS_LATENCY"]


def test_missing_latency_constant__is_named_with_its_file(tmp_path):
    package = tmp_path / "fp_pkg.sv"
    package.write_text("localparam int unsigned FP_FMA_LATENCY = 6;\n")
    with pytest.raises(MachineError, match=r"fp_pkg\.sv: no '.*FP_DIVSQRT_LATENCY = n;'"):
        load_machine("fast", fp_pkg_file=package)


def test_unknown_configuration__is_refused_with_the_known_ones():
    with pytest.raises(MachineError, match="no configuration 'tiny'; it has fast, small"):
        load_machine("tiny")


def test_unknown_mnemonic__is_refused_by_name():
    with pytest.raises(MachineError, match="fhalf: not an operation"):
        FAST.latency(Operation("fhalf"))


def test_dependent_bundle__issues_latency_plus_one_cycles_later():
    multiply = Operation("fmul", a(0), Register("K", 0), Register("K", 1))
    issues = FAST.issue_cycles([fast(multiply), fast(aux=mov(c(0), a(0)))])
    assert issues[1].cycle == FMA + 1
    assert issues[1].operand == FMA


def test_reads_and_writes_of_one_bundle__do_not_depend_on_each_other():
    multiply = Operation("fmul", a(0), c(0), c(0))
    assert cycles([fast(multiply, aux=mov(c(0), a(0)))]) == [0]


def test_write_port__delays_the_later_of_two_results_in_one_cycle():
    divide = Operation("fdiv", c(0), Register("K", 0), Register("K", 1))
    fillers = [fast(Operation("fmul", a(i))) for i in range(DIV - CMP - 1)]
    issues = FAST.issue_cycles([fast(aux=divide), *fillers, fast(aux=mov(c(1)))])
    assert (issues[-1].cycle, issues[-1].port) == (DIV - CMP + 1, 1)


def test_write_port__is_shared_with_outputs_and_not_used_by_stores():
    divide = Operation("fdiv", Output(0), Register("K", 0), Register("K", 1))
    fillers = [fast(Operation("fmul", a(i))) for i in range(DIV - CMP - 1)]
    store = Operation("st", None, Register("K", 0), imm=0)
    assert cycles([fast(aux=divide), *fillers, fast(aux=mov(Output(1)))])[-1] == DIV - CMP + 1
    between = [fast()] * (FAST.units["memory"].latency - CMP - 1)
    bundles = [fast(aux=store), *between, fast(aux=mov(c(0)))]
    assert cycles(bundles) == list(range(len(bundles)))


def test_sincos__takes_the_next_operation_after_its_interval():
    sine, cosine = Operation("fsin", c(0)), Operation("fcos", c(1))
    issues = FAST.issue_cycles([fast(aux=sine), fast(aux=cosine)])
    assert (issues[1].cycle, issues[1].unit) == (SINCOS, SINCOS - 1)
    assert SINCOS < FAST.units["sincos"].latency


def test_sincos__in_small__takes_the_next_operation_after_its_result():
    sines = [Bundle([Operation("fsin", c(i))]) for i in (0, 1)]
    assert cycles(sines, SMALL) == [0, SMALL.units["sincos"].latency + 1]


def test_write_after_write__waits_for_the_earlier_result():
    divide = Operation("fdiv", c(0), Register("K", 0), Register("K", 1))
    issues = FAST.issue_cycles([fast(aux=divide), fast(aux=mov(c(0)))])
    assert (issues[1].cycle, issues[1].waw) == (DIV + 1, DIV)


def test_write_after_read__does_not_wait():
    divide = Operation("fdiv", c(1), c(0), c(0))
    assert cycles([fast(aux=divide), fast(aux=mov(c(0)))]) == [0, 1]


def test_run_cycles__end_with_the_last_write():
    divide = Operation("fdiv", c(0), Register("K", 0), Register("K", 1))
    assert FAST.drain_cycle([fast(aux=divide), fast(aux=mov(c(1)))]) == DIV + 1
    assert FAST.drain_cycle([]) == 0


def test_slots_and_banks__follow_the_configuration():
    multiply, move = Operation("fmul", a(0)), mov(c(0))
    assert FAST.slots_of(multiply) == (0, 1)
    assert FAST.slots_of(move) == (2,)
    assert [FAST.bank(multiply, slot) for slot in (0, 1)] == ["A", "B"]
    assert SMALL.slots_of(multiply) == SMALL.slots_of(move) == (0,)
    assert (SMALL.bank(multiply, 0), SMALL.bank(move, 0)) == ("A", "C")
    assert SMALL.bank_sizes["B"] == 0
