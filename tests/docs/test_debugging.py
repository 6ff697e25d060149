# SPDX-License-Identifier: Apache-2.0
"""The steps of docs/verification.md: WAVES=1 gives an FST from each kind of bench."""

from __future__ import annotations

import os
import re
import struct
import sys
from pathlib import Path

import pytest
import pywellen

from sim.rtl.build import ROOT
from tests.bench.commands import output
from tests.bench.needs import needs
from tests.motion_rtl.test_pulse_generator import Generator

PAGE = (ROOT / "docs/verification.md").read_text()
ALONE = re.search(r'pytest "(\S+)"', PAGE)[1]
COCOTB = "tests/motion_rtl/test_axil.py::test_axil__every_scenario"
SCENARIO = "latency__handshake_to_response_valid"
BENCH = "tests/fpu/test_fp_i2f.py::test_i2f__reset_in_flight__clears_valid"


def end_time(path: Path) -> int:
    """Last time in the header of an FST (block type 0, 329 bytes, start and end time)."""
    kind, size, start, end = struct.unpack(">BQQQ", path.read_bytes()[:25])
    assert (kind, size, start) == (0, 329, 0)
    return end


def layout(path: Path, ending: str) -> str:
    """Text of a layout next to an FST."""
    return path.with_suffix(ending).read_text()


@pytest.mark.quick("bench")
@needs("fst")
@pytest.mark.parametrize("test", [ALONE, COCOTB, BENCH], ids=["harness", "cocotb", "bench"])
def test_waves__of_one_test__are_named_and_hold_its_time(test, tmp_path):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", test]
    environment = {**os.environ, "WAVES": "1", "WAVES_CLOCKS": "1000", "SCENARIO": SCENARIO}
    said = output(*command, cwd=ROOT, env=environment)
    files = [Path(name) for name in re.findall(r"^waves: (.*\.fst)$", said, re.M)]
    assert len(files) == 1 and test.rpartition("::")[2] in files[0].parent.name
    assert end_time(files[0]) > 20
    in_file = {v.full_name: v.bitwidth for v in pywellen.Waveform(str(files[0])).all_vars()}
    names = re.findall(r"^[^@^\[-].*$", layout(files[0], ".gtkw"), re.M)
    shown = [re.fullmatch(r"(.*?)(?:\[(\d+):0\])?", name).groups() for name in names]
    assert shown and all(in_file[name] == int(top or 0) + 1 for name, top in shown)
    added = re.findall(r"^variable_add (\S+)$", layout(files[0], ".sucl"), re.M)
    assert added == [name for name, _ in shown]


def test_page__names_a_test_by_its_name_and_by_a_part_of_it():
    part = re.search(r"make test T=(\w+) WAVES=1", PAGE)[1]
    assert part in ALONE
    assert f"{ALONE.replace('/', '_').replace('::', '_')}/pulse_generator-1.fst" in PAGE


def test_model_without_waves__holds_nothing_of_them(monkeypatch):
    monkeypatch.delenv("WAVES", raising=False)
    with pytest.raises(AttributeError):
        Generator().lib.bench_close_waves  # noqa: B018
