# SPDX-License-Identifier: Apache-2.0
"""Goals of the workbench for the debugger: its start, and sessions of the DAP server."""

from __future__ import annotations

import resource
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from sim.debug.model import DebugRtl
from sim.report.goals import Goal, at_most, exactly
from tests.debugger.dap_client import DapClient, dap_session
from tests.debugger.debugged import INPUTS, LEG
from tests.debugger.terminal import PROMPT, Terminal

START_SECONDS = 2.0


def rows(full: bool) -> Iterator[Goal]:
    """Both rows; the models are built before anything is timed."""
    DebugRtl("fast").close()
    before = processor_time()
    starts = [start_time() for _ in range(15 if full else 5)]
    work = (processor_time() - before) / len(starts)
    yield at_most(
        "asip-dbg: start to first prompt, Verilated core",
        statistics.median(starts),
        START_SECONDS,
        "s",
        f"median of {len(starts)}, longest {max(starts):.2f} s",
    )
    name = "asip-dbg: processor time from its start to its end"
    yield at_most(name, work, START_SECONDS, "s", "what a busy machine does not lengthen")
    messages, kinds, refused = 0, set(), []
    for core in ({}, {"uart": True}, {"iss": True}):
        client = session(core, 40 if full else 8)
        messages += client.sequence + client.received
        kinds |= client.seen
        refused += client.refused
    yield exactly(
        "DAP: messages that the protocol's schema refuses",
        len(refused),
        0,
        "",
        f"{messages} messages of {len(kinds)} kinds, on three cores"
        + "".join(f"; {text}" for text in refused[:1]),
    )


def processor_time() -> float:
    """Seconds of processor time of all processes waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def start_time() -> float:
    """Seconds from the command to its prompt, on a terminal."""
    with tempfile.TemporaryDirectory() as home:
        begun = time.monotonic()
        with Terminal(Path(home), str(LEG)) as terminal:
            terminal.wait_for(PROMPT)
            seconds = time.monotonic() - begun
            terminal.type("\x04")
            terminal.close()
    return seconds


def session(core: dict[str, bool], steps: int) -> DapClient:
    """A session of every kind of request."""
    with dap_session(lenient=True) as client:
        client.launch(LEG, set=INPUTS, stopOnEntry=True, **core)
        source = {"path": str(LEG)}
        client.ask("setBreakpoints", source=source, breakpoints=[{"line": 16}])
        client.ask("setFunctionBreakpoints", breakpoints=[{"name": "(29)"}])
        client.go("configurationDone")
        for step in range(steps):
            client.go(("continue", "next", "stepIn", "stepOut")[step % 4], threadId=1)
            client.ask("threads")
            client.ask("stackTrace", threadId=1)
            for scope in client.ask("scopes", frameId=1)["scopes"]:
                if not scope["expensive"]:
                    client.ask("variables", variablesReference=scope["variablesReference"])
            client.ask("evaluate", expression="2*x", context="watch")
        client.ask("setVariable", variablesReference=2, name="z", value="0.7")
        client.ask("disassemble", memoryReference="0x0", instructionCount=8)
        client.ask("setBreakpoints", source=source, breakpoints=[])
        client.ask("setFunctionBreakpoints", breakpoints=[])
        client.go("restart")
        assert client.go("continue", threadId=1)["reason"] == "exception"
        client.ask("exceptionInfo", threadId=1)
        client.ask("disconnect")
    return client
