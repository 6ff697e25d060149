# SPDX-License-Identifier: Apache-2.0
"""Faults: cause and place, safe outputs, interrupt, no start until cleared, then a good run."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from asip_asm.encode import encode_operation
from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image
from asip_asm.ir import Operation
from sim.core.iss import Fault, Iss
from sim.rtl.asip_bus import BLOCK, CLEAR, CSR, IRQ_DONE, IRQ_FAULT, START, STATUS, register_address
from tests.asip import core_bench as bench
from tests.asip.core_bench import CONFIGURATIONS, EMPTY, HALT, ISA, CoreRun, op

LAST = ISA.program_bundles - 1
NOP = encode_operation(Operation("nop"), ISA, {})
GOOD_WORD, OTHER_WORD = 0x40E00000, 0x41100000
NON_FINITE = (0x7F800000, 0xFF800000, 0x7FC00000, 0xFFFFFFFF, 0x7F800001)
SLOT_OF = {"fast": (0, 1, 2), "small": (0,)}


def good(configuration: str) -> Image:
    """Program that writes o0 and o1."""
    return bench.image(
        configuration,
        [op("mov", "o0", "k0"), (op("mov", "o1", "k0"), HALT)],
        {"k0": GOOD_WORD},
        outputs=2,
    )


def check_fault(
    program: Image, cause: str, info: int, csr: Mapping[str, int] = {}, *, model: bool = True
) -> CoreRun:
    """A fault as the register map describes it, between two good runs; `csr` as for bench.load."""
    configuration = program.configuration
    before = bench.run(good(configuration))
    assert before.fault == "NONE" and set(before.outputs.values()) == {GOOD_WORD}

    got = bench.run(program, csr)
    dut = bench.core(configuration)
    assert (got.fault, got.info) == (cause, info)
    fields = {name: STATUS[name].of(got.status) for name in ("busy", "done", "fault")}
    assert fields == {"busy": 0, "done": 0, "fault": 1}
    safe = {o.name: bench.safe_word(o.index) for o in program.outputs}
    assert got.outputs == safe, "the safe values replace the outputs of the run before"
    assert len(got.issued) + sum(got.stalls.values()) == got.cycles
    if model:
        assert Iss(program.to_json()).run().fault.name == cause

    # interrupt by the fault alone; no start before clear
    dut.write(CSR["IRQ_ENABLE"], IRQ_DONE)
    assert not dut.irq
    dut.write(CSR["IRQ_ENABLE"], IRQ_FAULT)
    assert dut.irq
    count = int(dut.issued(ISA.program_bundles).sum())
    for control in (START, START | CLEAR):
        dut.write(CSR["CONTROL"], control)
        dut.clock(30)
        assert int(dut.issued(ISA.program_bundles).sum()) == count, "a faulted core started"
    assert not dut.irq and STATUS["fault"].of(dut.read(CSR["STATUS"])) == 0
    assert STATUS["cause"].of(dut.read(CSR["STATUS"])) == 0
    assert {o.name: dut.read(BLOCK["outputs"] + o.index) for o in program.outputs} == safe

    after = bench.run(good(configuration))
    assert (after.outputs, after.cycles) == (before.outputs, before.cycles)
    return got


def word_bundle(configuration: str, words: dict[int, int], control: int = 0) -> str:
    """Bundle of operation words by slot, nops elsewhere."""
    value = control
    for slot in reversed(SLOT_OF[configuration]):
        value = value << ISA.word_width | words.get(slot, NOP)
    return f"{value:0{ISA.bundle_width(configuration) // 4}x}"


def fields(mnemonic: str, **values: int) -> int:
    """Operation word with the given fields, the others 0."""
    word = ISA.operations[mnemonic].opcode << ISA.fields["op"].low
    for name, value in values.items():
        word |= value << ISA.fields[name].low
    return word


def check_illegal(configuration: str, illegal: str) -> None:
    """The bundle at address 2 is illegal: what is before it is executed, nothing else."""
    before = [op("mov", "o0", "k0"), op("mov", "c1", "k0")]
    behind = (op("mov", "c2", "k0"), HALT)
    program = bench.image(
        configuration, [*before, illegal, behind], {"k0": OTHER_WORD, "c2": 5}, outputs=2
    )
    got = check_fault(program, "ILLEGAL", 2)
    assert got.writes == {"o0": [OTHER_WORD], "c1": [OTHER_WORD]}
    assert got.bundle_order == [0, 1]
    # the cycle of the illegal bundle is no stall
    assert got.stalls == dict.fromkeys(bench.STALLS, 0) | {"DRAIN": got.cycles - 2}


def companions(configuration: str, slot: int) -> dict[int, int]:
    """Legal operations for the other slots; none of them may write."""
    legal = {0: ("fmul", 3), 1: ("fmul", 3), 2: ("mov", 3)}
    return {
        other: fields(name, dst=dst, a=0x100)
        for other, (name, dst) in legal.items()
        if other in SLOT_OF[configuration] and other != slot
    }


SLOTS = [(c, slot) for c in CONFIGURATIONS for slot in SLOT_OF[c]]


@pytest.mark.parametrize(("configuration", "slot"), SLOTS)
def test_illegal__every_unassigned_opcode__stops_before_the_bundle(configuration, slot):
    unassigned = set(range(64)) - set(ISA.by_opcode)
    assert 0 in unassigned and len(unassigned) == 64 - len(ISA.operations)
    for opcode in sorted(unassigned):
        words = companions(configuration, slot) | {slot: opcode << ISA.fields["op"].low}
        check_illegal(configuration, word_bundle(configuration, words))


@pytest.mark.parametrize("slot", SLOT_OF["fast"])
def test_illegal__operation_in_a_slot_without_its_unit__stops_before_the_bundle(slot):
    aux = slot == 2
    for mnemonic, record in ISA.operations.items():
        if mnemonic != "nop" and (ISA.units[record.unit].bank == "pipe") == aux:
            check_illegal(
                "fast", word_bundle("fast", companions("fast", slot) | {slot: fields(mnemonic)})
            )


@pytest.mark.parametrize(("configuration", "slot"), SLOTS)
def test_illegal__register_that_does_not_exist__stops_before_the_bundle(configuration, slot):
    sources = [0x001, 0x03F, 0x180, 0x1BF, 0x1C0, 0x1FF]  # zero has one register; banks 6 and 7
    if configuration == "small":
        sources += [0x080, 0x0BF]  # bank B
    mnemonics = [("nop", "abc")] + ([("fmadd", "abc"), ("fmul", "c")] if slot < 2 else [])
    if slot == SLOT_OF[configuration][-1]:
        mnemonics += [("fsat", "abc"), ("fdiv", "abc"), ("f2i", "bc")]
        mnemonics += [("jmp", "ab"), ("bz", "ab"), ("st", "ab"), ("ld", "b")]
    for mnemonic, operands in mnemonics:
        for operand in operands:
            for source in sources:
                word = fields(mnemonic, **{operand: source})
                words = companions(configuration, slot) | {slot: word}
                check_illegal(configuration, word_bundle(configuration, words))


def test_illegal__output_that_does_not_exist_or_of_a_pipe__stops_before_the_bundle(configuration):
    aux = SLOT_OF[configuration][-1]
    for index in (32, 33, 63):
        word = fields("mov", dst=64 + index)
        check_illegal(configuration, word_bundle(configuration, {aux: word}))
    for slot in SLOT_OF[configuration][:2]:
        for mnemonic in ("fmadd", "fmul", "fadd"):
            word = fields(mnemonic, dst=64)
            check_illegal(configuration, word_bundle(configuration, {slot: word}))


def test_illegal__reserved_control_bits__stop_before_the_bundle(configuration):
    aux = SLOT_OF[configuration][-1]
    for bit in range(1, ISA.control_width):
        for halt in (0, 1):
            words = {aux: fields("mov", dst=3)}
            check_illegal(configuration, word_bundle(configuration, words, 1 << bit | halt))


@pytest.mark.parametrize("mnemonic", ["jmp", "bz", "bnz"])
def test_illegal__halt_with_a_branch__stops_before_the_bundle(mnemonic, configuration):
    aux = SLOT_OF[configuration][-1]
    words = companions(configuration, aux) | {aux: fields(mnemonic)}
    program = bench.image(
        configuration,
        [op("mov", "o0", "k0"), word_bundle(configuration, words, control=1)],
        {"k0": OTHER_WORD},
    )
    got = check_fault(program, "ILLEGAL", 1)
    assert got.writes == {"o0": [OTHER_WORD]}


def test_illegal__empty_program_memory__stops_behind_the_program(configuration):
    program = bench.image(configuration, [op("mov", "o0", "k0")] * 3, {"k0": OTHER_WORD})
    check_fault(program, "ILLEGAL", 3)


OUTSIDE = [(1024, 0), (0, 1024), (0xFFFFFFFF, 0), (0x80000000, 0), (0x7FFFFFFF, 1), (1, 0xFFFF)]


@pytest.mark.parametrize(("index", "imm"), OUTSIDE)
def test_address__data_outside_the_memory__names_the_bundle(index, imm, configuration):
    data = [0x100 + i for i in range(ISA.data_words)]
    for access in (
        op("ld", "c5", "k1", imm=imm),
        op("ld", "o1", "k1", imm=imm),
        op("st", "k0", "k1", imm=imm),
    ):
        bundles = [
            op("mov", "o0", "k0"),
            EMPTY,
            access,
            *[EMPTY] * 8,
            (op("mov", "c7", "k0"), HALT),
        ]
        program = bench.image(
            configuration, bundles, {"k0": OTHER_WORD, "k1": index, "c7": 1}, outputs=2, data=data
        )
        got = check_fault(program, "ADDRESS", 2)
        assert "c7" not in got.writes, "the run goes on after an address fault"
        dut = bench.core(configuration)
        assert [dut.read(BLOCK["data"] + i) for i in range(ISA.data_words)] == data


def test_address__program_runs_off_the_end__names_the_first_address_outside(configuration):
    bundles = [op("mov", "c0", "k0")] * ISA.program_bundles
    program = bench.image(configuration, bundles, {"k0": OTHER_WORD})
    got = check_fault(program, "ADDRESS", ISA.program_bundles)
    assert len(got.writes["c0"]) == ISA.program_bundles
    # the last bundle itself is inside
    halts = bundles[:-1] + [HALT]
    assert bench.run(bench.image(configuration, halts, {"k0": 0})).fault == "NONE"


@pytest.mark.parametrize("target", [1024, 2048, 65535])
def test_address__branch_beyond_program_memory__names_the_target(target, configuration):
    for branch in (
        op("jmp", target="t"),
        op("bz", "zero", target="t"),
        op("bnz", "k0", target="t"),
    ):
        program = bench.image(
            configuration,
            [op("mov", "o0", "k0"), branch, (op("mov", "c7", "k0"), HALT)],
            {"k0": OTHER_WORD},
            labels={"t": target},
        )
        got = check_fault(program, "ADDRESS", target)
        assert got.bundle_order == [0, 1] and "c7" not in got.writes


def test_address__entry_beyond_program_memory__is_a_fault(configuration):
    entry = ISA.program_bundles + 5
    got = check_fault(good(configuration), "ADDRESS", entry, {"ENTRY": entry}, model=False)
    assert got.issued == []


def test_watchdog__endless_loop__stops_after_the_stated_cycles(configuration):
    for watchdog in (1, 2, 3, 50, 333):
        program = bench.image(
            configuration,
            [op("mov", "o0", "k0"), op("jmp", target="loop")],
            {"k0": OTHER_WORD},
            labels={"loop": 1},
            watchdog=watchdog,
        )
        got = check_fault(program, "WATCHDOG", 0 if watchdog == 1 else 1)
        # stopped with the cycle after; two stages and the last write leave the pipeline
        assert watchdog < got.cycles <= watchdog + bench.PIPELINE
    got = bench.run(program, {"WATCHDOG": 0})
    assert got.fault == "WATCHDOG" and 0 < got.cycles <= 1 + bench.PIPELINE


def test_watchdog__run_of_exactly_that_many_cycles__is_not_stopped(configuration):
    for last in (op("mov", "o0", "k0"), op("fdiv", "o0", "k0", "k0"), op("fsin", "o0", "zero")):
        program = bench.image(configuration, [(last, HALT)], {"k0": OTHER_WORD})
        cycles = bench.run(program).cycles
        program.watchdog = cycles
        assert bench.run(program).fault == "NONE"
        program.watchdog = cycles - 1
        check_fault(program, "WATCHDOG", 0, model=False)  # the model counts bundles


@pytest.mark.parametrize("word", NON_FINITE)
def test_not_finite__nan_or_infinity_to_an_output__names_the_output(word, configuration):
    for index in (0, 1, 31):
        for write in (op("mov", f"o{index}", "k1"), op("ld", f"o{index}", "zero", imm=2)):
            program = bench.image(
                configuration,
                [write, *[EMPTY] * 7, (op("mov", "c7", "k0"), HALT)],
                {"k0": OTHER_WORD, "k1": word},
                outputs=32,
                data=[0, 0, word],
            )
            program.output_mask = 1 << index
            got = check_fault(program, "NOT_FINITE", index)
            assert "c7" not in got.writes, "the run goes on after the fault"


@pytest.mark.parametrize(
    "write",
    [
        op("fdiv", "o3", "k0", "zero"),
        op("fsqrt", "o3", "k2"),
        op("fsin", "o3", "k1"),
        op("fmax", "o3", "k1", "k1"),
    ],
    ids=lambda operation: operation.mnemonic,
)
def test_not_finite__result_of_any_unit_with_the_last_bundle__is_a_fault(write, configuration):
    # the fault comes with the last write-back, in the cycle in which the run would be done
    program = bench.image(
        configuration,
        [(write, HALT)],
        {"k0": OTHER_WORD, "k1": 0x7F800000, "k2": 0xBF800000},
        outputs=4,
    )
    check_fault(program, "NOT_FINITE", 3)


def test_output__largest_finite_numbers__are_no_fault(configuration):
    for word in (0x7F7FFFFF, 0xFF7FFFFF, 0x80000000, 0x00000001):
        program = bench.image(configuration, [(op("mov", "o0", "k1"), HALT)], {"k1": word})
        assert bench.run(program).outputs == {"out0": word}


def test_output_missing__any_output_of_the_mask__names_the_last_bundle(configuration):
    for missing in (0, 1, 31):
        writes = [op("mov", f"o{index}", "k0") for index in (0, 1, 31) if index != missing]
        program = bench.image(configuration, [*writes, HALT], {"k0": OTHER_WORD}, outputs=32)
        program.output_mask = 0x80000003
        check_fault(program, "OUTPUT_MISSING", 2)


def test_output_missing__on_the_path_taken__is_a_fault_of_that_run_only(configuration):
    def program(condition: int) -> Image:
        return bench.image(
            configuration,
            [op("bz", "k1", target="skip"), op("mov", "o0", "k0"), HALT],
            {"k0": OTHER_WORD, "k1": condition},
            labels={"skip": 2},
        )

    assert bench.run(program(1)).fault == "NONE"
    check_fault(program(0), "OUTPUT_MISSING", 2)
    assert bench.run(program(1)).outputs == {"out0": OTHER_WORD}


def test_two_faults__the_first_in_time__stays(configuration):
    program = bench.image(
        configuration,
        [op("ld", "c5", "k1", imm=0), EMPTY, EMPTY, EMPTY, word_bundle(configuration, {0: 0})],
        {"k1": 0x80000000},
    )
    # issue at 0: address fault in stage E2 at 4, the cycle in which the illegal bundle is decoded
    check_fault(program, "ADDRESS", 0)


def test_outputs__before_the_first_run_and_after_reset__are_the_safe_values(configuration):
    program = good(configuration)
    dut = bench.load(program)
    dut.reset()
    safe = [bench.safe_word(0), bench.safe_word(1)]
    assert bench.output_words(dut) == safe
    assert set(bench.run(program).outputs.values()) == {GOOD_WORD}
    dut.reset()
    assert bench.output_words(dut) == safe


def test_outputs__safe_values_written_after_any_number_of_runs__are_read_after_a_reset(
    configuration,
):
    # runs fill two pages in turn: safe values must go to neither of them
    program = good(configuration)
    bench.load(program).reset()
    for runs in (0, 1, 2):
        dut = bench.load(program)
        for _ in range(runs):
            bench.run(program, loaded=True)
        safe = [0x3E000000 + 16 * runs, 0x3E800000 + 16 * runs]
        for index, word in enumerate(safe):
            dut.write(BLOCK["safe"] + index, word)
        dut.clock(2)
        if runs:
            assert bench.output_words(dut) == [GOOD_WORD] * 2
        dut.reset()
        assert bench.output_words(dut) == safe


def test_fault_with_long_operations_in_flight__core_is_idle_before_the_next_run(configuration):
    # a division and a sine are in flight when the illegal bundle stops the run
    program = bench.image(
        configuration,
        [op("fsin", "c1", "k0"), op("fdiv", "c2", "k0", "k0"), word_bundle(configuration, {0: 0})],
        {"k0": GOOD_WORD, "c1": 0, "c2": 0},
    )
    got = check_fault(program, "ILLEGAL", 2)
    assert set(got.writes) == {"c1", "c2"}
    dut = bench.core(configuration)
    assert dut.read(register_address("c2")) == 0x3F800000


def test_every_cause_is_tested_here():
    resilient = {"MEMORY", "CONTROL", "DISAGREE", "IMPLAUSIBLE"}  # tests/upsets, test_plausible
    here = {"NONE", "ILLEGAL", "ADDRESS", "WATCHDOG", "NOT_FINITE", "OUTPUT_MISSING"}
    assert {fault.name for fault in Fault} == here
    assert set(REGMAP.faults) == here | resilient
