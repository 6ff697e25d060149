# SPDX-License-Identifier: Apache-2.0
"""C driver against the Verilated core: the demonstration's words are those of the instruction-set
model, and every return code of the driver is reached (driver_checks.c)."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from asip_asm.assemble import assemble
from asip_asm.c_image import enumeration, identifier, to_c
from asip_asm.gen.asip_regmap import REGMAP
from sim.core.host import DRIVER, simulated_core
from sim.core.iss.core import Iss
from tests.asip.core_bench import CONFIGURATIONS, assembled
from tests.bench.commands import output

CHECKS = Path(__file__).with_name("driver_checks.c")
C_FLAGS = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O1")
CC = os.environ.get("CC", "cc")
ENDLESS = """\
.program "endless"
.watchdog 3000
.input n : int
.output F, safe = 1.5
again:  bnz n, again
        mov F, zero
        halt
"""
RECORD = """\
.program "record"
.input x
.output F, safe = 1.5
        mov F, x
        halt
"""

TABLE = """\
.program "table"
.input i : int
.data words = 1.0, 2.0, 3.0
.output F, safe = 1.5
        ld F, words[i]
        halt
"""


def build(
    folder: Path, configuration: str, main: Path, images: dict[str, str], resilience: int = 0
) -> Path:
    """Executable of a C program with the driver and the core; images: text by header name."""
    core = simulated_core(configuration, resilience)
    for name, text in images.items():
        (folder / name).write_text(text)
    program = folder / main.stem
    options = [*C_FLAGS, f"-I{DRIVER}", f"-I{folder}", f"-Wl,-rpath,{core.parent}"]
    output(CC, *options, "-o", program, main, DRIVER / "asip.c", core)
    return program


def execute(program: Path, *arguments: str) -> tuple[int, list[str]]:
    done = subprocess.run(
        [program, *arguments], capture_output=True, text=True, check=False, timeout=300
    )
    return done.returncode, (done.stdout + done.stderr).splitlines()


@pytest.fixture(scope="module", params=CONFIGURATIONS)
def demo(request, tmp_path_factory):
    """(executable, image) of the demonstration."""
    image = assemble(DRIVER / "leg_length.s", configuration=request.param)
    folder = tmp_path_factory.mktemp("demo")
    images = {"leg_length.asip.h": to_c(image)}
    return build(folder, request.param, DRIVER / "demo.c", images), image


def build_checks(folder: Path, configuration: str, resilience: int = 0) -> Path:
    """Executable of driver_checks.c."""
    (other,) = set(CONFIGURATIONS) - {configuration}
    texts = (ENDLESS, RECORD, TABLE)
    image, record, table = (assembled(text, configuration, optimise=True) for text in texts)
    wrong = assembled(ENDLESS, other, optimise=True)
    wrong.title = "other"
    images = {"endless": image, "other": wrong, "record": record, "table": table}
    headers = {f"{name}.asip.h": to_c(each) for name, each in images.items()}
    return build(folder, configuration, CHECKS, headers, resilience)


@pytest.fixture(scope="module", params=CONFIGURATIONS)
def checks(request, tmp_path_factory):
    """Checks on a core without redundancy."""
    return build_checks(tmp_path_factory.mktemp("checks"), request.param)


def model_rows(image, ticks) -> list[list[str]]:
    """Words of outputs and export of each tick, by the instruction-set model."""
    model = Iss(image.to_json())
    rows = []
    for x, y, z, counter in ticks:
        model.set_inputs({"x": x, "y": y, "z": z, "counter": counter})
        result = model.run()
        assert result.fault.name == "NONE"
        words = [result.output_bits[o.name] for o in image.outputs]
        rows.append([f"{word:08x}" for word in [*words, model.read_bits("square")]])
    return rows


def words(line: str) -> list[str]:
    """Words that a line of the demonstration shows."""
    return re.findall(r"0x([0-9a-f]{8})", line)


@pytest.mark.quick("fast")
def test_demo__several_ticks__words_of_the_model(demo):
    program, image = demo
    rng = np.random.default_rng(20)
    ticks = [
        (*map(float, rng.uniform(-2, 2, 3).astype(np.float32)), int(rng.integers(-(2**20), 2**20)))
        for _ in range(8)
    ]
    status, lines = execute(program, *(",".join(map(repr, tick)) for tick in ticks))
    assert status == 0 and all(line.startswith("done: ") for line in lines), lines
    assert [words(line) for line in lines] == model_rows(image, ticks), f"ticks {ticks} (seed 20)"
    assert all(int(line.split()[-1]) > 0 for line in lines)


def test_demo__nan_input__not_finite_and_safe_outputs__cleared__good_run(demo):
    program, image = demo
    good = (3.0, 0.5, 4.0, 7)
    status, lines = execute(program, "3,0.5,4,7", "nan,0,0,0", "3,0.5,4,7")
    assert status == 0 and len(lines) == 3
    want = model_rows(image, [good])[0]
    assert words(lines[0]) == want
    assert re.match(r"fault 4, NaN or infinity written to an output, info [0-2]:", lines[1])
    assert words(lines[1]) == [output.safe for output in image.outputs]
    assert words(lines[2]) == want


@pytest.mark.parametrize(
    "name", ["absent", "wrong", "timeout", "interrupt", "data", "memory_bus", "no_record"]
)
def test_driver__off_the_good_run(name, checks):
    assert execute(checks, name) == (0, [])


@pytest.mark.full
def test_driver__plausibility_record__staged_judged_and_ended(tmp_path):
    assert execute(build_checks(tmp_path, "fast", resilience=1), "plausible") == (0, [])


def test_header__every_address_fault_and_field_by_value(tmp_path):
    values = {f"ASIP_WORD(csr.{name})": REGMAP.address(name) for name in REGMAP.registers}
    values |= {f"ASIP_WORD({name})": block.base for name, block in REGMAP.blocks.items()}
    values |= {f"ASIP_FAULT_{fault.name}": fault.code for fault in REGMAP.faults.values()}
    for register in REGMAP.registers.values():
        for field in register.fields.values():
            place = f"ASIP__CSR__{register.name}__{field.name.upper()}"
            values |= {f"{place}_bm": field.mask, f"{place}_bp": field.low}
    rows = [
        f"  typedef char is_{i}[{name} == {value}u ? 1 : -1];"
        for i, (name, value) in enumerate(values.items())
    ]
    source = tmp_path / "values.c"
    source.write_text('#include "asip.h"\n' + "\n".join(rows) + "\n")
    output(CC, "-std=c99", f"-I{DRIVER}", "-fsyntax-only", source)


def test_image__names_that_c_does_not_know__stay_apart():
    rows = enumeration("p_input", [("a.b", 0), ("a_b", 1), ("A.B", 2), ("s", 3)])[1]
    names = [row.split()[0] for row in rows.split(",\n")]
    assert names == ["P_INPUT_A_B", "P_INPUT_A_B_2", "P_INPUT_A_B_3", "P_INPUT_S", "P_INPUTS"]
    assert identifier("2nd law, optimised") == "program_2nd_law_optimised"


def test_image__title_with_quotes_and_empty_tables__compiles(tmp_path):
    text = '.program "a ??/ */ \\\\ b"\n.output F, safe = 0.0\n mov F, zero\n halt\n'
    (tmp_path / "t.c").write_text(
        f'#include "asip.h"\n{to_c(assembled(text, optimise=True))}'
        "const asip_image *used(void) { return &a_b_image; }\n"
    )
    output(CC, *C_FLAGS, f"-I{DRIVER}", "-fsyntax-only", tmp_path / "t.c")
