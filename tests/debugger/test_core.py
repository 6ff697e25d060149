# SPDX-License-Identifier: Apache-2.0
"""The debugger on the Verilated core: in this process, by its serial pins, over TCP.

What it answers is held against the same session on the instruction-set model.
"""

from __future__ import annotations

import random
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from sim.core.backends import Backend
from sim.debug.asip_dbg.command_table import CommandError
from sim.debug.backend import BlockBackend, DrivenBackend
from sim.debug.client import Client, connect
from sim.debug.model import DebugRtl
from sim.debug.server import Server
from sim.rtl.asip_bus import AsipError, LinkError
from tests.bench.seed import SEED
from tests.debugger import debugged
from tests.debugger.debugged import ENDLESS, INPUTS, LEG, LOOP, STORES


@pytest.fixture(scope="module")
def model() -> DebugRtl:
    return DebugRtl("fast")


@contextmanager
def over_tcp(model: DebugRtl) -> Iterator[str]:
    """Address of a core without a host of its own."""
    server = Server(model, 0)
    going = threading.Event()

    def work() -> None:
        while not going.is_set():
            server.poll(1e-3)
            model.clock(200)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield f"tcp://localhost:{server.port}"
    finally:
        going.set()
        thread.join()
        server.close()


@pytest.fixture(params=["process", "serial", "tcp"])
def core(request, model) -> Iterator[BlockBackend]:
    with ExitStack() as stack:
        if request.param == "tcp":
            address = stack.enter_context(over_tcp(model))
            target = BlockBackend(lambda: connect(address), "core")
        elif request.param == "serial":
            target = BlockBackend(lambda: Client(model.serial_link(4)), "core")
        else:
            target = BlockBackend(lambda: connect(model), "core")
        stack.callback(target.close)
        yield target


class Debugger(debugged.Debugger):
    """Its answers leave out counts of cycles and bundles, and which output faulted."""

    def tell(self, line: str) -> str:
        try:
            text = super().tell(line)
        except CommandError as error:
            return f"error: {error}"
        text = re.sub(r", \d+ (cycles|bundles)$", "", text, flags=re.M)
        return re.sub("(written to an output, ).*", r"\1", text)  # the core knows which output


def both(path: Path, core: Backend) -> tuple[Debugger, Debugger]:
    return Debugger(path, core), Debugger(path)


STEPS = (
    *("break (28)", "run", "info values", "print q", "print e", "stepi", "print/x e", "step"),
    *("set e = 0.5", "continue", "print last", "info outputs", "tick 3", "info state", "start"),
    *("info registers", "next 2", "x/4f table", "tbreak *6", "continue", "p f", "finish"),
)


def test_session_as_on_the_model(core):
    ours, other = both(LEG, core)
    for line in STEPS:
        assert ours.tell(line) == other.tell(line), line


def test_loop_with_conditions(core):
    ours, other = both(LOOP, core)
    for line in ("break entry if i == 1", "run", "p i", "p total", "bt", "c", "info outputs"):
        assert ours.tell(line) == other.tell(line), line


def test_watch_of_a_value(core):
    ours, _ = both(LEG, core)
    ours.tell("watch e")
    assert "watch 1, e in" in ours.tell("run")
    assert ours.session.position > 4 and ours.tell("p e").startswith("e = 0.008")
    assert "end of tick 0" in ours.tell("continue")


def test_watch_of_data_words_as_on_the_model(core):
    ours, other = both(STORES, core)
    for line in ("watch table[1]", "watch table[2]", "run", "c", "c", "run", "p table[2]"):
        assert ours.tell(line) == other.tell(line), line
    assert (
        "watch 2, table[2] in d2: 0 -> 0.054"
        in (ours.tell("set table[2] = 0"), ours.tell("run"))[1]
    )


def test_fault_and_the_tick_behind_it(core):
    ours, _ = both(LEG, core)
    ours.tell("set z = 0.7")
    text = ours.tell("run")
    assert text.startswith("NOT_FINITE") and "leg.s:20: fsat F, f" in text
    assert "first computed: l_d = nan" in text
    ours.tell("set z = 0.2")
    ours.tell("reset")
    assert "end of tick 0" in ours.tell("run")


def test_halt_of_a_core_that_runs_and_cycles(core):
    ours, _ = both(ENDLESS, core)
    ours.session.pause.set()
    assert "halted at bundle" in ours.tell("run")
    ours.tell("kill")
    assert "core idle" in ours.tell("info state")


def test_reconnect_loads_again(core):
    ours, _ = both(LEG, core)
    ours.tell("start")
    assert "program loaded" in ours.tell("reconnect")
    assert "end of tick 0" in ours.tell("run")


@pytest.mark.parametrize("length", [50, pytest.param(300, marks=pytest.mark.full)])
@pytest.mark.parametrize("path", [LEG, LOOP], ids=["leg", "loop"])
def test_random_sessions_show_what_the_model_shows(core, path, length):
    rng = random.Random(SEED)
    ours, other = both(path, core)
    bundles = ours.session.program.bundles
    names = ours.session.program.map.names()
    names = [name for name in names if not name.startswith(("F", "sum"))]
    for _ in range(length):
        line = rng.choice(
            [
                "stepi",
                "step",
                "next",
                "continue",
                "run",
                "start",
                "finish",
                "delete",
                f"tbreak *{rng.randrange(bundles)}",
                f"stepi {rng.randrange(1, 4)}",
                f"set {rng.choice(names)} = {rng.choice((0.25, 1, -3))}",
                *(f"print {name}" for name in rng.sample(names, 3)),
            ]
        )
        assert ours.tell(line) == other.tell(line), f"SEED={SEED}: {line}"


PAIR = """
.program "pair"
.output  y, safe = 0.0
.output  z, safe = 0.0
        mov     y, 1.0
        mov     z, 2.0
        halt
"""


@contextmanager
def machine() -> Iterator[tuple[subprocess.Popen, str]]:
    """A process that starts the ticks of a core, and the core's address."""
    settings = [f"--set={name}={value}" for name, value in INPUTS.items()]
    command = [sys.executable, "-m", "sim.debug.server", str(LEG), "--port", "0", *settings]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            yield server, server.stdout.readline().split()[-1]
        finally:
            server.kill()  # nothing if it has ended


def test_machine_whose_host_starts_the_ticks(tmp_path):
    with machine() as (_, address):
        target = DrivenBackend(lambda: connect(address), "machine")
        debugger = Debugger(LEG, target)
        assert "bundle 0" in debugger.tell("start")
        debugger.tell("break (28)")
        assert "=> bundle 4" in debugger.tell("continue")
        assert debugger.tell("print t").startswith("t = 0.25  ")
        assert "host writes" in debugger.tell("print x")
        debugger.tell("delete")
        assert "end of tick 0" in debugger.tell("continue")
        assert "end of tick 3" in debugger.tell("tick 3")
        assert debugger.tell("print e").startswith("e = 0.008")
        target.close()
        again = connect(address)  # the machine runs again
        before = again.runs()
        again.wait(lambda state: again.runs() > before)
        again.close()
        pair = tmp_path / "pair.s"
        pair.write_text(PAIR)
        wrong = DrivenBackend(lambda: connect(address), "machine")
        with pytest.raises(AsipError, match="the core has another program than 'pair'"):
            Debugger(pair, wrong)
        wrong.close()


def test_server_that_goes_away_is_told():
    with machine() as (server, address):
        debugger = Debugger(LEG, DrivenBackend(lambda: connect(address), "machine"))
        debugger.tell("start")
        server.kill()
        server.wait(timeout=60)
        for command in ("stepi", "reconnect"):
            with pytest.raises(LinkError):
                debugger.tell(command)
