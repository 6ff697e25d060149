# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC, unmodified, drives the five axes: its configuration, the drives' states, whole runs.

The runs have the application as C on this machine (`linuxcnc_host`), which takes half a minute for
each; `test_command` has pysoem and the slave in RTL.
"""

from __future__ import annotations

import configparser
import json
import os
import re
import struct
from pathlib import Path

import numpy as np
import pytest

from asip_asm.project import ROOT
from sim.bus.coe.dictionary import load
from sim.bus.linuxcnc import config, link
from sim.bus.linuxcnc.__main__ import main, wrong
from sim.bus.linuxcnc.master import MOST_LOST, RESET_PERIODS, Drives, set_up
from sim.bus.linuxcnc.result import away_from
from sim.robot.parameters import Robot
from tests.bench.needs import needs
from tests.ethercat.linuxcnc_host import play

DEVICE = load()
ON, ESTOP_OK, HOME = link.ENABLE, link.ESTOP_OK, link.HOME
DISABLED, READY, SWITCHED_ON, ENABLED, FAULT = 0x250, 0x231, 0x233, 0x237, 0x218
SHORT = """\
G21 G90 G64 P0.01 G17
F2000
G1 X2 Y1
G2 X4 Y1 I1 J0
(MSG, half way)
M0
G1 Z601 A2 C5
M2
"""
PAGE = ROOT / "docs/ethercat.md"


def frame(status: int, error: int = 0, mode: int = 8, position: int = 0) -> bytes:
    """Process data of five drives, all the same."""
    values = {
        "statusword": status,
        "error_code": error,
        "mode_display": mode,
        "position_actual": position,
    }
    data = bytearray(DEVICE.bytes("tx"))
    for at, _, _, entry in DEVICE.places("tx"):
        struct.pack_into(entry.format, data, at, values.get(entry.field, 0))
    return bytes(data)


def sent(drives: Drives, flags: int, target: tuple[float, ...] = (0.0,) * 5) -> dict[str, list]:
    """What the drives are sent, by name of the object."""
    data = drives.outputs(link.Request(1, flags, target))
    found: dict[str, list] = {}
    for at, _, _, entry in DEVICE.places("rx"):
        found.setdefault(entry.field, []).append(struct.unpack_from(entry.format, data, at)[0])
    return found


def told(drives: Drives) -> dict[str, object]:
    """What LinuxCNC hears."""
    number, flags, lost, faults, *rest = link.ANSWER.unpack(
        drives.answer(link.Request(7, ON, (0.0,) * 5))
    )
    assert number == 7
    return {"flags": flags, "lost": lost, "faults": faults, "errors": rest[:5], "at": rest[6:]}


def test_configuration__has_the_limits_of_the_robot():
    robot = Robot.load(None)
    found = configparser.ConfigParser(inline_comment_prefixes=None)
    found.read_string(config.ini(robot))
    x, c = found["AXIS_X"], found["JOINT_4"]
    assert float(x["max_limit"]) == pytest.approx(1e3 * robot.x_max)
    assert float(found["JOINT_2"]["home"]) == pytest.approx(1e3 * robot.z_start)
    assert float(c["max_velocity"]) == pytest.approx(np.degrees(robot.v_max_table))
    diagonal = np.sqrt(3) * float(x["max_acceleration"])
    # A change within a servo period keeps to the jerk, and no more than the acceleration is used.
    assert diagonal <= 1e3 * robot.a_max_tool
    assert diagonal / 1e-3 == pytest.approx(1e3 * robot.j_max_tool)
    for n in range(5):
        joint = found[f"JOINT_{n}"]
        lag = 3.6e-3 * float(joint["max_velocity"])
        assert lag < float(joint["ferror"]) < 3 * lag


def test_drives__come_to_operation_enabled_by_6_7_15():
    drives = Drives(DEVICE)
    words = []
    for status in (DISABLED, READY, SWITCHED_ON, ENABLED):
        drives.take(frame(status))
        words += sent(drives, ON | ESTOP_OK)["controlword"]
    assert words == [6] * 5 + [7] * 5 + [15] * 10
    assert told(drives) | {"at": 0} == {
        "flags": link.LINK | link.ENABLED,
        "lost": 0,
        "faults": 0,
        "errors": [0] * 5,
        "at": 0,
    }


def test_drives__home_by_method_37_where_they_stand():
    pose = (0.01, -0.02, 0.6, 0.1, -0.2)
    objects = dict(set_up(DEVICE, pose))
    assert int.from_bytes(objects[0x607C + 0x1000], "little", signed=True) == 60_000_000
    assert int.from_bytes(objects[0x607C + 0x2000], "little", signed=True) == -2_000_000
    assert [objects[0x6098 + 0x800 * n] for n in range(5)] == [bytes([37])] * 5
    drives = Drives(DEVICE)
    drives.take(frame(ENABLED))
    assert sent(drives, ON | ESTOP_OK | HOME)["mode"] == [6] * 5
    assert sent(drives, ON | ESTOP_OK | HOME)["controlword"] == [15] * 5  # still in CSP
    drives.take(frame(ENABLED, mode=6))
    assert sent(drives, ON | ESTOP_OK | HOME)["controlword"] == [31] * 5
    assert not told(drives)["flags"] & link.HOMED
    drives.take(frame(ENABLED | 0x1000, mode=6))
    assert sent(drives, ON | ESTOP_OK | HOME)["mode"] == [8] * 5
    assert not told(drives)["flags"] & link.HOMED  # the mode is not back yet
    drives.take(frame(ENABLED | 0x1000))
    assert told(drives)["flags"] & link.HOMED
    assert sent(drives, ON | ESTOP_OK | HOME)["mode"] == [8] * 5  # once


def test_targets__are_increments_of_the_axes():
    found = sent(Drives(DEVICE), ON | ESTOP_OK, (1.0, -2.5, 600.0, 90.0, -45.0))
    assert found["target_position"] == [100_000, -250_000, 60_000_000, 15_707_963, -7_853_982]


def test_drives__emergency_stop_is_a_quick_stop_and_no_fault():
    drives = Drives(DEVICE)
    drives.take(frame(ENABLED))
    assert sent(drives, ON | ESTOP_OK)["controlword"] == [15] * 5
    drives.take(frame(ENABLED))
    assert sent(drives, ON)["controlword"] == [2] * 5
    drives.take(frame(DISABLED))
    assert told(drives)["faults"] == 0
    assert sent(drives, ESTOP_OK)["controlword"] == [6] * 5  # off, and reset
    assert sent(drives, ESTOP_OK | ON)["controlword"] == [6] * 5


def test_drives__off_is_disable_operation():
    drives = Drives(DEVICE)
    drives.take(frame(ENABLED))
    assert sent(drives, ESTOP_OK)["controlword"] == [7] * 5
    drives.take(frame(SWITCHED_ON))
    assert sent(drives, ESTOP_OK)["controlword"] == [6] * 5
    assert told(drives)["faults"] == 0


def test_drives__a_fault_is_told_with_its_code_and_reset_by_the_next_switching_on():
    drives = Drives(DEVICE)
    drives.take(frame(ENABLED))
    sent(drives, ON | ESTOP_OK)
    drives.take(frame(ENABLED))
    drives.take(frame(FAULT, error=0x8611))
    assert told(drives)["faults"] == 0b11111 and told(drives)["errors"] == [0x8611] * 5
    assert sent(drives, ON | ESTOP_OK)["controlword"] == [0] * 5  # LinuxCNC has to switch off first
    assert sent(drives, ESTOP_OK)["controlword"] == [0] * 5
    for _ in range(RESET_PERIODS):
        assert sent(drives, ON | ESTOP_OK)["controlword"] == [0x80] * 5
        drives.take(frame(FAULT, error=0x8611))
        assert told(drives)["faults"] == 0
    drives.take(frame(DISABLED))
    assert sent(drives, ON | ESTOP_OK)["controlword"] == [6] * 5
    assert told(drives)["faults"] == 0


def test_drives__a_fault_that_stays_is_told_again():
    drives = Drives(DEVICE)
    for _ in range(RESET_PERIODS + 1):
        sent(drives, ON | ESTOP_OK)
        assert told(drives)["faults"] == 0
        drives.take(frame(FAULT, error=0x5441))
    assert told(drives)["faults"] == 0b11111


def test_drives__an_axis_that_leaves_by_itself_is_a_fault():
    drives = Drives(DEVICE)
    drives.take(frame(DISABLED))
    sent(drives, ON | ESTOP_OK)
    drives.take(frame(READY))
    assert told(drives)["faults"] == 0  # on its way
    drives.take(frame(ENABLED))
    drives.take(frame(SWITCHED_ON))
    assert told(drives)["faults"] == 0b11111


def test_drives__silence_is_lost_periods_and_after_some_of_them_a_lost_bus():
    drives = Drives(DEVICE)
    drives.take(frame(ENABLED, position=5))
    at = told(drives)["at"]
    for n in range(1, MOST_LOST + 1):
        assert told(drives)["flags"] & link.LINK
        drives.missed()
        assert told(drives)["lost"] == n and told(drives)["at"] == at
    assert told(drives)["flags"] == 0
    drives.take(frame(ENABLED))
    assert told(drives)["flags"] & link.LINK


def test_away_from__is_the_distance_from_the_lines_between_points():
    path = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0)])
    assert away_from(path, np.array([(0.5, 0.1, 0.0), (1.0, 0.5, 0.2)])) == pytest.approx(0.2)
    assert away_from(path, path) == 0.0


def test_wrong__names_what_is_not_as_it_should_be():
    good = {"lost": 0, "following_faults": 0, "ended": "ON", "messages": []}
    assert wrong(good, "") == []
    assert wrong(good, "cable") == ["LinuxCNC is on after the fault 'cable'"]
    assert wrong(good | {"lost": 2}, "") == ["2 servo periods were lost"]
    assert wrong(good | {"messages": ["a"]}, "") == ["LinuxCNC: a"]
    assert wrong(good | {"ended": "ESTOP"}, "") == ["LinuxCNC left the state ON, it is in ESTOP"]


def test_command__refuses_what_it_cannot_do(tmp_path, capsys, monkeypatch):
    with pytest.raises(SystemExit):
        main(["--seconds", "-1"])
    assert "expected 0 to" in capsys.readouterr().err
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main([]) == 1
    assert "scripts/debian_tool.sh linuxcnc gets it" in capsys.readouterr().err


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "short.ngc"
    path.write_text(SHORT)
    return path


@needs("linuxcnc")
def test_linuxcnc__plays_a_program_to_its_end(tmp_path, program):
    folder = tmp_path / "run"
    folder.mkdir()
    run = play(folder, program)
    report = run.report()
    assert wrong(report, "") == []
    assert report["tool_error"] < 10e-6 and report["table_error"] < 5e-4
    assert np.abs(np.array(report["end"]) - (4.0, 1.0, 601.0, 2.0, 5.0)).max() < 5e-3
    assert 300 < report["periods"] < 2000
    assert report["statuswords"] == [0x0231] * 5  # ready to switch on, remote: switched off again
    events = [line["event"] for line in run.events if line["event"] != "line"]
    assert [e for e in events if e != "note"] == [
        "enabled",
        "homed",
        "begin",
        "over",
        "rest",
        "end",
    ]
    notes = [line["text"] for line in run.events if line["event"] == "note"]
    assert "half way" in notes and any("resumed" in text for text in notes), notes


def rows_of_page() -> dict[str, list[str]]:
    """Cells of the table of faults on the page, by the fault's name."""
    text = PAGE.read_text(encoding="utf-8")
    table = text[text.index("| `--fault` |") :].split("\n\n")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return {row[0].strip("`"): row[1:] for row in rows[2:]}


@pytest.mark.full
@needs("linuxcnc")
@pytest.mark.parametrize("fault", ["estop", "drive", "cable", "master"])
def test_linuxcnc__after_a_fault__is_in_the_states_of_the_page(tmp_path, program, fault):
    folder = tmp_path / "run"
    folder.mkdir()
    report = play(folder, program, fault).report()
    assert wrong(report, fault) == []
    _, seen, drives, slave, brakes = rows_of_page()[fault]
    after = report["after_fault"]
    state, *messages = re.findall(r"`([^`]+)`", seen)
    assert after["linuxcnc"] == state
    for message in messages:
        assert any(message in text for text in after["messages"]), (message, after["messages"])
    code, word = (int(text, 16) for text in re.findall(r"\b[0-9A-F]{4}\b", drives)[:2])
    worst = max(range(5), key=lambda n: report["error_codes"][n])
    assert report["error_codes"][worst] == code and report["statuswords"][worst] == word
    al_state, al_code = (int(text, 16) for text in re.findall(r"`([0-9A-F]{2,4})`", slave))
    assert (report["al_state"], report["al_code"]) == (al_state, al_code)
    limit = float(re.search(r"[\d.]+", brakes).group())
    assert after["brakes_after"] is not None and after["brakes_after"] / 10 <= limit
    assert after["stands_after"] / 10 <= limit + 1


@pytest.mark.full
@needs("linuxcnc", "tap")
def test_command__plays_a_program_through_the_slave_in_rtl(tmp_path, program):
    output = tmp_path / "out"
    assert main([str(program), "--output", str(output)]) == 0
    report = json.loads((output / "linuxcnc.json").read_text())
    assert report["lost"] == 0 and report["tool_error"] < 10e-6
    assert report["off_program"] < 30e-6  # G64 P0.01, and the feet of two arcs
    assert {"bus.pcap", "index.html", "linuxcnc.log"} <= set(os.listdir(output))
