# SPDX-License-Identifier: Apache-2.0
"""docs/own_c_program.md word for word: its files are the demos, its commands print what it says."""

from __future__ import annotations

import subprocess

from scripts import own_c_page
from sim.rtl.build import ROOT
from tests.bench.needs import needs


@needs("nios-gcc", "nios-gdb")  # the page's first command would build either for minutes
def test_commands_of_the_page_print_what_it_says():
    page = own_c_page.PAGE.read_text(encoding="utf-8")
    assert page.count("\n$ ") > 15
    assert own_c_page.render(page) == page


@needs("nios-gcc")
def test_nested_function_that_needs_code_on_the_stack_is_refused(tmp_path):
    source = tmp_path / "nested.c"
    source.write_text(
        "int call(int (*f)(int));\n"
        "int outer(int x) { int inner(int y) { return x + y; } return call(inner); }\n"
    )
    done = compiled("-c", source, "-o", tmp_path / "nested.o")
    assert done.returncode != 0
    assert "trampoline generated for nested function 'inner'" in done.stderr


@needs("nios-gcc")
def test_file_input_does_not_link(tmp_path):
    source = tmp_path / "file.c"
    source.write_text('#include <stdio.h>\nint main(void) { return fopen("x", "r") != 0; }\n')
    done = compiled(source, "-o", tmp_path / "file.elf")
    assert done.returncode != 0
    assert "undefined reference to `open'" in done.stderr


@needs("nios-gcc")
def test_several_files_in_a_folder_with_spaces(tmp_path):
    folder = tmp_path / "my program"
    folder.mkdir()
    (folder / "main.c").write_text("int seven(void);\nint main(void) { return seven(); }\n")
    (folder / "seven.c").write_text("int seven(void) { return 7; }\n")
    elf = folder / "my program.elf"
    done = compiled("-Wall", "-Werror", "main.c", "seven.c", "-o", elf, cwd=folder)
    assert done.returncode == 0, done.stderr
    done = subprocess.run([ROOT / ".venv/bin/nios-run", elf], capture_output=True, check=False)
    assert done.returncode == 7


def test_unknown_system_is_refused_with_the_choice():
    done = compiled("--system", "fpga3", "x.c")
    assert done.returncode == 2
    assert "no system 'fpga3'" in done.stderr and "fpga1 or --system fpga2" in done.stderr


def compiled(*arguments, cwd=ROOT):
    """nios-gcc with these arguments."""
    return subprocess.run(
        [ROOT / "nios_sw/nios-gcc", *arguments],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=False,
    )
