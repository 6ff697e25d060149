# SPDX-License-Identifier: Apache-2.0
"""Tables of the main job: a sentence each, with platforms left out, table 4 as it is saved."""

import json
import re
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

from scripts import readme
from sim.bench.run import tables
from sim.report.marks import between_marks
from sim.robot.published import Published
from sim.robot.records import OUTPUTS, TABLE_3
from sim.rtl.figures import measured_at

ROWS = (*TABLE_3, *OUTPUTS)
TIMING = {"clock_mhz": 125, "cycles_min": 118, "cycles_max": 118, "time_us": 0.944}
TRACKED = {"leg": 1e-6, "tool": 2e-6, "table": 3e-6}
FPGA3 = {
    "ticks": 10,
    "platforms": {"fpga3": {"optimised": TIMING, "as_printed": TIMING}},
    "operations": {"as_printed": dict.fromkeys(tables.OPERATIONS, 7)},
    "errors": {row: dict.fromkeys(tables.ERRORS, 1e-9) for row in ROWS},
    "worst_fraction_of_bound": {"optimised": dict.fromkeys(OUTPUTS, 0.5)},
    "tracking": {"optimised": TRACKED},
}
NIOS = {
    "ticks": 10,
    "platforms": {"fpga1": TIMING | {"ticks": 10}},
    "nios": {
        "fpga1": {
            "variants": {"unoptimised": TIMING},
            "replayed_ticks": 5,
            "closed_loop_ticks": 5,
            "pc_float32_same_ticks": dict.fromkeys(ROWS, 1e-9),
            "tracking": TRACKED,
        }
    },
    "errors": {row: {"fpga1": 1e-9} for row in ROWS},
    "tracking": {},
}
BOTH = FPGA3 | {
    "nios": NIOS["nios"],
    "platforms": FPGA3["platforms"] | NIOS["platforms"],
    "errors": {row: FPGA3["errors"][row] | NIOS["errors"][row] for row in ROWS},
}


@pytest.mark.parametrize(("results", "count"), [(FPGA3, 6), (NIOS, 4), (BOTH, 7)])
def test_tables__of_what_ran__a_sentence_each(results, count):
    written = list(tables.all_tables(results))
    assert len(written) == count
    for table in written:
        assert str(table.caption).endswith(".") and len(str(table.caption)) > 60
        assert table.rows
        Console(file=open("/dev/null", "w"), width=120).print(table)


def test_table_4__nothing_synthesised__kept_figures_with_their_commit(monkeypatch, tmp_path):
    kept = json.loads(tables.SYNTHESIS[1].read_text())
    monkeypatch.setattr(tables, "SYNTHESIS", (tmp_path / "synth.json", tables.SYNTHESIS[1]))
    table = tables.resource_table(tables.synthesised(), Published.load())
    assert kept["tops"]["asip_fast"]["commit"] in table.caption
    cells = [str(cell) for column in table.columns for cell in column.cells]
    text = StringIO()
    Console(file=text, width=120).print(table)
    assert "[kbit]" in text.getvalue()  # not taken for markup
    assert "asip_fast" in cells and str(kept["tops"]["asip_fast"]["aluts"]) in cells
    # What was synthesised here comes first.
    changes = {"aluts": 77777, "commit": "abc"}
    own = {"tops": {"asip_fast": kept["tops"]["asip_fast"] | changes}}
    (tmp_path / "synth.json").write_text(json.dumps(own))
    table = tables.resource_table(tables.synthesised(), Published.load())
    assert "commit abc (asip_fast), " in table.caption
    assert "77777" in [str(cell) for cell in table.columns[1].cells]


def test_readme__synthesis_is_what_is_kept():
    data = json.loads(readme.KEPT.read_text())
    text = readme.README.read_text()
    assert between_marks(text, {"synthesis": readme.synthesis(data)}, "README") == text
    data["tops"]["n2_core"]["aluts"] += 1
    assert between_marks(text, {"synthesis": readme.synthesis(data)}, "README") != text


def test_figures_of_the_first_page__are_those_of_the_readme():
    """README has cycles and times in a table of the same results."""
    page, overview = readme.README.read_text(), readme.INDEX.read_text()
    for program in ("optimised", "as printed"):
        (row,) = re.findall(
            rf"FPGA3, ours, {program}\*\* \| (\d+) \| \*\*(.*)\*\* \| \*\*(.*)\*\* \|", page
        )
        clock, cycles, time = row
        assert f"ASIP, {program} | {cycles} cycles, {time} µs at {clock} MHz |" in overview
    (ticks,) = re.findall(r"Path A-G-H, (\d+) ticks", page)
    (tool,) = re.findall(r"tool ([\d.]+) µm", page)
    assert f"| {ticks} |" in overview and f"| {tool} µm |" in overview


def test_make_readme__synthesis_is_kept_and_shown(monkeypatch, tmp_path):
    page, kept = tmp_path / "README.md", tmp_path / "kept.json"
    page.write_text("<!-- synthesis: x -->\nold\n<!-- end of synthesis -->\n")
    platforms = tmp_path / "platforms.md"
    platforms.write_text("<!-- area: x -->\nold\n<!-- end of area -->\n")
    monkeypatch.setattr(readme, "README", page)
    monkeypatch.setattr(readme, "PLATFORMS", platforms)
    monkeypatch.setattr(readme, "KEPT", kept)
    arguments = ["synthesis", "--folder", str(tmp_path)]
    assert readme.main(arguments) == 1
    top = {
        **{"aluts": 12, "registers": 34, "dsp_18x18": 5, "memory_bits": 6789, "commit": "abc"},
        "modules": ["fp_add"],
        "rtl": "0123",
        "fmax_mhz": {"median": 100.4, "min": 99.0, "max": 101.0, "seeds": {"1": 99.0, "2": 101.0}},
    }
    cores = ["asip_fast", "n2_core", "fpga2"]
    other = top | {"commit": "before", "fmax_mhz": top["fmax_mhz"] | {"runs": 2}}
    kept.write_text(json.dumps({"measured": "so", "tops": {name: other for name in cores}}))
    data = {"measured": "so", "tops": {"n2_core": top, "fp_add": top}}
    (tmp_path / "synth.json").write_text(json.dumps(data))
    assert readme.main(arguments) == 0
    row = "| Nios II core | 12 | 34 | 5 | 7 | 100 (99..101, 2 seeds) |"
    assert row in page.read_text()
    tops = json.loads(kept.read_text())["tops"]
    assert measured_at(tops) == "before (asip_fast, fpga2), abc (n2_core)"
    assert "| FPGA2, the whole system | 12 | 34 | 5 | 7 | 100 |" in platforms.read_text()
    assert list(tops) == cores
    monkeypatch.setattr(tables, "SYNTHESIS", (Path(tmp_path / "none"), kept))
    table = tables.resource_table(tables.synthesised(), Published.load())
    assert "100 (99..101)" in [str(cell) for cell in table.columns[5].cells]
