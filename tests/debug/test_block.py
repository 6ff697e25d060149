# SPDX-License-Identifier: Apache-2.0
"""The debug block in RTL: same runs with and without it, halted runs, live parameters."""

from __future__ import annotations

import random

import numpy as np
import pytest

from asip_asm.assemble import assemble
from sim.debug.client import DebugError
from sim.debug.packets import Packet, Type, encode, pack_words
from sim.debug.state import REGISTER, REGMAP, word_of
from sim.rtl.asip_bus import BLOCK, CSR, START
from sim.rtl.asip_rtl import AsipRtl
from tests.asip import core_bench
from tests.bench.seed import SEED
from tests.debug import campaigns
from tests.debug.campaigns import SHIPPED, client_of, loaded, model, random_halts, shipped, written

SUM = """.program "sum"
.input x
.output z, safe = 5.0
.output w, safe = 6.0
.state s = 1.0
  fadd s, s, x
  mov z, s
  fmul t, s, s
  mov w, t
  halt
"""


BRANCH = """.program "a branch that is not taken"
.input skip : int, x
.output z, safe = 5.0
  bnz skip, done
  fadd a1, x, zero
done:
  mov z, x
  halt
"""


def traced(core: AsipRtl, image, ticks: int, seed: int):
    """Words, cycles, flags, and the clock in its run of every issue and write; random inputs.

    The first issue of a run is in clock 0: the accesses before it take longer with the block.
    """
    rng = np.random.default_rng(seed)
    core.reset()
    core.clear()
    core.load(image)
    shape = (ticks, len(image.inputs))
    data = rng.uniform(0.1, 0.9, shape).astype(np.float32).view(np.uint32)
    inputs = core.input_addresses([e.name for e in image.inputs])
    outputs = core.output_addresses([o.name for o in image.outputs])
    return [one_run(core, inputs, row, outputs) for row in data]


def one_run(core: AsipRtl, inputs, row: np.ndarray, outputs):
    """What `traced` gives of one run."""
    core.trace()
    result = core.run(inputs, row[None], outputs)
    issues = np.array(core.traced_issues())
    begin = issues[0, 0]
    return (
        result.words.tolist(),
        result.cycles.tolist(),
        result.status.tolist(),
        (issues - [begin, 0]).tolist(),
        [(clock - begin, *write) for clock, *write in core.timed_writes()],
    )


def plain_and_debug(seed: int, programs: int, configuration: str = "fast"):
    """Runs of the shipped and of so many random programs, on the core alone and with the block."""
    plain, debug = AsipRtl(configuration), model(configuration)
    images = [shipped(name, configuration) for name in SHIPPED]
    images += [written(seed + n, configuration) for n in range(programs)]
    for n, image in enumerate(images):
        yield tuple(traced(core, image, 3, seed + n) for core in (plain, debug))


@pytest.mark.parametrize("configuration", ["fast", pytest.param("small", marks=pytest.mark.full)])
def test_block__run_that_is_not_halted__has_the_cycles_and_bits_of_the_core_alone(configuration):
    for n, (alone, beside) in enumerate(plain_and_debug(SEED, 8, configuration)):
        assert alone == beside, f"program {n}, SEED={SEED}"


@pytest.mark.parametrize("sequences", [75, pytest.param(10_000, marks=pytest.mark.full)])
def test_block__random_halts_and_steps__end_as_an_undisturbed_run(sequences: int) -> None:
    found = list(random_halts(sequences, SEED))
    assert len(found) >= sequences
    assert [text for text in found if text] == [], f"SEED={SEED}"


@pytest.mark.full
def test_block__random_halts_of_the_small_core__end_as_an_undisturbed_run() -> None:
    assert [text for text in random_halts(2000, SEED, "small") if text] == [], f"SEED={SEED}"


@pytest.mark.parametrize("changes", [100, pytest.param(10_000, marks=pytest.mark.full)])
def test_block__live_parameters_under_load__change_together(changes: int) -> None:
    assert campaigns.torn_pages(changes, SEED) == (changes, 0, 0), f"SEED={SEED}"


@pytest.fixture
def bench():
    """A client on the program SUM, x = 2."""
    image = core_bench.assembled(SUM)
    rtl, client = loaded(image)
    client.write_register("k0", word_of(2.0))
    return rtl, client, image


def ended(client):
    return client.wait(lambda state: not state.running)


def run(client):
    """A run to its end."""
    client.start()
    return ended(client)


def finished(client):
    """Let a halted run go on to its end."""
    client.resume()
    return ended(client)


def held(client):
    """Start a run; its state once it is halted."""
    client.start()
    return client.wait(lambda state: state.halted)


def test_halt__outputs_stay_those_of_the_last_run_and_the_line_is_high(bench) -> None:
    rtl, client, image = bench
    run(client)
    assert client.read_register("o0") == word_of(3.0) and not rtl.debug_active
    last = client.state().last
    client.set_breakpoint(last)
    state = held(client)
    assert (state.reason, state.next, state.held, state.empty) == ("breakpoint", last, True, True)
    assert rtl.debug_active and not rtl.irq
    assert client.read_register("o0") == word_of(3.0), "a run that stands shows nothing"
    finished(client)
    assert client.read_register("o0") == word_of(5.0) and not rtl.debug_active


def test_halt__registers_data_and_bank_k__read_and_written_for_the_next_bundle(bench) -> None:
    rtl, client, image = bench
    register = image.states[0].register
    client.halt()
    state = held(client)
    assert (state.reason, state.next) == ("request", 0)
    assert client.read_register(register) == word_of(1.0)
    assert client.read_register("k0") == word_of(2.0)
    client.write_register(register, word_of(10.0))
    client.write_register("k0", word_of(0.5))
    client.write_data(7, [1, 2, 3])
    assert client.read_data(7, 3) == [1, 2, 3]
    state = client.step()
    assert (state.halted, state.last, state.next) == (True, 0, 1)
    assert client.read_register(register) == word_of(10.5)
    finished(client)
    assert client.read_register("o1") == word_of(10.5 * 10.5)


def test_step__behind_the_last_bundle__waits_at_the_first_of_the_next_run(bench) -> None:
    _, client, image = bench
    client.set_mode(stop_at_start=True)
    state = held(client)
    assert state.reason == "start"
    client.set_mode()
    state = client.step(len(image.bundles) + 5)
    assert not state.running and state.held
    state = held(client)
    assert (state.reason, state.next) == ("step", 0)
    with pytest.raises(DebugError, match="halt it first"):
        client.resume()
        client.step()


def test_watch__write_with_value__holds(bench) -> None:
    _, client, image = bench
    register = image.states[0].register
    watch = client.set_watch(register, word_of(5.0))
    assert run(client).reason == "none", "the first run writes 3"
    client.start()
    state = client.wait(lambda state: state.halted or not state.running)
    assert state.reason == "watch" and client.read_register(register) == word_of(5.0)
    client.clear_watch(watch)
    finished(client)


@pytest.mark.parametrize("runs", [False, True])
def test_watchdog__of_a_halted_core__stands_or_ends_the_run(bench, runs: bool) -> None:
    rtl, client, _ = bench
    rtl.write(CSR["WATCHDOG"], 300)
    client.set_mode(watchdog_runs=runs)
    client.halt()
    held(client)
    rtl.clock(1000)
    assert client.state().halted != runs
    finished(client)
    assert client.fault()[0] == ("WATCHDOG" if runs else "NONE")
    assert client.read_register("o0") == word_of(5.0 if runs else 3.0)
    assert (client.cycles() >= 300) == runs


def test_abort__ends_a_halted_run_with_safe_outputs(bench) -> None:
    _, client, _ = bench
    client.halt()
    held(client)
    client.abort()
    ended(client)
    assert client.fault()[0] == "WATCHDOG" and client.read_register("o1") == word_of(6.0)
    client.resume()
    client.clear()


def test_breakpoint__disabled_while_its_bundle_waits_for_a_branch__holds_nothing(bench) -> None:
    rtl, client, _ = bench
    client.load(core_bench.assembled(BRANCH))
    client.write_register("k0", 0)
    resume = REGMAP.registers["CONTROL"].word(resume=1)
    for clocks in range(24):
        client.set_breakpoint(1)
        client.start()
        rtl.clock(clocks)
        rtl.write(REGISTER["ENABLE"], 0)
        rtl.clock(2)  # in which the core may still have been held
        rtl.write(REGISTER["CONTROL"], resume)
        ended(client)


def test_breakpoints__more_than_there_are__is_an_error_with_the_cure(bench) -> None:
    _, client, _ = bench
    taken = [client.set_breakpoint(100 + n) for n in range(4)]
    with pytest.raises(DebugError, match="all 4 breakpoints of the core are taken; clear one"):
        client.set_breakpoint(7)
    client.clear_breakpoint(taken[2])
    assert client.set_breakpoint(7) == taken[2]


def test_stage__more_words_than_fit__are_refused_until_discard(bench) -> None:
    _, client, _ = bench
    with pytest.raises(DebugError, match="more than 64 words are staged"):
        client.stage((n % 128, n) for n in range(65))
    client.commit()
    assert client.version() == (0, 0) and client.state().staged
    client.discard()
    assert not client.state().staged and not client.state().overflow
    client.stage([(0, word_of(4.0)), (0, word_of(7.0))])
    client.commit()
    run(client)
    assert client.version() == (1, 1) and client.read_register("o0") == word_of(8.0)


def test_stage__commit_while_halted__waits_for_the_end_of_the_run(bench) -> None:
    rtl, client, _ = bench
    client.halt()
    held(client)
    client.stage([(0, word_of(100.0))])
    client.commit()
    rtl.clock(50)
    assert client.state().committing and client.read_register("k0") == word_of(2.0)
    finished(client)
    rtl.clock(5)
    assert client.read_register("o0") == word_of(3.0) and client.version() == (1, 0)
    assert client.read_register("k0") == word_of(100.0)


def test_program__written_while_halted__continues_at_the_bundle_that_waits(bench) -> None:
    _, client, image = bench
    client.set_breakpoint(1)
    held(client)
    words = list(image.words())
    for offset, word in words:  # the same program again
        client.write_word(BLOCK["program"] + offset, word)
    assert client.state().next == 1
    finished(client)
    assert client.read_register("o1") == word_of(9.0) and client.fault()[0] == "NONE"


def test_random_address__beyond_the_map__is_answered(bench) -> None:
    rtl, client, _ = bench
    rng = random.Random(SEED)
    for _ in range(200):
        assert 0 <= client.read_word(0x4000 + rng.randrange(1 << 13)) < 1 << 32
    rtl.write(CSR["CONTROL"], START)
    ended(client)


TAKE = """.program "a word of a stream"
.config stream
.input x
.output z, safe = 5.0
.stream W, pin A = 1.0
  seek W
  fmul z_of, W+, x
  mov z, z_of
  halt
"""


def test_host_writes_a_word__as_the_serial_link_releases_its_bundle__old_or_new(
    tmp_path,
):
    """The assertions of the stream report a word that is read while it is written."""
    source = tmp_path / "take.s"
    source.write_text(TAKE)
    image, rtl = assemble(source), model("stream")
    resume = REGMAP.registers["CONTROL"].word(resume=1)
    place = REGISTER["CONTROL"].to_bytes(2, "little")
    packet = encode(Packet(Type.WRITE, 1, place + pack_words([resume])))

    def issued(clocks: int | None) -> tuple[int, float]:
        """Clock of the first issue; output, with a write after so many clocks of the packet."""
        rtl.reset()
        client_of(rtl).load(image)
        rtl.serial_link()
        rtl.write(BLOCK["constants"] + image.inputs[0].index, 0x3F800000)
        rtl.write(CSR["STREAM"], 0)
        rtl.write(REGISTER["CONTROL"], REGMAP.registers["CONTROL"].word(halt=1))
        rtl.write(CSR["CONTROL"], START)
        rtl.clock(40)
        rtl.write(REGISTER["CONTROL"], REGMAP.registers["CONTROL"].word(step=1))  # the seek
        rtl.clock(40)
        rtl.trace()
        rtl.send_line(packet)
        if clocks is None:
            rtl.clock(3000)
        else:
            rtl.clock(clocks)
            rtl.write(BLOCK["streams"], 0x41000000)
            rtl.clock(3000 - clocks)
        word = rtl.read(BLOCK["outputs"] + image.outputs[0].index)
        return rtl.traced_issues()[0][0], np.uint32(word).view(np.float32)

    first, value = issued(None)
    assert value == 1
    values = [issued(first + offset)[1] for offset in range(-12, 5)]
    assert set(values) == {1.0, 8.0} and values == sorted(values, reverse=True)
