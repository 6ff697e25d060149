# SPDX-License-Identifier: Apache-2.0
"""The Nios II core against QEMU, instruction by instruction."""

from __future__ import annotations

from pathlib import Path

import pytest

from sim.rtl.n2_lockstep import LockstepError, lockstep, main
from sim.rtl.n2_lockstep_program import ISA, LabelledWords, prologue
from sim.rtl.n2_lockstep_rtl import DTCM, N2Rtl
from sim.rtl.nios_image import IMAGES
from tests.bench.needs import require
from tests.bench.seed import SEED
from tests.nios.n2_bench import core
from tests.nios.n2_programs import access_program, corner_program, random_program

RANDOM = 16
RANDOM_FULL = 1000
WAITS = 5
ELFS = sorted((IMAGES / "tests").glob("*.elf"))
# Compiled tests of more than a quarter of a million instructions.
LONG = ("parse_integer", "print_integer", "polynomial", "print_double", "double_arithmetic")


def run(program: LabelledWords, waits: int = 0):
    require("qemu")
    model = core()
    result = lockstep(model, program.image(), timeout=60, waits=waits)
    assert model.protocol_errors == 0
    return result


def run_random(seed: int) -> None:
    try:
        run(random_program(seed), waits=seed % WAITS)
    except LockstepError as error:
        pytest.fail(
            f"random_program({seed}): {error}\nreplay: make test T=random_program SEED={seed}"
        )


def test_arithmetic_and_branches__corner_operands__as_qemu():
    run(corner_program())


def test_loads_and_stores__every_alignment_and_memory__as_qemu():
    run(access_program(), waits=WAITS)


@pytest.mark.parametrize("number", range(RANDOM))
def test_random_program__seeded__as_qemu(number):
    run_random(SEED + number)


@pytest.mark.full
def test_random_program__campaign__as_qemu():
    for number in range(RANDOM_FULL):
        run_random(100_000 * SEED + number)


def test_start__model_that_ran_nothing__every_register_is_zero():
    """A register that the program never writes: 0 as in QEMU, on a fresh and a used model."""
    program = prologue()
    for register in range(1, 32):
        program.emit("add", 1, register, 0)
    program.end()
    require("qemu")
    model = N2Rtl({})
    for _ in range(2):
        lockstep(model, program.image(), timeout=60)


def test_control_registers__all_numbers__as_qemu():
    program = prologue()
    for number in range(32):
        program.emit("rdctl", 2, number)
        program.emit("add", 3, 2, 2)
    program.li(2, 0x55AA_12FF)
    for number in (4, 5, 6, 7, 12, 13, 14, 15, 16, 31):
        program.emit("wrctl", number, 2)
        program.emit("rdctl", 3, number)
    run(program_end(program))


@pytest.mark.parametrize("name,register", [("eret", 29), ("bret", 30), ("ret", 31)])
def test_return__misaligned_target__as_qemu(name, register):
    program = prologue()
    program.la(register, "target")
    program.emit("addi", register, register, 2)
    program.emit(name)
    program.label("target")
    program.emit("addi", 7, 0, 1)
    run(program_end(program))


def program_end(program: LabelledWords) -> LabelledWords:
    program.end()
    return program


def test_random_programs__many_seeds__hold_every_instruction():
    """The random programs of one run execute every instruction that QEMU has."""
    seen = set()
    for number in range(RANDOM):
        for _, data in random_program(SEED + number).image()[:1]:
            words = [int.from_bytes(data[i : i + 4], "little") for i in range(0, len(data), 4)]
            seen |= {record.name for record in map(ISA.find, words) if record}
    assert set(ISA.instructions) - seen <= {"custom", "rdprs", "wrprs"}


def compiled(path: Path):
    marks = [pytest.mark.full] if path.stem in LONG else []
    return pytest.param(path, id=path.stem, marks=marks)


@pytest.mark.quick(
    "add_sub_wrap", "bits", "divide", "float_add", "multiply", "recursion", "switch_table"
)
@pytest.mark.parametrize("path", [compiled(path) for path in ELFS])
def test_compiled_program__committed_elf__as_qemu(path, capsys):
    require("qemu")
    assert main([str(path)]) == 0, capsys.readouterr().err


def test_command__no_elf_file__names_the_file(tmp_path, capsys):
    path = tmp_path / "text.elf"
    path.write_text("no program")
    assert main([str(path)]) == 1
    assert f"{path}: error: no little-endian 32-bit ELF file" in capsys.readouterr().err


def test_lockstep__custom_instruction__names_its_address():
    program = prologue()
    program.label("custom")
    program.emit("custom", 3, 2, 2, 2)
    message = f"custom instruction at {program.address('custom'):#010x}"
    with pytest.raises(LockstepError, match=message):
        run(program_end(program))


def test_lockstep__different_data__are_noticed():
    """The comparison sees one wrong bit of one loaded word."""
    require("qemu")

    class Wrong(N2Rtl):
        def load(self, address, data):
            super().load(address, b"\x0b" if address == DTCM else data)

    program = prologue()
    program.li(3, DTCM)
    program.emit("ldw", 2, 0, 3)
    program.data.append((DTCM, b"\x0a"))
    with pytest.raises(LockstepError, match="r2  core 0000000b  QEMU 0000000a"):
        lockstep(Wrong(), program_end(program).image())


def test_lockstep__core_that_stops__is_noticed():
    """Fewer instructions than QEMU's are no success."""
    require("qemu")

    class Short(N2Rtl):
        def run(self, *arguments, **options):
            return super().run(*arguments, **options)[:-1]

    with pytest.raises(LockstepError, match="the core stopped after"):
        lockstep(Short(), program_end(prologue()).image())
