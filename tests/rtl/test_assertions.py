# SPDX-License-Identifier: Apache-2.0
"""Assertions of sim/rtl/assertions: each fires on a planted violation; every block of state has.

All checkers are side by side in one bench. A case of violations.toml drives the ports of one;
Verilator names what failed. One block of the RTL is there too: a checker bound to it fires.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest
from pyslang import ast, syntax

from sim.rtl.assertion_files import FOLDER, RULES, assertions_of
from sim.rtl.build import ROOT
from tests.bench.self_running import Program

TABLE = tomllib.loads(Path(__file__).with_name("violations.toml").read_text())
PACKAGES = [
    ROOT / f"rtl/{name}_pkg.sv"
    for name in (
        "fpu/fp",
        "gen/ci",
        "gen/asip_isa",
        "gen/asip_regmap",
        "asip/asip",
        "gen/n2_system",
        "gen/debug_regmap",
        "debug/debug",
        "gen/esc_regmap",
        "ethercat/ecat",
    )
]
BOUND = ROOT / "rtl/motion/line_interpolator.sv"
# Registers without a rule of order: memories, the steps of an approximation, and boards' tops.
WITHOUT = {
    *("fp_sincos_memory", "fp_sincos_result"),  # rules: fp_sincos, fp_sincos_overlapped
    *("asip_de3", "asip_ecp5"),  # reset and lights
}
CASES = [(checker, label) for checker, rows in TABLE.items() for label in rows if label != "idle"]


@dataclass(frozen=True)
class Checker:
    """A checker alone: its ports {name: bits} and its text without what binds it."""

    name: str
    ports: dict[str, int]
    text: str


def labels(path: Path) -> list[str]:
    """Names of the assertions of a file."""
    return re.findall(r"(\w+)\s*:\s*assert property", path.read_text())


def checker(name: str) -> Checker:
    """The checker of this name, its ports as slang sees them."""
    text = re.sub(r"(?ms)^bind .*?;\n", "", (FOLDER / f"{name}.sv").read_text())
    compilation = ast.Compilation()
    for path in PACKAGES:
        compilation.addSyntaxTree(syntax.SyntaxTree.fromFile(str(path)))
    compilation.addSyntaxTree(syntax.SyntaxTree.fromText(text))
    top = next(top for top in compilation.getRoot().topInstances if top.name == name)
    return Checker(name, {port.name: port.type.bitWidth for port in top.body.portList}, text)


def assignments(row: str) -> dict[str, int]:
    """Values of the ports that a clock names."""
    words = (word.partition("=") for word in row.split())
    return {name: int(value or "1", 0) for name, _, value in words}


def bench(checkers: list[Checker]) -> str:
    """SystemVerilog text: checkers, a bound block, and the cases one after another."""
    lines = [
        "module bench;",
        "logic clk_i = 1'b0, rst_ni = 1'b0, start = 1'b0, active;",
        "logic [1:0] step, negative;",
        "line_interpolator u_line (.clk_i, .rst_ni, .flush_i(1'b0), .start_i(start),"
        " .combined_i(1'b1), .end_u_i(24'sd5), .end_v_i(24'sd3), .advance_i(1'b0),"
        " .active_o(active), .step_o(step), .negative_o(negative));",
        "always #5 clk_i = !clk_i;",
    ]
    own = {"clk_i": "clk_i", "rst_ni": "rst_ni"}
    for each in checkers:
        driven = {port: bits for port, bits in each.ports.items() if port not in own}
        lines += [f"logic [{bits - 1}:0] {each.name}__{port};" for port, bits in driven.items()]
        pins = [f".{port}({own.get(port, f'{each.name}__{port}')})" for port in each.ports]
        lines.append(f"{each.name} u_{each.name} ({', '.join(pins)});")

    def drive(each: Checker, row: str) -> list[str]:
        values = assignments(TABLE[each.name].get("idle", "")) | assignments(row)
        unknown = set(values) - set(each.ports)
        assert not unknown, f"violations.toml: {each.name} has no port {sorted(unknown)}"
        return [
            f"{each.name}__{port} = {bits}'d{values.get(port, 0)};"
            for port, bits in each.ports.items()
            if port not in own
        ]

    step = "@(negedge clk_i);"
    by_name = {each.name: each for each in checkers}
    lines += ["`ifdef WAVES", "string waves;", 'initial if ($value$plusargs("waves=%s", waves))']
    lines += ["begin $dumpfile(waves); $dumpvars; end", "`endif", "initial begin"]
    for each in checkers:
        lines += drive(each, "")
    lines += [step, "rst_ni = 1'b1;", *3 * [step], '$display("CASE bound");']
    lines += ["start = 1'b1;", step, step, "start = 1'b0;", step]
    for name, label in CASES:
        each = by_name[name]
        lines += ["rst_ni = 1'b0;", *drive(each, ""), step, "rst_ni = 1'b1;", *3 * [step]]
        lines.append(f'$display("CASE {name}.{label}");')
        for row in TABLE[name][label].split(";"):
            count, _, row = row.rpartition(" x ")
            lines += [f"repeat ({count or 1}) begin", *drive(each, row), step, "end"]
        lines += [*drive(each, ""), step, step, '$display("CASE");']
    return "\n".join([*lines, "$finish;", "end", "endmodule", ""])


@pytest.fixture(scope="module")
def fired(tmp_path_factory) -> dict[str, str]:
    """What Verilator printed, case by case; "" is outside all cases."""
    folder = tmp_path_factory.mktemp("assertions")
    checkers = [checker(name) for name in TABLE]
    bound = FOLDER / f"{BOUND.stem}_sva.sv"
    files = [*PACKAGES, BOUND, *assertions_of([BOUND])]
    for each in checkers:
        if FOLDER / f"{each.name}.sv" not in (bound, *RULES):
            files.append(folder / f"{each.name}.sv")
            files[-1].write_text(each.text)
    files.append(folder / "bench.sv")
    files[-1].write_text(bench(checkers))
    # It runs for a second; with the compiler's optimisation it would be built for a minute.
    program = Program("bench", files, folder / "obj", "-Wno-lint", optimisation="-O0")
    done = program.run("+verilator+error+limit+100000")
    output: dict[str, str] = {"": ""}
    case = ""
    for line in (done.stdout + done.stderr).splitlines():
        if line.startswith("CASE"):
            case = line[5:]
        output[case] = output.get(case, "") + line + "\n"
    return output


@pytest.mark.full
@pytest.mark.parametrize(("checker_name", "label"), CASES, ids=[".".join(case) for case in CASES])
def test_violation__assertion_fires(fired, checker_name, label):
    said = fired[f"{checker_name}.{label}"]
    assert re.search(rf"Assertion failed in \S*u_{checker_name}\S*\.{label}\b", said), said


@pytest.mark.full
def test_nothing_wrong__nothing_fires(fired):
    assert "Assertion failed" not in fired[""], fired[""]


@pytest.mark.full
def test_bound_checker__violation_in_the_block__fires(fired):
    assert re.search(r"Assertion failed in \S*u_line\.u_sva\.NoStartWhileActive", fired["bound"])


def test_table__has_every_assertion():
    planted = {name: sorted(set(rows) - {"idle"}) for name, rows in TABLE.items()}
    written = {path.stem: sorted(labels(path)) for path in FOLDER.glob("*.sv") if labels(path)}
    assert planted == written


def test_every_block_with_state__has_assertions():
    with_state = {
        path.stem
        for path in (ROOT / "rtl").rglob("*.sv")
        if re.search(r"\balways_ff\b|\balways @", path.read_text())
    }
    checked = {path.stem.removesuffix("_sva") for path in FOLDER.glob("*_sva.sv")}
    assert with_state - checked == WITHOUT, "write sim/rtl/assertions/<module>_sva.sv"
    assert checked <= {path.stem for path in (ROOT / "rtl").rglob("*.sv")}
