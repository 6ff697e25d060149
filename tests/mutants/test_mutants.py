# SPDX-License-Identifier: Apache-2.0
"""Planted faults: the table fits the RTL, its copies hold what it says, some faults really run."""

from __future__ import annotations

import re
import subprocess
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from sim.core.fpbench.native import RTL, Report, Unit, operations
from sim.report import cache
from sim.rtl.build import BuildError, verilator_driver
from tests.mutants import campaign, faults
from tests.mutants.__main__ import main
from tests.mutants.campaign import Sound, Verdict, sound_of, verdict_of
from tests.mutants.faults import Fault, load, write_copy

TABLE = load()
NOT_MUTATED = {"fp_pkg", "fp_sincos_rom", "fp_sincos_memory"}  # constants; coefficients
RIGHT = "module fp_round"
ENTRY = """[[fault]]
id = {id}
file = "{file}"
found = {ops}
breaks = "x"
right = "{right}"
wrong = "w"
"""


def code(path: Path, macros: tuple[str, ...] = ()) -> str:
    """What Verilator's preprocessor leaves of a file, without comments and white space."""
    defines = [f"-D{macro}" for macro in macros]
    command = [str(verilator_driver()), "-E", "-P", *defines, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return "".join(done.stdout.split())


def test_table__faults__are_at_least_forty_and_in_every_module() -> None:
    assert len(TABLE) >= 40
    modules = {path.stem for path in RTL.glob("*.sv")} - NOT_MUTATED
    assert {Path(entry.file).stem for entry in TABLE} >= modules


@pytest.mark.quick("fp_add.sv", "fp_round.sv", "fp_sincos.sv")
@pytest.mark.parametrize("name", sorted({entry.name for entry in TABLE}))
def test_copy__no_macro_and_each_macro__is_the_rtl_and_differs(name: str, tmp_path: Path) -> None:
    folder = write_copy(TABLE, tmp_path)
    original = code(RTL / name)
    assert code(folder / name) == original
    seen = [code(folder / name, (entry.macro,)) for entry in TABLE if entry.name == name]
    assert original not in seen
    assert len(set(seen)) == len(seen), "two faults are the same"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"right": "no such text"}, "fault 1: `right` stands 0 times in fp_round.sv"),
        ({"file": "fpu/fp_none.sv"}, "fault 1: no file fpu/fp_none.sv in "),
        (
            {"file": "fpu/fp_add.sv", "right": "module fp_add"},
            "fault 1: fp_add.sv is no part of fp_mul, which executes mul",
        ),
        ({"ops": '["times"]'}, "fault 1: found: times; name operations of the bench: add, sub"),
        ({"ops": '["mul", "add"]'}, "fault 1: found: operations of several units: fp_add, fp_mul"),
        ({"ops": "[]"}, "fault 1: needs an id from 1 and somebody in `found`"),
        ({"id": '"1"'}, "fault 1: needs id, int"),
        ({"right": "w"}, "fault 1: `wrong` is the same as `right`"),
        ({"right": 'a"\nunit = "b'}, "fault 1: unknown unit; known are id, file, breaks"),
        ({"right": '"'}, "not TOML: "),
    ],
)
def test_command__wrong_table__says_where_and_why(
    change: dict, message: str, tmp_path: Path, capsys
) -> None:
    values = {"id": 1, "file": "fpu/fp_round.sv", "ops": '["mul"]', "right": RIGHT} | change
    path = tmp_path / "table.toml"
    path.write_text(ENTRY.format(**values))
    assert main(["--table", str(path)]) == 1
    error = capsys.readouterr().err
    assert message in error and re.match(r".*:(\d+:)? error: ", error), error


def test_command__unknown_fault__is_named(capsys) -> None:
    assert main(["--only", "fp_none"]) == 1
    assert "no fault 'fp_none'; give a number" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("caught", "good", "status"), [(True, True, 0), (False, True, 1), (True, False, 1)]
)
def test_command__cached_verdicts__decide_the_exit_status(
    caught: bool, good: bool, status: int, tmp_path: Path, capsys
) -> None:
    entry = next(entry for entry in TABLE if entry.name == "fp_f2i.sv")
    ops = [op for op, (unit, _) in operations().items() if unit == entry.unit]
    verdict = Verdict(entry.number, caught, "microtick fp case f2i 0", 1, False)
    path = tmp_path / "report.json"
    cache.save(verdict_of(entry, path), asdict(verdict))
    for op in ops:
        cache.save(sound_of(op, path), asdict(Sound(op, good, 1, "FAIL here")))
    assert main(["--only", entry.macro, "--report", str(path), "--jobs", "1"]) == status
    shown = capsys.readouterr().out
    assert f"{int(caught)} of 1 faults caught" in shown
    assert ("the RTL itself fails: FAIL here" in shown) is not good


def test_verdict__entry_changed__does_not_count(tmp_path: Path) -> None:
    entry = TABLE[0]
    changed = Fault(**(entry.__dict__ | {"wrong": entry.wrong + " "}))
    same = Fault(**(entry.__dict__ | {"where": ""}))
    assert verdict_of(changed, tmp_path) != verdict_of(entry, tmp_path)
    assert verdict_of(same, tmp_path) == verdict_of(entry, tmp_path)


@pytest.mark.full
def test_faults__underflow_and_sticky_in_one_simulation__are_found_and_a_harmless_one_is_not(
    tmp_path: Path, monkeypatch
) -> None:
    harmless = Fault(
        99, "fpu/fp_mul.sv", "nothing", "a_i[31] ^ b_i[31]", "b_i[31] ^ a_i[31]", ("mul",)
    )
    chosen = [entry for entry in TABLE if entry.number in (4, 5, 38)] + [harmless]
    monkeypatch.setattr(faults, "COPY", tmp_path / "rtl")
    monkeypatch.setattr(faults, "BUILD", tmp_path)
    monkeypatch.setattr(campaign, "COPY", tmp_path / "rtl")
    monkeypatch.setattr(campaign, "DEFAULT_SHARED_CASES", 20_000)
    write_copy([*TABLE, harmless], tmp_path / "rtl")
    verdicts = {verdict.number: verdict for verdict in campaign.shared("fp_mul", chosen)}
    assert verdicts.keys() == {4, 5, 38}
    assert all(verdict.caught for verdict in verdicts.values())
    # The named case passes on the unit without a fault.
    unit = Unit("fp_mul")
    for verdict in verdicts.values():
        words = re.findall(r"[AB]=([0-9a-f]{8})", verdict.case)
        assert unit.run_list("mul", [[int(word, 16) for word in words]]).good, verdict
    assert verdicts[4].case == "microtick fp case mul 007fffff 3f800001"
    assert verdicts[5].case == "microtick fp case mul 00ffffff 3f000000"


class WrongUnit:
    """Replaces a unit all of whose lanes answer 1 where the reference says 0."""

    name = "fp_f2i"

    def __init__(self, *_args, **_options) -> None:
        pass

    def size(self, _op: str, kind: str) -> int:
        return int(kind == "level1")

    def operands(self, _op: str, _kind: str, _start: int, count: int, _seed: int) -> np.ndarray:
        return np.zeros((count, 3), np.uint32)

    def answers(self, op: str, rows: np.ndarray) -> tuple[Report, np.ndarray, np.ndarray]:
        report = Report(op, "list", len(rows), 0, 0, 0.0, "", [])
        return report, np.ones(len(rows), np.uint32), np.zeros(len(rows), np.uint8)

    def reference(self, _op: str, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(len(rows), np.uint32), np.zeros(len(rows), np.uint8)


def test_shared__lane_without_a_fault_fails__is_an_error(monkeypatch) -> None:
    monkeypatch.setattr(campaign, "bench_unit", WrongUnit)
    monkeypatch.setattr(campaign, "write_lanes", lambda *_: [])
    chosen = [entry for entry in TABLE if entry.name == "fp_f2i.sv"]
    with pytest.raises(BuildError, match="without a fault fails: microtick fp case f2i 4f000000"):
        campaign.shared("fp_f2i", chosen)


@pytest.mark.full
def test_faults__all__are_found() -> None:
    assert main(["--jobs", "2"]) == 0
