# SPDX-License-Identifier: Apache-2.0
"""No page shows a figure as one of today's RTL that was measured on another."""

from __future__ import annotations

import re
import shutil

import pytest

from asip_asm.project import ROOT
from scripts import figures
from sim.rtl import figures as marks
from sim.rtl.figures import is_present, rtl_mark, statement
from sim.rtl.sources import RTL


def test_pages__state_which_figures_are_of_an_earlier_rtl(capsys):
    assert figures.main(["--check"]) == 0, capsys.readouterr().err


def test_pages__that_name_a_measured_commit__have_a_statement():
    """A page writer that names a commit by itself would not see that the RTL has changed."""
    stated = figures.statements()
    for page in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        text = page.read_text(encoding="utf-8")
        name = str(page.relative_to(ROOT))
        found = re.findall(r"[Mm]easured at commit", text)
        assert len(found) == (name in stated), f"{name}: {len(found)} measured commits"


def test_changed_rtl__makes_figures_out_of_date_and_the_pages_wrong(tmp_path, monkeypatch, capsys):
    """One line of code in the divider; a comment changes nothing."""
    copy = tmp_path / "rtl"
    shutil.copytree(RTL, copy)
    today = {"commit": "abc", "rtl": rtl_mark("asip_fast"), "modules": []}
    own = {"asip_fast": today, "n2_core": today | {"rtl": rtl_mark("n2_core")}}
    again = "microtick synth --only {}"
    assert statement(own, again) == "Measured at commit abc. The RTL is the same today."
    monkeypatch.setattr(marks, "rtl_mark", lambda name, modules: rtl_mark(name, modules, (copy,)))
    source = copy / "fpu/fp_divsqrt.sv"
    source.write_text(source.read_text() + "// a comment\n")
    assert is_present("asip_fast", today)
    source.write_text(source.read_text() + "module other; endmodule\n")
    assert not is_present("asip_fast", today) and is_present("n2_core", own["n2_core"])
    assert statement(own, again) == (
        "Measured at commit abc. **Out of date:** the RTL of asip_fast has changed since; "
        "`microtick synth --only asip_fast` measures again."
    )
    monkeypatch.setattr(figures, "statements", lambda: {"README.md": statement(own, again)})
    assert figures.main(["--check"]) == 1
    assert "README.md: error: its figures are of another RTL" in capsys.readouterr().err


@pytest.mark.parametrize(("modules", "same"), [(["asip", "fp_divsqrt"], True), ([], False)])
def test_module__that_only_another_configuration_has__does_not_count(tmp_path, modules, same):
    copy = tmp_path / "rtl"
    shutil.copytree(RTL, copy)
    before = rtl_mark("asip_fast", modules, (copy,))
    file = copy / "fpu/fp_divsqrt_folded.sv"
    file.write_text(file.read_text() + "module other; endmodule\n")
    assert (rtl_mark("asip_fast", modules, (copy,)) == before) is same
