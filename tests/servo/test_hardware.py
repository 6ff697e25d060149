# SPDX-License-Identifier: Apache-2.0
"""Parameters that the drives' hardware cannot follow stop a run; what cures them is accepted."""

from __future__ import annotations

import re
from dataclasses import fields, replace

import pytest

from scripts.drive import PAGE
from sim.bench.drive import hardware, path, response, start_up
from sim.bench.drive.__main__ import main
from sim.bench.drive.plant import Plant
from sim.bench.drive.recording import PATH
from sim.bench.drive.whole import path_of
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.robot.parameters import ROBOT_TOML, ParameterError, Robot

ROBOT, DRIVES = Robot.load(), Drives.load()

# Changes -> the name that is refused, what the message says, another change that cures it.
REFUSED = [
    ({"i_max_legs": 26.0}, "i_max_legs", "current_scale = 32 A", {"current_scale": 33.8}),
    ({"i_max_tilt": 26.0}, "i_max_tilt", "must be <= 24.61 A", {"i_max_tilt": 24.61}),
    ({"current_scale": 28.0}, "i_max_legs", "current_scale >= 28.6 A", {"current_scale": 28.6}),
    (
        {f"i_max_{axis}": 0.1 for axis in ("legs", "tilt", "rotation")} | {"current_scale": 90.0},
        *("current_scale", "must be < 66.56 A", {"current_scale": 66.55}),
    ),
    ({"dead_time": 5e-6}, "dead_time", "12 .. 255 clocks of 8 ns", {"dead_time": 2.04e-6}),
    ({"dead_time": 2.048e-6}, "dead_time", "9.6e-08 .. 2.04e-06 s", {"dead_time": 1e-6}),
    ({"dead_time": 0.0}, "dead_time", "within 9.6e-08 ..", {"dead_time": 3e-7}),
    ({"delay_off": 1.5e-6}, "dead_time", "short the bus", {"dead_time": 1.2e-6}),
    ({"delay_on": 4.5e-6}, "delay_on", "must be <= 4e-06 s", {"delay_on": 4e-6}),
    ({"f_pwm": 4e4}, "f_pwm", "2500 clocks of 8 ns.*enter 50000 Hz", {"f_pwm": 5e4}),
    ({"f_modulator": 2e7}, "f_modulator", "enter 20833333.33", {"f_modulator": 20833333.33}),
]
# The last one is 3000 revolutions a minute with 4 pole pairs: 1257 rad/s electrical.
TOO_FAST = [
    (
        {},
        {"pole_legs": 0.003},
        "v_max_leg",
        "1257 rad/s electrical.*longer pole_legs",
        {"pole_legs": 0.004},
    ),
    ({"v_max_leg": 6.0}, {}, "v_max_leg", "must be <= 5.092 m/s", {}),
    (
        {"v_max_table": 50.0},
        {},
        "v_max_table",
        "1100 rad/s.*<= 45.45 rad/s, or a smaller poles_tilt",
        {},
    ),
    (
        {"v_max_table": 50.0},
        {"poles_tilt": 10},
        "v_max_table",
        "smaller poles_rotation",
        {"poles_rotation": 20},
    ),
    (
        {"v_max_table": 314.16},
        {"poles_tilt": 4, "poles_rotation": 3},
        *("v_max_table", "1257 rad/s electrical.*<= 250 rad/s", {"poles_tilt": 3}),
    ),
]


@pytest.mark.parametrize(("changes", "name", "text", "cure"), REFUSED)
def test_drives__what_the_hardware_does_not_follow_is_refused_with_its_cure(
    changes, name, text, cure
):
    changed = replace(DRIVES, **changes)
    with pytest.raises(ParameterError, match=rf"^{name} = \S+ \w+: .*{text}"):
        hardware.check(ROBOT, changed)
    hardware.check(ROBOT, replace(changed, **cure))


@pytest.mark.parametrize(("robot", "changes", "name", "text", "cure"), TOO_FAST)
def test_speed__beyond_what_the_loops_are_proved_for_is_refused(robot, changes, name, text, cure):
    fast, drives = replace(ROBOT, **robot), replace(DRIVES, **changes)
    with pytest.raises(ParameterError, match=rf"^{name} = \S+ \S+: .*{text}"):
        hardware.check(fast, drives)
    slower = {} if cure else {name: float(text.split("<= ")[1].split(" ")[0])}
    hardware.check(replace(fast, **slower), replace(drives, **cure))


def test_robot__another_control_period_is_refused():
    slower = replace(ROBOT, T_s=2e-4, f_legs=20.0)
    with pytest.raises(ParameterError, match=r"^T_s = 0.0002 s: .*12500 clocks.*enter 0.0001 s"):
        hardware.check(slower, DRIVES)


def test_accepted__every_register_takes_its_value_and_the_current_trips():
    """At the ends of what passes: no field overflows, and a comparator can reach its limit."""
    for _, _, _, cure in REFUSED:
        drives = replace(DRIVES, **cure)
        assert 0 < start_up.trip_size(drives) <= start_up.FAST_FULL_SCALE
        assert start_up.dead_clocks(drives) < 256 and start_up.least_clocks(drives) <= 625


@pytest.mark.parametrize("loops", [[], ["--loops"]])
def test_command__ends_with_file_line_and_cure_and_a_status(tmp_path, capsys, loops):
    text = ROBOT_TOML.read_text(encoding="utf-8")
    file = tmp_path / "robot.toml"
    file.write_text(text.replace("value = 1e-06", "value = 5e-06", 1), encoding="utf-8")
    line = 1 + text[: text.index("[dead_time]")].count("\n")
    results = tmp_path / "drive.json"
    assert main(["--robot", str(file), "--results", str(results), *loops]) == 1
    shown = capsys.readouterr().out
    assert shown.startswith(f"{file}:{line}: error: dead_time = 5e-06 s: ")
    assert "Traceback" not in shown and not results.exists()


def test_library__chain_and_current_loops_refuse_before_anything_runs(monkeypatch):
    """Also without the command: a chain of RTL is never built for such parameters."""
    drives = replace(DRIVES, f_pwm=4e4)
    plant = Plant(ROBOT, drives)
    for module in (path, response):
        monkeypatch.setattr(module, "ChainRtl", lambda: pytest.fail("was built"))
    with pytest.raises(ParameterError, match="f_pwm"):
        response.locked(ROBOT, drives, Setting(ROBOT.resolution), plant)
    with pytest.raises(ParameterError, match="f_pwm"):
        path.Chain(plant, path_of(ROBOT, 1, PATH), [])


def test_page__own_motor_names_every_parameter_of_the_drives_and_none_that_is_not():
    """`_legs`, and the same with `_tilt` and `_rotation` by one name; `lugre_*` represents all."""
    section = re.search(r"## Your own motor\n(.*?)\n## ", PAGE.read_text(encoding="utf-8"), re.S)
    named = set(re.findall(r"`([A-Za-z]\w*\*?)`", section[1]))
    known = {field.name for field in (*fields(Robot), *fields(Drives))}
    for field in fields(Drives):
        names = {field.name, *(f"{field.name[:k]}*" for k in range(1, len(field.name) + 1))}
        assert names & named, f"{field.name} is not told"
    shaped = {n for n in named if re.search(r"_(legs|tilt|rotation|table|time|on|off|scale)$", n)}
    assert shaped <= known
