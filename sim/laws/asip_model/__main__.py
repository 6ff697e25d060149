# SPDX-License-Identifier: Apache-2.0
"""Command asip-model: a program for the core from a CasADi function and an interface record, or
from a URDF and the name of a law.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import replace
from pathlib import Path

from asip_asm.c_image import c_files
from asip_asm.command import command_parser, count, duration, run_command
from asip_asm.files import open_output, refuse_overwriting
from asip_asm.image import Image, ImageError
from asip_asm.isa import default_isa
from asip_asm.link import LinkError, link, link_maps
from asip_asm.model.c_code import to_c_code
from asip_asm.model.certificate import certify
from asip_asm.model.compiler import SINES, Options
from asip_asm.model.law import Law, load_law
from asip_asm.model.onnx_file import OnnxPolicy
from asip_asm.model.program import Built, build
from asip_asm.model.read import ModelError
from asip_asm.signals import InterfaceError
from sim.laws.account import account
from sim.laws.asip_model.effects import Forms, allowed_sets, effects, words
from sim.laws.asip_model.proof_report import CERTIFICATE, report, write_certificate
from sim.laws.asip_model.robot_options import (
    add_robot_options,
    check_robot_options,
    is_urdf,
    reference_of,
    robot_law,
    settings_of,
)
from sim.laws.closed_loop import Arm, close_loop
from sim.laws.elements import RobotError
from sim.laws.laws import Settings
from sim.laws.prove_casadi import truth_of_files
from sim.laws.prove_points import Point, directed, load_points
from sim.laws.prove_reference import RobotTruth, Truth
from sim.laws.tree import Tree

EPILOG = """example:
  import casadi as ca                                   # law.py
  q, goal = ca.SX.sym("q"), ca.SX.sym("goal")
  law = ca.Function("law", [q, goal], [40*(goal - q)], ["q", "goal"], ["torque"])
  law.save("law.casadi")

  asip-model law.casadi law.interface.toml --reassociate --prove -o build/law
  asip-model arm.urdf --law computed_torque --reassociate --prove --loop 2
  asip-model fast.casadi fast.interface.toml slow.casadi slow.interface.toml -o build/both

writes build/law.s (linear assembly), .asip.json (image), .asip.map.json (its debug map, for
asip-dbg), .h (tables for the C driver) and .report.txt (cycles, bounds, occupancy; with
--effects what each option changes). With --prove it also writes .certificate.json (what is proved,
docs/numerics.md), with --c
build/law.tick.c and .tick.h, the law as a C function for the Nios II systems or a PC. Arguments and
results of the function go by the names of the signals, or of their vectors (docs/your_robot.md).
With several functions .s, .asip.map.json, .certificate.json, .tick.c and .tick.h are
build/both.NAME.s and so on.

exit status: 0 written, and proved with --prove; 1 an error, a proof that failed, or a loop beyond
its bound; 2 wrong command line
"""
RATIO = 1.05
"""Tracking error of an axis on the core by that in double precision, at most."""
MILLION = 1_000_000
EFFORT = 5
"""Million operations of a certificate by default: some seconds."""


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    options = parse_arguments(arguments)
    errors = (ModelError, InterfaceError, RobotError, LinkError, ImageError)
    return run_command("asip-model", lambda: _model(options), *errors)


def _model(options: argparse.Namespace) -> int:
    stem = options.output or options.parts[0][0].with_suffix("")
    several = len(options.parts) > 1
    settings = settings_of(options)
    stems = {name: f"{stem}.{name}" if several else str(stem) for name in _names(options)}
    ends = (".s", ".asip.map.json", *((".tick.h", ".tick.c") if options.c else ()))
    ends += (CERTIFICATE,) if options.prove else ()
    paths = [Path(f"{each}{end}") for each in stems.values() for end in ends]
    paths += [Path(f"{stem}{end}") for end in (".asip.json", ".h", ".report.txt")]
    refuse_overwriting(paths, [path for part in options.parts for path in part if path])
    laws = [_law(options, file, interface, settings) for file, interface in options.parts]
    points = load_points(options.points, laws[0][0]) if options.points else []
    # Each of several functions keeps its registers from run to run: constants would take them all.
    base = Options(options.config, constants=options.constants, registers=not several)
    free = (options.reassociate, options.reciprocal, options.sine)
    if not options.best:
        free = (bool(options.reassociate), bool(options.reciprocal), options.sine or SINES[0])
    allowed = allowed_sets(base, *free)
    paths[0].parent.mkdir(parents=True, exist_ok=True)
    forms = {name: Forms(law) for name, (law, _) in zip(stems, laws, strict=True)}
    ranked = {name: _ranked(name, form, allowed) for name, form in forms.items()}
    while True:
        status = 0
        built = {n: build(of[0].compiled, Path(f"{stems[n]}.s")) for n, of in ranked.items()}
        image = _write(options, stem, stems, built, forms, laws, settings)
        failed = []
        for (name, one), (_, tree), files in zip(
            built.items() if options.prove else (), laws, options.parts, strict=False
        ):
            whole = replace(one, image=image.function(name)) if several else one
            file = Path(f"{stems[name]}{CERTIFICATE}")
            truth = reference_of(options, tree, settings) if tree else truth_of_files(*files)
            if _prove(whole, options, truth, points, file):
                failed.append(name)
        if not failed:
            break
        status = 1
        if not all(ranked[name][1:] for name in failed):
            break
        for name in failed:  # --best: the next shortest
            ranked[name].pop(0)
            print(f"{name}: next with {words(ranked[name][0].compiled.options)}")
    if options.prove and several:
        status = max(status, _prove_together(image, built, options))
    if options.loop and laws[0][1] is not None:
        status = max(status, _loop(built.popitem()[1], laws[0][1], settings, options.loop))
    return status


def _ranked(name: str, forms: Forms, allowed: list[Options]) -> list[Built]:
    """Programs of a law, the shortest first. Raises ModelError, AssemblyError."""

    def progress(text: str) -> None:
        if len(allowed) > 1:
            print(f"{name}, options {text}", file=sys.stderr, flush=True)

    return forms.ranked(allowed, progress)


def _write(
    options: argparse.Namespace,
    stem: str | Path,
    stems: dict[str, str],
    built: dict[str, Built],
    forms: dict[str, Forms],
    laws: list[tuple[Law, Tree | None]],
    settings: Settings,
) -> Image:
    """Write all files of the built programs; the image."""
    images = {name: one.image for name, one in built.items()}
    maps = {name: one.map for name, one in built.items()}
    several = len(built) > 1
    if several:
        image = link(Path(stem).name, images)
        maps = link_maps(image, images, maps)
    else:
        (image,) = images.values()
    texts = {f"{stem}.asip.json": Image.dumps(image), **c_files(str(stem), image)}
    texts[f"{stem}.report.txt"] = "\n".join(
        one.report.render()
        + (
            "\n" + effects(one, options.seed, forms[name])
            if options.effects or options.best
            else ""
        )
        + (f"\n{account(tree, settings)}" if tree else "")
        for (name, one), (_, tree) in zip(built.items(), laws, strict=True)
    )
    texts |= {f"{stems[name]}.asip.map.json": found.dumps() for name, found in maps.items()}
    for name, each in stems.items() if options.c else ():
        header, source = to_c_code(built[name].compiled, Path(f"{each}.tick.h").name)
        texts |= {f"{each}.tick.h": header, f"{each}.tick.c": source}
    for path, text in texts.items():
        with open_output(Path(path)) as file:
            file.write(text)
    for name, one in built.items():
        where = f"{stem}.asip.json{f', {name}' if several else ''}"
        chosen = f" ({words(one.compiled.options)})" if options.best else ""
        print(f"{where}: {one.cycles} cycles, lower bound {one.bound_cycles}{chosen}")
    return image


def _names(options: argparse.Namespace) -> list[str]:
    """Names of the functions: those of their files. Raises LinkError."""
    names = [re.sub(r"\W", "_", part[0].stem, flags=re.ASCII) for part in options.parts]
    for name in names:
        if names.count(name) > 1:
            raise LinkError(f"two functions are named {name}, as their files; rename one")
    return names


def _law(
    options: argparse.Namespace, file: Path, interface: Path | None, settings: Settings
) -> tuple[Law, Tree | None]:
    """The law, and the robot of a URDF."""
    if interface is None:
        law, tree = robot_law(options, file, settings)
        for warning in tree.description.warnings:
            print(f"asip-model: warning: {warning}", file=sys.stderr)
        return law, tree
    streams = default_isa().configurations[options.config].stream_words > 0
    law = load_law(file, interface, whole=not streams)
    if streams and isinstance(law.function, OnnxPolicy):
        from asip_asm.model.onnx_layers import dense_layers

        if isinstance(found := dense_layers(law.function), str):
            print(f"asip-model: {file}: compiled without streams: {found}", file=sys.stderr)
    return law, None


def _loop(built: Built, tree: Tree, settings: Settings, seconds: float) -> int:
    from sim.core.api import CoreFault

    try:
        loop = close_loop(built.compiled.law, built.image, Arm(tree, settings, seconds))
    except CoreFault as fault:
        print(f"asip-model: the program stops in the closed loop: {fault}")
        return 1
    print(f"closed loop: {loop.ticks} ticks; root mean square of each axis' tracking error behind")
    print("the start, and by that in double precision:")
    for (name, unit), error in zip(loop.axes.items(), loop.rms(loop.core), strict=True):
        print(f"  {name}: {error:.2g} {unit}, {loop.ratios[name]:.4f}")
    print(f"worst axis {loop.worst}: {loop.ratio:.4f}, goal {RATIO}")
    if loop.saturated:
        print(
            f"an output was at its limit in {loop.saturated} ticks: take a lower --bandwidth "
            "or finer --counts, or expect the errors above to depend on chance"
        )
    return 0 if loop.ratio <= RATIO else 1


def _prove(
    built: Built,
    options: argparse.Namespace,
    truth: Truth | RobotTruth,
    points: list[Point],
    file: Path,
) -> int:
    from sim.core.api import CoreFault
    from sim.laws.prove_program import prove
    from sim.laws.samples import near

    compiled, inputs, seed = built.compiled, options.inputs, options.seed
    sample = near(compiled.law) if not isinstance(truth, Truth) else None

    def progress(text: str) -> None:
        print(f"certificate: {text}", file=sys.stderr, flush=True)

    certificate = certify(
        compiled.graph, compiled.law, (options.boxes_effort or EFFORT) * MILLION, progress
    )
    try:
        proof = prove(
            compiled, built.image, count=inputs, seed=seed, sample=sample, truth=truth,
            certificate=certificate, points=directed(compiled.law, points),
        )  # fmt: skip
    except CoreFault as fault:
        print(f"asip-model: the program stops for an input within its limits: {fault}")
        proof = None
    write_certificate(file, certificate, proof)
    print("\n".join(report(certificate, proof)))
    passed = proof is not None and proof.passed and (not options.c or _prove_c(built, options))
    print("proved" if passed else "NOT proved")
    return 0 if passed else 1


def _prove_together(image: Image, built: dict[str, Built], options: argparse.Namespace) -> int:
    """Run the functions in a drawn order on one core."""
    from sim.core.api import CoreFault
    from sim.laws.prove_functions import TICKS, prove_functions

    ticks = min(TICKS, options.inputs)
    compiled = {name: one.compiled for name, one in built.items()}
    try:
        difference = prove_functions(compiled, image, ticks=ticks, seed=options.seed)
    except CoreFault as fault:
        print(f"asip-model: a function stops for an input within its limits: {fault}")
        return 1
    equal = "bits equal the interpreter's, states are kept"
    print(f"{ticks} ticks of {len(built)} functions in turn: {difference or equal}")
    return 1 if difference else 0


def _prove_c(built: Built, options: argparse.Namespace) -> bool:
    """Whether the C has the interpreter's bits on this machine."""
    from sim.laws.native.bits import prove_c
    from sim.laws.native.law import CompilerError

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
    parser = command_parser(
        "asip-model",
        "Compile a CasADi function, an ONNX policy or a robot's URDF into a program for the core.",
        EPILOG,
    )
    parser.add_argument(
        "files",
        type=Path,
        nargs="+",
        metavar="FILE",
        help="file that casadi.Function.save wrote, or a policy (.onnx), with its interface record "
        "(*.interface.toml), or a robot's URDF; several: one image, a function of each, named "
        "after its file",
    )
    parser.add_argument("-o", dest="output", metavar="STEM", help="files to write, without suffix")
    parser.add_argument(
        "--config",
        choices=tuple(default_isa().configurations),
        default="fast",
        help="configuration of the core",
    )
    parser.add_argument(
        "--best",
        action="store_true",
        help="build the program with every set of --reassociate, --reciprocal and --sine and keep "
        "the shortest that fits, and with --prove is proved; an option that is given stays as "
        "given, as does --no-reassociate",
    )
    parser.add_argument(
        "--effects",
        action="store_true",
        help="add to the report what each option changes (as --best does): builds three more "
        "programs",
    )
    parser.add_argument(
        "--reassociate",
        action=argparse.BooleanOptionalAction,
        help="join the terms of sums as they arrive: shorter, rounds differently",
    )
    parser.add_argument(
        "--reciprocal",
        action=argparse.BooleanOptionalAction,
        help="divide by a shared or constant divisor through its reciprocal: rounds once more",
    )
    parser.add_argument(
        "--sine",
        choices=SINES,
        help="which sines and cosines of inputs with limits become polynomials: those that would "
        "wait for the sine unit (balanced, the default), none (unit), or all (pipes)",
    )
    parser.add_argument(
        "--constants",
        type=count,
        help="largest number of constants of a function in bank K; the others are in data memory",
    )
    parser.add_argument(
        "--c", action="store_true", help="write the law as C too: STEM.tick.c, STEM.tick.h"
    )
    parser.add_argument("--prove", action="store_true", help="run on the core and compare")
    parser.add_argument(
        "--inputs", type=count, default=10_000, help="number of inputs that the proof tries (10000)"
    )
    parser.add_argument(
        "--points",
        type=Path,
        metavar="FILE",
        help="CSV file of further inputs for the proof, with their names in the first line",
    )
    parser.add_argument(
        "--boxes-effort",
        type=count,
        metavar="N",
        help=f"million operations for the certificate ({EFFORT}); more give tighter bounds",
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the proof's inputs")
    add_robot_options(parser)
    parser.add_argument(
        "--loop",
        type=duration,
        metavar="SECONDS",
        help="simulate this time in closed loop with the robot of a URDF (computed_torque)",
    )
    options = parser.parse_args(arguments)
    options.parts = []
    files = list(options.files)
    while files:
        file = files.pop(0)
        urdf = is_urdf(file)
        record = files.pop(0) if files and not urdf else None
        if ".xacro" in (file.suffix.lower(), record and record.suffix.lower()):
            parser.error("a xacro is no URDF yet; expand it: xacro FILE > robot.urdf")
        if urdf != (record is None) or (record and is_urdf(record)):
            parser.error("a function needs its interface record, a URDF has none")
        options.parts.append((file, record))
    check_robot_options(parser, options)
    if options.loop and len(options.parts) > 1:
        parser.error("--loop is for computed_torque of one URDF")
    if options.points and (not options.prove or len(options.parts) > 1):
        parser.error("--points is for --prove of one function")
    if options.boxes_effort and not options.prove:
        parser.error("--boxes-effort is for --prove")
    return options


if __name__ == "__main__":
    sys.exit(main())
