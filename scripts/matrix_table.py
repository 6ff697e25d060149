# SPDX-License-Identifier: Apache-2.0
"""Table of docs/your_robot.md: cycles and memory of matrix laws by configuration."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from asip_asm.isa import default_isa
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.program import build
from asip_asm.project import ROOT
from scripts.generated import run
from sim.bench.stream_law_goals import POLICIES, drawn_policy, policy_law
from sim.laws.mpc import build_mpc
from sim.laws.mpc_flight import quadrotor_problem
from sim.laws.rocket_landing import rocket_problem

SCRIPT, PAGE = "scripts/matrix_table.py", "docs/your_robot.md"
BEGIN, END = "<!-- matrix laws: begin -->", "<!-- matrix laws: end -->"


def rows() -> list[str]:
    """Lines of the table."""
    isa = default_isa()
    clock = isa.clock_mhz
    lines = [
        "| law | configuration | multiply-adds a cycle | cycles | us | stream | data | bundles |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    with tempfile.TemporaryDirectory() as folder:
        built = []
        for configuration, sizes in POLICIES:
            policy = drawn_policy(sizes, Path(folder))
            made = compile_law(policy_law(policy, sizes), Options(configuration=configuration))
            name = f"policy {'-'.join(map(str, sizes))}, Elu"
            built.append((name, configuration, build(made, Path(folder) / "law.s")))
        for configuration in ("stream", "wide"):
            for name, problem in (
                ("quadrotor MPC 12/4/10, 10 iterations", quadrotor_problem()),
                ("rocket MPC 6/3/10 with a cone, 12 iterations", rocket_problem()),
            ):
                made_mpc, _ = build_mpc(problem, Path(folder) / "law.s", configuration)
                built.append((name, configuration, made_mpc))
    for name, configuration, one in built:
        words = max(sum(len(b.words) for b in one.image.streams if b.pin == pin) for pin in "AB")
        products = 2 * (1 + isa.configurations[configuration].lanes)
        sizes_used = f"{words} | {len(one.image.data)} | {len(one.image.bundles)}"
        time = f"{one.cycles} | {one.cycles / clock:.1f}"
        lines.append(f"| {name} | `{configuration}` | {products} | {time} | {sizes_used} |")
    return lines


def generate() -> dict[str, str]:
    """Text of the page by its path, with the table of today."""
    text = (ROOT / PAGE).read_text(encoding="utf-8")
    head, _, rest = text.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return {PAGE: "\n".join([f"{head}{BEGIN}", "", *rows(), "", f"{END}{tail}"])}


if __name__ == "__main__":
    sys.exit(run(SCRIPT, __doc__.splitlines()[0], generate))
