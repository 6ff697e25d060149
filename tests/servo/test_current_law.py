# SPDX-License-Identifier: Apache-2.0
"""The current loops as a program: cycles, bits, words of the link, a motor in closed loop."""

from __future__ import annotations

import functools
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from asip_asm.model.program import Built
from sim.bench.drive import goals
from sim.bench.drive.__main__ import main
from sim.bench.drive.current_loop import loop_program, respond, rise_and_overshoot
from sim.bench.drive.goals import CYCLES, SMALL
from sim.laws.drive.current_law import AXES, DELAY, MAGIC, Setting, current_law, gains
from sim.laws.prove_program import COUNT, prove
from sim.robot.drives import Drives
from sim.robot.parameters import Robot

DRIVES = Drives.load()
SETTING = Setting(Robot.load().resolution)


@functools.cache
def program(configuration: str) -> Built:
    return loop_program(DRIVES, SETTING, configuration)


@pytest.mark.parametrize("configuration", CYCLES)
def test_five_axes__within_their_cycles(configuration):
    assert program(configuration).cycles <= CYCLES[configuration]


def test_words__stand_where_the_link_writes_and_reads_them():
    image = program("small").image
    at = {entry.name: entry.index for entry in image.inputs}
    for n in AXES:
        assert [at[f"{name}{n}"] for name in ("q", "ia", "ib", "age")] == list(
            range(4 * n, 4 * n + 4)
        )
    assert at["bus"] == 20
    outputs = {entry.name: entry.index for entry in image.outputs}
    assert [outputs[f"pwm{n}{phase}"] for n in AXES for phase in "abc"] == list(range(15))


FULL = pytest.mark.full


def turning(size: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Words of a machine at work: motors turn by some counts a period, currents follow sines."""
    t, found = np.arange(size), {}
    law = current_law(DRIVES, SETTING)
    for n in AXES:
        motor, resolution = DRIVES.motors[n], SETTING.resolution[n]
        most = 0.9 * law.port(f"q{n}").limits[1] - MAGIC
        step = rng.uniform(-200, 200) / motor.wave / resolution * SETTING.period  # counts a period
        counts = np.clip(rng.uniform(-0.5, 0.5) * most + step * t, -most, most)
        angle = motor.wave * resolution * counts + rng.uniform(-np.pi, np.pi)
        peak = rng.uniform(0, motor.i_max) / DRIVES.current_scale / SETTING.ampere_per_count
        noise = rng.normal(0, 10, (2, size))
        found[f"q{n}"] = MAGIC + np.round(counts)
        found[f"ia{n}"] = MAGIC + np.round(peak * np.sin(angle) + noise[0])
        found[f"ib{n}"] = MAGIC + np.round(peak * np.sin(angle - 2 * np.pi / 3) + noise[1])
        found[f"age{n}"] = MAGIC + rng.integers(0, 4_000_000, size)
        strongest = motor.force_per_ampere * motor.i_max
        found[f"force{n}"] = strongest * rng.uniform(-1.2, 1.2) * np.sin(0.01 * t)
    found["bus"] = MAGIC + np.round(DRIVES.U_dc * rng.uniform(0.8, 1.1, size) / SETTING.bus_scale)
    return {name: np.asarray(values, dtype=np.float32) for name, values in found.items()}


@pytest.mark.parametrize("sample", [None, turning], ids=["any", "turning"])
@pytest.mark.parametrize("count", [500, pytest.param(COUNT, marks=FULL)])
@pytest.mark.parametrize("configuration", CYCLES)
def test_proof__bits_on_the_core_and_distance_from_double_precision(configuration, count, sample):
    """Any words with corners in a tenth of them, and those of a machine at work."""
    built = program(configuration)
    proof = prove(built.compiled, built.image, count=count, sample=sample)
    assert proof.passed and proof.inputs_tried == count, proof


STEPS = [(0, 0.5), *(pytest.param(*step, marks=FULL) for step in ((0, 0.0), (3, 0.0), (4, 1.5)))]


@pytest.mark.parametrize(("axis", "speed"), STEPS)
def test_step_of_current__rises_in_100_us_with_little_overshoot(axis, speed):
    wanted = SMALL * DRIVES.motors[axis].i_max
    found = respond(DRIVES, replace(SETTING, compensation=0.0), axis, wanted, 300, speed)
    assert found[-50:, 1].mean() == pytest.approx(wanted, rel=0.02)
    rise, overshoot = rise_and_overshoot(found[:, 1], SETTING.period)
    assert rise <= 100e-6 and overshoot <= 0.15
    assert np.abs(found[-50:, 0]).max() < 0.1 * wanted


def test_greatest_currents__make_the_forces_that_the_tracking_law_may_order():
    robot = Robot.load()
    most = (*[robot.F_max] * 3, robot.tau_max_4, robot.tau_max_5)
    for motor, limit in zip(DRIVES.motors, most, strict=True):
        assert motor.force_per_ampere * motor.i_max >= limit


def test_gains__give_the_magnitude_optimum():
    """K_p / (s L) with 1.5 periods of delay crosses at 1 / (2 delay), 61 degrees of margin."""
    motor = DRIVES.motors[0]
    k_d, _, k_i = gains(motor, 1e-5)
    crossover = k_d / motor.L_d
    assert crossover == pytest.approx(1 / (2 * DELAY * 1e-5))
    margin = 90 - math.degrees(crossover * DELAY * 1e-5)
    assert margin > 60 and k_i == pytest.approx(k_d * motor.R / motor.L_d * 1e-5)


def test_goals__a_value_that_is_missed__or_not_measured():
    rows = goals.Rows()
    rows.most("a", 1.5, "us", 1.5)
    rows.most("b", 1.6, "us", 1.5)
    rows.least("c", 45, "degrees", 45)
    rows.least("d", None, "degrees", 45)
    assert [row.met for row in rows] == [True, False, True, None]
    assert (rows[1].target, rows[3].target) == ("<= 1.5", ">= 45")


def test_goals__exit_status_and_file_say_what_is_missed(tmp_path, monkeypatch):
    def measure(job, rows) -> dict:
        rows.most("whole path, leg", leg, "um", 1.5)
        return {"seconds": leg}

    def other(job, rows) -> dict:
        rows.most("other", 1, "um", 2)
        return {}

    parts = {"path": measure, "loops": other}
    monkeypatch.setattr("sim.bench.drive.__main__.PARTS", parts)
    results = tmp_path / "drive.json"
    to = ["--results", str(results)]
    leg = 1.6
    assert main(to) == 1
    row, _ = json.loads(results.read_text())["goals"]
    assert row["value"] == leg and not row["met"]
    assert main(["loops", *to]) == 0, "the row that is missed is of another producer"
    found = json.loads(results.read_text())
    assert [row["value"] for row in found["goals"]] == [1.6, 1] and found["seconds"] == 1.6
    leg = 1.5
    assert main(["path", "--full", *to]) == 0
    found = json.loads(results.read_text())
    assert [row["value"] for row in found["goals"]] == [1.5, 1] and not found["whole"]
    assert main(["loops", "--full", *to]) == 0
    assert json.loads(results.read_text())["whole"]
    assert main(to) == 0
    assert not json.loads(results.read_text())["whole"]


def test_goals__an_unknown_producer_is_refused_with_those_there_are(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["curents"])
    assert stopped.value.code == 2
    assert "no curents; there are loops, speeds, path, chain" in capsys.readouterr().err
