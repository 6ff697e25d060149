# SPDX-License-Identifier: Apache-2.0
"""Each field of the protocol's requests is obeyed, or refused by its name."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator

import pytest

from asip_asm.project import ROOT
from sim.debug.asip_dbg.dap_adapter import CAPABILITIES
from sim.debug.asip_dbg.dap_fields import CHECKED_ELSEWHERE, OBEYED
from tests.debugger.dap_client import DapClient, dap_session, schema
from tests.debugger.debugged import INPUTS, LEG

ADAPTER = (ROOT / "sim/debug/asip_dbg/dap_adapter.py").read_text()
REQUESTS = [name for name in re.findall(r"def do_(\w+)", ADAPTER) if name not in CHECKED_ELSEWHERE]
PARTS = {
    "source": "Source",
    "format": "ValueFormat",
    "line breakpoint": "SourceBreakpoint",
    "function breakpoint": "FunctionBreakpoint",
    "instruction breakpoint": "InstructionBreakpoint",
    "data breakpoint": "DataBreakpoint",
}
SAMPLES = {"integer": 1, "boolean": True, "string": "x", "array": ["x"], "object": {"x": 1}}


def fields(definition: str) -> dict[str, object]:
    """A value that asks for something, by field of a definition of the schema."""
    found = schema()["definitions"].get(definition, {})
    for part in found.get("allOf", [found]):
        if "$ref" in part:
            continue
        found = part
    samples = {}
    for name, about in found.get("properties", {}).items():
        kind = about.get("type", "object")
        samples[name] = SAMPLES[kind if isinstance(kind, str) else kind[0]]
    return samples


@pytest.fixture(scope="module")
def client() -> Iterator[DapClient]:
    """A client of a program that is before its first bundle."""
    with dap_session() as client:
        client.launch(LEG, iss=True, set=INPUTS, stopOnEntry=True)
        client.go("configurationDone")
        yield client


def others(what: str, definition: str) -> list[tuple[str, object]]:
    return [item for item in fields(definition).items() if item[0] not in OBEYED[what]]


@pytest.mark.parametrize("command", REQUESTS)
def test_request__its_other_fields_are_refused_by_name(client, command):
    definition = f"{command[0].upper()}{command[1:]}Arguments"
    for name, value in others(command, definition):
        if command == "initialize" and name.startswith("supports"):
            continue  # A client says what it can do itself.
        client.sequence += 1
        message = {"seq": client.sequence, "type": "request", "command": command}
        answer = client.exchange(message | {"arguments": {name: value}})
        assert not answer["success"] and f"'{name}' is not supported" in answer["message"]


def test_list__has_every_request_and_no_field_that_the_schema_lacks():
    assert set(OBEYED) == {*REQUESTS, *PARTS}
    for command in REQUESTS:
        known = fields(f"{command[0].upper()}{command[1:]}Arguments")
        if command == "initialize":
            known = fields("InitializeRequestArguments")
        assert OBEYED[command] <= set(known), command
    for part, definition in PARTS.items():
        assert OBEYED[part] <= set(fields(definition)), part


def point(client: DapClient, command: str, item: dict, **more) -> dict:
    (found,) = client.ask(command, breakpoints=[item], **more)["breakpoints"]
    return found


def test_breakpoint__a_field_that_is_not_obeyed_makes_it_unverified(client):
    source = {"path": str(LEG)}
    found = point(client, "setBreakpoints", {"line": 16, "column": 3}, source=source)
    assert not found["verified"] and "'column' is not supported" in found["message"]
    found = point(client, "setDataBreakpoints", {"dataId": "F", "accessType": "read"})
    assert not found["verified"] and "accessType 'read' is not supported" in found["message"]
    found = point(client, "setBreakpoints", {"line": 16}, source=source, sourceModified=True)
    assert not found["verified"] and "newer than the program" in found["message"]
    client.ask("setDataBreakpoints", breakpoints=[])


@pytest.mark.parametrize(
    ("field", "text", "reason"),
    [
        ("condition", "e > 0 and", "is not an expression"),
        ("condition", "e > nothing", "no value 'nothing'"),
        ("condition", "table[4] > 0", "table has 4 words, 0 to 3"),
        ("condition", "e[0]", "no value 'e[0]'"),
        ("hitCondition", "often", "is not a hit condition"),
        ("hitCondition", "% 0", "is not a hit condition"),
        ("logMessage", "e is {e", "a brace without its partner"),
        ("logMessage", "e is {e +}", "is not an expression"),
        ("logMessage", "{nothing}", "no value 'nothing'"),
    ],
)
def test_condition__is_parsed_where_it_is_given(client, field, text, reason):
    item = {"line": 16, field: text}
    found = point(client, "setBreakpoints", item, source={"path": str(LEG)})
    assert not found["verified"] and reason in found["message"]


@pytest.mark.parametrize("first", [0, 1])
def test_lines_and_columns__are_counted_as_the_client_counts(first):
    with dap_session() as client:
        start = bool(first)
        client.ask("initialize", adapterID="x", linesStartAt1=start, columnsStartAt1=start)
        client.ask("launch", program=str(LEG), iss=True, set=INPUTS)
        client.event("initialized")
        line = 15 + first
        found = point(client, "setBreakpoints", {"line": line}, source={"path": str(LEG)})
        assert found["verified"] and found["line"] == line and "leg.s:16" in found["message"]
        client.go("configurationDone")
        frame = client.ask("stackTrace", threadId=1)["stackFrames"][0]
        assert (frame["line"], frame["column"]) == (line, first)
        places = client.ask("breakpointLocations", source={"path": str(LEG)}, line=line)
        assert places["breakpoints"] == [{"line": line}]
        (row,) = client.ask("disassemble", memoryReference="0x4", instructionCount=1)[
            "instructions"
        ]
        assert row["line"] == line
        words = client.ask("completions", text="help\nprint l_", line=1 + first, column=8 + first)
        assert [target["label"] for target in words["targets"]] == ["l_d"]


def test_values__shown_as_hex_read_back(client):
    scopes = client.ask("scopes", frameId=1)["scopes"]
    reference = next(s["variablesReference"] for s in scopes if s["name"] == "Inputs")
    hexadecimal = {"hex": True}
    before = client.ask("variables", variablesReference=reference)["variables"]
    shown = client.ask("variables", variablesReference=reference, format=hexadecimal)["variables"]
    for variable, plain in zip(shown, before, strict=True):
        text = variable["value"]
        (wanted,) = struct.unpack(">I", struct.pack(">f", float(plain["value"])))
        assert text == f"0x{wanted:08x}"
        answer = client.ask(
            "setVariable", variablesReference=reference, name=variable["name"], value=text,
            format=hexadecimal,
        )  # fmt: skip
        assert answer["value"] == text
    assert client.ask("variables", variablesReference=reference)["variables"] == before
    piece = client.ask("variables", variablesReference=reference, start=1, count=2)["variables"]
    assert piece == before[1:3]


def test_table_elements__in_watch_and_hover(client):
    for context in ("watch", "hover"):
        found = client.ask("evaluate", expression="table[3]", context=context)
        assert found["result"] == "8"
    assert client.ask("evaluate", expression="2*table[1] + 1")["result"] == "5"
    answer = client.request("evaluate", expression="table[9]")
    assert not answer["success"] and "table has 4 words, 0 to 3" in answer["message"]


def test_hit_conditions_and_log_points():
    assert {"HitConditionalBreakpoints", "LogPoints"} <= set(CAPABILITIES)
    with dap_session() as client:
        client.launch(LEG, iss=True, set=INPUTS)
        source = {"path": str(LEG)}
        points = [
            {"line": 16, "hitCondition": "3"},
            {"line": 17, "logMessage": "e is {e}, twice {2*e > 0}"},
        ]
        found = client.ask("setBreakpoints", source=source, breakpoints=points)["breakpoints"]
        assert [item["verified"] for item in found] == [True, True]
        reasons = [client.go("configurationDone")["reason"]]
        for _ in range(3):
            reasons.append(client.go("continue", threadId=1)["reason"])
        assert reasons == ["end of tick", "end of tick", "breakpoint", "end of tick"]
        assert len(client.output) == 3
        assert all(re.fullmatch(r"e is 0\.00825\d+, twice true\n", t) for t in client.output)


@pytest.mark.parametrize(
    ("command", "arguments", "reason"),
    [
        ("continue", {"threadId": 7}, "threadId 7"),
        ("next", {"threadId": 1, "granularity": "module"}, "granularity 'module'"),
        ("disconnect", {"terminateDebuggee": False}, "the core stops"),
        ("restart", {"arguments": {"program": "other.s"}}, "launch again"),
        ("setExceptionBreakpoints", {"filters": ["all"]}, "every fault stops"),
        ("initialize", {"adapterID": "x", "pathFormat": "uri"}, "pathFormat 'uri'"),
    ],
)
def test_value__that_asks_for_something_else_is_refused(client, command, arguments, reason):
    client.sequence += 1
    message = {"seq": client.sequence, "type": "request", "command": command}
    answer = client.exchange(message | {"arguments": arguments})
    assert not answer["success"] and reason in answer["message"]
