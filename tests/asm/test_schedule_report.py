# SPDX-License-Identifier: Apache-2.0
"""Report of a scheduled program: figures worked out by hand on small programs."""

import pytest

from asip_asm.assemble import build_program
from asip_asm.ir import Register
from asip_asm.machine import RUN_OVERHEAD, load_machine
from asip_asm.report import report_program

from .workload import Builder, arrange, loop_program

FAST = load_machine("fast")
K0, K1 = Register("K", 0), Register("K", 1)
FMA = FAST.units["fma"].latency
CMP = FAST.units["cmp"].latency


def chain_of_three():
    build = Builder()
    x = build.op("fmul", K0, K1)
    y = build.op("fmul", x, x)
    build.output("mov", y)
    return build.program


def test_chain__is_bounded_by_its_critical_path():
    program = chain_of_three()
    arrange(program, FAST)
    section = report_program(program, FAST).sections[0]
    path = 2 * (FMA + 1) + CMP + 1 + RUN_OVERHEAD
    assert (section.cycles, section.critical_path, section.bound) == (path, path, path)
    assert section.distance == 0.0
    assert section.stalls["operand"] == 2 * FMA
    assert section.bundles == 3


def test_independent_operations__are_bounded_by_the_slots():
    build = Builder()
    for _ in range(20):
        build.op("fmul", K0, K1)
    arrange(build.program, FAST, in_order=True)
    section = report_program(build.program, FAST).sections[0]
    assert section.bounds["fma slots"] == 9 + FMA + 1 + RUN_OVERHEAD
    assert section.cycles == 19 + FMA + 1 + RUN_OVERHEAD
    assert section.occupancy("fma slots") == pytest.approx(100 * 20 / (2 * section.cycles))


def test_registers__count_values_in_use_at_once_and_states():
    build = Builder()
    build.state("s", pin="A")
    values = [build.op("mov", K0) for _ in range(5)]
    for value in values:
        build.output("mov", value)
    arrange(build.program, FAST, in_order=True)
    report = report_program(build.program, FAST)
    assert report.registers == {"A": (1, 64), "B": (0, 64), "C": (5, 64)}


def test_program_with_branches__has_a_section_per_region():
    program = loop_program()
    arrange(program, FAST)
    report = report_program(program, FAST)
    assert [section.title for section in report.sections] == [
        "region 0",
        "loop",
        "region 2",
        "region 3",
        "end",
    ]


def test_body_of_a_loop__has_the_cycles_of_its_rounds(tmp_path):
    path = tmp_path / "loop.s"
    head = [".config stream", ".param x = 0.5", ".output y, safe = 0", "fmul p, x, x"]
    rows = [*head, "loop 9", "fmul p, p, x", "fadd p, p, x", "endloop", "fabs y, p", "halt", ""]
    path.write_text("\n".join(rows), encoding="utf-8")
    report = report_program(*build_program(path))
    chain = 2 * (FMA + 1), FMA + 2  # around the loop; of one round, to its last bundle
    assert [section.round_cycles for section in report.sections] == [None, chain, None]
    assert f"a round of the loop  {chain[0]} cycles, {chain[1]} at least" in report.render()


def test_text__names_every_figure():
    program = chain_of_three()
    program.title = "chain"
    arrange(program, FAST)
    text = report_program(program, FAST).render()
    path = 2 * (FMA + 1) + CMP + 1 + RUN_OVERHEAD
    assert text.startswith("chain (fast)\n")
    assert f"cycles               {path}, 0.0 % above the lower bound\n" in text
    assert f"critical path {path}, fma slots" in text
    assert f"operand {2 * FMA}, waw 0, unit 0, port 0\n" in text
    assert "A 1/64, B 0/64, C 0/64\n" in text
