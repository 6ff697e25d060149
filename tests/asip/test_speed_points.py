# SPDX-License-Identifier: Apache-2.0
"""The table of versions: written from its data, and a revision that cannot be measured says so."""

from __future__ import annotations

import json

import pytest

from scripts import speed_points
from scripts.readme import longest


def test_page__written_again__equal():
    assert speed_points.main(["--check"]) == 0


def test_page__other_data__refused(monkeypatch, capsys):
    points = json.loads(speed_points.DATA.read_text())
    points[0]["aluts"] += 1
    other = speed_points.ROOT / "build/speed_points/test.json"
    other.parent.mkdir(parents=True, exist_ok=True)
    other.write_text(json.dumps(points))
    monkeypatch.setattr(speed_points, "DATA", other)
    assert speed_points.main(["--check"]) == 1
    assert "differs" in capsys.readouterr().err


@pytest.mark.parametrize(("clock", "fastest"), [(1.0, False), (1000.0, True)])
def test_shipped__page__is_the_shortest_tick_of_configuration_fast(clock, fastest):
    points = json.loads(speed_points.DATA.read_text())
    points[0] |= {"configuration": "fast", "fmax_mhz": {"1": clock}}
    shipped = speed_points.page(points).partition("shortest optimised tick")[2].split("`")[3]
    assert (shipped == points[0]["commit"]) == fastest


def test_add__unknown_revision__error_names_it(capsys):
    assert speed_points.main(["--add", "no-such-revision"]) == 1
    error = capsys.readouterr().err
    assert error.startswith("error: ") and "no-such-revision" in error


def test_add__same_commit_and_configuration_again__replaces_the_row():
    points = [{"commit": "a", "configuration": "fast", "aluts": 1}]
    speed_points.add(points, {"commit": "a", "configuration": "fast", "aluts": 2})
    speed_points.add(points, {"commit": "a", "configuration": "small", "aluts": 3})
    assert [point["aluts"] for point in points] == [2, 3]


@pytest.mark.parametrize("program", speed_points.PROGRAMS)
def test_cycles__this_tree__are_those_of_the_assembler(program):
    from asip_asm.assemble import assemble
    from asip_asm.machine import load_machine
    from tests.asip.core_bench import decoded

    source = speed_points.ROOT / f"asip_asm/programs/tracking_{program}.s"
    image = assemble(source, configuration="small")
    want = load_machine("small").run_cycles(decoded(image))
    speed_points.FOLDER.mkdir(parents=True, exist_ok=True)
    assert speed_points.cycles(speed_points.ROOT, program, "small") == want


def test_figures_that_were_committed__or_what_to_run(tmp_path, monkeypatch) -> None:
    kept = tmp_path / "synthesis.json"
    monkeypatch.setattr(speed_points, "FIGURES", kept)
    kept.write_text(json.dumps({"tops": {}}))
    with pytest.raises(speed_points.PointError, match="microtick synth --only asip_small"):
        speed_points.committed_figures("small")
    figures = {"aluts": 1, "registers": 2, "dsp_18x18": 3}
    record = figures | {"commit": "abc", "lut4": 9, "fmax_mhz": {"median": 5.0, "runs": 5}}
    kept.write_text(json.dumps({"tops": {"asip_small": record}}))
    got = speed_points.committed_figures("small")
    assert got == ("abc", figures | {"fmax_mhz": {"median of 5": 5.0}})


def test_longest_path__names_its_registers_and_the_time_in_wires() -> None:
    steps = [
        "  0.40  0.40 clk-to-q dut.u_div.remainder_q_TRELLIS_FF_Q_2",
        "  1.44  1.04 routing  dut.u_div.remainder_q[2]",
        "  1.63  0.19 logic    dut.quotient_a_TRELLIS_FF_Q_DI_PFUMX_Z_BLUT_LUT4_Z",
        "  2.14  0.51 routing  dut.quotient_a_TRELLIS_FF_Q_DI",
    ]
    path = longest(steps)
    assert path == {"from": "u_div.remainder_q", "to": "quotient_a", "ns": 2.14, "wires_ns": 1.55}
    text = speed_points.paths({"tops": {"n2_core": {"longest_path": path}, "old": {}}})
    assert "| `n2_core` | `u_div.remainder_q` | `quotient_a` | 2.14 | 1.55 |" in text
    assert "old" not in text and speed_points.paths({"tops": {"old": {}}}) == ""
