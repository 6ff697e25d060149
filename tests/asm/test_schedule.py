# SPDX-License-Identifier: Apache-2.0
"""Schedules: same results as the written order, legal slots and timing, determinism, quality."""

import copy
import random
from collections import Counter
from pathlib import Path

import pytest

from asip_asm import schedule, search
from asip_asm.allocate import allocate_registers
from asip_asm.assemble import assemble, parse_program
from asip_asm.dependence import build_graph
from asip_asm.ir import (
    Bundle,
    Operation,
    Output,
    Program,
    Region,
    Register,
    SourceLine,
    State,
    Virtual,
)
from asip_asm.machine import load_machine, sources
from asip_asm.report import report_program
from asip_asm.schedule import ScheduleError, bundle_in_order, schedule_program

from .interpret import operations_of, run_bundles, run_written
from .workload import Builder, arrange, loop_program, random_program

MACHINES = {name: load_machine(name) for name in ("fast", "small")}
FAST = MACHINES["fast"]
PROGRAMS = Path(search.__file__).parent / "programs"
SEEDS = range(40)
EFFORT = 60
K0, K1 = Register("K", 0), Register("K", 1)


def program_of(seed, configuration):
    print(f"replay: random_program({seed}, ..., {configuration!r})")
    return random_program(seed, random.Random(seed).randrange(1, 120), configuration)


def check_legal(program, machine):
    """Every slot can execute its operation; fixed destinations are in the bank of the slot."""
    for region in program.regions:
        for bundle in region.bundles:
            assert len(bundle.slots) == len(machine.slots)
            for slot, op in bundle.placed():
                fma = machine.units[machine.unit_names[op.mnemonic]].bank == "pipe"
                assert machine.slots[slot] in ("any", "fma" if fma else "aux")
                if isinstance(op.dst, Register):
                    assert op.dst.bank == ("AB"[slot] if fma else "C")
        assert [b.halt for b in region.bundles].index(True) == len(region.bundles) - 1


def check_timing(program, machine):
    """Reported issue cycles keep every rule, looked at pair by pair instead of cycle by cycle."""
    bundles = program.regions[0].bundles
    issues = machine.issue_cycles(bundles)
    events = [
        (issue.cycle, op)
        for issue, bundle in zip(issues, bundles, strict=True)
        for op in bundle.operations
    ]
    writes = [
        (cycle + machine.latency(op)) for cycle, op in events if op.dst and machine.writes_port(op)
    ]
    assert len(writes) == len(set(writes))
    for i, (first, earlier) in enumerate(events):
        ready = first + machine.latency(earlier) + 1
        for second, later in events[i + 1 :]:
            if second == first:
                continue
            if earlier.dst is not None and not isinstance(earlier.dst, Output):
                assert earlier.dst not in (later.dst, *sources(later)) or second >= ready
            if {earlier.mnemonic, later.mnemonic} <= {"fsin", "fcos"}:
                assert second - first >= machine.unit(earlier).interval


@pytest.mark.parametrize("configuration", MACHINES)
@pytest.mark.parametrize("seed", SEEDS)
def test_scheduled_program__computes_what_was_written(seed, configuration):
    machine = MACHINES[configuration]
    program = program_of(seed, configuration)
    written = run_written(program)
    operations = set(program.regions[0].operations)
    schedule_program(program, machine, EFFORT)
    planned = machine.run_cycles(program.regions[0].bundles)
    assert set(operations_of(program)) == operations
    assert len(list(operations_of(program))) == len(operations)
    allocate_registers(program, machine)
    assert run_bundles(program, len(program.data)) == written
    assert machine.run_cycles(program.regions[0].bundles) == planned
    check_legal(program, machine)
    check_timing(program, machine)


@pytest.mark.parametrize("configuration", MACHINES)
@pytest.mark.parametrize("seed", SEEDS)
def test_order_as_written__computes_what_was_written(seed, configuration):
    machine = MACHINES[configuration]
    program = program_of(seed, configuration)
    written = run_written(program)
    operations = list(program.regions[0].operations)
    bundle_in_order(program, machine)
    assert list(operations_of(program)) == operations
    allocate_registers(program, machine)
    assert run_bundles(program, len(program.data)) == written
    check_legal(program, machine)


def test_schedule__takes_the_planned_cycles_when_the_core_issues_it(monkeypatch):
    planned = []

    def recorded(problem, *given):
        times = search.search(problem, *given)
        planned.append(search.length(problem, times))
        return times

    monkeypatch.setattr(schedule, "search", recorded)
    for seed in SEEDS:
        program = program_of(seed, "fast")
        schedule_program(program, FAST, 10)
        assert FAST.drain_cycle(program.regions[0].bundles) <= planned[-1]


def looped(number, rounds):
    """Text of a loop whose body is random: values of the round before, loads and stores."""
    rng = random.Random(f"loop {number}")
    rows = [".config stream", ".param x = 0.75", ".watchdog 90000", ".space words, 16"]
    rows += [".output y, safe = 0", *(f"fmul {name}, x, 1.5" for name in "pq"), f"loop {rounds}"]
    for i in range(count := rng.randrange(6, 16)):
        rows += [f"ld word{i}, words+{i}", f"fmadd sum{i}, word{i}, x, 0.5"]
        rows += [f"fsat near{i}, sum{i}, -9.0, 9.0", f"fnmsub left{i}, near{i}, 0.5, word{i}"]
        rows += [f"fabs size{i}, left{i}", f"st size{i}, words+{i}"]
    for name in "pq":
        for i in rng.sample(range(count), count // 2):
            rows += [f"fmadd {name}, left{i}, {rng.choice('pq')}, {name}"]
    return "\n".join([*rows, "endloop", "fadd u, p, q", "fabs y, u", "halt", ""])


def round_of(number, folder):
    """Cycles that a further round of `looped` takes."""
    cycles = []
    for rounds in (51, 151):
        path = folder / "loop.s"
        path.write_text(looped(number, rounds), encoding="utf-8")
        cycles.append(assemble(path).cycles)
    return (cycles[1] - cycles[0]) / 100


def test_body_of_a_loop__takes_the_planned_cycles_a_round_and_fewer_than_as_a_straight_part(
    monkeypatch, tmp_path
):
    planned = []

    def recorded(problem, *given):
        times = search.search(problem, *given)
        if problem.around is not None:
            planned.append(search.round_cycles(problem, times))
            assert planned[-1] >= search.round_bound(problem)
        return times

    monkeypatch.setattr(schedule, "search", recorded)
    rounds = [round_of(number, tmp_path) for number in range(8)]
    assert all(cycles <= plan for cycles, plan in zip(rounds, planned[::2], strict=True))
    monkeypatch.setattr(schedule, "edges_around", lambda *given: None)
    straight = [round_of(number, tmp_path) for number in range(8)]
    assert sum(rounds) + 2 * len(rounds) <= sum(straight)


def test_nops__stand_only_where_an_early_issue_would_cost_cycles_at_the_write_port(monkeypatch):
    """A division planned one cycle late keeps the port free for a move at the end of a chain."""
    step = FAST.units["fma"].latency + 1
    ahead = FAST.units["divsqrt"].latency - FAST.units["cmp"].latency
    links = ahead // step + 1
    # One operation of another length where the collision would meet a link of the chain.
    turns = [] if ahead % step else [links * step]
    move = links * step + len(turns) * (FAST.units["cmp"].latency + 1)
    collision = move - ahead
    build = Builder()
    value = K0
    for _ in range(links):
        value = build.op("fmul", value, K1)
    for _ in turns:
        value = build.op("fabs", value)
    for _ in range(collision - 1):
        build.op("fadd", K0, K1)
    build.op("fdiv", K0, K1)
    build.op("fmul", build.op("mov", value), K1)
    last = move + FAST.units["cmp"].latency + 1
    chain = [link * step for link in range(links)]
    times = [*chain, *turns, *range(1, collision), collision + 1, move, last]
    monkeypatch.setattr(schedule, "search", lambda *given: times)
    schedule_program(build.program, FAST)
    bundles = build.program.regions[0].bundles
    nops = [i for i, bundle in enumerate(bundles) if not any(bundle.slots)]
    assert nops == [collision]
    issues = FAST.issue_cycles(bundles)
    assert issues[-1].cycle == last
    without = [bundle for bundle in bundles if any(bundle.slots)]
    assert FAST.issue_cycles(without)[-1].cycle == last + 1


@pytest.mark.parametrize("configuration", MACHINES)
@pytest.mark.parametrize(
    "name", ["tracking_as_printed.s", "tracking_optimised.s", "tracking_observer.s"]
)
def test_controller_programs__are_within_8_percent_of_the_lower_bound(name, configuration):
    machine = MACHINES[configuration]
    program = parse_program(PROGRAMS / name, configuration=configuration)
    written = run_written(program)
    words = len(program.data)
    arrange(program, machine)
    section = report_program(program, machine).sections[0]
    assert section.distance <= 8.0
    assert section.stalls["waw"] == 0
    assert len(program.data) == words, "no value needs data memory"
    assert all(any(bundle.slots) for bundle in program.regions[0].bundles)
    assert run_bundles(program, words) == written


def test_same_input__gives_the_same_bundles():
    layouts = []
    for _ in range(2):
        program = random_program(3, 100)
        position = {op: i for i, op in enumerate(program.regions[0].operations)}
        schedule_program(program, FAST, EFFORT)
        layouts.append(
            [[position.get(op) for op in bundle.slots] for bundle in program.regions[0].bundles]
        )
    assert layouts[0] == layouts[1]


def test_effort__bounds_the_schedules_tried(monkeypatch):
    placed = []
    place = search.place
    monkeypatch.setattr(search, "place", lambda *given: placed.append(1) or place(*given))
    # An unreachable bound keeps the search from ending early.
    monkeypatch.setattr(search, "lower_bound", lambda problem: 0)
    program = random_program(1, 60)
    seen, tried = [], []
    improve = search._Search._improve

    def improved(self, times):
        found = improve(self, times)
        tried.append(self.tried)
        return found

    monkeypatch.setattr(search._Search, "_improve", improved)
    schedule_program(program, FAST, 100, seen.append)
    assert tried[-1] == 100  # those that came back are not placed again
    assert 20 < len(placed) <= 100
    assert [progress.tried for progress in seen] == sorted({progress.tried for progress in seen})
    assert {(progress.effort, progress.bound) for progress in seen} == {(100, 0)}


def tried_by(program):
    """Schedules tried, as the progress last stated."""
    seen = [0]
    schedule_program(program, FAST, progress=lambda p: seen.append(p.tried))
    return seen[-1]


def test_search__one_cycle_above_a_bound_that_cannot_be_reached__gives_up_soon(monkeypatch):
    path = PROGRAMS / "planner_scurve.s"
    best = search.lower_bound
    monkeypatch.setattr(search, "lower_bound", lambda problem: best(problem) - 1)
    tried = tried_by(parse_program(path))
    assert 0 < tried <= search.PATIENCE + 100
    monkeypatch.setattr(search, "PATIENCE", 10**9)
    assert tried_by(parse_program(path)) > schedule.DEFAULT_EFFORT - 10


def test_search__large_program__shares_its_placements_among_the_operations(monkeypatch):
    monkeypatch.setattr(schedule, "PLACEMENTS", 5000)
    monkeypatch.setattr(search, "PATIENCE", 10**9)
    program = parse_program(PROGRAMS / "tracking_optimised.s")
    assert tried_by(program) <= 5000 // len(program.regions[0].operations)


def test_blocking_unit__three_hundred_operations__issue_as_early_as_the_unit_allows(tmp_path):
    source = tmp_path / "x.s"
    rows = "".join(f" fsqrt r{i}, x\n" for i in range(300))
    source.write_text(f".input x\n.output F, safe = 0.0\n{rows} mov F, r299\n halt\n")
    program, machine = parse_program(source), MACHINES["small"]
    schedule_program(program, machine)
    bundles = program.regions[0].bundles
    roots = [
        issue.cycle
        for issue, bundle in zip(machine.issue_cycles(bundles), bundles, strict=True)
        if any(op.mnemonic == "fsqrt" for op in bundle.operations)
    ]
    interval = machine.units[machine.unit_names["fsqrt"]].interval
    assert roots == [interval * i for i in range(300)]


def test_more_effort__is_never_worse():
    lengths = []
    for effort in (2, 50, 400):
        program = random_program(250013, 250)
        schedule_program(program, FAST, effort)
        lengths.append(FAST.run_cycles(program.regions[0].bundles))
    assert lengths == sorted(lengths, reverse=True)


def test_state__is_overwritten_no_earlier_than_its_last_reader():
    build = Builder()
    state = build.state("s")
    slow = build.op("fsqrt", K0)
    build.output("fsat", state, slow, K1)
    build.write_state("s", "mov", K0)
    program = build.program
    written = run_written(program)
    arrange(program, FAST)
    assert run_bundles(program, 0) == written


@pytest.mark.parametrize(("pin", "slot"), [("A", 0), ("B", 1)])
def test_pinned_states__are_written_by_their_pipe(pin, slot):
    build = Builder()
    for i in range(4):
        build.state(f"s{i}", pin=pin)
        build.write_state(f"s{i}", "fmul", K0, K1)
    arrange(build.program, FAST)
    assert {state.register.bank for state in build.program.states} == {pin}
    bundles = build.program.regions[0].bundles
    assert [bundle.slots[slot] is not None for bundle in bundles] == [True] * 4


def test_impossible_pin__is_refused_with_line_and_reason():
    build = Builder()
    build.state("s", pin="B")
    build.write_state("s", "mov", K0)
    build.region.operations[-1].source = SourceLine("law.s", 7, "mov s, x")
    with pytest.raises(ScheduleError, match=r"law\.s:7: mov: the writes of 's' cannot .* bank B"):
        schedule_program(build.program, FAST)


def test_symbol_written_by_different_units__is_refused():
    build = Builder()
    build.op("fmul", K0, K1, name="t", version=-1)
    build.op("mov", K0, name="t", version=-1)
    with pytest.raises(ScheduleError, match="the writes of 't' cannot all go to one bank"):
        schedule_program(build.program, FAST)


def test_multiply_add_to_an_output__is_refused():
    build = Builder()
    build.output("fmul", K0, K1)
    with pytest.raises(ScheduleError, match="fmul: no slot .* in an output"):
        schedule_program(build.program, FAST)


def test_bank_b_in_the_small_configuration__is_refused():
    build = Builder("small")
    build.emit("fmul", Register("B", 0), K0, K1)
    with pytest.raises(ScheduleError, match="configuration 'small' .* bank B"):
        schedule_program(build.program, MACHINES["small"])


def test_braced_bundles__stay_as_they_are():
    late = Bundle([None, None, Operation("mov", Virtual("x", 1), K0)])
    early = Bundle([Operation("fmul", Virtual("y", 1), K0, K1), None, None])
    program = Program(regions=[Region(bundles=[late, early], halt=True)])
    schedule_program(program, FAST)
    assert program.regions[0].bundles == [late, early]


@pytest.mark.parametrize("first", range(8))
def test_branches__compute_what_was_written(first):
    """Different constants take the loop and the branch in different ways."""
    program = loop_program()
    for region in program.regions:
        for op in region.operations:
            for name in ("a", "b", "c"):
                value = getattr(op, name)
                if isinstance(value, Register) and value.bank == "K":
                    setattr(op, name, Register("K", value.index + 2 * first))
    written = run_written(copy.deepcopy(program))
    schedule_program(program, FAST)
    for region in program.regions:
        branches = [
            i
            for i, bundle in enumerate(region.bundles)
            for op in bundle.operations
            if op.mnemonic in ("bz", "bnz", "jmp")
        ]
        assert branches in ([], [len(region.bundles) - 1])
    allocate_registers(program, FAST)
    assert run_bundles(program, 1) == written


def test_state_of_a_program_with_branches__keeps_one_register_in_its_pinned_bank():
    """Such a state is one variable: first and last value are the same symbol."""
    total = Virtual("total", -1)
    program = loop_program()
    program.states.append(State("total", "float", 0, total, total, pin="B"))
    for region in program.regions[1:3]:
        region.operations.insert(0, Operation("fadd", total, total, c=K0))
    written = run_written(copy.deepcopy(program))
    arrange(program, FAST)
    assert program.states[-1].register.bank == "B"
    assert run_bundles(program, 1) == written


def test_empty_halting_program__is_one_bundle_of_nops():
    program = Program(regions=[Region(halt=True)])
    schedule_program(program, FAST)
    assert [(b.slots, b.halt) for b in program.regions[0].bundles] == [([None] * 3, True)]


def test_loads_are_delayed__and_the_schedule_is_as_long():
    machine, build = FAST, Builder()
    loads = [build.op("ld", imm=i) for i in range(12)]
    total = build.op("fmul", loads[0], loads[1])
    for value in loads[2:]:
        total = build.op("fmadd", total, value, value)
    graph = build_graph(build.region.operations, machine)
    problem = search.build_problem(graph, machine)
    early = search.place(problem, range(len(build.region.operations)), True)
    late = search.delay_loads(problem, early)
    assert search.length(problem, late) == search.length(problem, early)
    assert set(late) <= set(early)
    assert all(b >= a for a, b in zip(early, late, strict=True))
    assert sum(late) > sum(early)
    for i, edges in enumerate(graph.successors):
        assert all(late[j] >= late[i] + distance for j, distance in edges)
    lanes = Counter(zip(problem.lane, late, strict=True))
    assert all(count <= problem.lanes[lane] for (lane, _), count in lanes.items())
    writes = [t + graph.latency[i] for i, t in enumerate(late) if problem.port[i]]
    assert len(writes) == len(set(writes))
