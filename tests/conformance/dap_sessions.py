# SPDX-License-Identifier: Apache-2.0
"""The debug adapter under the test client that VS Code's authors publish for debug adapters.

    python -m tests.conformance.dap_sessions            on the instruction-set model
    python -m tests.conformance.dap_sessions --full     on the Verilated core too, and its pins

Node.js runs tests/conformance/dap/session.js; npm gets the client by the lock file there. Results
go to build/conformance/dap.json.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from asip_asm.command import command_parser
from asip_asm.files import write_text
from asip_asm.project import ROOT
from sim.debug.model import DebugRtl
from tests.conformance.tools import FOLDER, ToolError

SOURCE = Path(__file__).with_name("dap")
RESULTS = FOLDER / "dap.json"
CORES = {
    "instruction-set model": {"iss": True},
    "Verilated core": {},
    "Verilated core, serial pins": {"uart": True},
}


def client() -> Path:
    """Folder of the installed client. Raises ToolError without npm, or if it cannot get it."""
    folder = FOLDER / "dap"
    if not (shutil.which("node") and shutil.which("npm")):
        raise ToolError("no node or npm; install Node.js 18 or later")
    folder.mkdir(parents=True, exist_ok=True)
    for file in SOURCE.iterdir():
        shutil.copy(file, folder)
    if not (folder / "node_modules/.package-lock.json").exists():
        command = ["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        if done.returncode:
            raise ToolError(f"npm cannot get the client: {done.stderr.strip()[-200:]}")
    return folder


def sessions(core: dict[str, bool]) -> list[dict[str, object]]:
    """What each check of session.js found on a core. Raises ToolError."""
    programs = [ROOT / f"tests/debugger/{name}.s" for name in ("leg", "endless", "loop")]
    adapter = Path(sys.executable).with_name("asip-dbg")
    command = ["node", "session.js", adapter, *programs, json.dumps(core)]
    done = subprocess.run(command, cwd=client(), stdout=subprocess.PIPE, text=True)
    lines = [line for line in done.stdout.splitlines() if line.startswith('{"check"')]
    if done.returncode or not lines:
        raise ToolError(f"session.js ended with status {done.returncode}")
    return [json.loads(line) for line in lines]


def measure(full: bool) -> dict[str, list[dict[str, object]]]:
    """The checks by core; writes the results. Raises ToolError."""
    if full:
        DebugRtl("fast").close()  # built before a client waits for it
    cores = CORES if full else {name: CORES[name] for name in list(CORES)[:1]}
    found = {name: sessions(core) for name, core in cores.items()}
    write_text(RESULTS, json.dumps({"cores": found}, indent=2) + "\n")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; exit status 1 if a check failed."""
    parser = command_parser("python -m tests.conformance.dap_sessions", __doc__)
    parser.add_argument("--full", action="store_true", help="on all cores")
    options = parser.parse_args(arguments)
    try:
        found = measure(options.full)
    except ToolError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    failed = 0
    for core, checks in found.items():
        bad = [check for check in checks if not check["passed"]]
        failed += len(bad)
        print(f"{core}: {len(checks) - len(bad)} passed, {len(bad)} failed")
        for check in bad:
            print(f"  {check['check']}: {check['detail']}")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
