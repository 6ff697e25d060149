# SPDX-License-Identifier: Apache-2.0
"""Register allocation: reuse without stalls, states, exports, spilling to data memory."""

import random
from dataclasses import replace
from pathlib import Path

import pytest

from asip_asm import allocate
from asip_asm.allocate import AllocationError, allocate_registers
from asip_asm.assemble import parse_program
from asip_asm.ir import (
    Bundle,
    Export,
    FixedState,
    Operation,
    Program,
    Region,
    Register,
    State,
    Virtual,
)
from asip_asm.machine import load_machine
from asip_asm.schedule import bundle_in_order, schedule_program

from .interpret import operations_of, run_bundles, run_written
from .workload import Builder, arrange, random_program

MACHINES = {name: load_machine(name) for name in ("fast", "small")}
FAST = MACHINES["fast"]
K0, K1 = Register("K", 0), Register("K", 1)
SEEDS = range(30)
LAW = Path(allocate.__file__).parent / "programs/tracking_optimised.s"


def with_banks(machine, size):
    sizes = {bank: min(size, n) if bank in "ABC" else n for bank, n in machine.bank_sizes.items()}
    return replace(machine, bank_sizes=sizes)


def write_stalls(program, machine):
    return sum(issue.waw for issue in machine.issue_cycles(program.regions[0].bundles))


@pytest.mark.parametrize("seed", SEEDS)
def test_reused_registers__never_wait_for_an_earlier_write(seed):
    print(f"replay: random_program({seed}, 150)")
    program = random_program(seed, 150)
    schedule_program(program, FAST, 20)
    # Symbols that the source itself writes twice may wait for each other.
    written = write_stalls(program, FAST)
    allocate_registers(program, FAST)
    assert write_stalls(program, FAST) == written


def test_register_of_an_unread_result__comes_last_until_it_is_written():
    build = Builder()
    slow = build.op("fdiv", K0, K1)
    build.op("mov", K0)
    for _ in range(FAST.units["cmp"].latency + 1):
        build.op("fmul", K0, K1)
    quick = build.op("mov", K1)
    operations = {op.dst: op for op in build.region.operations}
    machine = replace(FAST, bank_sizes={**FAST.bank_sizes, "C": 2})
    arrange(build.program, machine, in_order=True)
    assert operations[quick].dst != operations[slow].dst
    assert write_stalls(build.program, machine) == 0


def test_value_read_in_a_loop__survives_the_whole_loop():
    base, n = Virtual("base", -1), Virtual("n", -1)
    t, u = Virtual("t", 1), Virtual("u", 1)
    start = Region(operations=[Operation("mov", base, K0), Operation("mov", n, K1)])
    loop = Region(
        labels=["loop"],
        operations=[
            Operation("mov", t, base),
            Operation("fneg", u, t),
            Operation("isub", n, n, u),
            Operation("bnz", None, n, target="loop"),
        ],
    )
    program = Program(regions=[start, loop, Region(halt=True)])
    arrange(program, with_banks(FAST, 3), in_order=True)
    base_register = start.operations[0].dst
    assert all(op.dst != base_register for op in loop.operations)


@pytest.mark.parametrize("order", ["as_written", "scheduled"])
@pytest.mark.parametrize("configuration", MACHINES)
@pytest.mark.parametrize("seed", SEEDS)
def test_spilled_program__computes_what_was_written(seed, configuration, order):
    print(f"replay: random_program({seed}, ..., {configuration!r}), banks of 10 registers")
    machine = with_banks(MACHINES[configuration], 10)
    program = random_program(seed, random.Random(seed).randrange(40, 140), configuration)
    written, words = run_written(program), len(program.data)
    arrange(program, machine, in_order=order == "as_written", effort=20)
    assert run_bundles(program, words) == written
    assert all(
        place.index < 10
        for op in operations_of(program)
        for place in (op.dst, op.a, op.b, op.c)
        if isinstance(place, Register) and place.bank in "ABC"
    )
    assert set(program.regions[0].operations) == set(operations_of(program))


@pytest.mark.parametrize("configuration", MACHINES)
def test_spilling_the_tracking_law__uses_data_memory_and_keeps_the_results(configuration):
    machine = with_banks(MACHINES[configuration], 26)
    program = parse_program(LAW, configuration=configuration)
    written, words = run_written(program), len(program.data)
    bundle_in_order(program, machine)
    before = len(list(operations_of(program)))
    allocate_registers(program, machine)
    assert len(program.data) > words
    assert len(list(operations_of(program))) > before
    assert run_bundles(program, words) == written


def test_constant_that_gives_way_before_it_is_read__is_loaded_once():
    build = Builder()
    values = [build.op("ld", imm=i, name=f"x{i}") for i in range(8)]
    for value in values:
        build.output("fabs", value)
    build.program.data = list(range(8))
    arrange(build.program, with_banks(FAST, 4), in_order=True)
    loads = [op.imm for op in operations_of(build.program) if op.mnemonic == "ld"]
    assert sorted(loads) == list(range(8))
    copies = [op.dst for op in operations_of(build.program) if "~" in str(op.symbols)]
    assert not copies
    assert all(op.mnemonic != "st" for op in operations_of(build.program))


def test_no_data_word_left_to_spill__names_the_value():
    build = Builder()
    values = [build.op("mov", K0, name=f"x{i}") for i in range(4)]
    for value in values:
        build.output("mov", value)
    machine = replace(with_banks(FAST, 3), data_words=0)
    with pytest.raises(AllocationError, match="there is no word left for 'x2'"):
        arrange(build.program, machine, in_order=True)


def test_states_that_do_not_fit__are_reported():
    build = Builder()
    for i in range(3):
        build.state(f"s{i}")
    with pytest.raises(AllocationError, match="state 's2': bank C has no register left"):
        arrange(build.program, with_banks(FAST, 2))


def test_exports_that_do_not_fit__are_reported():
    build = Builder()
    for i in range(3):
        build.export(build.op("mov", K0, name=f"x{i}"))
    with pytest.raises(AllocationError, match="bank C has 2 registers; .* none of its values"):
        arrange(build.program, with_banks(FAST, 2))


def test_state__keeps_one_register_and_nothing_else_writes_it():
    program = parse_program(LAW)
    last = {state.name: state.last for state in program.states}
    writer = {op.dst: op for op in program.regions[0].operations}
    writers = {name: writer[symbol] for name, symbol in last.items()}
    arrange(program, FAST)
    for state in program.states:
        writing = [op for op in operations_of(program) if op.dst == state.register]
        assert writing == [writers[state.name]]


def test_unwritten_state__still_has_a_register():
    build = Builder()
    state = build.state("gain", pin="B")
    build.output("mov", state)
    arrange(build.program, FAST)
    assert build.program.states[0].register.bank == "B"


def test_export_of_an_overwritten_first_value__is_refused():
    first, last = Virtual("s", 0), Virtual("s", 1)
    program = Program(regions=[Region(operations=[Operation("mov", last, K0)], halt=True)])
    program.states = [State("s", "float", 0, first, last)]
    program.exports = [Export("s", first)]
    with pytest.raises(AllocationError, match="export 's': the state's value at the start"):
        arrange(program, FAST)


def test_export_of_an_input__is_its_own_place():
    build = Builder()
    build.program.exports = [Export("x", K1)]
    arrange(build.program, FAST)
    assert build.program.exports[0].register == K1


def test_registers_named_in_the_source__are_left_alone():
    build = Builder()
    named = [Register("C", 0), Register("C", 2)]
    build.emit("mov", named[0], K0)
    build.op("mov", K1)
    build.emit("mov", named[1], named[0])
    build.op("mov", named[1])
    arrange(build.program, FAST)
    chosen = [op.dst for op in operations_of(build.program) if op.dst not in named]
    assert len(chosen) == 2 and not set(chosen) & set(named)


def test_registers_of_fixed_states__are_left_alone():
    build = Builder()
    build.program.fixed_states = [FixedState("s", "float", 0, Register("C", 0))]
    build.op("mov", K0)
    arrange(build.program, FAST)
    assert build.region.operations[0].dst == Register("C", 1)


def test_symbols_in_braces__get_the_bank_of_their_slot():
    x, y, z = (Virtual(name, 1) for name in "xyz")
    first = Bundle(
        [Operation("fmul", x, K0, K1), Operation("fmul", y, K0, K1), Operation("mov", z, K0)]
    )
    second = Bundle([None, Operation("fmadd", Virtual("w", 1), x, y, z), None])
    program = Program(regions=[Region(bundles=[first]), Region(bundles=[second], halt=True)])
    allocate_registers(program, FAST)
    assert [op.dst.bank for op in first.slots] == ["A", "B", "C"]
    use = second.slots[1]
    assert [use.a, use.b, use.c] == [op.dst for op in first.slots]


def test_value_read_but_never_written__is_reported():
    build = Builder()
    build.output("mov", Virtual("ghost", 1))
    with pytest.raises(AllocationError, match="'ghost' is read or exported but never written"):
        arrange(build.program, FAST)


def test_spilling__beyond_its_bound__is_refused_with_the_reason(monkeypatch):
    monkeypatch.setattr(allocate, "SPILL_WORK", 0)
    program = random_program(3, 100)
    schedule_program(program, FAST, effort=5)
    with pytest.raises(AllocationError, match="too many values at once: 0 were moved to data mem"):
        allocate_registers(program, with_banks(FAST, 4))
