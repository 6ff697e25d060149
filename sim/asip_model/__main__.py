# SPDX-License-Identifier: Apache-2.0
"""Command asip-model: a program for the core from a CasADi function and an interface record, or
from a URDF and the name of a law.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from asip_asm.c_image import to_c
from asip_asm.command import count, duration, run_command
from asip_asm.diagnostics import AssemblyError
from asip_asm.files import open_output, refuse_overwriting
from asip_asm.image import Image
from asip_asm.isa import default_isa
from asip_asm.model.c_code import to_c_code
from asip_asm.model.compiler import SINES, Options, compile_law
from asip_asm.model.law import Law, load_law
from asip_asm.model.program import Built, build
from asip_asm.model.read import ModelError
from asip_asm.signals import InterfaceError
from sim.asip_model.effects import effects
from sim.robots.closed_loop import Arm, close_loop
from sim.robots.laws import LAWS, Settings
from sim.robots.tree import RobotError, Tree, load_tree

EPILOG = """example:
  import casadi as ca                                   # law.py
  q, goal = ca.SX.sym("q"), ca.SX.sym("goal")
  law = ca.Function("law", [q, goal], [40*(goal - q)], ["q", "goal"], ["torque"])
  law.save("law.casadi")

  asip-model law.casadi law.interface.toml --reassociate --prove -o build/law
  asip-model arm.urdf --law computed_torque --reassociate --prove --loop 2

writes build/law.s (linear assembly), .asip.json (image), .h (tables for the C driver) and
.report.txt (cycles, bounds, occupancy, what each option changes); with --c also build/law.tick.c
and .tick.h, the law as a C function for the Nios II systems or a PC. Arguments and results of the
function go by the names of the signals, or of their vectors (docs/your_robot.md).

exit status: 0 written, and proved with --prove; 1 an error, a proof that failed, or a loop beyond
its bound; 2 wrong command line
"""
RATIO = 1.05
"""Largest tracking error on the core by that in double precision."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    return run_command("asip-model", lambda: _model(options))


def _model(options: argparse.Namespace) -> int:
    stem = options.output or options.function.with_suffix("")
    ends = (".s", ".asip.json", ".h", ".report.txt", *((".tick.h", ".tick.c") if options.c else ()))
    paths = {end: Path(f"{stem}{end}") for end in ends}
    try:
        given = [path for path in (options.function, options.interface) if path]
        refuse_overwriting(paths.values(), given)
        law, tree, settings = _law(options)
        chosen = Options(options.config, options.reassociate, options.reciprocal, options.sine)
        paths[".s"].parent.mkdir(parents=True, exist_ok=True)
        built = build(compile_law(law, chosen), paths[".s"])
    except (ModelError, InterfaceError, RobotError) as error:
        print(f"asip-model: error: {error}", file=sys.stderr)
        return 1
    except AssemblyError as error:
        print(error.report(), file=sys.stderr)
        return 1
    texts = {
        ".asip.json": Image.dumps(built.image),
        ".h": to_c(built.image, ""),
        ".report.txt": built.report.render() + "\n" + effects(built.compiled, options.seed),
    }
    if options.c:
        header, source = to_c_code(built.compiled, paths[".tick.h"].name)
        texts |= {".tick.h": header, ".tick.c": source}
    for end, text in texts.items():
        with open_output(paths[end]) as file:
            file.write(text)
    print(f"{paths['.asip.json']}: {built.cycles} cycles, lower bound {built.bound_cycles}")
    status = _prove(built, options) if options.prove else 0
    if options.loop and tree is not None:
        status = max(status, _loop(built, tree, settings, options.loop))
    return status


def _law(options: argparse.Namespace) -> tuple[Law, Tree | None, Settings]:
    """The law, and the robot of a URDF with the settings of its law."""
    settings = Settings(
        rate=options.rate,
        counts=options.counts,
        bandwidth=options.bandwidth,
        integral=options.integral,
        friction=options.friction,
    )
    if options.function.suffix == ".urdf":
        tree = load_tree(options.function, options.lock)
        return LAWS[options.law](tree, settings), tree, settings
    return load_law(options.function, options.interface), None, settings


def _loop(built: Built, tree: Tree, settings: Settings, seconds: float) -> int:
    from sim.core import CoreFault

    try:
        loop = close_loop(built.compiled.law, built.image, Arm(tree, settings, seconds))
    except CoreFault as fault:
        print(f"asip-model: the program stops in the closed loop: {fault}")
        return 1
    worst = ", ".join(f"{error:.2g}" for error in abs(loop.core.errors).max(axis=0))
    print(f"closed loop: {loop.ticks} ticks, largest errors {worst} [{loop.unit}]")
    print(f"largest error by that in double precision: {loop.ratio:.4f}")
    if loop.saturated:
        print(
            f"an output was at its limit in {loop.saturated} ticks: take a lower --bandwidth "
            "or finer --counts, or expect the errors above to depend on chance"
        )
    return 0 if loop.ratio <= RATIO else 1


def _prove(built: Built, options: argparse.Namespace) -> int:
    from sim.core import CoreFault
    from sim.prove_program import prove

    try:
        proof = prove(built.compiled, built.image, count=options.inputs, seed=options.seed)
    except CoreFault as fault:
        print(f"asip-model: the program stops for an input within its limits: {fault}")
        return 1
    equal = "bits equal the interpreter's" if proof.bits_equal else proof.first_difference
    print(f"{proof.inputs_tried} inputs, seed {proof.seed}: {equal}")
    print(
        f"largest error / bound {proof.worst_fraction_of_bound:.3g} ({proof.worst_result}); "
        + ", ".join(f"{name} {error:.3g}" for name, error in proof.largest_error.items())
    )
    if proof.unbounded:
        print(f"{proof.unbounded} results have no finite bound: keep divisors away from zero")
    passed = proof.passed and (not options.c or _prove_c(built, options))
    print("proved" if passed else "NOT proved")
    return 0 if passed else 1


def _prove_c(built: Built, options: argparse.Namespace) -> bool:
    """Whether the C has the interpreter's bits on this machine."""
    from sim.platforms.bits import prove_c
    from sim.platforms.native import CompilerError

    try:
        difference = prove_c(built.compiled, options.inputs, options.seed)
    except CompilerError as error:
        print(f"asip-model: error: {error}", file=sys.stderr)
        return False
    equal = "bits equal the interpreter's with the C library's sine"
    print(f"C on this machine: {difference or equal}")
    return not difference


def parse_arguments(arguments: list[str] | None = None) -> argparse.Namespace:
    """Options of the command line; SystemExit(2) if they are wrong."""
    parser = argparse.ArgumentParser(
        prog="asip-model",
        description="Compile a CasADi function into a program for the core.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "function", type=Path, help="file that casadi.Function.save wrote, or a robot's URDF"
    )
    parser.add_argument(
        "interface", type=Path, nargs="?", help="interface record (*.interface.toml) of a function"
    )
    parser.add_argument("-o", dest="output", metavar="STEM", help="files to write, without suffix")
    parser.add_argument(
        "--config",
        choices=tuple(default_isa().configurations),
        default="fast",
        help="configuration of the core",
    )
    parser.add_argument(
        "--reassociate",
        action="store_true",
        help="join the terms of sums as they arrive: shorter, rounds differently",
    )
    parser.add_argument(
        "--reciprocal",
        action="store_true",
        help="divide by a shared or constant divisor through its reciprocal: rounds once more",
    )
    parser.add_argument(
        "--sine",
        choices=SINES,
        default=SINES[0],
        help="balanced: those sines and cosines that would wait for the sine unit, of inputs with "
        "limits, become polynomials; unit: none",
    )
    parser.add_argument(
        "--c", action="store_true", help="write the law as C too: STEM.tick.c, STEM.tick.h"
    )
    parser.add_argument("--prove", action="store_true", help="run on the core and compare")
    parser.add_argument("--inputs", type=count, default=10_000, help="inputs of the proof")
    parser.add_argument("--seed", type=int, default=1, help="seed of the proof's inputs")
    robot = parser.add_argument_group("laws of a URDF")
    robot.add_argument("--law", choices=tuple(LAWS), default="computed_torque", help="which law")
    robot.add_argument("--rate", type=float, default=10_000.0, help="ticks per second")
    robot.add_argument("--counts", type=int, default=1 << 20, help="encoder counts per turn")
    robot.add_argument("--bandwidth", type=float, default=20.0, help="of the position loop [Hz]")
    robot.add_argument("--integral", action="store_true", help="PID in place of PD")
    robot.add_argument("--friction", action="store_true", help="the URDF's friction in the law")
    robot.add_argument("--lock", action="append", default=[], help="a joint that does not move")
    robot.add_argument(
        "--loop",
        type=duration,
        metavar="SECONDS",
        help="closed loop with the robot (computed_torque)",
    )
    options = parser.parse_args(arguments)
    urdf = options.function.suffix == ".urdf"
    if urdf == (options.interface is not None):
        parser.error("a function needs its interface record, a URDF has none")
    if options.loop and not (urdf and options.law == "computed_torque"):
        parser.error("--loop is for computed_torque of a URDF")
    return options


if __name__ == "__main__":
    sys.exit(main())
