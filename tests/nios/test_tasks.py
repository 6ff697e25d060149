# SPDX-License-Identifier: Apache-2.0
"""The kernel of nios_sw/tasks: preempted floating point, and C as people write it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from asip_asm.project import ROOT
from sim.debug.nios_run import main
from sim.rtl.nios_image import IMAGES
from tests.bench.needs import needs, require

GREETING, FAREWELL = "a constructor ran\n", "atexit, ticks 200\n"


def test_tasks__preempted_at_every_tick__compute_as_alone(capfd):
    assert main([str(IMAGES / "run/tasks_fpga2.elf")]) == 0
    text = capfd.readouterr().out
    assert text.startswith(GREETING) and text.endswith(FAREWELL)
    assert "80 results, 0.40 a tick, 0 wrong" in text


def test_tasks__whose_switch_forgets_the_custom_registers__are_wrong(capfd):
    """A planted fault: without it the result above would not mean much."""
    assert 0 < main([str(IMAGES / "run/tasks_lost_fpga2.elf")]) < 254
    assert " 0 wrong" not in capfd.readouterr().out


@pytest.mark.full
@needs("nios-gcc")
@pytest.mark.parametrize("system", ["fpga1", "fpga2"])
def test_ten_seconds_of_preemption(system, tmp_path, capfd):
    build = ["make", "-s", "-C", ROOT / "nios_sw", f"BUILD={tmp_path}", "TICKS=100000"]
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}
    elf = tmp_path / f"tasks_{system}.elf"
    subprocess.run([*build, elf], check=True, env=environment)
    assert main(["--system", system, "--max-cycles", "1100000000", str(elf)]) == 0
    assert " 0 wrong" in capfd.readouterr().out


LIFE = """
#include <stdio.h>
#include <stdlib.h>
static void last(void) { puts("atexit"); }
__attribute__((constructor(200))) static void second(void) { puts("constructor 200"); }
__attribute__((constructor(101))) static void first(void) { puts("constructor 101"); }
__attribute__((destructor(101))) static void end(void) { puts("destructor 101"); }
__attribute__((destructor(200))) static void before(void) { puts("destructor 200"); }
int main(void) {
  atexit(last);
  float *three = malloc(3 * sizeof *three);
  three[2] = 2.5f;
  printf("%g %.3e %f %a %5.1f|\\n", three[2], 1e-7 / 3, -0.125, 0.75, 9.96);
  free(three);
  return 7;
}
"""
SAID = """constructor 101
constructor 200
2.5 3.333e-08 -0.125000 0x1.8p-1  10.0|
atexit
destructor 200
destructor 101
"""


def compiled(folder: Path, source: str, *options: str) -> Path:
    """A program by nios-gcc."""
    require("nios-gcc")
    (folder / "own.c").write_text(source)
    command = [ROOT / "nios_sw/nios-gcc", *options, "-O2", folder / "own.c", "-o", folder / "a.elf"]
    subprocess.run(command, check=True)
    return folder / "a.elf"


@needs("nios-gcc")
def test_life_of_a_program__as_the_c_library_has_it(tmp_path, capfd):
    elf = compiled(tmp_path, LIFE)
    capfd.readouterr()
    assert main([str(elf)]) == 7
    assert capfd.readouterr().out == SAID


OWN_ENTRY = """
#include "io.h"
static uint32_t seen;
__attribute__((section(".exception"), naked)) void own_entry(void) {
  __asm__("addi sp, sp, -4\\n stw r2, 0(sp)\\n movia et, seen\\n ldw r2, 0(et)\\n addi r2, r2, 1\\n"
          "stw r2, 0(et)\\n ldw r2, 0(sp)\\n addi sp, sp, 4\\n eret");
}
int main(void) {
  for (int i = 0; i < 5; ++i) __asm__ volatile("trap 1" ::: "memory");
  return (int)*(volatile uint32_t *)&seen;
}
"""


@needs("nios-gcc")
def test_own_exception_entry__takes_the_place_of_ours(tmp_path):
    source = OWN_ENTRY.replace("static uint32_t seen", "uint32_t seen")
    assert main([str(compiled(tmp_path, source, "--own-exceptions"))]) == 5


@needs("nios-gcc")
def test_own_linker_script_and_start(tmp_path):
    """A start-up of one's own, and a script that puts the stack below the end of the memory."""
    script = (ROOT / "nios_sw/link/tcm.ld").read_text()
    own = script.replace("ORIGIN(dtcm) + LENGTH(dtcm)", "ORIGIN(dtcm) + LENGTH(dtcm) - 0x1000")
    assert own != script
    (tmp_path / "own.ld").write_text(own)
    source = '#include "io.h"\nint main(void) { char here; return (unsigned)&here > 0x1004f000u; }'
    assert main([str(compiled(tmp_path, source))]) == 1
    assert main([str(compiled(tmp_path, source, "-T", str(tmp_path / "own.ld")))]) == 0
    start = """
    #include "io.h"
    __attribute__((section(".reset"), naked)) void _start(void) {
      __asm__("movia sp, __stack_top\\n movia gp, _gp\\n call own_main");
    }
    void own_main(void) { program_exit(9); }
    """
    assert main([str(compiled(tmp_path, start, "-nostartfiles"))]) == 9
