# SPDX-License-Identifier: Apache-2.0
"""Runs Yosys and nextpnr, whose packages hold them as WebAssembly."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from asip_asm.project import ROOT


def run_tool(tool: str, arguments: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """The tool's exit status and what it printed; it runs in the folder of the project.

    These tools have a /tmp of their own, so files of the project get relative names, which also
    have no space in them, whatever folder the project is in.
    """
    command = [str(Path(sys.executable).parent / tool)]
    command += [argument.replace(f"{ROOT}/", "") for argument in arguments]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
