# SPDX-License-Identifier: Apache-2.0
"""Area and speed of the ASIP on Stratix III with Quartus II 13.1, to build/synth.json.

Runs scripts/quartus/build.tcl under quartus_sh and reads its reports. Quartus II 13.1 Subscription
Edition is the last version with Stratix III; it is not part of this project's environment.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from rich.console import Console

from asip_asm.command import command, script_parser
from scripts.quartus_report import FOLDER, RESULT, ROOT
from scripts.quartus_report import main as store_figures

TOOL = "quartus_sh"
SCRIPT = Path("scripts/quartus/build.tcl")
MISSING = (
    f"error: {TOOL} is not on PATH.\n"
    "Missing: Quartus II 13.1 Subscription Edition with Stratix III device support, the last\n"
    "version that knows device EP3SL150F1152C2. Add <quartus>/bin to PATH and run this again.\n"
    "Area and speed by free tools instead: microtick synth"
)


@command("scripts/quartus.py")
def main(argv: list[str] | None = None) -> int:
    """Command line; exit 0 done, 1 for a missing tool, a failed build or an unreadable report."""
    prog = "python scripts/quartus.py"
    script_parser(__doc__, prog, prog).parse_args(argv)
    console = Console()
    tool = shutil.which(TOOL)
    if tool is None:
        console.print(MISSING, markup=False, highlight=False, soft_wrap=True)
        return 1
    if subprocess.run([tool, "-t", str(SCRIPT)], cwd=ROOT).returncode:
        console.print(f"error: {TOOL} failed, reports in {FOLDER.relative_to(ROOT)}", markup=False)
        return 1
    status = store_figures([])
    if not status:
        console.print(f"figures: {RESULT.relative_to(ROOT)}")
    return status


if __name__ == "__main__":
    sys.exit(main())
