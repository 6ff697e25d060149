# SPDX-License-Identifier: Apache-2.0
"""Tops of the boards by their pins: commands over the serial port, steps, encoders; pin files."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest

from asip_asm.regmap import REGISTER_BLOCK
from scripts.bitstream import BOARDS, main, timing_met
from sim.debug.client import Client
from sim.debug.gen.debug_regmap import REGMAP as DEBUG
from sim.debug.link import SerialLink
from sim.debug.packets import Packet, Type, write_body
from sim.debug.state import REGISTER
from sim.rtl.board.model import BOARDS as MODELS
from sim.rtl.board.model import BoardRtl
from sim.rtl.board.serial_device import serving
from sim.rtl.gen.encoder_regmap import REGMAP as ENCODER
from sim.rtl.gen.motion_regmap import REGMAP as MOTION
from sim.rtl.phase_record import DIRECTION, FIRST, FRACTION, LAST, UNITS_PER_HZ, Record

ROOT = Path(__file__).resolve().parents[2]
LEG = ROOT / "tests/debugger/leg.s"
INPUTS = [f"--set={name}" for name in ("x=0.3", "y=0.1", "z=0.2", "l=0.45")]
BOARD, SECOND = "ulx3s", "versa-ecp5"  # in every run; the others in `make test-full`
AXES = {"ulx3s": 5, "colorlight-i9": 5, "ecpix5": 5, "versa-ecp5": 3}
FAST = 33  # clocks of a bit
MOTION_BASE, ENCODER_BASE = 0x6000, 0x7000
ENCODER_WORDS = ENCODER.blocks[REGISTER_BLOCK].words  # of an axis
PORT = re.compile(r"^\s*(input|output)\s+logic\s*(?:\[(\d+):0\])?\s*(\w+),?", re.M)


def command(module: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    """A command as a user starts it."""
    return subprocess.run(
        [sys.executable, "-m", module, *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
    )


@pytest.fixture(scope="module")
def board():
    model = BoardRtl(BOARD)
    yield model
    model.close()


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(n, marks=() if n == SECOND else pytest.mark.full) for n in MODELS if n != BOARD
    ],
)
def other(request):
    """The other boards: name and model, with a fast line."""
    model = BoardRtl(request.param)
    connected(model, MODELS[request.param].divider)
    yield request.param, model
    model.close()


def connected(board: BoardRtl, divider: int) -> Client:
    """Client of a board over its pins in this process, after a reset; then the line is fast."""
    board.button(True)
    board.clock(10)
    board.button(False)
    board.clock(100)
    board.line(divider)
    client = Client(SerialLink(board, "pins of the board", clock=board))
    assert client.read_word(0) == 0x4D54_4B31
    if divider > FAST:
        word = DEBUG.registers["UART"].word(divider=FAST)
        client.link.send(Packet(Type.WRITE, 99, write_body(REGISTER["UART"], [word])))
        board.clock(40 * 10 * divider)
        board.line(FAST)
    return client


@pytest.fixture
def client(board):
    """Of the board, reset, over its pins in this process."""
    return connected(board, MODELS[BOARD].divider)


def runs_as_the_core(board: BoardRtl) -> None:
    """A program over the serial port gives bits and cycles of the core."""
    program = (LEG, "--config", "small", "--state", "last=0.02", "--ticks", 2, *INPUTS)
    with serving(board) as path:
        there = command("sim.debug.asip_run", *program, "--port", path)
    here = command("sim.debug.asip_run", *program, "--rtl")
    assert here.returncode == 0, here.stderr
    assert "cycles" in here.stdout and " F " in here.stdout
    assert (there.returncode, there.stdout) == (0, here.stdout), there.stderr


def test_asip_run__over_the_serial_port__gives_bits_and_cycles_of_the_core(board):
    runs_as_the_core(board)


def test_asip_run__program_for_another_configuration__is_refused_with_the_cure(board):
    with serving(board) as path:
        done = command("sim.debug.asip_run", LEG, "--config", "fast", "--port", path, *INPUTS)
    assert done.returncode == 1
    assert "assemble it with --config small" in done.stderr


def test_asip_run__fault_on_the_board__is_told_with_its_line(board):
    with serving(board) as path:
        done = command(
            "sim.debug.asip_run", LEG, "--config", "small", "--port", path, "--max-cycles=20"
        )
    assert done.returncode == 1
    assert "WATCHDOG" in done.stderr and "leg.s:" in done.stderr


def test_asip_dbg__over_the_serial_port__stops_at_an_equation(board):
    words = ("-ex", "break (30)", "-ex", "run", "-ex", "print e", "-ex", "continue", "--batch")
    with serving(board) as path:
        done = command(
            "sim.debug.asip_dbg", LEG, "--config", "small", "--port", path, *INPUTS, *words
        )
    assert done.returncode == 0, done.stderr
    assert "e = 0.00825" in done.stdout


def test_asip_dbg__port_beside_another_place__is_refused(tmp_path):
    done = command("sim.debug.asip_dbg", LEG, "--iss", "--port", "/dev/ttyUSB0")
    assert done.returncode == 2 and "place of its own" in done.stderr


def test_asip_run__no_such_port__says_where_devices_are():
    done = command("sim.debug.asip_run", LEG, "--config", "small", "--port", "/dev/ttyNone")
    assert done.returncode == 1 and "ls /dev/ttyUSB*" in done.stderr


@pytest.mark.full
def test_other_board__runs_a_program_over_its_serial_port(other):
    runs_as_the_core(other[1])


def test_other_board__has_its_axes_steps_and_encoders(other):
    name, board = other
    client = connected(board, MODELS[name].divider)
    last = AXES[name] - 1
    config = client.read_word(MOTION_BASE + MOTION.address("CONFIG"))
    assert MOTION.registers["CONFIG"].fields["axes"].of(config) == AXES[name]
    assert turned(board, client, last, 3) == [0] * last + [12]
    assert stepped(board, client, last) == (10, 1 << last)


def test_identity__of_core_and_motion__is_read_over_the_line(client):
    assert client.read_word(0) == 0x4D54_4B31
    assert client.read_word(MOTION_BASE) == MOTION.registers["ID"].reset


def turned(board: BoardRtl, client: Client, axis: int, periods: int) -> list[int]:
    """Turn an encoder by so many periods; counts of all axes up to this one."""
    for a, b in [(1, 0), (1, 1), (0, 1), (0, 0)] * periods:
        board.encoders(a << axis, b << axis, 0)
        board.clock(50)
    words = client.read_words(ENCODER_BASE, ENCODER_WORDS * (axis + 1))
    return words[ENCODER.address("POSITION") :: ENCODER_WORDS]


@pytest.mark.parametrize(("axis", "periods"), [(0, 3), (4, 5)])
def test_encoder__turned_by_periods__is_read_as_four_counts_each(board, client, axis, periods):
    assert turned(board, client, axis, periods) == [0] * axis + [4 * periods]
    assert turned(board, client, 4, 0).count(0) == 4


def test_encoder__two_lines_at_once__is_illegal_until_cleared(board, client):
    board.encoders(2, 2, 0)
    board.clock(50)
    status = ENCODER_BASE + ENCODER_WORDS + ENCODER.address("STATUS")  # of axis 1
    seen = ENCODER.registers["STATUS"].word(illegal=1, illegal_count=1)
    assert client.read_word(status) == seen
    client.write_word(status, 0)
    assert client.read_word(status) == 0
    board.encoders(0, 0, 0)


def stepped(board: BoardRtl, client: Client, axis: int) -> tuple[int, int]:
    """10 ticks at 1 MHz on an axis backwards, then 10 forwards, by the register map as a host
    writes it: pulses of the latter, and the lines of direction that have turned."""
    rate = 1_000_000 * UNITS_PER_HZ * FRACTION
    record = Record(DIRECTION | FIRST | LAST, 10, rate, 0, 0)
    timing = MOTION.registers["STEP_TIMING"].word(length=16, space=16)
    client.write_word(MOTION_BASE + MOTION.address("STEP_TIMING"), timing)
    records = MOTION_BASE + MOTION.blocks["records"].base + 64 * axis
    head = MOTION_BASE + MOTION.address("HEAD")
    client.write_words(records, record.words())
    client.write_word(head, MOTION.registers["HEAD"].word(**{f"axis{axis}": 1}))
    assert client.read_word(MOTION_BASE + MOTION.address("POSITION") + axis) == 2**32 - 10

    record = Record(FIRST | LAST, 10, rate, 0, 0)
    client.write_words(records + 8, record.words())
    released = MOTION.registers["HEAD"].word(**{f"axis{axis}": 2})
    client.link.send(Packet(Type.WRITE, 77, write_body(head, [released])))
    levels = []
    for _ in range(20_000):
        board.clock(1)
        levels.append((board.step, board.direction))
    assert {step for step, _ in levels} == {0, 1 << axis}, "this axis alone steps"
    rising = sum(after[0] & ~before[0] == 1 << axis for before, after in pairwise(levels))
    return rising, levels[0][1] ^ levels[-1][1]


def test_step_pins__of_a_motion_record__pulse_in_its_direction(board, client):
    assert stepped(board, client, 1) == (10, 2)


@pytest.mark.parametrize("name", BOARDS)
def test_pins__of_a_board__have_one_site_for_every_port(name):
    board = BOARDS[name]
    source = (ROOT / f"rtl/board/{board.module}.sv").read_text()
    ports = []
    for _, high, port in PORT.findall(source.split(");")[0]):
        ports += [f"{port}[{n}]" for n in range(int(high) + 1)] if high else [port]
    pins = re.sub(r"#[^\n]*", "", board.pins.read_text())
    sites = re.findall(r'LOCATE COMP "([^"]+)" SITE "([^"]+)";', pins)
    assert sorted(port for port, _ in sites) == sorted(ports)
    assert [s for s, n in Counter(site for _, site in sites).items() if n > 1] == []
    kinds = re.findall(r'IOBUF PORT "([^"]+)" IO_TYPE=(?:LVCMOS|LVDS)', pins)
    assert sorted(kinds) == sorted(ports)
    assert re.search(r'FREQUENCY PORT "clk_\d+mhz" \d+ MHZ;', pins)


def test_boards__of_the_simulation__are_those_of_the_bitstreams():
    assert {name: pins.module for name, pins in MODELS.items()} == {
        name: board.module for name, board in BOARDS.items()
    }


@pytest.mark.parametrize(
    ("fmax", "met"),
    [
        ({"clk": (101.0, 100.0), "osc": (300.0, 25.0)}, True),
        ({"clk": (99.9, 100.0), "osc": (300.0, 25.0)}, False),
        ({"osc": (300.0, 25.0)}, False),  # the core's clock has no constraint
        ({}, False),
    ],
)
def test_timing__of_a_report__is_met_only_with_every_clock_at_its_constraint(fmax, met):
    report = {"fmax": {n: {"achieved": a, "constraint": c} for n, (a, c) in fmax.items()}}
    assert timing_met(report, 100.0) is met


def test_bitstream__timing_missed__is_exit_status_1_and_no_file(tmp_path, monkeypatch, capsys):
    """Tools replaced: a report that misses the clock by little."""
    missed = {
        "fmax": {"clk": {"achieved": 99.0, "constraint": 100.0}},
        "utilization": {
            c: {"used": 1} for c in ("TRELLIS_COMB", "TRELLIS_FF", "MULT18X18D", "DP16KD")
        },
        "critical_paths": [],
    }

    def tool(name, arguments, log):
        for option, content in (("--report", json.dumps(missed)), ("--textcfg", "")):
            if option in arguments:
                Path(arguments[list(arguments).index(option) + 1]).write_text(content)
        assert "ecppack" not in name

    monkeypatch.setattr("scripts.bitstream._run", tool)
    monkeypatch.setattr("scripts.bitstream.commit", lambda: "0123456789ab")
    monkeypatch.setattr("scripts.bitstream.OUTPUT", tmp_path)
    assert main(["ulx3s", "--seeds", "1", "2"]) == 1
    assert "timing not met: ulx3s" in capsys.readouterr().out
    assert not (tmp_path / "ulx3s/ulx3s.bit").exists()
    assert json.loads((tmp_path / "ulx3s/result.json").read_text())["commit"] == "0123456789ab"
    assert set(json.loads((tmp_path / "ulx3s/result.json").read_text())["clocks"]) == {"1", "2"}
