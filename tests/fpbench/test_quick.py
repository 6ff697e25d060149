# SPDX-License-Identifier: Apache-2.0
"""The short set of every operation on the RTL: millions of cases each, result and flags."""

from __future__ import annotations

import os

import pytest

from sim.core.fpbench import Unit, operations, quick
from sim.core.fpbench import selfcheck as selfcheck_module
from sim.core.fpbench.directed import DIRECTED
from sim.core.fpbench.native import unit_of
from sim.core.fpbench.quick import RANDOM_CASES
from sim.core.fpbench.selfcheck import selfcheck

SEED = int(os.environ.get("SEED", "1"))
ITERATIVE = ("sin", "cos")


def shown(report) -> str:
    """The failure text: pasteable lines and how to replay the whole set."""
    lines = [str(failure) for failure in report.failures] + [report.protocol]
    replay = f"replay: SEED={SEED} .venv/bin/python -m sim.core.fpbench bench --op {report.op}"
    return f"{report.op}: {report.mismatches} of {report.cases} cases differ\n" + "\n".join(
        [*lines, replay]
    )


@pytest.mark.quick("fp_fma", "fp_divsqrt")
@pytest.mark.parametrize("unit", sorted({unit for unit, _ in operations().values()}))
def test_reference__level_one_and_random_operands__host_agrees_with_softfloat(unit: str) -> None:
    cases, mismatches = selfcheck(Unit(unit), SEED)
    assert not mismatches, "\n".join(map(str, mismatches[:8]))
    assert cases or unit == "fp_sincos"


@pytest.mark.parametrize("op", operations())
def test_unit__short_set__result_and_flags_match(op: str) -> None:
    report = quick(op, seed=SEED)
    assert report.good, shown(report)
    assert op in ITERATIVE or report.cases >= RANDOM_CASES


@pytest.mark.parametrize("name", DIRECTED)
def test_unit__directed_case__result_and_flags_as_written(name: str) -> None:
    op, operands, bits, flags = DIRECTED[name]
    report, got, got_flags = Unit(unit_of(op)).answers(op, [operands])
    assert (int(got[0]), int(got_flags[0])) == (bits, flags), shown(report)
    assert report.good, shown(report)


def test_operations__table_of_python_and_library__agree() -> None:
    known = operations()
    assert known == Unit("fp_add").table()
    for op, (unit, _) in known.items():
        assert Unit("fp_add").size(op, "level1"), (unit, op)


def test_selfcheck__oracle_of_another_operation__differs(monkeypatch: pytest.MonkeyPatch) -> None:
    table = selfcheck_module.oracle()
    wrong = table | {"add": table["sub"]}
    monkeypatch.setattr(selfcheck_module, "oracle", lambda: wrong)
    mismatches = selfcheck_module.selfcheck(Unit("fp_add"), SEED, cases=1000)[1]
    assert {mismatch.op for mismatch in mismatches} == {"add"}
