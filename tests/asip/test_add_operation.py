# SPDX-License-Identifier: Apache-2.0
"""docs/add_operation.md: its steps carried out as printed in a copy; the operation runs there."""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from tests.bench.commands import output
from tests.bench.copies import share_models

PAGE = ROOT / "docs/add_operation.md"
COPIED = ("rtl", "asip_asm", "sim", "scripts", "nios_sw/include", "tests/asip")
# After these lines the page puts its own.
LAST_CASE = "      fp_pkg::FP_CMP_NEG:   other_e1[31] = !a_i[31];\n"
LAST_COMPARE = "    COMPARE(ISUB, Integer, (Value{a - b, 0})),\n"
LAST_DIRECTED = '    ("fsin", (QUIET,), NAN, 0),\n'

RUN = """
import itertools, json, numpy as np
from sim.core import Core
corners = [0, 1 << 31, 1, 0x3F800000, 0xC0000000, 0x7F800000, 0xFF800000, 0x7FC00000, 0xFF800001]
rows = np.array(list(itertools.product(corners, repeat=2)), dtype=np.uint32)
ticks = {}
for backend in ("iss", "rtl"):
    with Core("bits.s", configuration="small", backend=backend) as core:
        x, y = rows.T.view(np.float32)
        ticks[backend] = core.batch({"x": x, "y": y}, ["t"])
want = rows[:, 0] & 0x7FFFFFFF | rows[:, 1] & 0x80000000
right = {name: bool((run["t"].view(np.uint32) == want).all()) for name, run in ticks.items()}
flags = [bool(run.flags.any()) for run in ticks.values()]
print(json.dumps([right, flags, len(rows)]))
"""
BITS = """.program "bits"
.input x, y
.output F, safe = 0.0
.export t
 fcopysign t, x, y
 mov F, 1.0
 halt
"""


def block(language: str) -> str:
    """The page's only block of a language, without the indentation of the list."""
    text = PAGE.read_text(encoding="utf-8")
    (found,) = re.findall(rf"^   ```{language}\n(.*?)^   ```$", text, re.M | re.S)
    return found


def insert(path: Path, behind: str, text: str) -> None:
    source = path.read_text()
    assert source.count(behind) == 1
    path.write_text(source.replace(behind, behind + text))


def run(copy: Path, *command: object) -> str:
    """What the copy's Python prints."""
    return output(sys.executable, *command, cwd=copy, env=os.environ | {"PYTHONPATH": copy})


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the sources with steps 1 to 5 done."""
    root = tmp_path_factory.mktemp("operation")
    for name in COPIED:
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, root / name, ignore=ignored)
    for name in ("pyproject.toml", "tests/__init__.py", "docs/isa.md"):
        (root / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, root / name)
    isa = root / "asip_asm/isa.toml"
    isa.write_text(isa.read_text() + re.sub(r"(?m)^   ", "", block("toml")))
    insert(root / "rtl/fpu/fp_cmp.sv", LAST_CASE, block("systemverilog"))
    insert(root / "sim/core/fpbench/operations.h", LAST_COMPARE, block("cpp"))
    insert(root / "tests/asip/operation_cases.py", LAST_DIRECTED, block("text"))
    (root / "copysign.s").write_text(re.sub(r"(?m)^   ", "", block("asm")))
    (root / "bits.s").write_text(BITS)
    # Models for a few runs: the compiler need not try hard.
    build = root / "sim/rtl/build.py"
    chosen = 'os.environ.get("MODEL_OPTIMISATION", "-O3")'
    build.write_text(build.read_text().replace(chosen, '"-O0"'))
    share_models(root / "build", "verilated-*")
    run(root, "scripts/gen_isa.py")
    return root


def test_record__everything_generated__has_the_operation(copy: Path) -> None:
    assert "OP_FCOPYSIGN = 6'b101111" in (copy / "rtl/gen/asip_isa_pkg.sv").read_text()
    assert "FP_CMP_COPYSIGN = 4'd15" in (copy / "rtl/fpu/fp_pkg.sv").read_text()
    assert "opcode == asip_isa_pkg::OP_FCOPYSIGN}" in (copy / "rtl/asip/asip_pkg.sv").read_text()
    assert (
        'COPYSIGN{"copysign", 2, 15}' in (copy / "sim/core/fpbench/gen/compare_codes.h").read_text()
    )
    assert "`fcopysign dst, a, b`" in (copy / "docs/isa.md").read_text()


def test_program__of_the_page__assembles_and_runs(copy: Path) -> None:
    run(copy, "-m", "asip_asm.cli_as", "copysign.s", "-o", "copysign.asip.json")
    options = block("sh").splitlines()[-1].split()[1:]
    assert "-2.5" in run(copy, "-m", "sim.debug.asip_run", *options)


@pytest.mark.full
def test_operation__on_the_rtl__is_that_of_the_model(copy: Path) -> None:
    assert json.loads(run(copy, "-c", RUN)) == [{"iss": True, "rtl": True}, [False, False], 81]


def test_unit__in_the_bench__gives_the_reference_which_is_the_record(copy: Path) -> None:
    check = (
        "from sim.core.fpbench.native import Unit\n"
        "from sim.core.fpbench.selfcheck import selfcheck\n"
        "unit = Unit('fp_cmp', lanes=1); report = unit.run('copysign', 'random', count=20_000)\n"
        "print(report.good, report.cases, selfcheck(unit, cases=500)[1])"
    )
    assert run(copy, "-c", check) == "True 20000 []\n"


def test_directed_cases__hold_and_are_asked_for(copy: Path) -> None:
    tests = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/asip/test_iss_operations.py")
    assert "3 passed" in run(copy, *tests, "-k", "fcopysign or every_operation")


@pytest.mark.full
def test_datapath_forgotten__is_found(copy: Path, tmp_path: Path) -> None:
    """Without step 2 the unit copies a; the run of the bench says so."""
    shutil.copytree(copy / "rtl/fpu", tmp_path / "fpu")
    unit = tmp_path / "fpu/fp_cmp.sv"
    unit.write_text(unit.read_text().replace(block("systemverilog"), ""))
    check = (
        "from pathlib import Path; from sim.core.fpbench.native import Unit\n"
        f"unit = Unit('fp_cmp', Path({str(tmp_path / 'fpu')!r}), lanes=1)\n"
        "print(unit.run('copysign', 'random', count=1000).mismatches > 0)"
    )
    assert run(copy, "-c", check) == "True\n"
