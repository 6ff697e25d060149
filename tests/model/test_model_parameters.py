# SPDX-License-Identifier: Apache-2.0
"""Parameter file: values used by the law, and the text of every refusal."""

import dataclasses
import math
import re
import tomllib

import pytest

from sim.robot.parameters import ROBOT_TOML, ParameterError, Robot
from sim.robot.published import Published
from tests.bench.copies import edited


def test_gains__from_bandwidths__match_the_specified_figures(robot):
    assert [f"{gain:.5g}" for gain in robot.K_P[2:4]] == ["1.0659e+05", "11844"]
    assert [f"{gain:.5g}" for gain in robot.K_V[2:4]] == ["565.49", "188.5"]
    assert [f"{gain:.5g}" for gain in robot.K_I[2:4]] == ["6.6974e+06", "2.4805e+05"]
    assert (len(robot.K_P), len(robot.K_V), len(robot.K_I)) == (5, 5, 5)


def test_derived_vectors__default_robot__are_those_of_the_specification(robot):
    assert robot.boost_ticks == 200
    assert robot.encoder_table == 2.0 * math.pi / 2**18
    assert robot.resolution == (0.25e-6,) * 3 + (robot.encoder_table,) * 2
    assert robot.output_max == (3000.0, 3000.0, 3000.0, 250.0, 120.0)
    assert robot.s_max == (3e-6,) * 3 + (2e-4,) * 2
    assert robot.e_c == (2e-6,) * 3 + (5e-5,) * 2
    radii = [math.hypot(*leg) for leg in robot.legs]
    assert radii == pytest.approx([0.5] * 3, rel=1e-15)
    angles = [math.degrees(math.atan2(y, x)) % 360 for x, y in robot.legs]
    assert angles == pytest.approx([90.0, 330.0, 210.0])


def test_load__every_parameter__has_a_meaning():
    tables = tomllib.loads(ROBOT_TOML.read_text(encoding="utf-8"))
    assert [name for name, table in tables.items() if not table["meaning"].strip()] == []


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        (
            "[R]\nvalue = 0.5",
            "[R]\nvalue = 0.0",
            "8: error: R = 0.0 m: must be within 0.05 .. 1.9 m; "
            "the error bounds hold for machines of this size",
        ),
        (
            "[m_s]\nvalue = 12.0",
            "[m_s]\nvalue = -1.0",
            "m_s = -1.0 kg: must be within 0 .. 10000 kg; "
            "products of parameters stay far inside the range of binary32",
        ),
        (
            "[xi_c]\nvalue = 5.0",
            "[xi_c]\nvalue = 0.5",
            "xi_c = 0.5: must be within 1 .. 8; "
            "a boosted loop s^3 + 3ws^2 + 3w^2s + xi w^3 needs < 9",
        ),
        ("[g]\nvalue = 9.81", "[g]\nvalue = nan", "g = nan m/s^2: must be finite"),
        ("[g]\nvalue = 9.81", "[g]\nvalue = inf", "g = inf m/s^2: must be finite"),
        ("[g]\nvalue = 9.81", '[g]\nvalue = "9.81"', "g = '9.81': must be a number"),
        ("[g]\nvalue = 9.81", "[g]\nvalue = true", "g = True: must be a number"),
        ("[m_p]", "[m_pp]", "m_pp: unknown parameter; did you mean m_p?"),
        ("[m_p]", "[colour]", "colour: unknown parameter"),
        (
            '[R]\nvalue = 0.5\nunit = "m"',
            '[R]\nvalue = 500\nunit = "mm"',
            "R: unit is 'mm', must be 'm'",
        ),
        (
            '[R]\nvalue = 0.5\nunit = "m"\n',
            "[R]\nvalue = 0.5\n",
            "R: has keys ['meaning', 'value'], must be meaning, unit, value",
        ),
        (
            "[z_max]\nvalue = 0.75",
            "[z_max]\nvalue = 0.4",
            "z_max = 0.4: must be > z_min = 0.45 m",
        ),
        (
            "[T_c]\nvalue = 0.02",
            "[T_c]\nvalue = 0.02005",
            "T_c = 0.02005: must be a whole number of periods T_s = 0.0001 s, 2 .. 1048576",
        ),
    ],
)
def test_load__bad_parameter__is_refused_by_name_value_and_limit(tmp_path, old, new, text):
    with pytest.raises(ParameterError) as caught:
        Robot.load(edited(ROBOT_TOML, tmp_path, old, new))
    assert str(caught.value).endswith(text)
    assert re.match(rf"{tmp_path}/robot.toml(:\d+)?: error: ", str(caught.value))


def test_load__missing_parameter__is_named(tmp_path):
    text = ROBOT_TOML.read_text(encoding="utf-8")
    table = text[text.index("[h]") : text.index("[x_max]")]
    with pytest.raises(ParameterError, match=r"robot.toml: error: h: missing parameter, unit m$"):
        Robot.load(edited(ROBOT_TOML, tmp_path, table, ""))


def test_every_parameter__minus_one__is_refused(robot):
    for entry in dataclasses.fields(robot):
        wrong = 1.0 if entry.name in ("tilt_min", "rotation_min") else -1.0
        with pytest.raises(ParameterError, match=rf"^{entry.name} = {wrong:g}"):
            dataclasses.replace(robot, **{entry.name: wrong})


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"R": 1.7}, "R = 1.7: the longest leg of the workspace has 2.048 m"),
        ({"z_min": 0.1}, "z_min = 0.1: must be >= 0.25 R = 0.125 m"),
        ({"z_start": 0.4}, "z_start = 0.4: must be within the workspace, z_min = 0.45 .. z_max"),
        ({"rotation_max": 403.0}, "rotation_max = 403.0: must be within +-402.124 rad; binary32"),
        ({"tilt_min": -256.5}, "tilt_min = -256.5 rad: must be within -256 .. 0 rad; the hardware"),
        ({"turn_table": 2.0**22}, "rotation_min = -188.49555921538757: must be within +-25.1327"),
        ({"encoder_legs": 5e-8}, "encoder_legs = 5e-08: the longest leg has 2.0"),
        ({"f_legs": 201.0}, "f_legs = 201.0: must be <= 200 Hz, 50 periods T_s"),
        ({"friction_legs": 101.0}, "friction_legs = 101.0: must be <= m_p friction_speed_legs"),
        ({"F_max": 100.0}, "F_max = 100.0: must be > 143.4 N, which holds the weight"),
        ({"tau_max_4": 8.0}, "tau_max_4 = 8.0: must be > r_4 m_4 g = 8.829 N m"),
        ({"T_s": 10**400}, "T_s = 1000000000"),
    ],
)
def test_robot__limits_that_depend_on_other_parameters__are_named(robot, change, text):
    with pytest.raises(ParameterError) as caught:
        dataclasses.replace(robot, **change)
    assert str(caught.value).startswith(text)


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"[R]\nvalue 0.5\n", ":2:7: error: Expected '=' after a key in a key/value pair"),
        (b"[R]\nvalue = \n", ":2:9: error: Invalid value"),
        (b"[R", ":1:1: error: Expected ']' at the end of a table declaration"),
        (b"[R]\nvalue = 0.5 # \xff\n", ": error: line 2 is not UTF-8 text"),
        (b"a = " + b"[" * 5000, "error: tables or lists nested too deep"),
        (b"a = 1" + b"0" * 5000, "error: Exceeds the limit"),
        (b"#" * (1 << 20) + b"#", ": error: larger than 1048576 bytes"),
        (b"R = 0.5\n", ":1: error: R: has no keys: 0.5, must be meaning, unit, value"),
    ],
)
def test_load__text_that_is_no_parameter_file__names_place_and_cause(tmp_path, content, text):
    path = tmp_path / "robot.toml"
    path.write_bytes(content)
    with pytest.raises(ParameterError) as caught:
        Robot.load(path)
    assert str(caught.value).startswith(str(path)) and text in str(caught.value)


def test_robot__after_load__cannot_be_changed(robot):
    with pytest.raises(dataclasses.FrozenInstanceError):
        robot.R = 1.0


def test_published__tables__have_the_printed_shape():
    published = Published.load()
    assert published.operations["sqrt"] == 13
    for platform in published.time.values():
        assert platform["cycles"] == platform["clock_mhz"] * platform["time_us"]
    assert {name: len(rows) for name, rows in published.error.items()} == {
        "PC": 9,
        "DSP-C28x": 15,
        "FPGA": 9,
    }
    assert published.resources["FPGA3"]["dsp18"] == 8
