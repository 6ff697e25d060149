# SPDX-License-Identifier: Apache-2.0
"""Command microtick mpc: a program for the core from a problem of model-predictive control."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from asip_asm.c_image import c_files
from asip_asm.command import command_parser, count, run_command
from asip_asm.files import open_output, refuse_overwriting
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.model.c_code import to_c_code
from asip_asm.model.law import check_limits
from asip_asm.model.mpc_bound import input_bounds
from asip_asm.model.mpc_lane_program import mpc_plan
from asip_asm.model.mpc_problem import Problem, half_width, load_problem
from asip_asm.model.mpc_program import mpc_law
from asip_asm.model.options import compiled
from asip_asm.model.plan import Plan, stream_machine
from asip_asm.model.program import Built, build
from asip_asm.model.read import ModelError

PROG = "microtick mpc"
CLOCK = 125  # MHz
TICKS, SEED = 1000, 1
TIMED = 100_000
"""Ticks of the C that are timed, one by one."""
EPILOG = """example:
  microtick mpc quadrotor.toml --prove -o build/quadrotor

writes build/quadrotor.s (assembly with loops and streams), .asip.json (image), .asip.map.json
(debug map), .h (tables for the C driver) and .report.txt, with --c also .tick.c and .tick.h (the
same program in C). With --prove the program runs on the core, and the C on this machine. Both are
compared with the exact interpreter and with double precision, and the distance of the plans
from the true optimum is measured (docs/your_robot.md#your-mpc-in-ten-minutes).

exit status: 0 written, and proved with --prove; 1 an error, or a proof that failed; 2 wrong command
line
"""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    return run_command(PROG, lambda: _mpc(options), ModelError)


def parse_arguments(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of the command line; SystemExit(2) if they are wrong."""
    streams = [name for name, c in default_isa().configurations.items() if c.stream_words]
    parser = command_parser(PROG, "Compile a problem of model-predictive control.", EPILOG)
    parser.add_argument("problem", type=Path, help="the problem, a TOML file")
    parser.add_argument("-o", dest="output", metavar="STEM", help="files to write, without suffix")
    parser.add_argument(
        "--config", choices=streams, default=streams[0], help="configuration of the core"
    )
    parser.add_argument("--c", action="store_true", help="write the program as C too: STEM.tick.c, "
                        "STEM.tick.h")  # fmt: skip
    parser.add_argument("--prove", action="store_true", help="run on the core and compare")
    parser.add_argument(
        "--ticks", type=count, default=TICKS, help="number of ticks that the proof runs"
    )
    parser.add_argument("--states", type=count, default=10_000, help="initial states whose optimum "
                        "is computed")  # fmt: skip
    return parser.parse_args(arguments)


def _mpc(options: argparse.Namespace) -> int:
    stem = Path(options.output or options.problem.with_suffix(""))
    ends = [".s", ".asip.json", ".asip.map.json", ".h", ".report.txt"]
    ends += [".tick.h", ".tick.c"] if options.c else []
    paths = {end: stem.with_name(stem.name + end) for end in ends}
    refuse_overwriting(list(paths.values()), [options.problem])
    problem = load_problem(options.problem)
    stem.parent.mkdir(parents=True, exist_ok=True)
    built, plan = build_mpc(problem, paths[".s"], options.config)
    lines = summary(problem, built, plan)
    texts = {
        ".asip.json": Image.dumps(built.image),
        ".asip.map.json": built.map.dumps(),
        **c_files("", built.image),
        ".report.txt": "\n".join([*lines, "", built.report.render()]),
    }
    if options.c:
        texts[".tick.h"], texts[".tick.c"] = to_c_code(built.compiled, paths[".tick.h"].name)
    for end, text in texts.items():
        with open_output(paths[end]) as file:
            file.write(text)
    print("\n".join([f"{paths['.asip.json']}: {lines[0]}", *lines[1:]]))
    return _prove(problem, built, options) if options.prove else 0


def build_mpc(problem: Problem, path: Path, configuration: str = "stream") -> tuple[Built, Plan]:
    """The program of a problem, its source at `path`, and its plan. Raises ModelError, OSError."""
    law, machine = mpc_law(problem), stream_machine(configuration)
    check_limits(law, machine)
    plan = mpc_plan(problem, machine)
    return build(compiled(plan, law), path), plan


def summary(problem: Problem, built: Built, plan: Plan) -> list[str]:
    """Cycles, where they go, and words of the memories."""
    isa, cycles = default_isa(), built.cycles
    boxes = (problem.state_box, problem.input_box)
    rho = ", ".join(
        f"{name} = {max([*weights[on] * half_width(box)[on] ** 2, 0.0]):.3g}"
        for name, weights, box, on in zip(
            ("state", "input"), problem.penalty, boxes, problem.boxed(), strict=True
        )
    )
    bound = input_bounds(problem).max()
    return [
        f"{cycles} cycles, {cycles / CLOCK:.1f} us at {CLOCK} MHz",
        f"penalty = {{ {rho} }}, relaxation = {problem.relaxation:g}",
        *plan.account(cycles),
        f"memories: {len(built.image.bundles)} of {isa.program_bundles} bundles, "
        f"{len(built.image.data)} of {isa.data_words} data words, "
        + " and ".join(str(len(words)) for words in plan.streams.values())
        + f" of {plan.machine.build.stream_words} words of the streams",
        f"roundings move an input by less than {bound:.2g} in a tick from zero memories, for every "
        "state in the box 'start'",
    ]


def _prove(problem: Problem, built: Built, options: argparse.Namespace) -> int:
    from sim.core.api import CoreFault
    from sim.laws.mpc_proof import prove_mpc
    from sim.laws.mpc_reference import distance

    try:
        proof = prove_mpc(problem, built.compiled, built.image, options.ticks)
    except CoreFault as fault:
        print(f"{PROG}: the program stops for a state within 'start': {fault}")
        return 1
    print("\n".join([*proof.lines(), *distance(problem, options.states).lines()]))
    passed = proof.passed and (not options.c or _prove_c(built, options))
    print("proved" if passed else "NOT proved")
    return 0 if passed else 1


def _prove_c(built: Built, options: argparse.Namespace) -> bool:
    """Whether the C has the interpreter's bits on this machine, over consecutive ticks. Prints its
    time and that of the core too.
    """
    from sim.laws.native.bits import prove_c
    from sim.laws.native.law import CompilerError, NativeLaw
    from sim.laws.prove_program import draw_ticks

    try:
        difference = prove_c(built.compiled, options.ticks, SEED)
        drawn, _ = draw_ticks(built.compiled.law, options.ticks, np.random.default_rng(SEED))
        times = NativeLaw(built.compiled).time(drawn, TIMED)
    except CompilerError as error:
        print(f"{PROG}: error: {error}", file=sys.stderr)
        return False
    equal = "bits equal the interpreter's"
    print(f"C on this machine: {difference or equal}")
    taken = (times.ticks - times.clock) / 1000
    median, far, worst = np.quantile(taken, (0.5, 0.9999, 1.0))
    print(
        f"time of the C, {TIMED} ticks: median {median:.2f} us, 99.99 % {far:.2f} us, worst "
        f"{worst:.2f} us; the core at {CLOCK} MHz: {built.cycles / CLOCK:.2f} us in every tick"
    )
    return not difference
