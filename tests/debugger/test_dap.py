# SPDX-License-Identifier: Apache-2.0
"""The server of the Debug Adapter Protocol: sessions, every message held against the schema."""

from __future__ import annotations

import re
import socket
from collections.abc import Iterator
from pathlib import Path

import jsonschema
import pytest

from sim.debug import guard
from sim.debug.asip_dbg.dap_launch import launch_options
from sim.debug.asip_dbg.options import parse_arguments
from sim.debug.asip_run.inputs import UserError
from tests.debugger.dap_client import DapClient, dap_session, start_server, validate
from tests.debugger.debugged import ENDLESS, INPUTS, LEG, LOOP


@pytest.fixture
def client() -> Iterator[DapClient]:
    with dap_session() as client:
        yield client


def launch(client: DapClient, program: Path = LEG, **arguments) -> None:
    client.launch(program, **({"iss": True, "set": INPUTS} | arguments))


def variables(client: DapClient, scope: str) -> dict[str, str]:
    scopes = client.ask("scopes", frameId=1)["scopes"]
    reference = next(s["variablesReference"] for s in scopes if s["name"] == scope)
    found = client.ask("variables", variablesReference=reference)["variables"]
    return {variable["name"]: variable["value"] for variable in found}


def test_session_from_launch_to_disconnect(client):
    launch(client)
    source = {"path": str(LEG)}
    locations = client.ask("breakpointLocations", source=source, line=10, endLine=20)
    assert [item["line"] for item in locations["breakpoints"]] == list(range(11, 21))
    points = client.ask("setBreakpoints", source=source, breakpoints=[{"line": 16}, {"line": 99}])
    assert [point["verified"] for point in points["breakpoints"]] == [True, False]
    client.ask("setExceptionBreakpoints", filters=[])
    stopped = client.go("configurationDone")
    assert stopped["reason"] == "breakpoint" and len(stopped["hitBreakpointIds"]) == 1
    assert client.ask("threads")["threads"] == [{"id": 1, "name": "core"}]
    frame = client.ask("stackTrace", threadId=1)["stackFrames"][0]
    assert frame["line"] == 16 and frame["source"]["path"] == str(LEG)
    assert frame["name"] == "bundle 4 (28)"
    values = variables(client, "Values")
    assert values["t"] == "0.25" and values["e"].startswith("<not yet computed at bundle 4")
    assert variables(client, "Inputs")["x"] == "0.3"
    assert variables(client, "States") == {"last": "0"}
    assert variables(client, "Constants")["K"] == "400"
    assert variables(client, "Outputs") == {"F": "0"}
    assert len(variables(client, "Registers")) == 192
    assert client.ask("evaluate", expression="2*t", context="watch")["result"] == "0.5"
    assert client.ask("evaluate", expression="t", format={"hex": True})["result"] == "0x3e800000"
    assert client.go("next", threadId=1)["reason"] == "step"
    assert client.ask("setVariable", variablesReference=1, name="e", value="0.5")["value"] == "0.5"
    client.go("stepIn", threadId=1, granularity="instruction")
    assert client.ask("evaluate", expression="de", context="hover")["result"] == "0.5"
    assert client.go("stepOut", threadId=1)["reason"] == "end of tick"
    assert variables(client, "Outputs") == {"F": "100"}
    assert client.ask("stackTrace", threadId=1)["stackFrames"][0]["name"] == "end of the tick"
    client.ask("disconnect")


def test_other_breakpoints_restart_and_console(client):
    launch(client, stopOnEntry=True)
    points = client.ask("setFunctionBreakpoints", breakpoints=[{"name": "(29)"}, {"name": "(99)"}])
    assert [point["verified"] for point in points["breakpoints"]] == [True, False]
    assert client.go("configurationDone")["reason"] == "entry"
    info = client.ask("dataBreakpointInfo", name="e")
    for name in ("R", "table[1]", "table[9]"):  # never written, or no word of the table
        assert client.ask("dataBreakpointInfo", name=name)["dataId"] is None
    client.ask("setDataBreakpoints", breakpoints=[{"dataId": info["dataId"]}])
    assert client.go("continue", threadId=1)["reason"] in ("data breakpoint", "breakpoint")
    client.ask("setDataBreakpoints", breakpoints=[])
    code = client.ask(
        "disassemble", memoryReference="0x4", instructionOffset=-5, instructionCount=12
    )
    rows = code["instructions"]
    assert len(rows) == 12 and rows[5]["instruction"].startswith("{ fsub")
    assert rows[0]["instruction"] == "outside the program"
    client.ask("setInstructionBreakpoints", breakpoints=[{"instructionReference": "0x2"}])
    assert client.go("restart")["reason"] == "entry"
    client.go("continue", threadId=1)
    assert client.ask("stackTrace", threadId=1)["stackFrames"][0]["name"] == "bundle 2 (7)"
    assert "t@1 = 0.09" in client.ask("evaluate", expression="p t@1", context="repl")["result"]
    client.ask("evaluate", expression="tick 2", context="repl")
    client.event("stopped")
    targets = client.ask("completions", text="print l_", column=9)["targets"]
    assert targets == [{"label": "l_d", "start": 6, "length": 2}]
    assert client.ask("loadedSources")["sources"][0]["path"] == str(LEG)
    client.ask("setExpression", expression="x", value="0.5")
    client.ask("terminate")
    client.event("terminated")


def test_fault_is_an_exception_with_its_place(client):
    launch(client, set=INPUTS | {"z": 0.7})
    stopped = client.go("configurationDone")
    assert stopped["reason"] == "exception" and "NOT_FINITE" in stopped["text"]
    assert client.ask("exceptionInfo", threadId=1)["exceptionId"] == "NOT_FINITE"
    client.ask("disconnect")


def test_frames_of_macro_calls(client):
    launch(client, LOOP, set={"scale": 2.0})
    client.ask("setBreakpoints", source={"path": str(LOOP)}, breakpoints=[{"line": 11}])
    client.go("configurationDone")
    frames = client.ask("stackTrace", threadId=1)["stackFrames"]
    assert [(f["name"], f["line"]) for f in frames[1:]] == [("macro add_entry", 18)]
    assert client.ask("stackTrace", threadId=1, startFrame=1, levels=1)["totalFrames"] == 2
    client.ask("disconnect")


def test_pause_and_breakpoints_while_it_runs(client):
    launch(client, ENDLESS, set={})
    client.ask("configurationDone")
    refused = client.request("stackTrace", threadId=1)
    assert not refused["success"] and "pause it first" in refused["message"]
    client.ask("pause", threadId=1)
    assert client.event("stopped")["reason"] == "pause"
    client.ask("continue", threadId=1)
    client.ask("setBreakpoints", source={"path": str(ENDLESS)}, breakpoints=[{"line": 8}])
    assert client.event("stopped")["reason"] == "breakpoint"
    client.ask("disconnect")


def test_requests_that_cannot_be_done(client):
    early = client.request("stackTrace", threadId=1)
    assert not early["success"] and "launch" in early["message"]
    client.ask("initialize", adapterID="asip")
    for arguments, message in [
        ({"program": "none.s"}, "none.s"),
        ({"program": str(LEG), "iss": True, "sett": {}}, "no argument 'sett'"),
        ({"program": str(LEG), "iss": True, "set": {"w": 1}}, "no input 'w'"),
        ({"program": str(LEG), "iss": True, "configuration": "big"}, "invalid choice"),
        ({"noDebug": False}, "program"),
        ({"program": "--help"}, "--help"),
        ({"program": str(LEG), "connect": "--help"}, "no such link"),
        ({"program": str(LEG), "token": "x"}, "for a server on a port"),
    ]:
        answer = client.request("launch", **arguments)
        assert not answer["success"] and message in answer["message"], answer
    assert not client.request("attach", program=str(LEG))["success"]
    launch(client)
    assert not client.request("variables", variablesReference=99)["success"]
    assert not client.request("evaluate", expression="1 +")["success"]
    assert not client.request("setVariable", variablesReference=1, name="K", value="1")["success"]
    client.send(b'{"seq": 900, "type": "request", "command": "zork"}')
    assert client._next()["message"] == "no request 'zork'"
    for rest in (b"", b', "arguments": {}', b', "arguments": {"variablesReference": 1e999}'):
        client.send(b'{"seq": 901, "type": "request", "command": "variables"%s}' % rest)
        assert "argument is missing" in client._next()["message"]
    client.ask("disconnect")


def test_stream_that_is_no_protocol():
    for data, message in [
        (b"hello\r\n\r\n", "a header field that is not"),
        (b"Content-Type: x\r\n\r\n", "without Content-Length"),
        (b"Content-Length: 2\r\nContent-Length: 2\r\n\r\n{}", "Content-Length, once"),
        (b"Content-Length: 2\r\nOrigin: http://evil.example\r\n\r\n{}", "a header field"),
        (b"POST / HTTP/1.1\r\nContent-Length: 2\r\n\r\n{}", "a request of HTTP"),
        (b"Content-Length: 99999999999\r\n\r\n", "Content-Length"),
        (b"Content-Length: 4\r\n\r\nzork", "no JSON"),
        (b"Content-Length: 2\r\n\r\n[]", "no JSON object"),
    ]:
        with start_server("--dap") as server:
            _, errors = server.communicate(data, timeout=60)
        assert server.returncode == 1 and message in errors.decode()


def test_tcp_serves_one_client_after_another():
    with start_server("--dap", "--port", "0", str(LEG), "--iss") as server:
        line = server.stderr.readline().decode()
        port = int(re.search(r"127\.0\.0\.1:(\d+)", line).group(1))
        for _ in range(2):
            with socket.create_connection(("127.0.0.1", port)) as connection:
                client = DapClient(connection.makefile("rb"), connection.makefile("wb"))
                client.ask("initialize", adapterID="asip")
                client.ask("launch", set=INPUTS, token=guard.token_of("127.0.0.1", port))
                client.event("initialized")
                assert client.go("configurationDone")["reason"] == "end of tick"
                client.ask("disconnect")


def test_the_schema_refuses_what_is_wrong():
    good = {"seq": 1, "type": "event", "event": "stopped", "body": {"reason": "step"}}
    validate(good)
    with pytest.raises(jsonschema.ValidationError):
        validate(good | {"body": {}})


@pytest.mark.parametrize("name", ["iss", "uart", "load", "optimise", "stopOnEntry"])
def test_switch_in_quotes_is_refused_by_name(name):
    arguments = {"program": str(LEG), name: "false"}
    with pytest.raises(UserError, match=f'"{name}" is true or false, without quotes'):
        launch_options(arguments, parse_arguments(["--dap"]))
