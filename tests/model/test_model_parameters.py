# SPDX-License-Identifier: Apache-2.0
"""Parameter file: values used by the law, and the text of every refusal."""

import dataclasses
import math
import tomllib

import pytest

from sim.model.parameters import ROBOT_TOML, ParameterError, Robot
from sim.model.published import Published


def variant(tmp_path, old: str, new: str):
    text = ROBOT_TOML.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path = tmp_path / "robot.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


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
        ("[R]\nvalue = 0.5", "[R]\nvalue = 0.0", "R = 0.0 m: must be > 0 m"),
        ("[m_s]\nvalue = 12.0", "[m_s]\nvalue = -1.0", "m_s = -1.0 kg: must be >= 0 kg"),
        ("[xi_c]\nvalue = 5.0", "[xi_c]\nvalue = 0.5", "xi_c = 0.5 1: must be >= 1 1"),
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
            "z_max = 0.4 m: must be > z_min = 0.45 m",
        ),
        (
            "[T_c]\nvalue = 0.02",
            "[T_c]\nvalue = 0.02005",
            "T_c = 0.02005 s: must be a whole number >= 2 of periods T_s = 0.0001 s",
        ),
    ],
)
def test_load__bad_parameter__is_refused_by_name_value_and_limit(tmp_path, old, new, text):
    with pytest.raises(ParameterError) as caught:
        Robot.load(variant(tmp_path, old, new))
    assert str(caught.value) == text


def test_load__missing_parameter__is_named(tmp_path):
    text = ROBOT_TOML.read_text(encoding="utf-8")
    path = tmp_path / "robot.toml"
    path.write_text(text.replace(text[text.index("[h]") : text.index("[x_max]")], ""), "utf-8")
    with pytest.raises(ParameterError, match=r"^h: missing parameter, unit m$"):
        Robot.load(path)


def test_every_parameter__minus_one__is_refused(robot):
    for entry in dataclasses.fields(robot):
        with pytest.raises(ParameterError, match=rf"^{entry.name} = -1"):
            dataclasses.replace(robot, **{entry.name: -1.0})


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
