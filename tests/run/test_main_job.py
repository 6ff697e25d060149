# SPDX-License-Identifier: Apache-2.0
"""Command line of the main job: exit statuses, no traceback, nothing left over, short paths."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

from sim.bench.run import __main__ as main_job
from sim.bench.run import estimate
from sim.bench.run.job import Order, run
from sim.motion.trajectory import windows
from sim.robot.parameters import ROBOT_TOML
from sim.rtl import plain
from tests.bench.commands import output

ROOT = Path(__file__).parents[2]
LINE = "G64 P0.01\nG1 X2 F1200\nY2\nM2\n"


@pytest.mark.parametrize(
    ("program", "robot", "text"),
    [
        ("G4 P1\nM2\n", None, "part.ngc: error: the program has no motion"),
        ("G1 X10 F0.001\nM2\n", None, "part.ngc:1: error: the motion is too long"),
        ("G61.1 G1 X10 F0.001\nM2\n", None, "part.ngc:1: error: the motion is too long"),
        ("G0 X1000\nM2\n", None, "part.ngc:1: error: the move leaves the workspace"),
        ("G1 X1\nM2\n", None, "part.ngc:1:"),
        ("G64 G1 X1 F600\nM2\nX2", None, "part.ngc: error: no move is in line 3"),
        ("G0 X1\nA14000\nM2\n", None, "part.ngc:2: error: the move leaves the workspace; got A"),
        ("G61.1 G0 X1\nA200\nM2\n", None, "part.ngc:2: error: tick "),
        (None, None, "part.ngc: No such file"),
        (LINE, "[T_s\n", "robot.toml:1:"),
        (LINE, "", "robot.toml: error: "),
    ],
)
def test_bad_input__status_1_one_message_no_folder(tmp_path, capsys, program, robot, text):
    part, folder = tmp_path / "part.ngc", tmp_path / "out"
    arguments = [str(part), "--output", str(folder)]
    if program is not None:
        part.write_text(program)
        arguments += ["--from", "3"] * ("M2\nX2" in program)
    if robot is not None:
        (tmp_path / "robot.toml").write_text(robot)
        arguments += ["--robot", str(tmp_path / "robot.toml")]
    assert main_job.main(arguments) == 1
    captured = capsys.readouterr()
    assert text in captured.err and "Traceback" not in captured.err + captured.out
    assert not folder.exists()


@pytest.mark.parametrize(
    "arguments",
    [
        ["--ticks", "0"],
        ["--ticks", "x"],
        ["--platforms", "fpga4"],
        ["--platforms", ","],
        ["--speed", "tacho"],
        ["--from", "0"],
        ["--seconds", "5"],
        ["--seconds", "2:1"],
        ["--seconds=-1:1"],
        ["--seconds", "0:x"],
        ["--seconds", "0:1", "--ticks", "5"],
    ],
)
def test_bad_command_line__status_2(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        main_job.main(arguments)
    assert stop.value.code == 2


def test_plan_only__tells_time_ticks_and_estimate(tmp_path, capsys):
    part = tmp_path / "my part.ngc"
    part.write_text(LINE)
    assert main_job.main([str(part), "--plan-only", "--output", str(tmp_path / "out")]) == 0
    out = capsys.readouterr().out
    assert "path time" in out and "ticks of 100" in out and "estimated time" in out
    assert "1 rounded" in out and not (tmp_path / "out").exists()


def test_low_robot__runs_a_program_from_its_own_start(tmp_path, capsys):
    text = ROBOT_TOML.read_text(encoding="utf-8")
    for name, value in {"z_min": 0.2, "z_max": 0.4, "z_start": 0.3}.items():
        text = re.sub(rf"(\[{name}\]\nvalue = )\S+", rf"\g<1>{value}", text)
    (tmp_path / "low.toml").write_text(text, encoding="utf-8")
    (tmp_path / "part.ngc").write_text("G43.4\nG1 X2 A5 F1200\nM2\n")
    arguments = [str(tmp_path / "part.ngc"), "--plan-only", "--robot", str(tmp_path / "low.toml")]
    assert main_job.main([*arguments, "--output", str(tmp_path / "out")]) == 0
    assert "path time" in capsys.readouterr().out


# A job whose workers never end; it prints their process numbers.
ENDLESS = """
import multiprocessing, sys, time
from sim.bench.run import __main__ as main_job
from sim.bench.run.progress import TickProgress
from sim.bench.run.workers import Workers

def endless(progress):
    progress(1)
    time.sleep(1000)

def run(order, console):
    with TickProgress(console) as bars, Workers(bars) as workers:
        tasks = [workers.submit(name, 1, endless) for name in "ab"]
        print(*(child.pid for child in multiprocessing.active_children()), flush=True)
        workers.result(tasks[0])

main_job.run = run
sys.exit(main_job.main([]))
"""


def heard() -> None:
    """Ctrl-C reaches the command, even where the tests run in the background of a shell."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize(
    ("number", "status", "text"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
)
def test_signal__ends_the_workers_too(number, status, text):
    job = subprocess.Popen(
        [sys.executable, "-c", ENDLESS],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heard,
    )
    workers = [int(pid) for pid in job.stdout.readline().split()]
    assert len(workers) == 2
    job.send_signal(number)
    _, errors = job.communicate(timeout=60)
    assert job.returncode == status and errors == f"{text}\n"
    for pid in workers:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


def test_worker_that_dies__is_told(capsys, monkeypatch):
    text = ENDLESS.replace("time.sleep(1000)", "import os; os._exit(9)")
    done = subprocess.run([sys.executable, "-c", text], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert (
        done.stderr.startswith("error: a worker process ended") and "Traceback" not in done.stderr
    )


def test_speed_of_a_program_of_the_asip__without_the_asip__is_refused(tmp_path, capsys):
    arguments = ["--speed", "observer", "--platforms", "fpga1", "--output", str(tmp_path / "out")]
    assert main_job.main(arguments) == 1
    assert "add fpga3 to the platforms" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.quick("observer-*")
@pytest.mark.parametrize(
    ("speed", "cycles", "ripple", "error"),
    [("observer", 125, 0.1, 1.0), ("stamps", 183, 0.1, 1.1)],
)
def test_speed__runs_and_compares_a_third_program(tmp_path, speed, cycles, ripple, error):
    """0.2 s with a rounded corner, where every method errs by some 11 um."""
    part = tmp_path / "part.ngc"
    part.write_text(LINE)
    order = Order(
        *(part, ROBOT_TOML, tmp_path / "out", None, 2000, None, ("fpga3",)),
        plots=False,
        speed=speed,
    )
    data = run(order, Console(quiet=True))
    assert data["bounds_ok"] is True
    assert list(data["platforms"]["fpga3"]) == ["as_printed", "optimised", speed]
    assert data["platforms"]["fpga3"][speed]["cycles_max"] == cycles
    for name, with_differences in data["ripple"]["optimised"].items():
        assert data["ripple"][speed][name] <= ripple * with_differences, name
    tools = {name: data["tracking"][name]["tool"] for name in ("optimised", speed)}
    assert tools[speed] <= error * tools["optimised"]


@pytest.mark.parametrize("ticks", [1, 300])
def test_short_path__every_comparison_is_made(tmp_path, ticks):
    part = tmp_path / "part.ngc"
    part.write_text(LINE)
    order = Order(
        *(part, ROBOT_TOML, tmp_path / "out", None, ticks, None, ("fpga3",)),
        plots=False,
        override=80.0,
    )
    data = run(order, Console(quiet=True))
    kept = json.loads((tmp_path / "out/results.json").read_text())
    assert kept == json.loads(json.dumps(data))
    assert kept["ticks"] == ticks and kept["gcode"] == str(part) and kept["bounds_ok"] is True
    assert set(kept["platforms"]) == {"fpga3"} and kept["path"]["whole"] is False
    assert kept["feed_override_percent"] == 80.0
    assert all(goal["met"] for goal in kept["goals"]) and len(kept["goals"]) == 2


def test_window__runs_in_and_is_compared_tick_by_tick(tmp_path, monkeypatch):
    monkeypatch.setattr(windows, "RUN_IN", 0.02)
    part = tmp_path / "part.ngc"
    part.write_text("G64 P0.01\nG1 X5 F900\nX2 F1200\nY2\nM2\n")
    order = Order(
        *(part, ROBOT_TOML, tmp_path / "out", 3, None, (0.05, 0.06), ("fpga3",)), plots=False
    )
    data = run(order, Console(quiet=True))
    assert data["bounds_ok"] is True and data["ticks"] == 1000 + 200 + 100
    assert data["path"]["windows"] == [
        {"why": "as chosen", "first_tick": 1200, "ticks": 100, "at_s": 0.05, "lines": [3, 3]}
    ]
    assert data["path"]["whole"] is False and data["path"]["moves"] == 2


def test_exceeded_bound__is_status_3(monkeypatch):
    monkeypatch.setattr(main_job, "run", lambda order, console: {"bounds_ok": False})
    assert main_job.main([]) == 3


def test_costs__broken_file__are_the_typical_ones(tmp_path):
    for text in ("", "[]", "{", '{"as printed": "x"}', '{"as printed": -1}'):
        (tmp_path / "costs.json").write_text(text)
        assert estimate.costs(tmp_path / "costs.json") == estimate.TYPICAL
    estimate.keep({"fpga1": 0.5}, tmp_path / "costs.json")
    assert estimate.costs(tmp_path / "costs.json") == estimate.TYPICAL | {"fpga1": 0.5}


def test_make_run__names_with_spaces__stay_one_word(tmp_path):
    words = [
        "GCODE=my part.ngc",
        "ROBOT=a robot.toml",
        "OUTPUT=to here",
        "TICKS=7",
        "OVERRIDE=80",
        "FROM=4",
    ]
    text = output("make", "-n", "run", *words, "PLATFORMS=fpga1,fpga3", cwd=ROOT)
    line = text[text.index("-m sim.bench.run") :].replace("\\\n", " ").splitlines()[0]
    wanted = "-m sim.bench.run 'my part.ngc' --robot 'a robot.toml' --output 'to here'"
    wanted += " --ticks 7 --from 4"
    assert shlex.split(line) == shlex.split(f"{wanted} --override 80 --platforms fpga1,fpga3")


def test_plain__folder_with_spaces__gets_a_link_without(tmp_path, monkeypatch):
    monkeypatch.setattr(plain.tempfile, "gettempdir", lambda: str(tmp_path))
    folder = tmp_path / "x y" / "micro tick"
    folder.mkdir(parents=True)
    (folder / "a.sv").write_text("module a; endmodule\n")
    monkeypatch.setattr(plain, "ROOT", folder)
    monkeypatch.setattr(plain, "BUILD", folder / "build")
    for _ in range(2):
        found = plain.plain(folder / "a.sv")
        assert not plain.ODD.search(str(found)) and found.samefile(folder / "a.sv")
        work = plain.workshop(folder / "build")
        assert not plain.ODD.search(str(work.resolve())) and work.is_dir()
    assert plain.plain(tmp_path / "b.sv") == tmp_path / "b.sv"
