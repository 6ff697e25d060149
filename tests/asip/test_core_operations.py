# SPDX-License-Identifier: Apache-2.0
"""Every operation through the core on corner operands against the instruction-set model."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from asip_asm.image import InputEntry
from sim.core.iss import Fault, Iss, arithmetic
from sim.rtl.asip_bus import BLOCK, STATUS, register_address
from tests.asip import core_bench as bench
from tests.asip.core_bench import CORNERS, HALT, ISA, op

# All pairs of corners for two operands; triples of these for three.
TRIPLES = (
    *(0x00000000, 0x80000000, 0x00000001, 0x80800000, 0x3F800000, 0xBF800001, 0x40490FDB),
    *(0x7F7FFFFF, 0x7F800000, 0xFF800000, 0x7FC00000, 0xFF800001),
)
ELSEWHERE = {"nop", "jmp", "bz", "bnz", "st", "ld", "seek", "loop"}
ELSEWHERE |= {op.name for op in ISA.of_unit("lanes")}
WRITING = [name for name in ISA.operations if name not in ELSEWHERE]
SINES = ("fsin", "fcos")


def operand_rows(mnemonic: str) -> list[tuple[int, ...]]:
    """Operand words of every run."""
    operands = len(ISA.operations[mnemonic].sources)
    if mnemonic in SINES:
        rng = np.random.default_rng(1)
        angles = np.concatenate((rng.uniform(-256, 256, 300), 10.0 ** rng.uniform(-30, 0, 100)))
        return [(word,) for word in (*CORNERS, *angles.astype(np.float32).view(np.uint32).tolist())]
    values = TRIPLES if operands == 3 else CORNERS
    return list(itertools.product(values, repeat=operands))


@pytest.mark.parametrize("mnemonic", WRITING)
def test_operation__corner_operands__result_and_flags_of_the_model(mnemonic, configuration):
    names = ("k0", "k1", "k2")[: len(ISA.operations[mnemonic].sources)]
    pipes = ("a7", "b7") if bench.is_fma(mnemonic) and configuration == "fast" else ("a7",)
    destinations = pipes if bench.is_fma(mnemonic) else ("c7",)
    body = [op(mnemonic, destination, *names) for destination in destinations]
    program = bench.image(configuration, [(*body, HALT)], outputs=0)
    rows = operand_rows(mnemonic)
    dut = bench.load(program)
    got = dut.run(
        [BLOCK["constants"] + i for i in range(len(names))],
        np.array(rows, dtype=np.uint32),
        [register_address(name) for name in destinations],
    )
    assert got.fault == "NONE" and len(got.status) == len(rows)
    inputs = [InputEntry(name, index, "int") for index, name in enumerate(names)]
    model = Iss(bench.image(configuration, program.bundles, outputs=0, inputs=inputs).to_json())
    tolerance = 1 if mnemonic in SINES else 0  # sine and cosine: faithful, the model is rounded
    for row, words, status in zip(rows, got.words.tolist(), got.status.tolist(), strict=True):
        model.set_inputs(dict(zip(names, row, strict=True)))
        want = model.run()
        assert want.fault is Fault.NONE
        case = f"{mnemonic} {' '.join(bench.texts(row))}"
        for name, word in zip(destinations, words, strict=True):
            right = model.read_bits(name)
            assert bench.ulps(word, right) <= tolerance, f"{case}: {word:08x}, want {right:08x}"
        flags = STATUS["flags"].of(status)
        assert flags == want.flags, f"{case}: flags {flags:05b}, want {want.flags:05b}"


@pytest.mark.parametrize("mnemonic", ["bz", "bnz"])
def test_branch__any_operand__goes_where_the_model_goes(mnemonic, configuration):
    for word in CORNERS:
        program = bench.image(
            configuration,
            [
                op(mnemonic, "k0", target="there"),
                op("mov", "c0", "k0"),
                (op("mov", "c1", "k0"), HALT),
            ],
            {"k0": word},
            outputs=0,
            labels={"there": 2},
        )
        got = bench.verify(program, f"{mnemonic} {word:08x}", timing=False)
        taken = (word & 0x7FFFFFFF == 0) == (mnemonic == "bz")
        assert got.bundle_order == ([0, 2] if taken else [0, 1, 2])
        # decided in E1, three cycles after issue, redirected in E2; a taken branch fetches again
        there = 4 + bench.REDIRECT
        assert got.issue_cycles == ([0, there] if taken else [0, 5, 6])
        assert got.stalls["STALL_FETCH"] == (there - 1 if taken else 4)


def test_memory__every_address_form__loads_what_was_stored(configuration):
    # index + immediate as 32-bit integers: -1 + 1 = 0, the last word both ways
    forms = [
        (0, 0),
        (1023, 0),
        (0, 1023),
        (0xFFFFFFFF, 1),
        (0xFFFF8000, 0x8000),
        (0xFFFFFC00, 2047),
    ]
    bundles, registers = [], {}
    for i, (index, imm) in enumerate(forms):
        registers |= {f"k{2 * i}": index, f"k{2 * i + 1}": 0x40000000 + i}
        bundles += [
            op("st", f"k{2 * i + 1}", f"k{2 * i}", imm=imm),
            op("ld", f"c{i}", f"k{2 * i}", imm=imm),
        ]
    bundles.append(HALT)
    program = bench.image(configuration, bundles, registers, outputs=0, data=[0] * 1024)
    got = bench.verify(program)
    assert [got.writes[f"c{i}"] for i in range(len(forms))] == [
        [0x40000000 + i] for i in range(len(forms))
    ]
    model, _ = bench.iss_run(program)
    dut = bench.core(configuration)
    for address in range(1024):
        assert dut.read(BLOCK["data"] + address) == model.read_data(address)


@pytest.mark.parametrize(
    ("bank", "configuration"), [*((b, "fast") for b in "abck"), *((b, "small") for b in "ack")]
)
def test_register__every_one_of_a_bank__reaches_every_operand_of_every_slot(bank, configuration):
    size = ISA.banks[bank.upper()].size
    one = "k127" if bank == "k" else "k0"
    values = {f"{bank}{i}": 0x3F900000 + 0x1234 * i for i in range(size)} | {one: 0x3F800000}
    bundles = []
    for i in range(size):
        source, to = f"{bank}{i}", i % 64
        # each gives the word itself: a bank under test keeps its words while it is written
        for pipe, aux in (
            (("fmul", source, one), ("mov", source)),
            (("fmul", one, source), ("sel", one, source, "zero")),
            (("fmadd", "zero", "zero", source), ("sel", "zero", one, source)),
        ):
            operations = [op(pipe[0], f"a{to}", *pipe[1:]), op(aux[0], f"c{to}", *aux[1:])]
            if configuration == "fast":
                operations.append(op(pipe[0], f"b{to}", *pipe[1:]))
                bundles.append(operations)
            else:
                bundles += operations
    bundles.append(HALT)
    got = bench.verify(bench.image(configuration, bundles, values, outputs=0))
    assert {name: words[-1] for name, words in got.writes.items() if name[0] == "c"} == {
        f"c{i % 64}": values[f"{bank}{i}"] for i in range(size)
    }


@pytest.mark.parametrize("optimise", [False, True])
def test_assembled_source__linear__words_and_flags_of_the_model(configuration, optimise):
    program = bench.assembled(
        """
        .input p, q
        .state total = 0.5
        .output F, safe = 9.0
                fmul  t, p, q
                fmadd u, t, t, 1.0
                fsqrt r, u
                fdiv  d, t, r
                fsin  s, d
                fcos  c, d
                fmadd total, s, c, total
                fsat  F, total, -1.0, 1.0
                halt
        """,
        configuration,
        optimise,
    )
    dut = bench.load(program)
    rows = np.array([(0.5, 3.0), (-7.25, 0.1), (1e20, -1e-3)], dtype=np.float32)
    got = dut.run(dut.input_addresses(["p", "q"]), rows.view(np.uint32), [BLOCK["outputs"]])
    model = Iss(program.to_json(), sincos=bench.rtl_sincos)
    for row, words, status in zip(
        rows.tolist(), got.words.tolist(), got.status.tolist(), strict=True
    ):
        model.set_inputs({"p": row[0], "q": row[1]})
        want = model.run()
        assert [words, STATUS["flags"].of(status)] == [[want.output_bits["F"]], want.flags]
    assert arithmetic.NX & want.flags


def test_every_operation_is_tested_here():
    """Or in test_core_faults.py, test_streams.py, test_loops.py, test_lanes.py."""
    assert set(WRITING) | ELSEWHERE == set(ISA.operations)
