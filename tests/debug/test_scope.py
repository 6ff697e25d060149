# SPDX-License-Identifier: Apache-2.0
"""The scope of the debug block: recorded words, triggers, black box; its serial port."""

from __future__ import annotations

import random
import threading

import pytest

from sim.debug import packets
from sim.debug.client import Client, connect
from sim.debug.gen.debug_regmap import REGMAP as DEBUG
from sim.debug.link import LinkError
from sim.debug.packets import Packet, Type
from sim.debug.server import Server, serve
from sim.debug.state import FIELDS, REGISTER, Channel, ScopeSetup, Trigger, word_of
from sim.rtl.asip_bus import CSR, START, place_address
from tests.asip import core_bench
from tests.bench.seed import SEED
from tests.debug.campaigns import loaded, model, recorded

ECHO = """.program "eight values"
.input x0, x1, x2, x3, x4, x5, x6, x7
.output z, safe = 0.0
.export e0, e1, e2, e3, e4, e5, e6
  mov e0, x0
  mov e1, x1
  mov e2, x2
  mov e3, x3
  mov e4, x4
  mov e5, x5
  mov e6, x6
  mov z, x7
  halt
"""
TWICE = """.program "a register written three times, in some runs"
.input x0, x1, x2, skip : int
.output z, safe = 0.0
  bnz skip, done
  fadd a1, x0, zero
  fadd a1, x1, zero
  fadd a1, x2, zero
done:
  mov z, x0
  halt
"""
INF, NAN = 0x7F800000, 0x7FC00000


def echo():
    """A core with ECHO, its client, and channels: seven registers, an output."""
    image = core_bench.assembled(ECHO)
    rtl, client = loaded(image)
    channels = tuple(Channel(e.register) for e in image.exports) + (Channel("o0"),)
    return rtl, client, channels


bench = pytest.fixture(echo, name="bench")


def tick(rtl, words) -> None:
    """A run with these inputs, and its record."""
    for n, word in enumerate(words):
        rtl.write(place_address(f"k{n}"), word)
    rtl.write(CSR["CONTROL"], START)
    rtl.clock(80)


@pytest.mark.parametrize("ticks", [25, pytest.param(3000, marks=pytest.mark.full)])
def test_scope__every_tick_of_eight_channels__has_the_words_of_the_model(ticks: int) -> None:
    pairs = list(recorded(ticks, SEED))
    assert len(pairs) >= 7 * ticks
    assert [pair for pair in pairs if pair[0] != pair[1]] == [], f"SEED={SEED}"


def expected_trigger(kind, low, high, values, pre):
    """Number of the record that triggers, by the text of docs/debug_regmap.md."""
    for n, value in enumerate(values):
        above = value >= low
        before = values[n - 1] >= low if n else None
        hit = {
            "never": False,
            "above": above,
            "below": not above,
            "rising": above and before is False,
            "falling": not above and before is True,
            "inside": low <= value <= high,
            "outside": not low <= value <= high,
            "now": True,
        }[kind]
        if hit and n >= pre:
            return n
    return None


@pytest.mark.parametrize("type_name", ["float", "int"])
@pytest.mark.parametrize(
    "kind", ["never", "above", "below", "rising", "falling", "inside", "outside", "now"]
)
def test_trigger__random_values__as_described(bench, kind: str, type_name: str) -> None:
    rtl, client, channels = bench
    rng = random.Random(f"{SEED} {kind} {type_name}")
    for _ in range(2):
        scale = 3.0 if type_name == "float" else 1000
        draw = rng.uniform if type_name == "float" else rng.randint
        low = draw(-scale, scale)
        high = low + (scale if type_name == "float" else int(scale)) / 2
        low, high = (int(low), int(high)) if type_name == "int" else (low, high)
        pre, post = rng.randrange(4), rng.randrange(1, 4)
        chosen = rng.randrange(7)
        typed = tuple(Channel(c.place, type=type_name) for c in channels[:7])
        client.configure(ScopeSetup(typed, 1, Trigger(kind, chosen, low, high), pre=pre, post=post))
        client.arm()
        values, rows = [], []
        for _ in range(14):
            row = [word_of(draw(-scale, scale), type_name) for _ in range(7)]
            value = draw(-scale, scale)
            values.append(value)
            row[chosen] = word_of(value, type_name)
            rows.append(tuple(row))
            tick(rtl, row)
        want = expected_trigger(kind, low, high, values, pre)
        assert client.triggered_at() == want
        count = len(rows) if want is None else min(len(rows), want + post)
        assert client.state().scope == (
            "waiting" if want is None else "frozen" if want + post <= len(rows) else "triggered"
        )
        assert client.drain().words == rows[:count]


def test_trigger__command__after_the_records_before_it(bench) -> None:
    rtl, client, channels = bench
    client.configure(ScopeSetup(channels, 3, Trigger("never"), pre=2, post=2))
    client.arm()
    client.trigger()
    for n in range(20):
        tick(rtl, [n] * 8)
    assert client.triggered_at() == 2 and client.state().scope == "frozen"
    assert client.drain().words == [(3 * n,) * 8 for n in range(4)]


def test_fault__freezes_the_ring_with_the_faulty_run_last(bench) -> None:
    rtl, client, channels = bench
    client.configure(ScopeSetup(channels, decimation=4))
    client.arm()
    total = 2100  # the ring has gone round: 512 records of 8 channels
    for n in range(total):
        tick(rtl, [n + 1] * 8)
    tick(rtl, [1, 2, 3, 4, 5, 6, 7, NAN])
    state = client.state()
    assert (state.fault, state.scope, state.black_box) == (True, "frozen", True)
    client.clear()
    tick(rtl, [0] * 8)
    records = client.drain()
    assert records.words[-1] == (1, 2, 3, 4, 5, 6, 7, NAN)
    assert records.words[:-1] == [(4 * n + 1,) * 8 for n in range(525)][-511:]
    assert records.lost == records.first == 525 + 1 - 512


def test_channels__of_any_number__stand_at_their_places(bench) -> None:
    rtl, client, channels = bench
    for count in range(1, 9):
        client.configure(ScopeSetup(channels[-count:]))
        client.arm()
        rows = [[100 * count + 10 * n + i for i in range(8)] for n in range(5)]
        for row in rows:
            tick(rtl, row)
        assert client.drain().words == [tuple(row[-count:]) for row in rows]


def test_channels__of_one_register__each_keeps_its_write_whatever_the_others_do(bench) -> None:
    rtl, client, _ = bench
    client.load(core_bench.assembled(TWICE))
    sets = (
        (("a1", 0), ("a1", 2), ("a1", 2), ("a1", 0), ("a1", 1), ("a1", 3), ("o0", 1), ("k1", 0)),
        (("o0", 0), ("a1", 2), ("a1", 2), ("a1", 0), ("a1", 1), ("a1", 3), ("k1", 0), ("k1", 0)),
        (("k0", 0), ("o0", 0), ("a1", 2), ("a1", 0), ("a1", 2), ("k1", 0), ("a1", 9), ("k1", 0)),
    )
    seen: dict[int, tuple[tuple[str, int], int]] = {}
    rng = random.Random(SEED)
    for channels in sets:
        client.configure(ScopeSetup(tuple(Channel(*channel) for channel in channels)))
        seen = {n: kept for n, kept in seen.items() if kept[0] == channels[n]}
        client.arm()
        for run in range(12):
            words = [rng.getrandbits(30) for _ in range(3)]
            skip = int(run < 2 or rng.random() < 0.4)
            tick(rtl, [*words, skip])
            (record,) = client.drain().words
            for n, (place, write) in enumerate(channels):
                if place == "a1" and not skip and write < 4:
                    seen[n] = (place, write), words[write - 1]
                elif place != "a1":
                    seen[n] = (place, write), words[1 if place == "k1" else 0]
                if n in seen:
                    assert record[n] == seen[n][1], f"run {run}, channel {n}, SEED={SEED}"


def test_setup__what_the_block_cannot_do__is_refused_with_what_it_can() -> None:
    one = (Channel("a0"),)
    for setup, text in (
        (ScopeSetup(()), "1 to 8"),
        (ScopeSetup(one, 0), "1 to 65536 runs"),
        (ScopeSetup(one, trigger=Trigger("odd")), "there are never, above"),
        (ScopeSetup(one, trigger=Trigger(channel=1)), "channel 1 of 1"),
        (ScopeSetup(8 * one, pre=500, post=13), "the ring holds 512 of 8"),
    ):
        with pytest.raises(ValueError, match=text):
            setup.check()
    for place, text in (("d3", "expected a register"), ("c64", "expected a"), ("o32", "expected")):
        with pytest.raises(ValueError, match=text):
            Channel(place).word()


# ---------------------------------------------------------------------- serial port
def smooth(n: int, channel: int) -> int:
    """A value that moves by less than 1/512 of itself: three bytes a record."""
    return word_of(1.5 + 0.4 * ((n * (channel + 3)) % 1000) / 1000)


def noise(n: int, channel: int) -> int:
    """A word of which nothing is known from the one before: four bytes a record."""
    return random.Random(f"{n} {channel}").getrandbits(32) & 0xFF7F_FFFF  # finite


FAST_LINE = 2424, 8
"""Clocks of a tick and of a bit: as many bits a tick as 10 kHz and 3 Mbit/s, in a quarter."""


def uart_stream(
    ticks: int, clocks: int = 10_000, divider: int = 33, value=smooth, channels: int = 8
):
    """Words of runs so many clocks apart, the records that came over the line with so many clocks
    a bit (at 100 MHz: 10 kHz, 3 Mbit/s), and how many were lost."""
    rtl, _, all_channels = echo()
    serial = Client(rtl.serial_link(divider), timeout=30)
    serial.configure(ScopeSetup(all_channels[:channels]))
    serial.arm()
    rows, got, lost = [], [], 0
    for n in range(ticks):
        rows.append(tuple(value(n, c) for c in range(8)))
        begun = rtl.cycles
        tick(rtl, rows[-1])
        rtl.clock(clocks - (rtl.cycles - begun))
        if n % 16 == 15:
            records = serial.drain()
            got += records.words
            lost += records.lost
    for _ in range(200):
        rtl.clock(10_000)
        records = serial.drain()
        got += records.words
        lost += records.lost
        if len(got) + lost >= ticks:
            break
    return [row[:channels] for row in rows], got, lost


@pytest.mark.full
@pytest.mark.parametrize(
    ("ticks", "line"), [(60, FAST_LINE), pytest.param(3000, (10_000, 33), marks=pytest.mark.full)]
)
def test_uart__eight_channels_at_10_khz_over_3_mbit__come_without_loss(ticks, line) -> None:
    rows, got, lost = uart_stream(ticks, *line)
    assert lost == 0 and got == rows
    assert model().read(REGISTER["UART_ERRORS"]) == 0


@pytest.mark.parametrize("ticks", [60, pytest.param(3000, marks=pytest.mark.full)])
def test_uart__six_channels_of_noise_at_10_khz__come_without_loss(ticks: int) -> None:
    rows, got, lost = uart_stream(ticks, *FAST_LINE, noise, 6)
    assert lost == 0 and got == rows
    assert packets.line_bits(rows) < 300 < packets.line_bits([(*row, *row[:2]) for row in rows])


@pytest.mark.full
def test_uart__eight_channels_of_noise_at_10_khz__every_record_comes_or_is_counted() -> None:
    rows, got, lost = uart_stream(5000, *FAST_LINE, noise)
    assert lost > 50 and len(got) + lost == len(rows)
    assert FIELDS["UART_ERRORS"]["lost"].of(model().read(REGISTER["UART_ERRORS"])) == lost
    places = {row: n for n, row in enumerate(rows)}
    order = [places[row] for row in got]
    assert order == sorted(set(order)), "a record is torn, or out of order"
    bits = packets.line_bits(rows)
    assert abs(len(got) / len(rows) - FAST_LINE[0] / FAST_LINE[1] / bits) < 0.15


def test_uart__more_than_the_line_carries__loses_oldest_records_and_counts_them() -> None:
    rows, got, lost = uart_stream(700, 250, 4, noise)
    assert lost > 50 and len(got) + lost == 700
    assert FIELDS["UART_ERRORS"]["lost"].of(model().read(REGISTER["UART_ERRORS"])) == lost
    assert set(got) <= set(rows), "a record is torn"


def test_uart__armed_by_the_host_while_samples_are_made__begins_again(bench) -> None:
    rtl, host, channels = bench
    serial = Client(rtl.serial_link(8), timeout=30)
    serial.configure(ScopeSetup(channels))
    serial.arm()
    for clocks in range(0, 300, 5):  # after a run: before, in and after the packet of its record
        tick(rtl, [noise(clocks, c) for c in range(8)])
        rtl.clock(clocks)
        host.arm()
        rtl.clock(10_000)
        rows = [tuple(noise(1000 + n, c) for c in range(8)) for n in range(3)]
        for row in rows:
            tick(rtl, row)
        rtl.clock(20_000)
        while (last := serial.drain()).words not in (rows, []):
            assert last.lost == 0 and len(last.words) == 1
        assert (last.first, last.words, last.lost) == (0, rows, 0)
    assert FIELDS["UART_ERRORS"]["lost"].of(rtl.read(REGISTER["UART_ERRORS"])) == 0


def test_uart__requests_events_and_damage(bench) -> None:
    rtl, client, _ = bench
    link = rtl.serial_link(8)
    serial = Client(link, timeout=30)
    assert serial.sizes == client.sizes
    rng = random.Random(SEED)
    data = [rng.choice([0, 0xFFFFFFFF, rng.getrandbits(32)]) for _ in range(100)]
    serial.write_data(3, data)
    assert serial.read_data(3, 100) == client.read_data(3, 100) == data
    serial.set_events()
    serial.halt()
    client.start()
    rtl.clock(6000)
    serial.poll()
    assert len(serial.events) >= 2 and serial.state().halted
    # A step sent twice is taken once.
    control = DEBUG.registers["CONTROL"].word(step=1)
    step = Packet(Type.WRITE, 200, packets.write_body(REGISTER["CONTROL"], [control]))
    for _ in range(2):
        link.send(step)
        rtl.clock(5000)
    serial.poll()
    assert serial.state().next == 1
    # Damaged, cut and endless frames are dropped; what follows is answered.
    good = packets.encode(Packet(Type.READ, 201, packets.read_body(0, 1)))
    before = rtl.read(REGISTER["UART_ERRORS"])
    for n in range(30):
        bad = bytearray(good)
        bad[rng.randrange(len(bad) - 1)] ^= 1 << rng.randrange(8)
        rtl.send_line(bytes(bad) if n % 3 else good[: rng.randrange(1, 6)] + b"\0")
    rtl.send_line(bytes(rng.randrange(1, 256) for _ in range(400)) + b"\0")
    rtl.clock(40_000)
    link.receive(0)
    assert rtl.read(REGISTER["UART_ERRORS"]) - before >= 25
    assert serial.state().halted
    for kind, body in ((0x55, b""), (Type.READ, b"\0\0\0"), (Type.WRITE, b"\0\0")):
        link.send(Packet(kind, 202, body))
        answer = link.receive(30)
        assert answer is not None and (answer.type, answer.sequence) == (Type.ERROR, 202)
    serial.resume()
    assert not serial.wait(lambda state: not state.running, 30).running


# ---------------------------------------------------------------------- TCP
def test_tcp__a_session__is_the_one_in_process(bench) -> None:
    rtl, direct, _ = bench
    server = Server(rtl, port=0)
    done = threading.Event()
    arguments = (rtl, server, 500, lambda: not done.is_set())
    runs = threading.Thread(target=serve, args=arguments, daemon=True)
    runs.start()
    with connect(f"tcp://localhost:{server.port}", timeout=30) as client:
        assert client.sizes == direct.sizes
        with pytest.raises(LinkError, match="has another client, and serves one at a time"):
            connect(f"tcp://localhost:{server.port}")
        slot = client.set_breakpoint(3)
        assert client.wait(lambda state: state.halted, 30).next == 3
        client.step()
        assert client.state().next == 4
        client.clear_breakpoint(slot)
        client.abort()
        client.resume()
        assert client.wait(lambda state: state.fault, 30).fault
    done.set()
    runs.join(60)
    server.close()
    assert not runs.is_alive()
