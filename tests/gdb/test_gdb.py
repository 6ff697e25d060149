# SPDX-License-Identifier: Apache-2.0
"""GDB of `make tools T=nios-toolchain` itself on nios_sw/demo/speed.c: a session of 40 commands."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from sim.rtl.nios_image import read_elf
from sim.rtl.nios_rtl import NiosRtl
from sim.rtl.plain import ROOT
from tests.bench.needs import needs, require
from tests.gdb.client import listening

# Command, and what its output must match; speeds are those that the program itself prints.
SESSION = (
    ("info registers pc", r"pc +0x10000000 .*<_start>"),
    ("info line main", r'Line \d+ of "nios_sw/demo/speed.c" starts at address 0x1000\w+ <main'),
    ("break main", r"Breakpoint 1 at 0x1000\w+: file nios_sw/demo/speed.c"),
    ("continue", r"Breakpoint 1, main \(\) at nios_sw/demo/speed.c:"),
    ("backtrace", r"#0  main \(\) at nios_sw/demo/speed.c"),
    ("next", r"timer_start\(PERIOD_US \* CLOCK_MHZ, control\);"),
    ("print wanted", r"= 100$"),
    ("ptype wanted", r"type = const float"),
    ("print ticks", r"= 0$"),
    ("break control", r"Breakpoint 2 at "),
    ("continue", r"Breakpoint 2, control \(\)"),
    ("backtrace 2", r"#0  control \(\) .*\n#1 .* in exception_handler \("),
    ("print speed", r"= 0$"),
    ("info registers ienable", r"ienable +0x1 "),
    ("print $status & 1", r"= 0$"),
    ("watch ticks", r"Hardware watchpoint 3: ticks"),
    ("continue", r"Hardware watchpoint 3: ticks\s+Old value = 0\s+New value = 1"),
    ("print ticks", r"= 1$"),
    ("print speed", r"= 2\.39999986$"),
    ("monitor comparators", r"breakpoint 3: free\nwatchpoint 0: free"),
    ("delete 3", r"^$"),
    ("finish", r"exception_handler \(.*\n.*timer_handler\(\);"),
    ("info breakpoints", r"1 +breakpoint .* main .*\n.*\n2 +breakpoint .* control "),
    ("delete", r"^$"),
    ("tbreak control", r"Temporary breakpoint 4"),
    ("continue", r"Temporary breakpoint 4, control \(\)"),
    ("info locals", r"begin = .*\n.*error = "),
    ("x/2i $pc", r"=> 0x1000\w+ <control(\+\d+)?>:"),
    ("stepi", r"0x1000\w+|\d+\t"),
    ("print &speed", r"\(volatile float \*\) 0x1004\w+ <speed>"),
    ("set variable speed = 50.5f", r"^$"),
    ("x/1fw &speed", r"<speed>:\s+50\.5"),
    ("print wanted - speed", r"= 49\.5$"),
    ("info registers fsat0_high", r"fsat0_high +"),
    ("set var $fsat0_high = 2.5", r"^$"),
    ("print $fsat0_high", r"= 2\.5$"),
    ("rwatch speed", r"Hardware read watchpoint 5: speed"),
    ("continue", r"Hardware read watchpoint 5: speed\s+Value = 50\.5"),
    ("delete", r"^$"),
    ("hbreak timer_stop", r"Hardware assisted breakpoint 6 at "),
    ("continue", r"Breakpoint 6, timer_stop \(\)"),
    ("up", r"#1 .* in main \(\) at nios_sw/demo/speed.c"),
    ("print ticks >= 500 && ticks < 510", r"= 1$"),
    ("monitor reset", r"speed is loaded, the core stands at its reset vector"),
    ("maintenance flush register-cache", r"^"),
    ("print $pc", r"= \(void \(\*\)\(\)\) 0x10000000 <_start>"),
    ("kill", r"\[Inferior 1 \(.*\) killed\]"),
)


def outputs(text: str) -> list[str]:
    """What each command printed, between the marks."""
    return [part.strip("\n") for part in re.split(r"^@\d+\n", text, flags=re.MULTILINE)[1:]]


def session(system: str) -> list[tuple[str, str]]:
    """The commands that a system has everything for: FPGA1 has no instruction of two limits."""
    return [row for row in SESSION if system != "fpga1" or "fsat0" not in row[0]]


def compiled(name: str, system: str, folder: Path) -> Path:
    """A demo program for a system, with what GDB wants to know of it."""
    elf = folder / f"{name}.elf"
    compiler = [ROOT / "nios_sw/nios-gcc", "--system", system, "-O1", "-g"]
    subprocess.run([*compiler, f"nios_sw/demo/{name}.c", "-o", elf], cwd=ROOT, check=True)
    return elf


def run_gdb(*arguments: str | Path) -> str:
    """What GDB prints that carries out commands and ends."""
    done = subprocess.run(
        [require("nios-gdb"), "-nx", "-batch", *arguments],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=400,
        stdin=subprocess.DEVNULL,
    )
    return done.stdout


@needs("nios-gcc", "nios-gdb")
@pytest.mark.parametrize("system", [pytest.param("fpga1", marks=pytest.mark.full), "fpga2"])
def test_session_of_forty_commands_on_a_program_of_the_project(tmp_path, system):
    elf = compiled("speed", system, tmp_path)
    server, said, status = listening(NiosRtl(system, debug=True), read_elf(elf), "0")
    place = said[0].rpartition(" ")[2]
    lines = ["set confirm off", "set pagination off", "set width 0", f"target remote {place}"]
    for number, (command, _) in enumerate(session(system)):
        lines += [f"echo @{number}\\n", command]
    script = tmp_path / "session.gdb"
    script.write_text("\n".join(lines) + "\n")
    text = run_gdb("-x", script, elf)
    found = outputs(text)
    assert len(session(system)) >= 40
    wrong = [
        (command, wanted, output)
        for (command, wanted), output in zip(session(system), found, strict=False)
        if not re.search(wanted, output, re.MULTILINE)
    ]
    assert not wrong
    assert len(found) == len(session(system)), text
    server.join(30)
    assert status == [0], "kill ends the server"


@needs("nios-gcc", "nios-gdb")
@pytest.mark.full
@pytest.mark.parametrize("system", ["fpga1", "fpga2"])
def test_gdb_loads_a_program_into_an_empty_system_through_a_pipe(tmp_path, system):
    elf = compiled("hello", system, tmp_path)
    server = f"{ROOT}/.venv/bin/nios-run --system {system} --gdb -"
    commands = ["set remotetimeout 300", f"target remote | {server}", "load", "continue"]
    text = run_gdb(*(word for command in commands for word in ("-ex", command)), elf)
    assert "Loading section .text" in text
    assert f"square root of 2 on {system.upper()}: 1.4142135" in text
    assert "exited normally" in text, text
