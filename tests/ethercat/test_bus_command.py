# SPDX-License-Identifier: Apache-2.0
"""`microtick bus`: cached results are valid for their sources only, and a failing row is shown."""

from __future__ import annotations

import json

import numpy as np
import pytest

from asip_asm.project import ROOT
from scripts import bus, bus_page, bus_rows
from sim.report.goals import at_least, at_most, terminal_table


@pytest.fixture
def producers(monkeypatch, tmp_path):
    """Two rows of each kind, and the place of saved results below tmp_path."""

    def good(order, report):
        yield at_most("near", 9, 20, "ns")
        yield at_least("cycles", 100, 100, "cycles")

    def broken(order, report):
        yield at_most("far", 21, 20, "ns")
        raise RuntimeError("no TAP device")

    monkeypatch.setattr(bus, "PRODUCERS", {"good": good, "broken": broken})
    monkeypatch.setattr(bus_rows, "CACHED", tmp_path / "kept")


def goals(tmp_path, *arguments: str) -> tuple[int, list[dict]]:
    file = tmp_path / "bus.json"
    status = bus.main([*arguments, "--results", str(file)])
    return status, json.loads(file.read_text())["goals"]


def test_goals__all_met(producers, tmp_path):
    status, rows = goals(tmp_path, "good")
    assert status == 0 and [row["met"] for row in rows] == [True, True]
    assert (tmp_path / "bus.html").exists()


def test_producer__that_fails_is_a_row_that_is_not_met(producers, tmp_path):
    status, rows = goals(tmp_path)
    assert status == 1 and [row["met"] for row in rows] == [True, True, False, False]
    assert "no TAP device" in rows[-1]["note"]


def test_one_producer__leaves_the_rows_of_the_others(producers, tmp_path):
    assert goals(tmp_path, "--full")[0] == 1
    file = tmp_path / "bus.json"
    assert json.loads(file.read_text())["whole"]
    status, rows = goals(tmp_path, "good")
    assert status == 0 and [row["producer"] for row in rows] == ["good"] * 2 + ["broken"] * 2
    assert not json.loads(file.read_text())["whole"], "a quick run is a sample"


def test_unknown_producer__is_refused_with_those_there_are(producers, capsys):
    with pytest.raises(SystemExit) as stopped:
        bus.main(["speed"])
    assert stopped.value.code == 2 and "good" in capsys.readouterr().err


def test_long_result__is_cached_for_its_fingerprint_only(producers):
    ran = []

    def work():
        ran.append(1)
        return {"worst": len(ran)}

    assert (
        bus_rows.cached("clocks", "a", work) == bus_rows.cached("clocks", "a", work) == {"worst": 1}
    )
    assert bus_rows.cached("clocks", "b", work) == {"worst": 2}


def test_path__whose_capture_is_lost__is_measured_again(producers, monkeypatch, tmp_path):
    order = bus_rows.Order(False, tmp_path / "bus.pcap")
    ran = []

    def run(module, options):
        ran.append(module)
        order.capture.touch()
        order.curves.touch()
        numbers = ("tool", "following_errors", "wrong_counters")
        return dict.fromkeys(numbers, 0) | {"faults": []}

    monkeypatch.setattr(bus_rows, "run", run)
    for _ in range(2):
        assert all(goal.met for goal in bus_rows.path(order, str))
    assert len(ran) == 1
    order.capture.unlink()
    assert all(goal.met for goal in bus_rows.path(order, str)) and len(ran) == 2


def test_fingerprint__follows_sources_and_choices():
    of = [
        bus_rows.fingerprint("ecat_check", files, n)
        for files, n in (([], 1), ([], 2), (["LICENSE"], 1))
    ]
    assert len(set(of)) == 3 and of[0] == bus_rows.fingerprint("ecat_check", [], 1)


def test_mark__of_a_missing_file_is_an_error():
    with pytest.raises(FileNotFoundError, match="sim/nothing"):
        bus_rows.fingerprint("ecat_check", ["sim/nothing/*.py"])


def marked(*patterns: str) -> set[str]:
    """Names of the files that a mark of these patterns reads."""
    return {path.relative_to(ROOT).as_posix() for name in patterns for path in ROOT.glob(name)}


def test_mark__of_the_path_has_law_plant_and_bench():
    found = marked(*bus_rows.BENCH, *bus_rows.PROGRAM, *bus_rows.ROBOT, *bus_rows.rtl_of("asip"))
    wanted = {
        *("rtl/asip/asip.sv", "asip_asm/programs/tracking_optimised.s", "sim/robot/plant.py"),
        *("asip_asm/programs/tracking.interface.toml", "sim/robot/kinematics.py", "sim/robot.toml"),
        *("sim/bus/device.py", "sim/bus/machine.py", "sim/core/controller.py"),
        *("nios_sw/images/ethercat.elf", "sim/paths/agh.ngc", "asip_asm/isa.toml"),
    }
    assert wanted <= found


def test_mark__of_slaves_and_masters_has_bench_dictionary_and_sii():
    wanted = {f"sim/bus/{name}.py" for name in ("line", "datagram", "redundant", "tap")}
    wanted |= {"sim/bus/slave_harness.cpp", "sim/bus/ring.h", "sim/bus/coe/sii.py"}
    assert wanted | {"nios_sw/ethercat/dictionary.toml"} <= marked(*bus_rows.BENCH)


def test_page__shows_the_path(producers, tmp_path):
    curves = tmp_path / "path.npz"
    tool, table = np.random.default_rng(1).normal(size=(50, 3)), np.zeros((50, 2))
    np.savez(curves, wanted=tool, tool=tool + 1e-6, wanted_table=table, table=table)
    bus_page.write(tmp_path / "bus.html", terminal_table([]), curves)
    assert "The tool on its path" in (tmp_path / "bus.html").read_text()


def test_page__takes_the_goals_and_keeps_the_rest(producers, tmp_path, monkeypatch):
    page = tmp_path / "ethercat.md"
    page.write_text("# Bus\n<!-- goals: written by hand -->\nold\n<!-- end of goals -->\nrest\n")
    monkeypatch.setattr(bus, "PAGE", page)
    goals(tmp_path, "--full")
    assert bus.main(["--docs", "--results", str(tmp_path / "bus.json")]) == 0
    text = page.read_text()
    assert "| near | 9 ns | <= 20 ns |\n" in text and "| far | 21 ns, missed | <= 20 ns |\n" in text
    assert "old" not in text and text.endswith("<!-- end of goals -->\nrest\n")
