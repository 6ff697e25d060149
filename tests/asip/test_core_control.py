# SPDX-License-Identifier: Apache-2.0
"""Control: starts, accesses while busy, reset in mid-run, rewriting, entry, irq, registers."""

from __future__ import annotations

import pytest

from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image
from sim.rtl.asip_bus import (
    BLOCK,
    CLEAR,
    CSR,
    IRQ_ALL,
    IRQ_DONE,
    IRQ_FAULT,
    START,
    STATUS,
    register_address,
)
from sim.rtl.asip_rtl import AsipRtl
from tests.asip import core_bench as bench
from tests.asip.core_bench import EMPTY, HALT, ISA, op

REGISTER_READ_CYCLES = 5
ONE, TWO, THREE = 0x3F800000, 0x40000000, 0x40400000


def busy_program(configuration: str) -> Image:
    """About 45 cycles that keep every unit busy: sums a state up, stores and loads."""
    lines = [
        (op("fsin", "c1", "k1"),),
        (op("fmadd", "a1", "a1", "k0", "k1"), op("fdiv", "c2", "k0", "k1")),
        (op("fmul", "a2", "a1", "a1"), op("st", "a1", "zero", imm=9)),
        (op("ld", "c3", "zero", imm=9),),
        (op("fadd", "a3", "a2", "c3"), op("i2f", "c4", "k2")),
        (op("fmadd", "a4", "c1", "c2", "a3"),),
        (op("fmax", "o0", "a4", "c4"),),
        (op("mov", "o1", "a1"),),
    ]
    if configuration == "small":
        lines = [(item,) for line in lines for item in line]
    lines[-1] += (HALT,)
    return bench.image(
        configuration,
        lines,
        {"k0": 0x3FC00000, "k1": 0x3F000000, "k2": 5, "a1": ONE},
        outputs=2,
        data=[0] * 16,
    )


def count(configuration: str) -> int:
    """Bundles issued since the model was made."""
    return int(bench.core(configuration).issued(ISA.program_bundles).sum())


def started(program: Image, clocks: int = 0) -> AsipRtl:
    """The core with the program, so many clocks after the start of a run."""
    dut = bench.load(program)
    dut.write(CSR["CONTROL"], START)
    dut.clock(clocks)
    return dut


def wait(configuration: str) -> None:
    """Until the core is idle."""
    dut = bench.core(configuration)
    for _ in range(bench.RUN_LIMIT):
        if not STATUS["busy"].of(dut.read(CSR["STATUS"])):
            return
    raise AssertionError("busy for ever")


def test_start__back_to_back__same_cycles_and_state_goes_on(configuration):
    program = busy_program(configuration)
    model, want = bench.iss_run(program)
    first = bench.run(program)
    for _ in range(12):
        got = bench.run(program, loaded=True)
        want = model.run()
        assert (got.issued, got.cycles, got.stalls) == (first.issued, first.cycles, first.stalls)
        assert got.outputs == want.output_bits
        assert {name: words[-1] for name, words in got.writes.items()} == {
            name: words[-1] for name, words in want.writes.items()
        }
    assert got.outputs != first.outputs, "the state did not change"


def test_start__in_any_cycle_of_a_run__is_ignored_until_the_run_is_over(configuration):
    program = busy_program(configuration)
    single = bench.run(program)
    runs = []
    for delay in range(single.cycles + 8):
        dut = bench.load(program)
        dut.clock(bench.REDIRECT)  # the first bundle waits for the start
        before = count(configuration)
        dut.write(CSR["CONTROL"], START)
        dut.clock(delay)
        dut.write(CSR["CONTROL"], START)
        dut.clock(3 * single.cycles)
        assert STATUS["done"].of(dut.read(CSR["STATUS"]))
        assert dut.read(CSR["CYCLES"]) == single.cycles
        done, rest = divmod(count(configuration) - before, len(program.bundles))
        assert rest == 0
        runs.append(done)
    assert set(runs) == {1, 2} and runs == sorted(runs)
    # accepted (1 cycle), first bundle in place (1), then the cycles of the run
    assert runs.index(2) == single.cycles + 1


def test_clear__in_any_cycle_of_a_run__does_not_disturb_it(configuration):
    program = busy_program(configuration)
    single = bench.run(program)
    for delay in range(single.cycles):
        dut = started(program, delay)
        dut.write(CSR["CONTROL"], CLEAR)
        wait(configuration)
        assert STATUS["done"].of(dut.read(CSR["STATUS"]))
        assert dut.read(CSR["CYCLES"]) == single.cycles
        assert bench.output_words(dut) == [*single.outputs.values()]


HELD_WRITES = {
    "constant": (BLOCK["constants"] + 1, TWO),
    "safe": (BLOCK["safe"], TWO),
    "register": (register_address("a1"), TWO),
    "data": (BLOCK["data"] + 9, TWO),
    "program": (BLOCK["program"] + 1, 0),  # the lane of an opcode
    "WATCHDOG": (CSR["WATCHDOG"], 1),
    "ENTRY": (CSR["ENTRY"], 5),
    "OUTPUT_MASK": (CSR["OUTPUT_MASK"], 0x80000000),
}


@pytest.mark.parametrize("target", HELD_WRITES)
def test_write__in_any_cycle_of_a_run__waits_for_its_end_and_is_not_lost(target, configuration):
    program = busy_program(configuration)
    single = bench.run(program)
    address, word = HELD_WRITES[target]
    for delay in range(single.cycles):
        dut = bench.load(program)
        dut.trace()
        dut.write(CSR["CONTROL"], START)
        dut.clock(delay)
        dut.write(address, word)
        status = dut.read(CSR["STATUS"])
        assert STATUS["done"].of(status) and not STATUS["busy"].of(status)
        assert dut.read(CSR["CYCLES"]) == single.cycles
        assert bench.output_words(dut) == [*single.outputs.values()]
        assert bench.traced_writes(dut) == single.writes
        access = {"register": "rw", "data": "rw"}.get(target, target.isupper() and "rw")
        if access:
            assert dut.read(address) == word
    # what cannot be read back takes effect in the next run
    if target == "constant":
        assert bench.run(program, loaded=True).writes["c1"] != single.writes["c1"]
    if target == "program":
        assert bench.run(program, loaded=True).fault == "ILLEGAL"
    if target == "safe":
        dut.reset()
        assert dut.read(BLOCK["outputs"]) == word


def test_read__in_any_cycle_of_a_run__waits_for_its_end(configuration):
    program = busy_program(configuration)
    single = bench.run(program)
    reads = {
        BLOCK["outputs"]: single.outputs["out0"],
        register_address("a4"): single.writes["a4"][-1],
        BLOCK["data"] + 9: single.writes["a1"][-1],
    }
    for address, word in reads.items():
        for delay in range(single.cycles):
            dut = started(program, delay)
            assert dut.read(address) == word
            assert dut.read(CSR["CYCLES"]) == single.cycles


def test_status_registers__while_busy__answer_at_once(configuration):
    program = bench.image(
        configuration, [op("jmp", target="loop")], labels={"loop": 0}, watchdog=2000
    )
    dut = started(program)
    for name, address in CSR.items():
        if "r" in REGMAP.registers[name].access:
            before = dut.cycles
            word = dut.read(address)
            assert dut.cycles - before == REGISTER_READ_CYCLES, name
            if name == "STATUS":
                assert word == STATUS["busy"].mask
            if name == "CYCLES":
                assert 0 < word < 100
    before = dut.cycles
    dut.write(CSR["IRQ_ENABLE"], IRQ_FAULT)
    assert dut.cycles - before == 1 and dut.read(CSR["IRQ_ENABLE"]) == IRQ_FAULT
    wait(configuration)
    assert dut.irq


def test_reset__in_any_cycle_of_a_run__next_run_is_right(configuration):
    program = busy_program(configuration)
    single = bench.run(program)
    for delay in range(single.cycles + 4):
        dut = started(program, delay)
        dut.reset()
        assert not dut.irq
        # at once, while what was in flight would still be: memories keep the program
        for name, word in (("IRQ_ENABLE", IRQ_ALL), ("OUTPUT_MASK", program.output_mask)):
            dut.write(CSR[name], word)
        dut.write(register_address("a1"), ONE)
        got = bench.run(program, loaded=True)
        assert got == single, f"after a reset {delay} cycles after the start"


def test_reset__in_any_cycle_of_a_run__idle_with_safe_outputs(configuration):
    program = busy_program(configuration)
    for delay in range(bench.run(program).cycles + 4):
        dut = started(program, delay)
        dut.reset()
        assert dut.read(CSR["STATUS"]) == 0 and not dut.irq
        assert dut.read(BLOCK["outputs"]) == bench.safe_word(0)
        count_before = count(configuration)
        dut.clock(50)
        assert count(configuration) == count_before and dut.read(CSR["STATUS"]) == 0


def test_reset__registers__have_the_values_of_the_map(configuration):
    dut = bench.core(configuration)
    for name in ("IRQ_ENABLE", "WATCHDOG", "ENTRY", "OUTPUT_MASK"):
        dut.write(CSR[name], 0xFFFFFFFF)
    dut.reset()
    for name, register in REGMAP.registers.items():
        if register.reset is not None:
            assert dut.read(CSR[name]) == register.reset, name
    for name in ("STATUS", "CYCLES", *bench.STALLS):
        assert dut.read(CSR[name]) == 0, name


def test_config__fields__describe_the_build(configuration):
    dut = bench.core(configuration)
    word = dut.read(CSR["CONFIG"])
    build = ISA.configurations[configuration]
    fields = {name: field.of(word) for name, field in REGMAP.registers["CONFIG"].fields.items()}
    assert fields == {
        "slots": len(build.slots),
        "fma_pipes": build.fma_pipes,
        "bank_size": ISA.banks["A"].size,
        "program_log2": ISA.program_bundles.bit_length() - 1,
        "data_log2": ISA.data_words.bit_length() - 1,
        "resilience": 0,
        "plausible": 0,
    }
    assert dut.read(CSR["ID"]).to_bytes(4, "big") == b"MTK1"


def test_registers__written_by_the_host__read_back(configuration):
    dut = bench.core(configuration)
    dut.reset()
    dut.write(CSR["ENTRY"], 0xABCD1234)
    assert dut.read(CSR["ENTRY"]) == 0x1234  # 16 bits
    words = {"WATCHDOG": 0xDEADBEEF, "OUTPUT_MASK": 0xA5A5A5A5, "IRQ_ENABLE": IRQ_ALL}
    for name, word in words.items():
        dut.write(CSR[name], word)
        assert dut.read(CSR[name]) == word
    for name in ("ID", "CONFIG", "STATUS", "CYCLES"):  # read only
        before = dut.read(CSR[name])
        dut.write(CSR[name], ~before)
        assert dut.read(CSR[name]) == before
    banks = "abc" if configuration == "fast" else "ac"
    names = [f"{bank}{i}" for bank in banks for i in range(64)]
    for i, name in enumerate(names):
        dut.write(register_address(name), 0x9E3779B9 * (i + 1))
    for i, name in enumerate(names):
        assert dut.read(register_address(name)) == 0x9E3779B9 * (i + 1) & 0xFFFFFFFF, name
    for i, name in enumerate(names):  # read in the next clock
        dut.write(register_address(name), 0xC2B2AE35 * (i + 1))
        assert dut.read(register_address(name)) == 0xC2B2AE35 * (i + 1) & 0xFFFFFFFF, name
    for address in range(ISA.data_words):
        dut.write(BLOCK["data"] + address, 0x85EBCA6B * (address + 1))
    dut.write(BLOCK["data"] + ISA.data_words, 0xFFFFFFFF)  # outside: lost, not folded back
    for address in range(ISA.data_words):
        assert dut.read(BLOCK["data"] + address) == 0x85EBCA6B * (address + 1) & 0xFFFFFFFF
    assert dut.read(BLOCK["data"] + ISA.data_words) == 0
    for block in ("constants", "safe", "program"):  # write only
        assert dut.read(BLOCK[block]) == 0


@pytest.mark.parametrize("source", ["k1", "a1", "c1"])
def test_word__written_in_the_clock_before_the_start__is_used(configuration, source):
    dut = bench.core(configuration)
    image = bench.image(configuration, [(op("mov", "o0", source), HALT)])
    assert bench.run(image).outputs
    address = BLOCK["constants"] + 1 if source == "k1" else register_address(source)
    for word in (THREE, TWO):
        dut.write(CSR["CONTROL"], CLEAR)
        dut.write(address, word)
        dut.write(CSR["CONTROL"], START)
        dut.clock(60)
        assert dut.read(BLOCK["outputs"]) == word


def test_program__rewritten_between_runs__the_new_one_runs(configuration):
    def single(word: int) -> Image:
        bundles = [(op("mov", "o0", "k0"), HALT)]
        return bench.image(configuration, bundles, {"k0": word})

    dut = bench.core(configuration)
    assert bench.run(single(ONE)).outputs == {"out0": ONE}
    assert bench.run(single(TWO)).outputs == {"out0": TWO}
    # the word of the entry's bundle written in the cycle before the start
    lanes = dict(bench.image(configuration, [(op("mov", "o0", "k1"), HALT)]).words())
    dut.write(BLOCK["constants"] + 1, THREE)
    dut.write(CSR["CONTROL"], CLEAR)
    for lane, word in lanes.items():
        dut.write(BLOCK["program"] + lane, word)
    dut.write(CSR["CONTROL"], START)
    wait(configuration)
    assert dut.read(BLOCK["outputs"]) == THREE


def test_program__word_beyond_program_memory__is_not_folded_back(configuration):
    program = busy_program(configuration)
    before = bench.run(program)
    dut = bench.load(program)
    for bundle in (ISA.program_bundles, 2 * ISA.program_bundles - 1):
        for lane in range(4):
            dut.write(BLOCK["program"] + 4 * bundle + lane, 0)
    assert bench.run(program, loaded=True).fault == before.fault == "NONE"


def test_program__lanes_that_the_bundle_does_not_have__are_ignored(configuration):
    program = busy_program(configuration)
    dut = bench.load(program)
    for lane in range(ISA.lanes(configuration), 4):
        dut.write(BLOCK["program"] + lane, 0xFFFFFFFF)
    assert bench.run(program, loaded=True).fault == "NONE"


def test_entry__changed_between_runs__each_part_runs(configuration):
    moves = [(op("mov", "o0", f"k{i}"), HALT) for i in range(5)]
    program = bench.image(configuration, moves, {f"k{i}": ONE + i for i in range(5)})
    dut = bench.load(program)
    for entry in (3, 0, 4, 4, 1, 2):
        dut.write(CSR["ENTRY"], entry)
        dut.write(CSR["CONTROL"], START)
        wait(configuration)
        assert dut.read(BLOCK["outputs"]) == ONE + entry
        assert dut.read(CSR["CYCLES"]) == bench.expected_cycles(program_of(program, entry))[1]


def program_of(program: Image, entry: int) -> Image:
    """The one bundle at `entry` as a program."""
    return bench.image(program.configuration, [program.bundles[entry]], outputs=0)


def test_irq__every_enable__follows_done_and_fault(configuration):
    ends = {
        "done": bench.image(configuration, [HALT], outputs=0),
        "fault": bench.image(configuration, ["0" * (ISA.bundle_width(configuration) // 4)]),
    }
    for end, program in ends.items():
        for enable in (0, IRQ_DONE, IRQ_FAULT, IRQ_ALL):
            dut = bench.load(program)
            dut.write(CSR["IRQ_ENABLE"], enable)
            assert not dut.irq
            dut.write(CSR["CONTROL"], START)
            wait(configuration)
            asked = enable & (IRQ_DONE if end == "done" else IRQ_FAULT)
            assert dut.irq == bool(asked)
            dut.write(CSR["IRQ_ENABLE"], enable ^ IRQ_ALL)
            assert dut.irq != bool(asked)
            dut.write(CSR["CONTROL"], CLEAR)
            dut.write(CSR["IRQ_ENABLE"], IRQ_ALL)
            assert not dut.irq


def test_done__next_start_without_clear__goes_down_and_up_again(configuration):
    program = busy_program(configuration)
    bench.run(program)
    dut = bench.core(configuration)
    assert dut.irq
    dut.write(CSR["CONTROL"], START)
    dut.clock(2)
    status = dut.read(CSR["STATUS"])
    assert not dut.irq and STATUS["busy"].of(status)
    assert not STATUS["done"].of(status) and not STATUS["fault"].of(status)
    wait(configuration)
    assert dut.irq


def test_flags__of_a_run__are_those_of_that_run_alone(configuration):
    def quotient(divisor: str) -> Image:
        bundles = [(op("fdiv", "c0", "k0", divisor), HALT)]
        return bench.image(configuration, bundles, {"k0": ONE, "k1": THREE, "k2": TWO}, outputs=0)

    flags = [bench.run(quotient(divisor)).flags for divisor in ("zero", "k2", "k1", "k2")]
    assert flags == [0b01000, 0, 0b00001, 0]


def test_outputs__of_the_last_run__stay_while_the_next_one_runs_and_change_together(configuration):
    # a run that faults after it has written o0: the host never sees that word
    def program(word: int, end: str) -> Image:
        return bench.image(
            configuration,
            [op("mov", "o0", "k0"), *[EMPTY] * 8, (op("mov", "o1", end), HALT)],
            {"k0": word, "k1": 0x7FC00000},
            outputs=2,
        )

    assert [*bench.run(program(ONE, "k0")).outputs.values()] == [ONE, ONE]
    assert [*bench.run(program(TWO, "k1")).outputs.values()] == [0x3F000000, 0x3FC00000]
    assert [*bench.run(program(THREE, "k0")).outputs.values()] == [THREE, THREE]
