# SPDX-License-Identifier: Apache-2.0
"""Write into docs/own_c_program.md its programs, from nios_sw/demo, and what its commands print.

Every line `$ command` of the page is run in the folder of the repository, in order. Needs the cross
compiler.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys

from asip_asm.command import command
from asip_asm.files import write_text
from asip_asm.project import ROOT
from sim.rtl.nios_rtl import PLATFORMS

PAGE = ROOT / "docs/own_c_program.md"
FILE = re.compile(r"(^`(\S+)`:\n\n```\w+\n)(.*?)(^```$)", re.MULTILINE | re.DOTALL)
CONSOLE = re.compile(r"(^```console\n)(.*?)(^```$)", re.MULTILINE | re.DOTALL)


def render(page: str) -> str:
    """The page with its programs and with what its commands print now.

    Raises RuntimeError for a command that fails.
    """
    # What is missing is built here, without a word in the page.
    run("make -s setup tools T=nios-toolchain")
    for system in PLATFORMS:
        build = f"from sim.rtl.nios_rtl import NiosRtl; NiosRtl({system!r})"
        run(shlex.join([sys.executable, "-c", build]))
    compiler = run("scripts/nios_toolchain.sh --prefix").strip()
    page = FILE.sub(_file, page)

    def console(match: re.Match[str]) -> str:
        commands = re.findall(r"^\$ (.*)$", match[2], re.MULTILINE)
        shown = "".join(f"$ {command}\n{run(command)}" for command in commands)
        return match[1] + shown.replace(compiler, "FOLDER") + match[3]

    return CONSOLE.sub(console, page)


def _file(match: re.Match[str]) -> str:
    """A file of the page; programs are those of the demos without their first two comments."""
    path = ROOT / match[2]
    demo = ROOT / "nios_sw/demo" / path.name
    if demo.exists():
        return match[1] + demo.read_text(encoding="utf-8").split("*/\n", 2)[2] + match[4]
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, match[3])
    return match[0]


def run(command: str) -> str:
    """What a command prints, errors too. Below make it is as if typed."""
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}
    done = subprocess.run(
        ["sh", "-c", command],
        cwd=ROOT,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(f"{command}\n{done.stdout}exit status {done.returncode}")
    return done.stdout


@command("scripts/own_c_page.py")
def main() -> int:
    """Write the page; returns the exit status."""
    try:
        write_text(PAGE, render(PAGE.read_text(encoding="utf-8")))
    except RuntimeError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
