# SPDX-License-Identifier: Apache-2.0
"""The reader of Quartus reports, and the command without Quartus.

The samples are made by hand in the documented layout of the reports; no Quartus wrote them and
their numbers mean nothing.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from scripts import quartus_report

ROOT = Path(__file__).resolve().parents[2]

MAP = """\
Analysis & Synthesis report for asip_de3
Quartus II 64-Bit Version 13.1.0 Build 162 10/23/2013 SJ Full Version

+---------------------------------------------------------------------+
; Analysis & Synthesis Summary                                        ;
+-------------------------------+-------------------------------------+
; Analysis & Synthesis Status   ; Successful - Mon Jan 06 10:00:00 2014 ;
; Family                        ; Stratix III                         ;
; Logic utilization             ; N/A                                 ;
;     Combinational ALUTs       ; 6,011                               ;
;     Memory ALUTs              ; 0                                   ;
;     Dedicated logic registers ; 5,100                               ;
; Total registers               ; 5100                                ;
; Total block memory bits       ; 200,704                             ;
; DSP block 18-bit elements     ; 8                                   ;
+-------------------------------+-------------------------------------+


+----------------------------------+
; Analysis & Synthesis Settings    ;
+----------------------------------+
; Total registers ; 1 ;
+----------------------------------+
"""
FIT = """\
Fitter report for asip_de3
Mon Jan 06 10:05:00 2014
Quartus II 64-Bit Version 13.1.0 Build 162 10/23/2013 SJ Full Version

; Table of Contents ;
  1. Legal Notice
  2. Fitter Summary

+-----------------------------------------------------------------------+
; Fitter Summary                                                        ;
+-------------------------------+---------------------------------------+
; Fitter Status                 ; Successful - Mon Jan 06 10:05:00 2014 ;
; Family                        ; Stratix III                           ;
; Device                        ; EP3SL150F1152C2                       ;
; Logic utilization             ; 8 %                                   ;
;     Combinational ALUTs       ; 6,023 / 113,600 ( 5 % )               ;
;     Memory ALUTs              ; 576 / 56,800 ( 1 % )                  ;
;     Dedicated logic registers ; 5,123 / 113,600 ( 5 % )               ;
; Total registers               ; 5123                                  ;
; Total pins                    ; 2 / 744 ( < 1 % )                     ;
; Total virtual pins            ; 82                                    ;
; Total block memory bits       ; 200,704 / 5,630,976 ( 4 % )           ;
; DSP block 18-bit elements     ; 8 / 384 ( 2 % )                       ;
+-------------------------------+---------------------------------------+
"""
STA = """\
TimeQuest Timing Analyzer report for asip_de3

+---------------------------------------------------------------------------+
; Slow 1100mV 85C Model Fmax Summary                                        ;
+------------+-----------------+-------------------------------------+------+
; Fmax       ; Restricted Fmax ; Clock Name                          ; Note ;
+------------+-----------------+-------------------------------------+------+
; 140.25 MHz ; 131.5 MHz       ; u_pll|u_altpll|auto_generated|pll1|clk[0] ; limit ;
; 612.0 MHz  ; 500.0 MHz       ; osc_50                              ;      ;
+------------+-----------------+-------------------------------------+------+
This panel reports FMAX for every clock in the design, regardless of user-specified periods.

+---------------------------------------------------------------------------+
; Slow 1100mV 0C Model Fmax Summary                                         ;
+------------+-----------------+-------------------------------------+------+
; Fmax       ; Restricted Fmax ; Clock Name                          ; Note ;
+------------+-----------------+-------------------------------------+------+
; 145.0 MHz  ; 145.0 MHz       ; u_pll|u_altpll|auto_generated|pll1|clk[0] ;      ;
+------------+-----------------+-------------------------------------+------+

+---------------------------------------------------------------------------+
; Fast 1100mV 0C Model Setup Summary                                        ;
+---------------------------------------------------------------------------+
"""


@pytest.fixture
def reports(tmp_path: Path) -> Path:
    for stage, text in (("map", MAP), ("fit", FIT), ("sta", STA)):
        (tmp_path / f"asip_de3.{stage}.rpt").write_text(text)
    return tmp_path


def test_figures_are_those_of_the_fitter_and_of_the_lowest_slow_corner(reports):
    result = quartus_report.figures(reports)
    assert result["device"] == "EP3SL150F1152C2"
    assert "13.1.0 Build 162" in result["tool"]
    fitted = {name: result[name] for name in quartus_report.ROWS}
    assert fitted == {
        "aluts": 6023,
        "memory_aluts": 576,
        "registers": 5123,
        "dsp_18x18": 8,
        "memory_bits": 200704,
    }
    assert result["after_synthesis"] == {
        "aluts": 6011,
        "registers": 5100,
        "dsp_18x18": 8,
        "memory_bits": 200704,
    }
    assert (result["fmax_mhz"], result["fmax_corner"]) == (131.5, "Slow 1100mV 85C Model")
    assert result["fmax_corners_mhz"]["Slow 1100mV 0C Model"] == 145.0


def test_store_keeps_the_other_keys(reports, tmp_path):
    output = tmp_path / "build/synth.json"
    output.parent.mkdir()
    output.write_text(json.dumps({"tops": {"asip_fast": {"aluts": 1}}, "stratix3": {"old": 1}}))
    assert quartus_report.main([str(reports), "--output", str(output)]) == 0
    data = json.loads(output.read_text())
    assert data["tops"] == {"asip_fast": {"aluts": 1}}
    assert data["stratix3"] == quartus_report.figures(reports)


@pytest.mark.parametrize(
    ("stage", "old", "new", "named"),
    [
        ("fit", "DSP block 18-bit elements", "Total DSP Blocks", "DSP block 18-bit elements"),
        ("fit", "; Fitter Summary  ", "; Flow Summary    ", "Fitter Summary"),
        ("fit", "6,023 / 113,600 ( 5 % )", "N/A", "N/A"),
        ("map", "; Total registers               ;", "; Registers ;", "Total registers"),
        ("sta", "pll1|clk[0]", "pll1|clk[1]", "clk[0]"),
        ("sta", "; Slow", "; Fast", "Fmax of a slow model"),
    ],
)
def test_figure_that_is_not_there_is_an_error_with_report_and_name(
    reports, capsys, stage, old, new, named
):
    path = reports / f"asip_de3.{stage}.rpt"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(quartus_report.ReportError) as caught:
        quartus_report.figures(reports)
    assert f"asip_de3.{stage}.rpt" in str(caught.value)
    assert named in str(caught.value)
    output = reports / "synth.json"
    assert quartus_report.main([str(reports), "--output", str(output)]) == 1
    assert not output.exists()


@pytest.mark.parametrize("stage", ["map", "fit", "sta"])
def test_missing_report_is_an_error_that_names_it(reports, stage):
    (reports / f"asip_de3.{stage}.rpt").unlink()
    with pytest.raises(quartus_report.ReportError, match=rf"asip_de3\.{stage}\.rpt"):
        quartus_report.figures(reports)


def run_quartus(path: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, ROOT / "scripts/quartus.py"],
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
    )


def test_command_without_quartus_says_what_is_missing_and_exits_1(tmp_path):
    done = run_quartus(str(tmp_path))
    assert done.returncode == 1
    assert "quartus_sh is not on PATH" in done.stdout
    assert "Quartus II 13.1" in done.stdout


def test_command_reports_a_quartus_that_fails(tmp_path):
    tool = tmp_path / "quartus_sh"
    tool.write_text('#!/bin/sh\necho "called with $@"\nexit 3\n')
    tool.chmod(0o755)
    done = run_quartus(f"{tmp_path}:/bin:/usr/bin")
    assert done.returncode == 1
    assert "called with -t scripts/quartus/build.tcl" in done.stdout
    assert "quartus_sh failed" in done.stdout
