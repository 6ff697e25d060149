# SPDX-License-Identifier: Apache-2.0
"""One motor alone: its file, alignment, identification, gains, responses, and what is refused."""

from __future__ import annotations

import io
import json
import math
import re
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asip_asm.model.compiler import compile_law
from asip_asm.model.program import build
from asip_asm.project import ROOT
from scripts.doc_blocks import code_blocks
from sim.bench.drive.__main__ import main
from sim.bench.drive.averaged import END, MIDDLE
from sim.bench.drive.axis import hall
from sim.bench.drive.axis.alignment import SHARE, SafeLoop
from sim.bench.drive.axis.bench import Bench, BringUpError, current_program
from sim.bench.drive.axis.campaign import campaign, goals, one_result
from sim.bench.drive.axis.identify import identify, rough_inductance
from sim.bench.drive.axis.motor_file import (
    CHOICES,
    FLAGS,
    GAIN_ERROR,
    KEYS,
    OFFSET,
    MotorFileError,
    OneMotor,
    load,
)
from sim.bench.drive.axis.random_motors import motors
from sim.bench.drive.axis.result import Result, bring_up
from sim.bench.drive.axis.tuning import current_crossover, velocity_program
from sim.bench.drive.chain import OPTIONS
from sim.laws.drive.clocks import CLOCK, HALF_PERIOD, LOOP_PERIOD
from sim.laws.drive.start_up_law import start_up_law
from sim.laws.prove_program import prove
from sim.rtl.gen.absolute_regmap import REGMAP
from tests.servo.clocked import Clocked, signed

FILE = ROOT / "sim/motor.toml"
TEXT = FILE.read_text(encoding="utf-8")
LINEAR = {
    "type": '"linear"',
    "pole_pairs": None,
    "inertia": None,
    "torque_constant": None,
    "pole_pitch": "0.016",
    "mass": "0.6",
    "force_constant": "12.0",
    "travel": "0.4",
    "encoder_counts": "1e6",
    "friction": "0.8",
    "viscous": "1.0",
}


def changed(folder: Path, **keys: str | None) -> Path:
    """The shipped file with other keys; None leaves one out."""
    lines = [line for line in TEXT.splitlines() if line.split(" ")[0] not in keys]
    lines += [f"{name} = {value}" for name, value in keys.items() if value is not None]
    file = folder / "motor.toml"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


@dataclass(frozen=True)
class Command:
    """The command with a file: its exit status, what it printed, its results, what it found."""

    status: int
    printed: str
    results: Path
    result: Result


@pytest.fixture(scope="module")
def shipped(tmp_path_factory) -> Command:
    """With the shipped file, of a motor at another angle than the command's."""
    results = tmp_path_factory.mktemp("shipped") / "motor.json"
    found: list[Result] = []

    def elsewhere(one: OneMotor, **options: Any) -> Result:
        found.append(bring_up(one, angle=-2.1, **options))
        return found[-1]

    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as printed:
        patch.setattr("sim.bench.drive.axis.command.bring_up", elsewhere)
        status = main([str(FILE), "--results", str(results)])
    return Command(status, printed.getvalue(), results, *found)


@pytest.fixture(scope="module")
def rotary(shipped) -> Result:
    return shipped.result


def missed(result: Result) -> list[str]:
    return [f"{goal.name}: {goal.value}" for goal in result.goals() if not goal.met]


def test_rotary__every_goal_is_met(rotary):
    assert missed(rotary) == []


def test_rotary__friction_within_a_hundredth_of_the_rated_torque(rotary):
    one = rotary.one
    rated = one.motor.force_per_ampere * one.motor.i_max
    assert abs(rotary.found.coulomb - one.friction.coulomb) < 0.01 * rated
    assert rotary.found.viscous == pytest.approx(one.friction.viscous, rel=0.3)


@pytest.mark.full
def test_linear__every_goal_is_met_within_the_travel(tmp_path):
    one = load(changed(tmp_path, **LINEAR))
    result = bring_up(one, angle=1.3)
    assert missed(result) == []
    for record in (result.found.swings, result.move[0]):
        assert np.abs(record.counts).max() * one.resolution < one.travel / 2


@pytest.mark.full
def test_identification__follows_the_plant_not_the_file():
    """The file is wrong in all that is identified: a motor of other values is connected."""
    one = load(FILE)
    motor = replace(one.motor, R=1.1, L_d=2.1e-3, L_q=2.6e-3, psi=0.031)
    wired = replace(one, motor=motor, inertia=1.1e-4)
    found = identify(Bench(one, 0.4, wired=wired))
    assert found.R == pytest.approx(1.1, rel=0.05)
    assert found.L_d == pytest.approx(2.1e-3, rel=0.05)
    assert found.L_q == pytest.approx(2.6e-3, rel=0.05)
    assert found.psi == pytest.approx(0.031, rel=0.03)
    assert found.inertia == pytest.approx(1.1e-4, rel=0.1)


@pytest.mark.full
def test_alignment__wrong_pole_pairs_stop_it():
    one = load(FILE)
    wired = replace(one, motor=replace(one.motor, pole=one.motor.pole * 4 / 5))
    with pytest.raises(BringUpError, match="correct pole_pairs or encoder_counts"):
        identify(Bench(one, 0.4, wired=wired))


def test_start_up__a_blocked_motor_stops_it():
    one = load(FILE)
    wired = replace(one, inertia=1e3)
    with pytest.raises(BringUpError, match="moved the encoder by .* counts.*closed brake"):
        identify(Bench(one, 0.4, wired=wired))


def test_crossover__makes_the_bandwidth_of_the_model():
    for bandwidth in (500.0, 4000.0, 9000.0):
        s = 2j * math.pi * bandwidth
        loop = current_crossover(bandwidth) / s * np.exp(-s * 1.5e-5)
        assert abs(loop / (1 + loop)) == pytest.approx(math.sqrt(0.5), rel=1e-6)


SSI = {"encoder": '"ssi"', "absolute_counts": "262144", "encoder_bits": "18"}
ENDAT = SSI | {"encoder": '"endat"'}
SINCOS = {"encoder": '"sincos"', "sine_periods": "512", "encoder_counts": "524288"}
COARSE = {"encoder_counts": "8192", "inertia": "1e-7"}  # 16 a line
HALL = {"encoder": '"hall"', "encoder_counts": None, "velocity_bandwidth": "15"}
ALONE = SSI | {"encoder": '"biss"', "encoder_lines": "false", "encoder_counts": "16384"}


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ({"R": None}, r"R: missing; add a line R = \.\.\. in ohm"),
        ({"type": '"stepper"'}, r"type = 'stepper'; write type = \"rotary\""),
        ({"Rs": "1.0"}, r"Rs: unknown key; did you mean 'R'|Rs: unknown key; the keys are"),
        ({"indutance": "1.0"}, "indutance: unknown key"),
        ({"travel": "0.3"}, "travel: a rotary motor has none; remove the line"),
        ({"R": '"1"'}, "R = '1': is no number; write R = 1.5, in ohm"),
        ({"R": "-1.0"}, r"R = -1 ohm .*: must be within 0.01 \.\. 100 ohm"),
        ({"R": "nan"}, "R = nan ohm"),
        ({"R": "4.0"}, "rated current needs 32 V of the 27.7 V"),
        ({"L_d": "1e-4", "L_q": "1e-4", "rated_current": "1.0"}, "makes a ripple of 0.6 A"),
        ({"L_q": None}, "L: missing; enter one of L, L_q"),
        ({"L": "1e-3"}, "L_d: has L and L_d; enter one of L, L_d"),
        ({"flux": "0.02"}, "torque_constant: has flux and torque_constant"),
        ({"pole_pairs": "2.5"}, "must be a whole number"),
        ({"encoder_counts": "400"}, "only 100 counts of an electrical turn; at least 200"),
        ({"velocity_bandwidth": "200", "current_bandwidth": "1500"}, "must be <= 150"),
        ({"current_bandwidth": "20000"}, r"must be within 500 \.\. 9000 Hz"),
        ({"friction": "0.5"}, "static friction"),
        ({"current_range": "9.0"}, "axes trip at 1.3 of the rated current"),
        ({"L_q": "6e-3"}, "must be within 3 times"),
        ({"encoder": '"endat3"'}, 'encoder = \'endat3\': not supported; .*"biss": .*"endat": '),
        (SINCOS | {"encoder_counts": "5e5"}, r"sine_periods = 512 times 16, 32, .*; correct one"),
        (SINCOS | {"sine_periods": "512.5", "encoder_counts": "524800"}, "has no part of a line"),
        (SINCOS | {"encoder_counts": "8388608"}, "counts a clock at 1000 rad/s .* divide them by"),
        (
            SINCOS | {"sine_periods": "4096"},
            "lines in the .* s of a sample .*; an encoder with fewer",
        ),
        (
            SINCOS | COARSE | {"sine_gain": "0.2", "sine_offset": "0.1", "sine_noise": "0.02"},
            "an acceleration by the rated current, and the errors of the lines, move .* smaller",
        ),
        (SINCOS | {"sine_periods": None}, r"sine_periods: missing; add a line sine_periods = "),
        (SINCOS | {"encoder_lines": "false"}, r"encoder_lines: of an absolute encoder; write"),
        ({"sine_gain": "0.01"}, r"sine_gain: of sine and cosine lines; write encoder = \"sincos\""),
        (
            HALL | {"encoder_counts": "20000"},
            'finer than Hall lines; write encoder = "incremental"',
        ),
        (HALL | LINEAR | {"encoder_counts": None}, r'"hall": not with a linear motor; .*another'),
        (HALL | {"velocity_bandwidth": "20"}, r"Hall lines have 267 edges a second .* <= 16\.7"),
        ({"hall_error": "0.1"}, 'hall_error: of Hall lines; write encoder = "hall", or remove it'),
        ({"encoder": "1"}, "encoder = 1: not supported"),
        (
            {"encoder_offset": "0.5"},
            'encoder_offset: of an absolute encoder; write encoder = "biss" or "ssi" or "endat"',
        ),
        (
            {"absolute_counts": "1024"},
            'absolute_counts: of an absolute encoder; write encoder = "bi',
        ),
        ({"encoder": '"biss"', "absolute_counts": "400"}, "only 100 positions of an electrical"),
        ({"encoder": '"biss"', "absolute_counts": "4096.5"}, "must be a whole number, a turn"),
        (
            {"encoder": '"biss"', "encoder_bits": "18"},
            'write encoder = "ssi" or "endat", or remove',
        ),
        ({"encoder": '"biss"', "encoder_gray": "true"}, 'encoder_gray: .* encoder = "ssi", or rem'),
        ({"encoder": '"ssi"'}, "encoder_bits: missing; add a line encoder_bits"),
        (SSI | {"encoder_bits": "17"}, "262144 positions of a turn need 18 bits"),
        (SSI | {"encoder_bits": "18.5"}, "encoder_bits = 18.5: must be a whole number"),
        (SSI | {"encoder_gray": "1"}, "encoder_gray = 1: write encoder_gray = true"),
        (SSI | {"encoder_clock": "400e3"}, "clocks a bit at .* MHz, `ssi_port` has 254; a faster"),
        (SSI | {"encoder_clock": "10e6"}, r"must be within 400000 \.\. 2e\+06 Hz"),
        (SSI | {"encoder_alarm": '"yes"'}, "encoder_alarm = 'yes': write encoder_alarm = true"),
        (SSI | {"encoder_repeat": "2"}, "encoder_repeat = 2: write encoder_repeat = true or"),
        (SSI | {"encoder_parity": "true"}, 'encoder_parity = True: write encoder_parity = "none"'),
        (SSI | {"encoder_parity": '"mark"'}, '"none" or encoder_parity = "even" or encoder_par'),
        (SSI | {"encoder_endat22": "true"}, 'encoder_endat22: .* encoder = "endat", or remove'),
        ({"encoder_alarm": "true"}, 'encoder_alarm: of an absolute encoder; write encoder = "ssi"'),
        (ENDAT | {"encoder_gray": "true"}, 'encoder_gray: .* write encoder = "ssi", or remove'),
        (ENDAT | {"encoder_alarm": "true"}, 'encoder_alarm: .* write encoder = "ssi", or remove'),
        (ENDAT | {"encoder_repeat": "true"}, 'encoder_repeat: .* write encoder = "ssi", or remo'),
        (ENDAT | {"encoder_parity": '"even"'}, 'encoder_parity: .* encoder = "ssi", or remove'),
        (ENDAT | {"encoder_bits": None}, "encoder_bits: missing; add a line encoder_bits"),
        (ENDAT | {"encoder_bits": "49"}, r"encoder_bits = 49 1 .* must be within 1 \.\. 48"),
        (ENDAT | {"encoder_bits": "17"}, "262144 positions of a turn need 18 bits"),
        (ENDAT | {"encoder_clock": "400e3"}, r"must be within 500000 \.\. 8e\+06 Hz"),
        (ENDAT | {"encoder_clock": "10e6"}, r"must be within 500000 \.\. 8e\+06 Hz"),
        (ENDAT | {"encoder_endat22": "2"}, "encoder_endat22 = 2: write encoder_endat22 = true"),
        (
            {"encoder_lines": "false"},
            'encoder_lines: of an absolute encoder; write encoder = "biss"',
        ),
        (SSI | {"encoder_lines": "0"}, "encoder_lines = 0: write encoder_lines = true"),
        (SSI | {"encoder_frame": "1e-4"}, "encoder_frame: with encoder_lines = false alone; add"),
        (ALONE | {"encoder_bits": None}, "encoder_bits: missing; add a line encoder_bits"),
        (ALONE | {"encoder_counts": "20000"}, "those of the position divided by 1, 2, 4"),
        (ALONE | {"encoder_counts": "524288"}, "those of the position divided by 1, 2, 4"),
        (ALONE | {"encoder_clock": "2e6"}, r"must be within 2.1e\+06 \.\. 1e\+07 Hz"),
        (ALONE | {"encoder_frame": "5e-6"}, "a frame takes 8.* s; a longer one, or a faster"),
        (
            ALONE | {"absolute_counts": "20000", "encoder_counts": "20000"},
            "several turns needs a power of two in a turn; 15 bits",
        ),
        (
            ALONE
            | {"absolute_counts": "4194304", "encoder_bits": "22"}
            | {"encoder_counts": "4194304"},
            "1.34 counts a clock at 1000 rad/s electrical, without lines",
        ),
        ({"encoder_party": '"even"'}, "encoder_party: unknown key; did you mean 'encoder_parity'"),
    ],
)
def test_file__wrong__names_file_line_cause_and_cure(tmp_path, keys, text):
    file = changed(tmp_path, **keys)
    with pytest.raises(MotorFileError, match=text) as refused:
        load(file)
    assert re.match(rf"{re.escape(str(file))}:\d+: error: ", str(refused.value))


def test_file__line_is_that_of_the_key(tmp_path):
    file = changed(tmp_path, R="1e9")
    number = file.read_text().splitlines().index("R = 1e9") + 1
    with pytest.raises(MotorFileError, match=rf"motor\.toml:{number}: error: R "):
        load(file)


def test_command__writes_results_page_and_programs(shipped):
    assert shipped.status == 0
    found, folder = json.loads(shipped.results.read_text()), shipped.results.parent
    assert found["identified"]["R"]["found"] == pytest.approx(0.8, rel=0.05)
    assert found["current_loop"]["bandwidth_hz"] >= 3000
    assert all(goal["met"] for goal in found["goals"])
    assert (folder / "motor.html").read_text().count("<figure") == 5
    assert {path.stem for path in (folder / "motor").glob("*.s")} == {
        "current_loop",
        "velocity_loop",
    }
    assert "flux" in shipped.printed


BISS = {"encoder": '"biss"', "absolute_counts": "262144"}


@pytest.mark.full
def test_absolute_encoder__the_start_up_finds_the_offset_and_the_offset_replaces_the_drag(
    tmp_path, monkeypatch
):
    one = load(changed(tmp_path, **BISS))
    found = identify(Bench(one, 0.9, at=0.7 * one.motor.pole))
    assert found.offset == pytest.approx(0.9, abs=math.radians(2))
    monkeypatch.setattr(
        "sim.bench.drive.axis.identify.with_motion", lambda *_: pytest.fail("the rotor was dragged")
    )
    result = bring_up(load(changed(tmp_path, **BISS, encoder_offset=f"{found.offset:.4f}")))
    assert missed(result) == []
    assert result.angles["by the encoder"] == pytest.approx(0.0, abs=math.radians(0.1))
    assert result.found.offset == pytest.approx(found.offset, abs=math.radians(0.1))


PER_BIT = {clocks: {"ClocksPerBit": clocks} for clocks in (16, 64, 126, 210)}
SSI_PORT = {"Width": 18, "ClocksPerBit": 126, "Gray": 0, "Alarm": 0, "Repeat": 0, "Parity": 0}
ENDAT_PORT = {
    **{"Width": 18, "ClocksPerBit": 64, "Endat22": 1, "StartClocks": 250},
    **{"RecoveryClocks": 3750, "MeasureClocks": 500},
}


@pytest.mark.parametrize(
    ("keys", "port"),
    [
        (SSI, {}),
        (SSI | {"encoder_gray": "true"}, {"Gray": 1}),
        (SSI | {"encoder_alarm": "true"}, {"Alarm": 1}),
        (SSI | {"encoder_repeat": "true"}, {"Repeat": 1}),
        (SSI | {"encoder_parity": '"none"', "encoder_gray": "false"}, {}),
        (SSI | {"encoder_parity": '"even"'}, {"Parity": 1}),
        (SSI | {"encoder_parity": '"odd"', "encoder_clock": "2e6"}, {"Parity": 2} | PER_BIT[64]),
        (SSI | {"encoder_clock": "600e3"}, PER_BIT[210]),
        (SSI | {"encoder_bits": "25"}, {"Width": 25}),
        (ENDAT, {}),
        (ENDAT | {"encoder_endat22": "false"}, {"Endat22": 0}),
        (ENDAT | {"encoder_clock": "8e6"}, PER_BIT[16] | {"MeasureClocks": 368}),
        (ENDAT | {"encoder_clock": "1e6"}, PER_BIT[126] | {"StartClocks": 0}),
        (ENDAT | {"encoder_bits": "37"}, {"Width": 37}),
    ],
)
def test_absolute_encoder__each_key_is_a_parameter_of_the_port(tmp_path, keys, port):
    """At 125 MHz."""
    one = load(changed(tmp_path, **keys))
    assert one.port == (SSI_PORT if one.encoder == "ssi" else ENDAT_PORT) | port
    assert one.port_name == f"{one.encoder}_port"


@pytest.mark.parametrize(
    "keys",
    [SSI | {"encoder_parity": '"odd"'}, ENDAT | {"encoder_clock": "8e6"}],
    ids=["ssi", "endat"],
)
def test_absolute_encoder__the_port_builds_with_its_parameters(tmp_path, keys):
    """A port refuses what it cannot do when it is built; CONFIG shows the parameters."""
    one = load(changed(tmp_path, **keys))
    block = Clocked(one.port_name, ("address", "read", "data"), ("readdata",), one.port)
    found = block.run(4, address=REGMAP.address("CONFIG"), read=1)["readdata"][-1]
    fields = REGMAP.registers["CONFIG"].fields
    assert fields["width"].of(found) == 18
    assert fields["bit_clocks"].of(found) == one.port["ClocksPerBit"]


@pytest.mark.quick("endat")
@pytest.mark.parametrize("keys", [SSI, ENDAT], ids=["ssi", "endat"])
def test_absolute_encoder__over_a_serial_line_gives_the_offset(tmp_path, keys):
    one = load(changed(tmp_path, **keys, encoder_offset="0.9"))
    found = identify(Bench(one, 0.9, at=0.7 * one.motor.pole))
    assert found.offset == pytest.approx(0.9, abs=math.radians(0.1))


@pytest.mark.quick("endat")
@pytest.mark.parametrize(
    "keys",
    [
        SSI | {"encoder_gray": "true", "encoder_alarm": "true", "encoder_parity": '"odd"'},
        ENDAT | {"encoder_clock": "4e6"},
    ],
    ids=["ssi", "endat"],
)
def test_command__prints_and_writes_the_parameters_of_the_encoders_port(tmp_path, capsys, keys):
    results = tmp_path / "motor.json"
    file = changed(tmp_path, **keys, encoder_offset="0.7")
    assert main([str(file), "--results", str(results)]) == 0
    one = load(file)
    assert json.loads(results.read_text())["encoder_port"] == one.port
    printed = capsys.readouterr().out
    for name, value in one.port.items():
        assert re.search(rf"{name} +{value} +parameter of", printed)
    assert printed.count(one.port_name) == len(one.port)


COUNTER = {"Width": 18, "Drop": 4, "Modulus": 0, "Instant": 8, "Periods": 4}


@pytest.mark.parametrize(
    ("keys", "counter", "frame"),
    [
        (ALONE, COUNTER | {"Period": 3546}, 1052),  # (18 + 12) 14 + 5 us; 20 us more
        (ALONE | {"encoder_frame": "10e-6"}, COUNTER | {"Period": 1250}, 1052),
        (
            ALONE | {"absolute_counts": "20000", "encoder_counts": "20000", "encoder_bits": "15"},
            {"Width": 15, "Drop": 0, "Modulus": 20000},
            27 * 14 + 626 + 6,
        ),
        (
            ALONE | {"encoder": '"ssi"', "encoder_repeat": "true", "encoder_clock": "2e6"},
            COUNTER | {"Instant": 1},
            2 * 20 * 64 + 3126 + 6,
        ),
        (
            ALONE | {"encoder": '"endat"', "encoder_clock": "8e6"},
            COUNTER | {"Instant": 1, "Period": 250 + 37 * 16 + 626 + 3876, "Periods": 7},
            250 + 37 * 16 + 626 + 6,
        ),
    ],
    ids=["biss", "fast", "modulus", "ssi", "endat"],
)
def test_encoder_without_lines__parameters_of_its_count(tmp_path, keys, counter, frame):
    """At 125 MHz; the block is built with them."""
    one = load(changed(tmp_path, **keys))
    assert {name: one.counter[name] for name in counter} == counter
    assert one.frame_clocks == frame and one.counter["MostJump"] >= 4
    block = Clocked("absolute_position", ("done",), ("request",), one.counter)
    found = block.run(one.counter["Period"] + 1)
    assert np.flatnonzero(found["request"]).tolist() == [one.counter["Period"] - 1]


def test_encoder_without_lines__every_goal_is_met(tmp_path, capsys):
    """The largest error of the angle is that of the whole counts: 3 of them and a half."""
    results = tmp_path / "motor.json"
    file = changed(tmp_path, **ALONE, encoder_offset="0.7")
    assert main([str(file), "--results", str(results)]) == 0
    one, found = load(file), json.loads(results.read_text())
    assert found["encoder_counter"] == one.counter
    errors = found["encoder_error_degrees"]
    assert set(errors) == {"in all motions", "after a lost frame", "after 3 lost frames"}
    count = math.degrees(one.resolution * one.motor.wave)
    for error in errors.values():
        assert 0.5 * count < error["largest"] <= 3.5 * count and 0 < error["rms"] < count
    printed = capsys.readouterr().out
    assert "absolute_posit" in printed and "age of the" in printed and "BiSS" not in printed


def test_encoder_without_lines__of_a_linear_motor_with_slow_ssi(tmp_path):
    keys = LINEAR | {"encoder": '"ssi"', "encoder_lines": "false", "encoder_bits": "24"}
    one = load(changed(tmp_path, **keys, absolute_counts="4e6", encoder_offset="-2.5"))
    assert (one.counter["Drop"], one.counter["Modulus"]) == (2, 0)
    found = identify(Bench(one, -2.5, at=-0.31 * one.motor.pole))
    assert found.offset == pytest.approx(-2.5, abs=math.radians(0.1))
    assert found.psi == pytest.approx(one.motor.psi, rel=0.03)


def test_bench__frames_that_are_lost_show_in_the_angle(tmp_path):
    """A constant force from rest: a count that stays, against one that goes on by the last speed;
    the counts of lines A and B are within half a count."""
    angles = {}
    for name, keys in (("lines", {}), ("alone", ALONE | {"encoder_counts": "262144"})):
        one = load(changed(tmp_path, **keys))
        count = math.degrees(one.resolution * one.motor.wave)
        for lost in (0, 1000):
            bench = Bench(one)
            bench.current_loop(one.motor, bench.truth["angle"], 5000.0)
            bench.run(np.full((300, 1), 0.5 * one.motor.force_per_ampere * one.motor.i_max))
            bench.lose(lost)
            bench.off()
            bench.run(np.full((300, 1), 0.5 * one.motor.force_per_ampere * one.motor.i_max))
            angles[name, lost] = bench.off()[1] / count
    assert 0.4 < angles["lines", 0] <= 0.51 and angles["lines", 1000] == angles["lines", 0]
    assert 0.5 < angles["alone", 0] <= 3.5
    # x = a t^2 / 2, extrapolated from 3 ms to 6 ms by the speed of the last frames, in whole counts
    # of a frame.
    acceleration = 0.5 * one.motor.force_per_ampere * one.motor.i_max / one.inertia
    moved = acceleration * 3e-3**2 / 2 / one.resolution
    period = one.counter["Period"] * CLOCK
    late = 1.5 * period * acceleration * 3e-3 / one.resolution
    assert angles["alone", 1000] == pytest.approx(moved, abs=3e-3 / period + late)
    assert moved > 5 * (3e-3 / period + late)


def test_absolute_encoder__of_a_linear_motor(tmp_path):
    keys = LINEAR | {"encoder": '"biss"', "absolute_counts": "2e7", "encoder_offset": "-2.5"}
    one = load(changed(tmp_path, **keys))
    found = identify(Bench(one, -2.5, at=-0.31 * one.motor.pole))
    assert found.offset == pytest.approx(-2.5, abs=math.radians(0.1))
    assert found.psi == pytest.approx(one.motor.psi, rel=0.03)


def test_absolute_encoder__a_wrong_offset_is_refused_with_the_right_one(tmp_path):
    one = load(changed(tmp_path, **BISS, encoder_offset="2.0"))
    with pytest.raises(BringUpError, match="encoder_offset = 2 rad is .* degrees") as refused:
        identify(Bench(one, 0.9, at=0.7 * one.motor.pole))
    right = float(re.search(r"about (-?[\d.]+)", str(refused.value))[1])
    assert right == pytest.approx(0.9, abs=math.radians(5))


def test_command__a_wrong_file_or_option__ends_with_an_error(tmp_path, capsys):
    assert main([str(changed(tmp_path, R=None))]) == 1
    assert "R: missing" in capsys.readouterr().out
    with pytest.raises(SystemExit) as stop:
        main([str(FILE), "--loops"])
    assert stop.value.code == 2


def test_bench__step_of_voltage_at_a_locked_rotor__is_the_closed_form():
    """Without dead time and drops, along the magnets: i = u / R (1 - exp(-t R / L_d))."""
    ideal = {"dead_time": 0.0, "delay_on": 0.0, "delay_off": 0.0, "drop": 0.0}
    one = replace(load(FILE), inertia=1e6, drop_resistance=0.0, **ideal)
    bench = Bench(one, angle=0.0)
    bench.start_up()
    bench.measure_offsets()
    rest = 10
    volts = np.r_[np.zeros(rest), np.full(600, 3.0)]
    seen = bench.run(bench.orders(len(volts), u_alpha=volts))
    motor, period = one.motor, one.setting().period
    # The voltage of a run begins with the next half period; currents are of the window's middle.
    t = period * (np.arange(len(volts)) - rest - 1) + MIDDLE * CLOCK
    volt = seen.u_alpha[-1]  # in whole clocks of the compare values
    expected = volt / motor.R * -np.expm1(-np.maximum(t, 0) * motor.R / motor.L_d)
    assert np.abs(seen.alpha / (1 + GAIN_ERROR) - expected).max() < 0.02
    assert np.abs(seen.u_alpha[rest:] - 3.0).max() < 0.05


def test_bench__the_record_has_the_sensors_errors_and_whole_counts(rotary):
    counts = rotary.found.swings.counts
    assert (counts == np.round(counts)).all()
    one = load(FILE)
    bench = Bench(one)
    bench.start_up()
    bench.measure_offsets()
    assert bench.zeros == pytest.approx(np.array([OFFSET, -OFFSET]) * 2**17, abs=3)


@pytest.mark.parametrize("name", ["start up", "current loop", "velocity loop"])
def test_program__bits_on_the_core_are_those_of_the_bench(name, rotary, tmp_path):
    one, found, tuned = rotary.one, rotary.found, rotary.tuned
    laws = {
        "start up": lambda: compile_law(start_up_law(one, one.setting()), OPTIONS),
        "current loop": lambda: current_program(one, found.motor(one.motor), tuned.crossover),
        "velocity loop": lambda: velocity_program(tuned),
    }
    built = build(laws[name](), tmp_path / "loop.s")
    proof = prove(built.compiled, built.image, count=200)
    assert proof.passed, proof


@pytest.mark.full
@pytest.mark.parametrize("number", [2, 19])
def test_random_motors__every_goal_of_the_campaign_is_met(number, tmp_path):
    """A slow one at 560 V, a fast one at 48 V with much friction, which must not end its move."""
    *_, (file, _) = motors(tmp_path, number)
    rows = list(goals({file.name: one_result(str(file), 0.3 * number)}))
    assert len(rows) > 10
    assert [f"{row.name}: {row.value} {row.note}" for row in rows if not row.met] == []


@pytest.mark.full
def test_random_motors__goals_of_the_campaign(tmp_path):
    rows = list(goals(campaign(tmp_path, print)))
    assert [f"{row.name}: {row.value} {row.note}" for row in rows if not row.met] == []


def test_campaign__a_motor_that_stops_or_is_off_is_missed():
    row = {"R": 6.0, "L_d": 1.0, "L_q": 1.0, "flux": 1.0, "inertia": 1.0, "friction": 0.1}
    row |= {"without motion": 1.0, "with motion": 0.1, "moved": 1.0, "bandwidth": 2900.0}
    row |= {"margin": 60.0, "share": 1.0, "velocity share": 1.0, "velocity margin": 60.0}
    row |= {"stays away": 1.0}
    found = {"a.toml": row, "b.toml": "b.toml: it stopped"}
    wrong = [goal.name.partition(": ")[2] for goal in goals(found) if not goal.met]
    assert wrong == [
        "bring-up stopped",
        "R, identified from the start-up",
        "current loop by injection, -3 dB",
    ]


def test_page__has_the_shipped_file_and_every_key():
    page = ROOT / "docs/drive.md"
    (block,) = [block for block in code_blocks(page) if block.title == "my_motor.toml"]
    assert block.text == TEXT
    text = page.read_text(encoding="utf-8")
    assert [name for name in (*KEYS, *FLAGS, *CHOICES) if f"`{name}`" not in text] == []


def test_sine_and_cosine__parameters_of_both_blocks(tmp_path):
    """Windows of 3 x 32 bits of 6 clocks; both blocks are built with them."""
    one = load(changed(tmp_path, **SINCOS))
    assert one.port_name == "sincos_position"
    assert one.port == {"Width": 16, "Bits": 10, "Least": 4096, "Most": 12288, "After": 4}
    assert {name: one.counter[name] for name in ("Width", "Period", "Instant", "Periods")} == {
        "Width": 10,
        "Period": 624,
        "Instant": 285,
        "Periods": 4,
    }
    assert one.frame_clocks == 96 * 6 + 4 + 13 + 6 - 285 and one.frame_clocks + 285 < 624
    port = Clocked("sincos_position", ("sample", "valid", "sine"), ("done", "good"), one.port)
    sample, valid = np.eye(40, dtype=int)[[1, 3]]
    found = port.run(40, sample=sample, valid=valid, sine=8192)
    assert np.flatnonzero(found["done"] & found["good"]).tolist() == [3 + 13]
    block = Clocked("absolute_position", ("done",), ("request",), one.counter)
    assert np.flatnonzero(block.run(700)["request"]).tolist() == [623]


def test_sine_and_cosine__every_goal_is_met_as_with_lines_a_and_b(tmp_path, capsys):
    """The current loop of the same motor with as many counts of lines A and B has the same
    bandwidth and margin."""
    results = tmp_path / "motor.json"
    lines = {"encoder_counts": SINCOS["encoder_counts"]}
    found = {}
    for name, keys in (("lines", lines), ("sincos", SINCOS)):
        assert main([str(changed(tmp_path, **keys)), "--results", str(results)]) == 0
        found[name] = json.loads(results.read_text())
    assert set(found["sincos"]["encoder_error_degrees"]) == {"in all motions"}
    assert "sincos_position" in capsys.readouterr().out
    loop, wanted = (found[name]["current_loop"] for name in ("sincos", "lines"))
    assert loop["bandwidth_hz"] == pytest.approx(wanted["bandwidth_hz"], rel=0.02)
    assert loop["margin_degrees"] == pytest.approx(wanted["margin_degrees"], abs=1.0)


def test_sine_and_cosine__errors_of_the_lines_are_errors_of_the_angle(tmp_path):
    """An offset of o by o / (2 pi) lines, amplitudes apart by g by g / (4 pi), in a slow motion."""
    quiet = {"sine_offset": "0", "sine_gain": "0", "sine_noise": "0"}
    for name, value, share in (
        ("sine_offset", 0.05, 0.05 / (2 * math.pi)),
        ("sine_gain", 0.1, 0.1 / (4 * math.pi)),
        ("sine_noise", 0.0, 0.0),
    ):
        one = load(changed(tmp_path, **SINCOS | quiet | {name: str(value)}))
        bench = Bench(one)
        bench.current_loop(one.motor, bench.truth["angle"], 5000.0)
        bench.run(np.full((1200, 1), 0.3 * one.motor.force_per_ampere * one.motor.i_max))
        turned = bench.truth["x"] * 512 / (2 * math.pi)
        line = 360 * one.motor.wave / 512
        assert turned > 5
        count = math.degrees(one.resolution * one.motor.wave)
        # Three samples with weights of 2, 1 and 1 at most, and four counts.
        assert 0.9 * share * line <= bench.off()[1] <= 4 * share * line + 4 * count


@pytest.mark.parametrize("wires", [(0, 1, 2), (0, 1, 4)])
def test_hall_lines__the_bench_has_the_count_of_the_decoder_in_every_sample(wires, tmp_path):
    """Start, motion, reversal and a stop beyond `Limit`; also with the line w on the inverted
    sensor of v, which makes illegal states and jumps."""
    one = load(changed(tmp_path, **HALL))
    one = replace(one, port=one.port | {"Limit": 400_000})
    bench = Bench(one, 0.9, at=0.3 * one.motor.pole, hall=wires)
    bench.current_loop(one.motor, 0.9, 5000.0)
    forces = np.repeat([1.0, -1.0, 1.0, 0.0], [900, 1500, 600, 400])
    before, rows = bench.halves_run, len(forces)
    forces *= one.motor.force_per_ampere * one.motor.i_max
    seen = bench.run(forces[:, None]).counts
    clock, state = bench.lines().T
    clocks = HALF_PERIOD * (before + rows)
    lines = state[np.maximum(np.searchsorted(clock, np.arange(clocks), side="right") - 1, 0)]
    outputs = ("position", "bad_count")
    decoder = Clocked("hall_decoder", ("u", "v", "w", "clear"), outputs, one.port)
    found = decoder.run(clocks, u=lines >> 2, v=lines >> 1 & 1, w=lines & 1)
    at = HALF_PERIOD * np.arange(before, before + rows) + int(END)
    np.testing.assert_array_equal(seen, signed(found["position"], 32)[at])
    bad = bench.bad()
    assert bad == found["bad_count"][-1]
    assert bad > 3 if 4 in wires else bad == 0 and len(np.unique(seen)) > 100


def test_hall_lines__every_goal_is_met_and_what_cannot_be_done_is_reported(tmp_path, capsys):
    results = tmp_path / "motor.json"
    assert main([str(changed(tmp_path, **HALL)), "--results", str(results)]) == 0
    found = json.loads(results.read_text())
    names = {"alignment without motion", "check of pole_pairs", "position after a move"}
    assert set(found["not_done"]) == names
    assert found["encoder_offset_rad"] == pytest.approx(0.7, abs=math.radians(2))
    assert found["encoder_port"] == {"Bits": 8, "Filter": 15, "Limit": 4194303}
    printed = capsys.readouterr().out
    assert printed.count("not done") == 3 and "hall_decoder" in printed
    assert not any("move" in goal["name"] for goal in found["goals"])


@pytest.mark.full
def test_hall_lines__an_entered_offset_replaces_the_drag(tmp_path, monkeypatch):
    monkeypatch.setattr(hall, "align", lambda *_: pytest.fail("the rotor was dragged"))
    one = load(changed(tmp_path, **HALL, encoder_offset="0.7"))
    found = identify(Bench(one, 0.7, at=0.3 * one.motor.pole))
    assert found.angle == 0.7
    assert found.psi == pytest.approx(one.motor.psi, rel=0.03)
    for offset, wires in ((2.0, (0, 1, 2)), (0.7, (1, 0, 2)), (0.7, (0, 2, 1)), (0.7, (2, 1, 0))):
        wrong = replace(one, encoder_offset=offset)
        with pytest.raises(BringUpError, match="encoder_offset = .*: the rotor is held .* order"):
            identify(Bench(wrong, 0.7, at=0.3 * one.motor.pole, hall=wires))


def turned(sectors_per_second: float, rows: int, begin: float = 0.1) -> np.ndarray:
    """Sectors of a rotor with this speed in each period of the current loop."""
    return begin + sectors_per_second * LOOP_PERIOD * np.arange(rows)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_hall_lines__speed_is_that_of_the_last_two_edges(way):
    sectors = turned(1000.0 * way, 1000)
    wanted = 1000.0 * way * hall.SECTOR
    assert hall.speed(np.floor(hall.SECTOR * sectors)) == pytest.approx(wanted, rel=0.03)
    # No edge for five times as long as a sector took: a fifth of the speed at most.
    edge = round(1 / (1000.0 * LOOP_PERIOD))
    rest = np.full(5 * edge, sectors[-1])
    found = hall.speed(np.floor(hall.SECTOR * np.concatenate([sectors, rest])))
    assert 0 < found / wanted <= 0.2
    assert hall.speed(np.floor(hall.SECTOR * sectors[:edge])) == 0.0  # one edge at most


def test_hall_lines__edges_of_a_reversal_are_the_same_boundary():
    up = turned(1000.0, 100)
    counts = np.floor(hall.SECTOR * np.concatenate([up, up[::-1]]))
    rows, boundaries = hall.edges(counts)
    half = len(rows) // 2
    assert half >= 1 and boundaries[:half].tolist() == boundaries[: half - 1 : -1].tolist()
    first = int(np.flatnonzero(np.diff(np.floor(up)))[-1]) + 1
    assert hall.speed(counts[: len(counts) - first + 1]) == 0.0


def test_hall_lines__between_uneven_edges_a_constant_speed_is_constant():
    """uneven: counts by which each edge is late; the spline takes them away."""
    uneven = np.array([0.0, -20.0, 20.0, 0.0, -20.0, 20.0])
    true = hall.SECTOR * turned(1000.0, 2000)
    boundaries = np.arange(1, true[-1] // hall.SECTOR, dtype=np.int64)
    rows = np.searchsorted(true, hall.SECTOR * boundaries + uneven[boundaries % 6])
    counts = np.zeros(len(true))
    counts[rows] = hall.SECTOR
    smooth, rate = hall.between(np.cumsum(counts), uneven)
    inner = slice(rows[0], rows[-1])
    step = 1000.0 * hall.SECTOR * LOOP_PERIOD  # of a period: the edges are seen in whole ones
    assert np.abs(smooth - true)[inner].max() < 2 * step
    assert rate[inner].mean() == pytest.approx(1000.0 * hall.SECTOR, rel=0.01)


@pytest.mark.parametrize(
    ("wires", "text"),
    [
        ((1, 0, 2), "wrong order: they count against the current; exchange two of u, v and w"),
        ((6, 1, 2), "states 010, 011, 001 .*: u is always 0; check that line"),
        ((0, 7, 2), "states 110, 010, 011 .*: v is always 1; check that line"),
        ((7, 6, 2), "u is always 1 and v is always 0; check that line"),
        ((0, 4, 2), "line v is inverted"),
        ((0, 0, 2), "u and v are always equal"),
        ((6, 6, 6), "states with equal lines; check the supply of the sensors"),
        ((7, 6, 6), "no edge; check the supply of the sensors, the motor cable"),
    ],
)
def test_hall_lines__a_wrong_line_is_named(wires, text, tmp_path):
    one = load(changed(tmp_path, **HALL))
    bench = Bench(one, 0.7, at=0.3 * one.motor.pole, hall=wires)
    bench.start_up()
    bench.measure_offsets()
    with pytest.raises(BringUpError, match=text):
        hall.align(bench, SafeLoop(rough_inductance(bench)))


def test_hall_lines__offset_and_error_of_each_line_are_measured(tmp_path):
    """Lines in turn, u, v, w instead of v, w, u, are another offset."""
    one = load(changed(tmp_path, **HALL | {"hall_error": "0.1"}))
    for wires, more in (((0, 1, 2), 0.0), ((1, 2, 0), 2 * np.pi / 3)):
        bench = Bench(one, 0.7, at=0.3 * one.motor.pole, hall=wires)
        bench.start_up()
        bench.measure_offsets()
        angle, uneven, _ = hall.align(bench, SafeLoop(rough_inductance(bench)))
        assert angle == pytest.approx(0.7 + more, abs=math.radians(1))
        if not more:
            late = uneven * one.motor.wave * one.resolution
            # Edges 0 and 3 are of u, 1 and 4 of w, 2 and 5 of v.
            assert late == pytest.approx(0.1 * np.array([0, -1, 1, 0, -1, 1]), abs=0.02)


def lagging(one: OneMotor, share: float) -> OneMotor:
    """The motor with this share of the force that drags it as friction."""
    drags = SHARE * one.motor.i_max * one.motor.force_per_ampere
    return replace(one, friction=replace(one.friction, coulomb=share * drags))


def test_hall_lines__friction_does_not_move_the_offset(tmp_path):
    """The rotor lags by 17 degrees in either direction."""
    one = lagging(load(changed(tmp_path, **HALL)), 0.3)
    bench = Bench(one, 0.7, at=0.3 * one.motor.pole)
    bench.start_up()
    bench.measure_offsets()
    angle, _, _ = hall.align(bench, SafeLoop(rough_inductance(bench)))
    assert angle == pytest.approx(0.7, abs=math.radians(2))


def test_hall_lines__a_sensor_that_is_mounted_wrongly_is_refused(tmp_path):
    """Line v late and w early by 34 degrees, which is no mistake of a sensor."""
    one = replace(load(changed(tmp_path, **HALL)), hall_error=0.6)
    bench = Bench(one, 0.7, at=0.3 * one.motor.pole)
    bench.start_up()
    bench.measure_offsets()
    with pytest.raises(BringUpError, match="the edge of the Hall lines from state .* mounted"):
        hall.align(bench, SafeLoop(rough_inductance(bench)))


def test_hall_lines__a_rotor_that_lags_too_far_is_refused(tmp_path):
    one = lagging(load(changed(tmp_path, **HALL)), 0.6)
    bench = Bench(one, 0.7, at=0.3 * one.motor.pole)
    bench.start_up()
    bench.measure_offsets()
    with pytest.raises(BringUpError, match=r"A drags the rotor, which lags by \d+ electrical"):
        hall.align(bench, SafeLoop(rough_inductance(bench)))
