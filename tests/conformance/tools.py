# SPDX-License-Identifier: Apache-2.0
"""What the suites of others share: their folder of results, the toolchain, DejaGnu."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from asip_asm.files import write_text
from asip_asm.project import BUILD, ROOT

FOLDER = BUILD / "conformance"
BOARDS = Path(__file__).with_name("boards")
LINE = re.compile(
    r"^(PASS|FAIL|XPASS|XFAIL|KPASS|KFAIL|UNSUPPORTED|UNTESTED|UNRESOLVED|ERROR): (.*)$"
)
RUNTIME = {
    "rtl": ("crt0.S", "exception_entry.S", "io.c", "syscalls.c"),
    "qemu": (
        "crt0.S", "exception_entry.S", "exit_semihost.S", "syscalls.c", "exceptions_none.c"
    ),
}  # fmt: skip
BAD = ("FAIL", "UNRESOLVED", "ERROR", "XPASS", "KPASS")


class ToolError(RuntimeError):
    """A tool is missing or fails; the message says how to get it."""


def run(command: Sequence[str | Path], **options: object) -> str:
    """Standard output of a command that must succeed."""
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, **options).stdout


def clean_environment() -> dict[str, str]:
    """The environment without what a make around this process has put there."""
    return {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}


def program(name: str) -> Path:
    """A program of the cross toolchain. Raises ToolError without it."""
    prefix = Path(run([ROOT / "scripts/nios_toolchain.sh", "--prefix"]).strip())
    found = prefix / "bin" / name
    if not found.exists():
        raise ToolError(f"no {name}; make tools T=nios-toolchain builds it")
    return found


def compiler_options(kind: str) -> list[str]:
    """Options of nios-gcc: those of a system, `link`, or what QEMU can execute."""
    command = ["make", "-s", "-C", ROOT / "nios_sw", f"options-{kind.replace('qemu', 'fpga2')}"]
    words = run(command, env=clean_environment()).split()
    return [w for w in words if not (kind == "qemu" and w.startswith("-mcustom-"))]


def runtime(system: str, gcc: Path, folder: Path) -> tuple[list[str], list[str]]:
    """Options of the compiler and of the linker, for programs of a system."""
    code = [*compiler_options(system), f"-I{ROOT / 'nios_sw/include'}"]
    folder.mkdir(parents=True, exist_ok=True)
    objects = []
    for name in RUNTIME["qemu" if system == "qemu" else "rtl"]:
        objects.append(str(folder / f"{Path(name).stem}.o"))
        run([gcc, *code, "-O2", "-c", ROOT / "nios_sw/lib" / name, "-o", objects[-1]])
    places = [f"-L{ROOT / 'nios_sw/link'}", f"-L{ROOT / 'nios_sw/link/gen'}"]
    return code, [*compiler_options("link"), *places, *objects]


def suite(name: str) -> Path:
    """The test suite of GCC or GDB, `gcc` or `gdb`; fetched when it is used first."""
    if shutil.which("runtest") is None:
        raise ToolError("no DejaGnu; scripts/debian_tool.sh dejagnu installs it")
    folder = Path(run([ROOT / "scripts/nios_toolchain.sh", "--tests"]).strip())
    return folder / name / "testsuite"


def dejagnu(
    tool: str, site: Mapping[str, str], tests: Sequence[str], output: Path, **environment: str
) -> Path:
    """Run tests of a suite; the summary. site: further variables of Tcl. Raises ToolError."""
    output.mkdir(parents=True, exist_ok=True)
    variables = {
        "srcdir": f"{{{suite(tool)}}}",
        "tmpdir": f"{{{output}}}",
        "objdir": f"{{{output}}}",
        "target_triplet": "nios2-unknown-elf",
        "target_alias": "nios2-elf",
        "boards_dir": f"{{{BOARDS}}}",
        "tool": tool,
        **site,
    }
    lines = (f"set {name} {value}\n" for name, value in variables.items())
    write_text(output / "site.exp", "".join(lines))
    summary = output / f"{tool}.sum"
    summary.unlink(missing_ok=True)
    command = ["runtest", "--tool", tool, f"--target_board=nios-{tool}", *tests]
    own = clean_environment() | {"PYTHONPATH": str(ROOT)} | environment
    with open(output / "runtest.out", "wb") as log:
        done = subprocess.run(
            command, cwd=output, env=own, stdin=subprocess.DEVNULL, stdout=log, stderr=log
        )
    # The exit status 1 says only that some tests failed.
    if done.returncode > 1 or not summary.exists():
        raise ToolError(f"runtest failed, see {output}/runtest.out")
    return summary


def results(summary: Path) -> Iterator[tuple[str, str]]:
    """Lines of a summary: result and text."""
    for line in summary.read_text(encoding="utf-8", errors="replace").splitlines():
        if found := LINE.match(line):
            yield found[1], found[2]
