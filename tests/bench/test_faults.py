# SPDX-License-Identifier: Apache-2.0
"""Tables of planted faults: a wrong entry is refused with its line; how faults get into a text."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bench.faults import (
    BY_MACRO,
    BY_NUMBER,
    REPLACED,
    Fault,
    TableError,
    copy,
    folder_of,
    load,
    plant,
)

GOOD = {
    "id": "1",
    "file": '"fpu/fp_round.sv"',
    "breaks": '"b"',
    "right": '"module fp_round"',
    "wrong": '"w"',
    "found": '["x"]',
}


def table(folder: Path, *entries: dict[str, str]) -> Path:
    """A file with these entries."""
    path = folder / "faults.toml"
    texts = ("".join(f"{key} = {value}\n" for key, value in entry.items()) for entry in entries)
    path.write_text("".join(f"[[fault]]\n{text}" for text in texts))
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"found": '"x"'}, "needs found, list"),
        ({"found": "[]"}, "needs an id from 1 and somebody in `found`"),
        ({"id": "0"}, "needs an id from 1"),
        ({"alone": "1"}, "needs alone, bool"),
        ({"ops": "1"}, "unknown ops; known are id, file, breaks"),
        ({"wrong": '"module fp_round "'}, "`wrong` is the same as `right`"),
        ({"file": '"fpu/none.sv"'}, "no file fpu/none.sv in "),
        ({"right": '"no such"'}, "`right` stands 0 times in fp_round.sv, not once; adapt"),
        ({"place": '"no such"'}, "`place` stands 0 times in fp_round.sv, not once"),
        ({"place": '"endmodule"'}, "`right` stands 0 times in `place`, not once"),
        ({"right": '"odule fp_round"'}, "`right` cuts `module`; take it whole"),
        ({"right": '"module fp_rou"'}, "`right` cuts `fp_round`; take it whole"),
        ({"file": '"nios_sw/none.c"'}, "no file nios_sw/none.c in "),
    ],
)
def test_wrong_entry__refused_with_its_line(change, message, tmp_path) -> None:
    path = table(tmp_path, GOOD, GOOD | {"id": "2"} | change)
    with pytest.raises(TableError) as caught:
        load(path)
    number = (GOOD | {"id": "2"} | change)["id"]
    assert str(caught.value).startswith(f"{path}:8: error: fault {number}: {message}")


@pytest.mark.parametrize("part", ["fpu", "nios_sw/ethercat"])
def test_copy__has_every_file_and_one_is_changed(part, tmp_path) -> None:
    original = folder_of(part) / part
    file = next(path for path in sorted(original.rglob("*.*")) if path.suffix in (".sv", ".c"))
    fault = Fault(1, f"{part}/{file.name}", "", "SPDX-License-Identifier", "other", ())
    folder = copy(tmp_path / "copy", [fault], part=part)
    names = {path.relative_to(original) for path in original.rglob("*.*")}
    assert names == {path.relative_to(folder) for path in folder.rglob("*.*")}
    differ = [
        name for name in names if (original / name).read_text() != (folder / name).read_text()
    ]
    assert differ == [Path(file.name)]


def test_number_used_twice__refused(tmp_path) -> None:
    with pytest.raises(
        TableError, match=":8: error: fault 1: the id is already .* in line 1; give"
    ):
        load(table(tmp_path, GOOD, GOOD))


def test_three_ways__of_the_same_faults() -> None:
    one, two = Fault(1, "f.sv", "", "b", "c", ()), Fault(2, "f.sv", "", "b", "d", (), "= b")
    assert plant("a = b;", [one], REPLACED) == "a = c;"
    macros = "a = \n`ifdef FAULT_01\nc\n`elsif FAULT_02\nd\n`else\nb\n`endif\n;"
    assert plant("a = b;", [two, one], BY_MACRO) == macros
    number = "a = (chosen == 1 ? (c) : chosen == 2 ? (d) : (b));"
    assert plant("a = b;", [one, two], BY_NUMBER) == number
    with pytest.raises(
        TableError, match="fault 1: `right` stands 2 times in f.sv, not once; adapt"
    ):
        plant("a b c b", [one], BY_MACRO)
    with pytest.raises(TableError, match="fault 1: `right` overlaps that of fault 3; give both"):
        plant("a = b;", [one, Fault(3, "f.sv", "", "= b", "x", ())], BY_MACRO)
