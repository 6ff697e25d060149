# SPDX-License-Identifier: Apache-2.0
"""The scope on a core with its debug block: what it shows is what the block has recorded."""

from __future__ import annotations

import threading
from unittest.mock import Mock

import numpy as np
import pytest

from asip_asm.assemble import assemble
from sim.debug.backend import BlockBackend, open_block
from sim.debug.client import Client, DebugError
from sim.debug.link import LinkError
from sim.debug.model import DebugRtl
from sim.debug.packets import PacketError
from sim.debug.scope import __main__ as command
from sim.debug.scope import goals
from sim.debug.scope.block_source import BlockSource, block_trigger, first_channels
from sim.debug.scope.session import Session
from sim.debug.scope.source import Applied, Block, Commit, Event, Fault, Note, Pace, SourceError
from sim.debug.state import Channel, Records
from tests.scope.fake_source import Scope
from tests.scope.page_link import Page, talk

PROGRAM = """
.program "integrator"
.input   x, n : int
.param   K = 2.5
.param   top = 1e30
.state   sum = 0.0
.output  y, safe = -1.0

        fmadd   sum, K, x, sum
        fsat    y, sum, -1e30, top
        halt
"""
NAMES = ["y", "x", "n", "sum", "cycles"]


class Machine:
    """A core with its block that runs when a test says so, a lock around every access."""

    def __init__(self, folder) -> None:
        file = folder / "integrator.s"
        file.write_text(PROGRAM)
        self.image = assemble(file)
        self.model = DebugRtl(self.image.configuration)
        self.model.load(self.image)
        self.lock = threading.RLock()
        self.y: list[float] = []
        self.x: list[float] = []

    def run(self, x: np.ndarray) -> None:
        """A run per value; n counts them."""
        data = np.empty((len(x), 2), dtype=np.uint32)
        data[:, 0] = x.astype(np.float32).view(np.uint32)
        data[:, 1] = np.arange(len(self.x), len(self.x) + len(x))
        with self.lock:
            writes = self.model.input_addresses(["x", "n"])
            result = self.model.run(writes, data, self.model.output_addresses(["y"]))
        self.y += result.words[:, 0].view(np.float32).tolist()
        self.x += x[: len(result.words)].astype(np.float32).tolist()

    # ------------------------------------------------------------------ as a bus of DirectLink
    def read(self, address: int) -> int:
        with self.lock:
            return self.model.read(address)

    def write(self, address: int, data: int) -> None:
        with self.lock:
            self.model.write(address, data)

    def clock(self, cycles: int = 1) -> None:
        with self.lock:
            self.model.clock(cycles)


@pytest.fixture()
def machine(tmp_path):
    made = Machine(tmp_path)
    yield made
    made.model.close()


def source_of(machine: Machine, **more) -> BlockSource:
    return BlockSource(lambda: open_block(machine), machine.image, NAMES, 1e-3, **more)


def until(source: BlockSource, enough, session: Session | None = None) -> list[Event]:
    """Events up to the first one that is enough; a session takes them."""
    events = []
    while not events or not enough(events[-1]):
        events.append(source.wait())
        if session:
            session.take(events[-1])
    return events


def end_at(tick: int):
    return lambda event: isinstance(event, Block) and event.first + len(event.values) >= tick


@pytest.mark.full
def test_block__every_run__the_words_that_the_core_wrote(machine):
    source, rng = source_of(machine), np.random.default_rng(1)
    session = Session(source.description)
    for total in range(50, 301, 50):
        machine.run(rng.normal(size=50))
        until(source, end_at(total), session)
    values = session.ring.window(0, 300).values
    assert len(values) == 300 and session.lost == 0
    assert values[:, 0].tolist() == machine.y  # bit for bit: both are exact in float64
    assert values[:, 1].tolist() == machine.x
    assert values[:, 2].tolist() == list(range(300))
    assert (values[:, 4] > 0).all() and (values[:, 4] == values[0, 4]).all()


def test_block__one_of_four_runs__has_its_period(machine):
    source = source_of(machine, every=4)
    assert source.description.period == 4e-3
    machine.run(np.ones(40))
    (block,) = until(source, end_at(10))
    assert np.diff(block.values[:, 2]).tolist() == [4.0] * 9


def test_block__live_parameters__change_together_between_two_runs(machine):
    source = source_of(machine)
    assert {gain.name: gain.value for gain in source.description.gains} == {
        "K": 2.5,
        "top": float(np.float32(1e30)),
    }
    machine.run(np.ones(10))
    until(source, end_at(10))
    source.check({"K": 1.0, "top": 26.0})
    source.send(Commit(1, {"K": 1.0, "top": 26.0}))
    (applied,) = until(source, lambda event: isinstance(event, Applied))
    assert applied == Applied(10, 1, {"K": 1.0, "top": 26.0})
    machine.run(np.ones(3))
    (block,) = until(source, end_at(13))
    assert block.values[:, 0].tolist() == [26.0, 26.0, 26.0]
    assert block.values[:, 3].tolist() == [26.0, 27.0, 28.0]


@pytest.mark.parametrize("way", ["bus", "serial line", "line that loses every record"])
def test_block__fault__the_black_box_is_the_ring_of_the_block(machine, way, monkeypatch):
    serial = way == "serial line"

    def core() -> BlockBackend:
        if serial:
            return BlockBackend(lambda: Client(machine.model.serial_link()), "serial pins")
        return open_block(machine)

    source = BlockSource(core, machine.image, NAMES, 1e-3)
    if "loses" in way:
        monkeypatch.setattr(source._core.client, "drain", lambda: Records(0, []))
    session = Session(source.description)
    last = 120 if serial else 700
    machine.run(np.append(np.linspace(0.0, 1.0, last), np.nan))
    (*_, fault) = until(source, lambda event: isinstance(event, Fault), session)
    assert fault.tick == last
    assert "NOT_FINITE" in fault.text and "integrator.s:10: fsat y" in fault.text
    box = session.part("blackbox")
    first = max(last + 1 - 4096 // 8, 0)
    assert box.values[:, 2].tolist() == list(range(first, last + 1))
    assert box.values[:-1, 0].tolist() == machine.y[first:last]
    assert np.isnan(box.values[-1, 1])
    assert session.lost == (0 if "loses" in way else first)


def test_block__after_a_fault__it_records_again(machine):
    source = source_of(machine)
    machine.run(np.array([1.0, np.nan]))
    until(source, lambda event: isinstance(event, Fault))
    machine.model.clear()
    machine.model.preset({"sum": 0})
    while source._faulted:
        source._look(source._core.client)
    machine.run(np.ones(5))
    (block,) = until(source, end_at(7))
    assert (block.first, block.values[:, 0].tolist()) == (2, [2.5, 5.0, 7.5, 10.0, 12.5])


@pytest.mark.parametrize("loses", [False, True])
def test_block__its_own_trigger__the_ring_around_it_is_whole(machine, loses, monkeypatch):
    source = source_of(machine, trigger="y rising 1000", before=0.25)
    if loses:
        monkeypatch.setattr(source._core.client, "drain", lambda: Records(0, []))
    session = Session(source.description)
    machine.run(np.full(900, 2.0))  # y = 5, 10, ..: 1000 in run 199
    (*_, note) = until(source, lambda event: isinstance(event, Note), session)
    assert note.text == "trigger 'y rising 1000': tick 199"
    begin, end = 199 - 128, 199 + 384  # of 512 records
    kept = session.ring.window(begin, end).values
    assert session.ring.end == end and kept[:, 2].tolist() == list(range(begin, end))
    assert kept[:, 0].tolist() == machine.y[begin:end]
    # It waits for the next one.
    machine.model.preset({"sum": 0})
    for _ in range(3):
        source._look(source._core.client)
    machine.run(np.full(700, 2.0))
    (*_, note) = until(source, lambda event: isinstance(event, Note))
    assert note.text == f"trigger 'y rising 1000': tick {end + 199}"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("force rising 5", "no channel 'force'; recorded: y, sum"),
        ("y", "expected CHANNEL and one of above LEVEL, .* outside LEVEL LEVEL"),
        ("y crosses 5", "expected CHANNEL and one of"),
        ("y inside 5", "expected CHANNEL and one of"),
        ("y rising high", "levels are numbers"),
        ("y rising nan", "levels are finite numbers"),
    ],
)
def test_trigger__words_that_say_none__are_refused_with_the_form(words, said):
    with pytest.raises(SourceError, match=said):
        block_trigger(words, [Channel("o0", name="y"), Channel("c3", name="sum")])


def test_block__what_cannot_be__is_refused(machine):
    source = source_of(machine)
    for values in ({"K": float("inf")}, {"K": 1e39}):
        with pytest.raises(SourceError, match="K = .* is too large for binary32"):
            source.check(values)
    with pytest.raises(SourceError, match="changes of gains only"):
        source.send(Pace(paused=True))
    for names, said in (
        (["z"], "the program has no 'z'"),
        (["y", "y"], "each once"),
        ([f"c{n}" for n in range(9)], "9 channels; the block records 1 to 8"),
    ):
        with pytest.raises(SourceError, match=said):
            BlockSource(lambda: open_block(machine), machine.image, names, 1e-3)
    assert first_channels(machine.image) == ["y", "sum", "x", "n", "cycles"]


def test_block__link_that_breaks__is_told_and_made_again(machine, monkeypatch):
    monkeypatch.setattr("sim.debug.scope.block_source.RETRY_S", 0.0)
    broken = {"left": 2}

    def core() -> BlockBackend:
        if 0 < broken["left"] < 2:
            broken["left"] -= 1
            raise LinkError("nothing answers at /dev/ttyUSB0")
        return open_block(machine)

    source = BlockSource(core, machine.image, NAMES, 1e-3)
    machine.run(np.ones(5))
    until(source, end_at(5))

    def silent() -> None:
        broken["left"] = 1
        raise LinkError("no answer from /dev/ttyUSB0")

    monkeypatch.setattr(source._core.client, "state", silent)
    events = until(source, lambda event: event == Note(""))
    assert events == [Note("no answer from /dev/ttyUSB0; trying again"), Note("")]
    machine.run(np.ones(5))
    (block,) = until(source, end_at(10))
    assert block.first == 5 and block.values[:, 2].tolist() == [5, 6, 7, 8, 9]


OTHER = """
.program "two outputs"
.input   x
.output  y, safe = 0.0
.output  z, safe = 0.0
        mov     y, x
        mov     z, x
        halt
"""


def test_block__core_with_another_program__is_refused(machine, tmp_path, monkeypatch):
    monkeypatch.setattr("sim.debug.scope.block_source.RETRY_S", 0.0)
    (tmp_path / "other.s").write_text(OTHER)
    other = assemble(tmp_path / "other.s")
    said = "another program than 'two outputs': its entry is 0 and its outputs 0x1, the image's 0 "
    with pytest.raises(DebugError, match=said):
        BlockSource(lambda: open_block(machine), other, ["y"], 1e-3)
    small = assemble(tmp_path / "other.s", configuration="small")
    with pytest.raises(DebugError, match="the program is for 'small'"):
        BlockSource(lambda: open_block(machine), small, ["y"], 1e-3)
    # Somebody loads another program while the link is gone: reported until the right one is back.
    source = source_of(machine)
    machine.model.load(other)
    monkeypatch.setattr(source._core.client, "state", Mock(side_effect=PacketError("garbage")))
    assert source.wait() == Note("garbage; trying again")
    assert "another program than 'integrator'" in source.wait().text
    machine.model.load(machine.image)
    until(source, lambda event: event == Note(""))
    machine.run(np.ones(5))
    until(source, end_at(5))


def test_block__through_the_page__gains_and_curves(machine):
    async def act(page: Page) -> None:
        hello = await page.hear("hello")
        assert [gain["name"] for gain in hello["source"]["gains"]] == ["K", "top"]
        machine.run(np.ones(20))
        await page.hear("state", lambda m: m["tick"] == 20)
        page.say(type="stage", name="K", value=0.5)
        page.say(type="commit")
        await page.hear("state", lambda m: m["version"] == 1 and m["gains"]["K"] == 0.5)
        machine.run(np.ones(20))
        page.say(type="view", channels=["sum"], begin=0, end=40)
        frame = await page.hear("frame", lambda m: m["end"] == 40)
        want = [2.5 * n for n in range(1, 21)] + [50 + 0.5 * n for n in range(1, 21)]
        assert frame["curves"]["sum"]["v"] == want

    with Scope(source_of(machine)) as scope:
        talk(scope.url, act)


def test_goals__few_changes__are_met(monkeypatch):
    monkeypatch.setattr(goals, "QUICK", 5)
    assert [(row.value, row.met) for row in goals.rows(full=False)] == [(0, True), (0, True)]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["none.asip.json", "tcp://localhost:1"], "none.asip.json"),
        (["{image}", "tcp://localhost:1"], "error: "),
        (["{image}", "/dev/no-such-port"], "error: "),
        (["{image}", "usb:3"], "no such link"),
        (["{image}", "tcp://localhost:65536"], "write tcp://host:port"),
        (["{image}", "tcp://localhost:1", "--channels", "speed"], "the program has no 'speed'"),
    ],
)
def test_command__that_cannot_begin__status_1_and_a_cause(machine, tmp_path, capsys, words, said):
    machine.image.save(tmp_path / "p.asip.json")
    arguments = [word.format(image=tmp_path / "p.asip.json") for word in words]
    assert command.main(arguments) == 1
    told = capsys.readouterr().err
    assert said in told and "Traceback" not in told


@pytest.mark.parametrize(
    "words", [[], ["p", "t", "--period", "0"], ["p", "t", "--period", "x"], ["p", "t", "--no"]]
)
def test_command__wrong_line__status_2(words, capsys):
    with pytest.raises(SystemExit) as stopped:
        command.main(words)
    assert stopped.value.code == 2
