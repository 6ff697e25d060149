# SPDX-License-Identifier: Apache-2.0
"""Let unmodified LinuxCNC drive the simulated machine over the bus, for a whole G-code program.

    microtick linuxcnc                         the letters A, G, H
    microtick linuxcnc part.ngc                a program of yours
    microtick linuxcnc part.ngc --seconds 2    its first two seconds
    microtick linuxcnc --fault cable           what happens when the cable is pulled

LinuxCNC's servo thread, in lockstep with the simulation, hands its targets to pysoem on a TAP
device. Slave controller, drives and law are RTL, simulated clock by clock; the robot is the plant
of the main job. A second of the path takes three to four minutes of a free core.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from asip_asm.command import command_parser, run_command
from asip_asm.files import read_text, write_text
from asip_asm.pace import Pace
from asip_asm.project import BUILD, ROOT
from sim.bus.linuxcnc import page
from sim.bus.linuxcnc.config import LinuxcncError, group, missing, prepare, started
from sim.bus.linuxcnc.result import Run, away_from
from sim.bus.path_run import TICKS
from sim.motion.gcode.interpreter import parse_file
from sim.motion.trajectory.program import AGH, plan
from sim.robot.parameters import ROBOT_TOML, ParameterError, Robot

PROG = "microtick linuxcnc"
OUTPUT = BUILD / "linuxcnc_run"
FILES_LEFT = ("bus.pcap", "linuxcnc.log", "screen.jsonl")  # in the output besides the results
MAX_BYTES = 10_000_000  # of a program
MOST_SECONDS = 86_400
FAULTS = ("estop", "drive", "cable", "master")
PERIODS_PER_S = 1000
FAULT_AFTER = 200  # periods after the program's begin
AROUND = 500  # periods before and after the program
POLL_S = 0.2


def planned(program: Path, robot: Robot) -> np.ndarray | None:
    """Our own plan of the program, tick by tick (N, 5); None where our reader refuses it."""
    try:
        return plan(parse_file(program, robot=robot), robot).position
    except ValueError as error:
        print(f"no estimate of the time, and no path to compare with: {error}", file=sys.stderr)
        return None


class Progress:
    """What happens, on the error stream."""

    def __init__(self, folder: Path, periods: int) -> None:
        self.log = folder / "screen.jsonl"
        self.periods = periods
        self.pace = Pace("simulated ms", periods)
        self.told = 0

    def at(self, periods: int) -> None:
        """So many servo periods have passed."""
        self.pace.at(periods, max(self.periods, periods + PERIODS_PER_S // 10))
        if not self.log.exists():
            return
        lines = self.log.read_text(encoding="utf-8").split("\n")[:-1]
        for line in map(json.loads, lines[self.told :]):
            if line["event"] != "line":
                text = line.get("text") or line.get("kind") or ""
                about = f"period {line['periods']}, {line['state']}: {line['event']} {text}"
                print(about.rstrip(), file=sys.stderr, flush=True)
        self.told = len(lines)


def play(folder: Path, robot_file: Path, fault: str, progress: Progress) -> Run:
    """Machine, master and LinuxCNC, until all are done. Raises LinuxcncError."""
    rig = [shutil.which("unshare") or "unshare", "-rn", sys.executable, "-m"]
    rig += [f"{__package__}.machine", str(folder), str(robot_file), "--fault", fault]
    lines: list[str] = []
    with contextlib.ExitStack() as stack:
        errors = stack.enter_context((folder / "machine.err").open("w+"))
        machine = stack.enter_context(
            group(rig, cwd=ROOT, stdout=subprocess.PIPE, stderr=errors, text=True)
        )

        def died(what: str) -> LinuxcncError:
            said = (folder / "machine.err").read_text().strip().splitlines()
            return LinuxcncError(f"{what}: {said[-1] if said else 'no word from it'}")

        print("the drives go to OP ...", file=sys.stderr, flush=True)
        assert machine.stdout
        if machine.stdout.readline().strip() != "ready":
            machine.wait()
            raise died("the simulated machine did not start")

        reader = threading.Thread(target=lines.extend, args=(machine.stdout,), daemon=True)
        reader.start()
        log = stack.enter_context((folder / "linuxcnc.log").open("w"))
        cnc = stack.enter_context(started(folder, log))
        while cnc.poll() is None:
            time.sleep(POLL_S)
            numbers = [line for line in lines[-1:] if line.strip().isdigit()]
            progress.at(int(numbers[0]) if numbers else 0)
            if machine.poll() is not None and fault != "master":
                raise died("the simulated machine ended before LinuxCNC")
        if not (folder / "screen.jsonl").exists():
            said = (folder / "linuxcnc.log").read_text(errors="replace").strip()
            raise LinuxcncError(f"LinuxCNC did not start:\n{said}")
        machine.wait()
        reader.join()
        progress.at(0)
    if not lines or not lines[-1].startswith("{"):
        raise died("the simulated machine did not end")
    return Run.read(folder, json.loads(lines[-1]))


def wrong(report: dict[str, Any], fault: str) -> list[str]:
    """What is not as it should be."""
    found = []
    if report["lost"]:
        found.append(f"{report['lost']} servo periods were lost")
    if report["following_faults"]:
        found.append(f"{report['following_faults']} faults by following errors")
    if not fault and report["ended"] != "ON":
        found.append(f"LinuxCNC left the state ON, it is in {report['ended']}")
    if not fault:
        found += [f"LinuxCNC: {text}" for text in report["messages"]]
    if fault and report["ended"] == "ON":
        found.append(f"LinuxCNC is on after the fault '{fault}'")
    return found


def _parser() -> argparse.ArgumentParser:
    parser = command_parser(PROG, __doc__ or "")
    parser.add_argument("program", nargs="?", type=Path, default=AGH, help="G-code (default A-G-H)")
    parser.add_argument("--robot", type=Path, default=ROBOT_TOML, help="parameters of the robot")
    parser.add_argument(
        "--seconds", type=float, default=0.0, help="stop after these seconds of the program"
    )
    parser.add_argument(
        "--fault",
        choices=FAULTS,
        default="",
        help="cause this fault 0.2 s after the begin of the program",
    )
    parser.add_argument("--output", type=Path, default=OUTPUT, help=f"folder (default {OUTPUT})")
    return parser


def _run(argv: Sequence[str] | None) -> int:
    parser = _parser()
    options = parser.parse_args(argv)
    if not 0 <= options.seconds < MOST_SECONDS:
        parser.error(f"--seconds {options.seconds:g}: expected 0 to {MOST_SECONDS}")
    if lack := missing():
        raise LinuxcncError(lack)
    robot = Robot.load(options.robot)
    read_text(options.program, MAX_BYTES, "a G-code program")
    path = planned(options.program, robot)
    cut = round(options.seconds * PERIODS_PER_S)
    expected = cut or (len(path) // TICKS if path is not None else PERIODS_PER_S)
    if options.fault:
        expected = min(expected, FAULT_AFTER)
    output: Path = options.output
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="run_", dir=output) as name:
        folder = Path(name).resolve()
        prepare(folder, robot, options.program, cut, options.fault, FAULT_AFTER)
        try:
            progress = Progress(folder, expected + AROUND)
            run = play(folder, options.robot.resolve(), options.fault, progress)
        finally:
            for file in FILES_LEFT:
                with contextlib.suppress(FileNotFoundError):
                    shutil.copy(folder / file, output / file)
    report = run.report() | {"program": options.program.name}
    if path is not None:
        report["off_program"] = away_from(path[:, :3], run.curves().wanted)
    write_text(output / "linuxcnc.json", json.dumps(report, indent=2) + "\n")
    page.write(output / "index.html", report, run)
    print(page.summary(report))
    print(f"written: {output}/index.html, linuxcnc.json, bus.pcap")
    for text in (found := wrong(report, options.fault)):
        print(f"{PROG}: error: {text}", file=sys.stderr)
    return int(bool(found))


def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 if the program came to its end, or LinuxCNC stopped at the fault."""
    return run_command(PROG, lambda: _run(argv), LinuxcncError, ParameterError)


if __name__ == "__main__":
    sys.exit(main())
