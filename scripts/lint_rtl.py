# SPDX-License-Identifier: Apache-2.0
"""Lint the RTL with two front ends, Verilator and slang; its style and format with verible.

Each finds what the other forgives: Verilator follows widths and unused signals, slang the rules
of IEEE 1800 on declarations, drivers and processes; each top in every configuration, for slang with
the assertions bound to it. A warning is an error. Waivers, each with its reason:
rtl/waivers.vlt for Verilator, WAIVED below for slang, scripts/ci/verible.* for verible.
`--format` formats all SystemVerilog in place.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pyslang import driver
from rich.console import Console

from asip_asm.command import command, script_parser
from sim.rtl.assertion_files import assertions_of
from sim.rtl.build import verilator_driver
from sim.rtl.sources import sources_of

ROOT = Path(__file__).resolve().parents[1]
CI = ROOT / "scripts/ci"
VERILATOR = verilator_driver()

# Warnings of slang that are off, and why.
WAIVED = {
    "unused-package-parameter": "the packages list every constant of their source",
    "unused-but-set-variable": "unused inputs end in a named `unused`; Verilator finds others",
    "unused-package-subroutine": "the units of one top need some of the functions of fp_pkg",
    "unused-package-typedef": "a configuration without scoreboards has no tags",
    "unused-def": "the file list of a system serves tops that are a part of it",
    "useless-cast": "a cast to a parameter's width is one at most of its values",
    "case-enum-explicit": "the last state is the `default`: each has a successor",
    # Widths are equal in all of these (Verilator's WIDTH rules), so the bits are the same.
    "sign-conversion": "two's complement: slices and concatenations are unsigned by the standard",
    "sign-compare": "a loop variable cast to a width keeps the sign of `int`",
    "arith-op-mismatch": "product of slices of two widths, sums of a concatenation",
    "bitwise-op-mismatch": "a packed struct of flags masked by a vector of its width",
    "packed-array-conv": "a vector concatenated for a port of two packed dimensions",
}

# Files that verible does not format, and why.
UNFORMATTED = {
    "*/sim/rtl/assertions/*.sv": "it breaks properties inside the parentheses of $past and $stable",
    "*/gen/*.sv": "generated, with columns",
    "*/ecp5_cells.sv": "a table of initial values, whose wrapping exceeds its search",
}


@dataclass(frozen=True)
class Top:
    """A module to lint with the file list (and files) that it needs, at each set of parameters."""

    name: str
    sources: tuple[str, ...]
    configurations: tuple[str, ...] = ("",)

    def files(self) -> list[str]:
        """Sources with the file lists read, relative to the checkout, each file once."""
        found: list[str] = []
        for source in self.sources:
            found += (ROOT / source).read_text().split() if source.endswith(".f") else [source]
        packages = [name for name in found if name.endswith("_pkg.sv")]
        return list(dict.fromkeys((*packages, *found)))


def needed(top: str) -> tuple[str, ...]:
    """Files of a top that has no list of its own."""
    return tuple(str(path.relative_to(ROOT)) for path in sources_of(top))


ECP5_BOARDS = ("asip_ulx3s", "asip_colorlight_i9", "asip_ecpix5", "asip_versa_ecp5")
ASIP, N2_SYSTEM = "rtl/asip/asip.f", "rtl/nios/n2_system.f"
DRIVE = "rtl/drive/drive.f"
BRIDGE = "rtl/bus/axil_bridge.sv"
TOPS = (
    Top(
        "asip",
        (ASIP,),
        (
            "",
            "FmaPipes=1 Slots=1",
            "StreamWords=8192 Loops=3",
            "StreamWords=8192 Loops=3 Lanes=3",
            "Resilience=1",
            "Resilience=1 Plausible=0",
        ),
    ),
    Top("asip_de3", (ASIP, "rtl/board/board_pll.sv", "rtl/board/asip_de3.sv")),
    Top("asip_ecp5", needed("asip_ecp5"), ("", "FmaPipes=2 Slots=3 Axes=1")),
    *(Top(top, needed(top)) for top in ECP5_BOARDS),
    Top("asip_lockstep", (ASIP, "rtl/asip/asip_lockstep.sv"), ("", "FmaPipes=1 Slots=1 Delay=1")),
    Top("asip_axil", (ASIP, BRIDGE, "rtl/asip/asip_axil.sv")),
    Top(
        "motion_axil",
        ("rtl/motion/motion.f", BRIDGE, "rtl/motion/motion_axil.sv"),
        ("Interpolators=0", "Axes=1", "Axes=8", ""),
    ),
    Top(
        "n2_core",
        ("rtl/nios/n2_core.f",),
        ("", "Trace=1 Debug=1 HardwareMultiply=0 HardwareDivide=0 DivisionError=0"),
    ),
    Top("n2_system", (N2_SYSTEM,), ("Platform=1", "Platform=2 Trace=1 Debug=1 External=1")),
    Top("dual_asip", ("rtl/dual/dual.f",)),
    Top("debug_asip", ("rtl/debug/debug.f",), ("", "FmaPipes=1 Slots=1 Uart=0")),
    Top(
        "drive_front_end",
        (DRIVE,),
        ("", "Axes=1", "Axes=8 FastRate=16 EdgeStamps=1", "Axes=2 External=2"),
    ),
    Top("ethercat_slave", ("rtl/ethercat/ethercat.f",)),
    Top("mii_to_rgmii", ("rtl/ethercat/mii_to_rgmii.sv",)),
    Top("ethercat_nios", needed("ethercat_nios")),
    Top("drive_chain", ("rtl/dual/dual.f", DRIVE, "rtl/drive/drive_chain.sv")),
    Top("biss_port", ("rtl/drive/biss_port.f",), ("", "Width=32 ClocksPerBit=6", "Width=64")),
    Top(
        "ssi_port",
        ("rtl/drive/ssi_port.f",),
        ("", "Gray=1 Alarm=1 Parity=1 Repeat=1", "Width=64 ClocksPerBit=6 Parity=2"),
    ),
    Top(
        "endat_port",
        ("rtl/drive/endat_port.f",),
        ("", "Endat22=0 StartClocks=0", "Width=48 ClocksPerBit=6 MeasureClocks=300"),
    ),
    Top(
        "absolute_position",
        ("rtl/drive/absolute_position.f",),
        ("", "Width=20 Drop=4 Modulus=60000 Instant=8", "Width=64 Period=1250"),
    ),
    Top(
        "sincos_position",
        ("rtl/drive/sincos_position.f",),
        ("", "Width=16 Bits=4 Least=4096 Most=12288", "Width=24 Bits=16 Most=4194304 After=0"),
    ),
    Top(
        "hall_decoder",
        ("rtl/drive/hall_decoder.f",),
        ("", "Bits=2 Filter=4 Limit=5", "Bits=16 Filter=255 Limit=16777215"),
    ),
)


def custom_alone() -> list[Top]:
    """Custom instructions that no platform instantiates, each a top of its own."""
    system = Top("n2_system", (N2_SYSTEM,)).files()
    units = tuple(file for file in system if not file.startswith("rtl/nios/"))
    paths = (path.relative_to(ROOT) for path in sorted((ROOT / "rtl/custom").glob("*.sv")))
    return [Top(path.stem, (*units, str(path))) for path in paths if str(path) not in system]


def run_verilator(top: str, files: Sequence[str], parameters: Sequence[str]) -> bool:
    """Whether Verilator has nothing to say; its messages go to the terminal."""
    command = [str(VERILATOR), "--lint-only", "-Wall", "--quiet", "--top-module", top]
    command += [*(f"-G{value}" for value in parameters), "rtl/waivers.vlt", *files]
    return subprocess.run(command, cwd=ROOT).returncode == 0


def run_verible(tool: str, *options: str | Path, but: Sequence[str] = ()) -> bool:
    """Whether a tool of verible has nothing to say of any file; its messages go to the terminal."""
    files = [path for folder in ("rtl", "sim", "tests") for path in (ROOT / folder).rglob("*.sv")]
    wanted = sorted(path for path in files if not any(path.match(name) for name in but))
    command = [Path(sys.executable).with_name(f"verible-verilog-{tool}"), *options, *wanted]
    return subprocess.run(command).returncode == 0


def run_verible_lint() -> bool:
    """Whether every file keeps the rules of style."""
    rules = CI / "verible.rules"
    waivers = rules.with_suffix(".waivers")
    return run_verible("lint", f"--rules_config={rules}", f"--waiver_files={waivers}")


def run_verible_format(*options: str) -> bool:
    """Format every file in place, or with `--verify` only look; whether all is well then."""
    options = ("--inplace", f"--flagfile={CI}/verible.format", *options)
    return run_verible("format", *options, but=tuple(UNFORMATTED))


def run_slang(top: str, files: Sequence[str], parameters: Sequence[str]) -> bool:
    """Whether slang has nothing to say, of the assertions too; its messages go to the terminal."""
    bound = assertions_of([ROOT / file for file in files])
    waived = " ".join(f"-Wno-{name}" for name in WAIVED)
    values = " ".join(f"-G{value}" for value in parameters)
    sources = " ".join(f'"{ROOT / file}"' for file in [*map(Path, files), *bound])
    slang = driver.Driver()
    slang.addStandardArgs()
    command = f"slang -Weverything -Werror {waived} --top {top} {values} {sources}"
    return (
        slang.parseCommandLine(command)
        and slang.processOptions()
        and slang.parseAllSources()
        and slang.runFullCompilation(quiet=True)
    )


@command("scripts/lint_rtl.py")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 clean, 1 findings."""
    parser = script_parser(__doc__, "python scripts/lint_rtl.py --top n2_core")
    tops = [*TOPS, *custom_alone()]
    parser.add_argument("--top", nargs="+", choices=[top.name for top in tops], metavar="MODULE")
    parser.add_argument("--format", action="store_true", help="format in place, lint nothing")
    options = parser.parse_args(argv)
    if options.format:
        return 0 if run_verible_format() else 1
    console = Console(soft_wrap=True, highlight=False, markup=False)
    bad: list[str] = []
    runs = 0
    for top in tops:
        if options.top and top.name not in options.top:
            continue
        files = top.files()
        for configuration in top.configurations:
            parameters = configuration.split()
            for name, tool in (("Verilator", run_verilator), ("slang", run_slang)):
                runs += 1
                if not tool(top.name, files, parameters):
                    bad.append(f"{name}: {top.name} {configuration}".rstrip())
    if not options.top:
        runs += 2
        if not run_verible_lint():
            bad.append("verible")
        if not run_verible_format("--verify"):
            bad.append("the formatter: make format mends them")
    for line in bad:
        console.print(f"lint_rtl: findings of {line}")
    console.print(f"lint_rtl: {runs} runs, {len(bad)} with findings")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
