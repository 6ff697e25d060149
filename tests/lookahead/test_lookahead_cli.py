# SPDX-License-Identifier: Apache-2.0
"""Command line and figures of the look-ahead planner: what is printed, written and refused."""

import json

import pytest

from sim.motion.command import INTERRUPTED, interruptible
from sim.motion.lookahead import __main__ as lookahead_cli
from sim.motion.lookahead.__main__ import main
from sim.motion.lookahead.figures import CORNER_TOLERANCES_MM, figures
from sim.motion.lookahead.joints import SLOWEST


@pytest.fixture
def program(tmp_path):
    path = tmp_path / "part.ngc"
    path.write_text("G64 P0.01\nG1 X5 F6000\nY5\nX0 A3\nM2\n")
    return path


def test_command__program__prints_time_corners_and_limits(program, tmp_path, capsys):
    assert main([str(program), "--json", str(tmp_path / "out/part.json")]) == 0
    text = capsys.readouterr().out
    assert "0 blended corners, 2 turned" in text
    assert "limits reached" in text
    document = json.loads((tmp_path / "out/part.json").read_text())
    assert document["moves"] == 3
    assert [corner["P [mm]"] for corner in document["slowest corners"]] == pytest.approx([0.01] * 2)
    assert all(0.0 <= row["ratio"] <= 1.001 for row in document["limits"])
    assert len(document["limits"]) == 9


def test_command__lower_limit__takes_longer_and_reaches_it(program, tmp_path):
    times, speeds = [], []
    for more in ([], ["--tool", "20", "1000", "1e5"]):
        main([str(program), "--json", str(tmp_path / "part.json"), *more])
        document = json.loads((tmp_path / "part.json").read_text())
        times.append(document["time [s]"])
        speeds.append(document["limits"][0]["reached"])
    assert times[1] > times[0]
    assert speeds[1] == pytest.approx(20.0, rel=0.01)


def test_command__time_only__has_no_limits(program, tmp_path):
    assert main([str(program), "--time-only", "--steps", "--json", str(tmp_path / "a.json")]) == 0
    assert "limits" not in json.loads((tmp_path / "a.json").read_text())


def test_command__from__begins_at_the_line(tmp_path, capsys):
    part, file = tmp_path / "part.ngc", tmp_path / "part.json"
    part.write_text("G64 P0.01 F1200\nG1 X5\nY5\nX9\nM2\n")
    assert main([str(part), "--from", "3", "--time-only", "--json", str(file)]) == 0
    assert json.loads(file.read_text())["moves"] == 2
    assert main([str(part), "--from", "5", "--time-only"]) == 1
    assert "no move is in line 5 or after it; the last is in line 4" in capsys.readouterr().err


def test_command__many_corners__keeps_the_slowest(tmp_path):
    path = tmp_path / "zigzag.ngc"
    steps = "".join(f"X{k % 2 * 2} Y{k / 10}\n" for k in range(60))
    path.write_text(f"G64 P0.01\nG1 F6000 X1\n{steps}M2\n")
    main([str(path), "--time-only", "--json", str(tmp_path / "a.json")])
    document = json.loads((tmp_path / "a.json").read_text())
    assert document["blended corners"] + document["turned corners"] > 4 * SLOWEST
    assert len(document["slowest corners"]) == SLOWEST


@pytest.mark.parametrize(
    ("text", "arguments", "message"),
    [
        ("G1 X1\nM2\n", [], "part.ngc:1:1: error: no feed is set"),
        ("G0 X1 B3\nM2\n", [], "part.ngc:1:7: error: B, an axis about Y"),
        ("G0 X900\nM2\n", [], "part.ngc:1: error: the move leaves the workspace"),
        ("G0 X1\nM2\n", ["--tool", "1", "0", "1"], "acceleration of --tool = 0 is outside"),
        ("G0 X1\nM2\n", ["--table", "1", "1", "nan"], "jerk of --table = nan is outside"),
        ("G0 X1\nM2\n", ["--leg", "1e300", "1", "1"], "limit of speed of the leg = 1e+297 is"),
        ("G0 X1\nM2\n", ["--tool", "1", "1e9", "1"], "acceleration / jerk = 1000000000.0 s is"),
        ("G0 X1\nM2\n", ["--rapid", "-3"], "--rapid = -3 is outside its limit: > 0 mm/s"),
        ("G0 X1\nM2\n", ["--depth", "0"], "depth = 0 is outside its limit: depth >= 2"),
    ],
)
def test_command__mistakes__are_told_without_a_traceback(program, capsys, text, arguments, message):
    program.write_text(text)
    assert main([str(program), *arguments]) == 1
    assert message in capsys.readouterr().err


def test_command__missing_file__is_told(tmp_path, capsys):
    assert main([str(tmp_path / "none.ngc")]) == 1
    assert "none.ngc: No such file" in capsys.readouterr().err


def test_command__long_motion__tells_progress_in_a_log(program, capsys, monkeypatch):
    monkeypatch.setattr(lookahead_cli, "LOGGED", 1.0)
    program.write_text("G1 X10 F60\nM2\n")
    for more, expected in (([], range(4, 12)), (["--time-only"], [1])):
        main([str(program), *more])
        told = capsys.readouterr().err.splitlines()
        assert len(told) in expected and told[-1].startswith("1 moves read, 10.0")


def test_command__stopped_by_the_user__is_no_traceback(capsys):
    def stopped() -> int:
        raise KeyboardInterrupt

    assert interruptible(stopped) == INTERRUPTED
    assert capsys.readouterr().err == "interrupted\n"


def test_command__nothing_to_do__is_a_wrong_command_line():
    with pytest.raises(SystemExit) as caught:
        main([])
    assert caught.value.code == 2


def test_figures__drawn__have_the_paper_beside_our_numbers(tmp_path):
    document = figures(tmp_path)
    assert json.loads((tmp_path / "lookahead.json").read_text()) == document
    for name in ("lookahead_path.svg", "lookahead_corner.svg"):
        assert "<svg" in (tmp_path / name).read_text()
    times = document["figures 4 and 5"]
    for name, digits in (("without blending [s]", 0.1), ("with blending [s]", 0.05)):
        assert times[name]["steps of acceleration"] == pytest.approx(
            times[name]["published"], abs=digits
        )
    for row, tolerance in zip(document["figure 6"], CORNER_TOLERANCES_MM, strict=True):
        assert row["P [mm]"] == tolerance
        assert 0.8 * tolerance < row["apex of the set-points [mm]"] <= tolerance
