# SPDX-License-Identifier: Apache-2.0
"""Table of docs/your_robot.md: cycles and memory of matrix laws by configuration."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.mpc_problem import Problem
from asip_asm.model.program import Built, build
from asip_asm.project import ROOT
from scripts.generated import run
from sim.bench.stream_law_goals import POLICIES, drawn_policy, policy_law
from sim.laws.mpc import build_mpc
from sim.laws.mpc_flight import quadrotor_problem
from sim.laws.observer import build_observer, observer
from sim.laws.rocket_landing import rocket_problem

SCRIPT, PAGE = "scripts/matrix_table.py", "docs/your_robot.md"
LANES = (2, 4, 8)
ELEMENTS = 4  # 18x18 of a multiply-add lane


def matrix_laws(folder: Path) -> Iterator[tuple[str, str, Callable[[], Built]]]:
    """Name and configuration of each law of the table, and what builds its program."""
    source = folder / "law.s"
    for configuration, sizes in POLICIES:

        def policy(configuration: str = configuration, sizes: tuple[int, ...] = sizes) -> Built:
            law = policy_law(drawn_policy(sizes, folder), sizes)
            return build(compile_law(law, Options(configuration=configuration)), source)

        yield f"policy {'-'.join(map(str, sizes))}, Elu", configuration, policy
    problems = {
        "quadrotor MPC 12/4/10, 10 iterations": quadrotor_problem,
        "rocket MPC 6/3/10 with a cone, 12 iterations": rocket_problem,
    }
    for name, load in problems.items():
        for configuration in ("stream", "wide"):

            def solver(
                configuration: str = configuration, load: Callable[[], Problem] = load
            ) -> Built:
                return build_mpc(load(), source, configuration)[0]

            yield name, configuration, solver
    for configuration in ("stream", "wide"):

        def watcher(configuration: str = configuration) -> Built:
            return build_observer(observer(), source, configuration)

        yield "observer 24/5/3", configuration, watcher


def longest_stream(image: Image) -> int:
    """Words of the longer of both streams, vectors on `wide`."""
    return max(sum(len(b.words) for b in image.streams if b.pin == pin) for pin in "AB")


def rows() -> list[str]:
    """Lines of the table."""
    isa = default_isa()
    clock = isa.clock_mhz
    lines = [
        "| law | configuration | multiply-adds a cycle | cycles | us | stream | data | bundles |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    with tempfile.TemporaryDirectory() as folder:
        for name, configuration, build_law in matrix_laws(Path(folder)):
            one = build_law()
            products = 2 * (1 + isa.configurations[configuration].lanes)
            sizes = (
                f"{longest_stream(one.image)} | {len(one.image.data)} | {len(one.image.bundles)}"
            )
            time = f"{one.cycles} | {one.cycles / clock:.1f}"
            lines.append(f"| {name} | `{configuration}` | {products} | {time} | {sizes} |")
    return lines


def lane_rows() -> list[str]:
    """Lines of the table of lanes: cycles, and words of the longer stream, with 2, 4 and 8."""
    words = default_isa().configurations["wide"].stream_words
    cells: dict[str, list[str]] = {}
    for lanes in LANES:
        command = [sys.executable, "-m", "scripts.lane_study", str(lanes)]
        done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
        for law in json.loads(done.stdout):
            fits = "cycles" in law
            cell = f"{law['cycles']}; {law['stream']}" if fits else f"more than {words} words"
            cells.setdefault(law["law"], []).append(cell)
    head = " | ".join(f"{lanes} lanes" for lanes in LANES)
    elements = " | ".join(str(ELEMENTS * 2 * lanes) for lanes in LANES)
    return [
        f"| law: cycles; words of the longer stream | {head} |",
        "| --- |" + " --- |" * len(LANES),
        *(f"| {law} | {' | '.join(row)} |" for law, row in cells.items()),
        f"| 18x18 elements of both pipes | {elements} |",
    ]


def generate() -> dict[str, str]:
    """Text of the page by its path, with the tables of today."""
    text = (ROOT / PAGE).read_text(encoding="utf-8")
    for mark, lines in (("matrix laws", rows), ("lanes", lane_rows)):
        begin, end = f"<!-- {mark}: begin -->", f"<!-- {mark}: end -->"
        head, _, rest = text.partition(begin)
        _, _, tail = rest.partition(end)
        text = "\n".join([f"{head}{begin}", "", *lines(), "", f"{end}{tail}"])
    return {PAGE: text}


if __name__ == "__main__":
    sys.exit(run(SCRIPT, __doc__.splitlines()[0], generate))
