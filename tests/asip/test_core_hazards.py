# SPDX-License-Identifier: Apache-2.0
"""Hazards: every producer against every reader and writer at every distance.

Words must be those of the instruction-set model and every bundle must issue in the cycle that the
machine description gives. `distance` counts bundles from the producer to the operation under test;
what is between them depends on nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import pytest

from asip_asm.ir import Operation
from tests.asip import core_bench as bench
from tests.asip.core_bench import CONFIGURATIONS, EMPTY, HALT, CoreRun, machine, op

# Registers 5 are under test in every bank. All words are positive, distinct, with finite results.
REGISTERS = {
    "k0": 0x40200000,  # 2.5
    "k1": 0x3FA00000,  # 1.25
    "k2": 0x3F400000,  # 0.75
    "k3": 3,
    "k4": 0x40E00000,  # 7.0
    "k5": 0x3E000000,  # 0.125, where a wrong bank is read
    "a5": 0x42280000,
    "c5": 0x42AA0000,
    "c6": 0,
}
DATA = [0x3F800000 + 0x100000 * i for i in range(16)]

# Producer -> (operation writing register 5, its value is an integer that can index data memory).
AUXILIARY: dict[str, tuple[Operation, bool]] = {
    "fdiv": (op("fdiv", "c5", "k0", "k1"), False),
    "fsqrt": (op("fsqrt", "c5", "k0"), False),
    "cmp": (op("fmax", "c5", "k0", "k1"), False),
    "iadd": (op("iadd", "c5", "k3", "k3"), True),
    "i2f": (op("i2f", "c5", "k3"), False),
    "f2i": (op("f2i", "c5", "k0"), True),
    "sincos": (op("fsin", "c5", "k2"), False),
    "load": (op("ld", "c5", "zero", imm=3), False),
}
PIPES = {
    "pipe0": (op("fmadd", "a5", "k0", "k1", "k2"), False),
    "pipe1": (op("fmadd", "b5", "k0", "k1", "k2"), False),
}


def producers(configuration: str) -> dict[str, tuple[Operation, bool]]:
    """Producers that the configuration has."""
    pipes = dict(PIPES)
    if configuration == "small":
        del pipes["pipe1"]
    return pipes | AUXILIARY


def registers(configuration: str) -> dict[str, int]:
    """Preset registers that the configuration has."""
    return REGISTERS | ({"b5": 0x42F00000} if configuration == "fast" else {})


def consumers(configuration: str, source: str, integer: bool) -> dict[str, list[Operation]]:
    """Operations of one bundle that read `source`, every operand position of every slot."""
    found = {
        "fma a": [op("fmadd", "a9", source, "k1", "k2")],
        "fma b": [op("fmadd", "a9", "k1", source, "k2")],
        "fma c": [op("fmadd", "a9", "k1", "k2", source)],
        "fma abc": [op("fmadd", "a9", source, source, source)],
        "aux a": [op("sel", "c9", source, "k1", "k2")],
        "aux b": [op("sel", "c9", "k0", source, "k2")],
        "aux c": [op("sel", "c9", "zero", "k2", source)],
        "div b": [op("fdiv", "c9", "k0", source)],
        "sin": [op("fcos", "c9", source)],
        "i2f": [op("i2f", "c9", source)],
        "output": [op("i2f", "o0", source)],
        "store": [op("st", source, "zero", imm=2)],
        "branch": [op("bz", source, target="end")],
    }
    if integer:
        found["load index"] = [op("ld", "c9", source, imm=1)]
        found["store index"] = [op("st", "k0", source, imm=1)]
    if configuration == "fast":
        found["fma1 a"] = [op("fmadd", "b9", source, "k1", "k2")]
        found["fma1 b"] = [op("fmadd", "b9", "k1", source, "k2")]
        found["fma1 c"] = [op("fmadd", "b9", "k1", "k2", source)]
        found["all slots"] = [*found["fma b"], *found["fma1 c"], *found["aux b"]]
    return found


def fillers(count: int) -> list[Operation]:
    """Bundles between producer and consumer; their writes are far enough apart not to wait."""
    return [op("fmadd", f"a{20 + i % 40}", "k0", "k1", "k4") for i in range(count)]


def destination(producer: Operation) -> str:
    return f"{producer.dst.bank.lower()}{producer.dst.index}"


def latency(configuration: str, operation: Operation) -> int:
    return machine(configuration).latency(operation)


def verify(
    configuration: str,
    bundles: Sequence[bench.Item],
    where: str,
    labels: Mapping[str, int] = {},
    timing: bool = True,
) -> CoreRun:
    """`bench.verify` of the bundles with the preset registers and data."""
    preset = registers(configuration)
    program = bench.image(configuration, bundles, preset, data=DATA, labels=labels)
    return bench.verify(program, where, timing=timing)


CASES = [(c, name) for c in CONFIGURATIONS for name in producers(c)]
DEPTHS = [False, pytest.param(True, marks=pytest.mark.full)]


def distances(ranks: int, beyond: int, every: bool) -> list[int]:
    """Bundles from the producer, 1 to `ranks` + `beyond`; the short set takes those at either end.

    In between nothing but the length of the wait changes.
    """
    return [d for d in range(1, ranks + beyond + 1) if every or d <= 2 or d >= ranks - 1]


@pytest.mark.parametrize("every", DEPTHS)
@pytest.mark.parametrize(("configuration", "name"), CASES)
def test_read_after_write__any_distance__waits_for_the_result_only(configuration, name, every):
    producer, integer = producers(configuration)[name]
    ranks = latency(configuration, producer)
    for consumer, operations in consumers(configuration, destination(producer), integer).items():
        for distance in distances(ranks, 4, every):
            bundles = [
                producer,
                *fillers(distance - 1),
                operations,
                # what was stored is read back
                op("ld", "c10", "zero", imm=2),
                HALT,
            ]
            got = verify(
                configuration,
                bundles,
                f"{name} -> {consumer}, {distance} on",
                labels={"end": distance + 2},
                timing=consumer != "branch",
            )
            due = max(distance, ranks + 1)
            assert got.issued[distance] == (due, distance)


@pytest.mark.parametrize(("configuration", "name"), CASES)
def test_write_after_write__any_distance__last_write_stays(configuration, name):
    first, _ = producers(configuration)[name]
    for other, (second, _) in producers(configuration).items():
        if destination(second) != destination(first):
            continue
        for distance in range(1, latency(configuration, first) + 4):
            last = op("mov", "c9", destination(first))
            bundles = [first, *fillers(distance - 1), second, last, HALT]
            where = f"{name} then {other} to the same register, {distance} on"
            got = verify(configuration, bundles, where)
            assert got.issue_cycles[distance] == max(distance, latency(configuration, first) + 1)
            assert got.writes["c9"][-1] == got.writes[destination(first)][-1]


@pytest.mark.parametrize(("configuration", "name"), CASES)
def test_write_after_read__next_bundle_or_same__old_value_is_read(configuration, name):
    writer, integer = producers(configuration)[name]
    source = destination(writer)
    for consumer, operations in consumers(configuration, source, integer=False).items():
        if consumer == "branch":
            continue
        bundles = [operations, writer]
        slots = [bench.is_fma(o.mnemonic) and o.dst.bank for o in (*operations, writer)]
        if configuration == "fast" and len(set(slots)) == len(slots):
            bundles = [(*operations, writer)]
        verify(configuration, [*bundles, HALT], f"{consumer} reads what {name} writes")


@pytest.mark.parametrize("name", AUXILIARY)
def test_write_port__second_result_due_in_the_same_cycle__waits_one_cycle(configuration, name):
    first, _ = AUXILIARY[name]
    ranks = {each: latency(configuration, producer) for each, (producer, _) in AUXILIARY.items()}
    waited = set()
    for other, (second, _) in AUXILIARY.items():
        for to in ("c6", "o0"):
            if to == "o0" and other in ("iadd", "f2i"):
                continue
            following = replace(second, dst=op("mov", to, "zero").dst)
            reader = (op("fmul", "a7", "c5", "c6"), HALT)
            for distance in range(1, ranks[name] + 3):
                bundles = [first, *fillers(distance - 1), following, reader]
                where = f"{name} and {other} to {to}, {distance} on"
                got = verify(configuration, bundles, where)
                if ranks[name] == distance + ranks[other] and other != "sincos":
                    waited.add(other)
                    assert got.stalls["STALL_PORT"] >= 1
    shorter = {other for other in AUXILIARY if ranks[other] < ranks[name]}
    assert waited >= shorter - {"sincos"}, "the collision was never met"


def test_write_port__queue_of_collisions__every_result_arrives(configuration):
    # divisions as close as the unit takes them: the write port is taken at once or again and again;
    # shorter operations want the same cycles
    interval = divsqrt_interval(configuration)
    body = [op("fdiv", f"c{10 + i}", "k0", "k1") for i in range(6 if interval == 1 else 2)]
    bundles: list[bench.Item] = []
    for i, division in enumerate(body):
        bundles += [EMPTY] * (i * interval - len(bundles))
        bundles.append(division)
    short = [
        op("ld", "c20", "k3", imm=0),
        op("i2f", "c21", "k3"),
        op("mov", "c22", "k0"),
        op("mov", "c23", "k1"),
    ]
    for i, operation in enumerate(short[: 4 if interval == 1 else len(body)]):
        # the one before waited, so that this one would issue a cycle later than it is placed
        ahead = latency(configuration, body[0]) - latency(configuration, operation)
        bundles += [EMPTY] * (ahead + i * (interval - 1) - len(bundles))
        bundles.append(operation)
    got = verify(configuration, [*bundles, HALT], "queue")
    assert got.stalls["STALL_PORT"] >= len(body)


def divsqrt_interval(configuration: str) -> int:
    """Cycles from one division or root to the next."""
    return machine(configuration).units["divsqrt"].interval


@pytest.mark.parametrize("target", ["c6", "o0"])
def test_divsqrt__next_at_any_distance__waits_for_its_turn(configuration, target):
    first, second = op("fdiv", "c5", "k0", "k1"), op("fsqrt", target, "k4")
    interval = divsqrt_interval(configuration)
    for distance in range(1, interval + 4):
        more = [op("fdiv", "c7", "k1", "k0"), op("fsqrt", "c8", "k0"), HALT]
        bundles = [first, *fillers(distance - 1), second, *more]
        got = verify(configuration, bundles, f"division and root, {distance} on")
        begin = max(distance, interval)
        turns = [begin + i * interval for i in range(3)]
        assert got.issue_cycles[distance : distance + 3] == turns
        assert got.stalls["STALL_UNIT"] == begin - distance + 2 * (interval - 1)


def test_sincos__next_at_any_distance__waits_for_the_unit(configuration):
    sine, cosine = op("fsin", "c5", "k2"), op("fcos", "c6", "k0")
    interval = machine(configuration).units["sincos"].interval
    for distance in range(1, interval + 4):
        bundles = [sine, *fillers(distance - 1), cosine, op("fsin", "c7", "k1"), HALT]
        got = verify(configuration, bundles, f"sine and cosine, {distance} on")
        second = max(distance, interval)
        assert got.issue_cycles[distance : distance + 2] == [second, second + interval]
        assert got.stalls["STALL_UNIT"] == second - distance + interval - 1


def test_memory__load_at_any_distance_from_a_store__reads_the_stored_word(configuration):
    for distance in range(1, 6):
        bundles = [
            op("st", "k0", "zero", imm=4),
            *fillers(distance - 1),
            op("ld", "c5", "zero", imm=4),
            op("st", "k1", "zero", imm=4),
            (op("ld", "c6", "zero", imm=4), HALT),
        ]
        got = verify(configuration, bundles, f"load {distance} on")
        assert [got.writes[name] for name in ("c5", "c6")] == [[REGISTERS["k0"]], [REGISTERS["k1"]]]


def test_three_banks__results_in_one_cycle_or_near__each_reader_gets_its_own():
    pipes = [op("fmul", "a5", "k0", "k1"), op("fmul", "b5", "k0", "k2")]
    ranks = latency("fast", pipes[0])
    readers = [
        [op("fmadd", "a9", "a5", "b5", "c5"), op("fmadd", "b9", "b5", "c5", "a5")],
        [op("fmadd", "a9", "c5", "a5", "b5"), op("fmadd", "b9", "a5", "b5", "c5")],
        [op("fmadd", "a9", "b5", "c5", "a5"), op("fmadd", "b9", "c5", "a5", "b5")],
    ]
    auxiliary = [op("sel", "c9", *order) for order in (("a5", "b5", "c5"), ("zero", "b5", "a5"))]
    for name, (third, _) in AUXILIARY.items():
        for lead in range(-3, 4):  # cycles that the auxiliary result comes before the others
            start = ranks - latency("fast", third) - lead
            gap = abs(start) - 1
            early, late = [third], [pipes]
            if start > 0:
                early, late = late, early
            bundles = [*early, *[EMPTY] * gap, *late]
            if start == 0:
                bundles = [(*pipes, third)]
            for reader in readers:
                for select in auxiliary:
                    last = (*reader, select, HALT)
                    verify("fast", [*bundles, last], f"pipes and {name}, {lead} earlier")
