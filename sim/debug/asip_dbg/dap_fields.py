# SPDX-License-Identifier: Apache-2.0
"""Fields of the requests of the Debug Adapter Protocol: which this adapter obeys.

A field that is not listed is refused by name as soon as it asks for something: a client that sends
it relies on it. `tests/debugger/test_dap_fields.py` holds the list against the protocol's schema.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_SOURCE = {"name", "path", "presentationHint", "origin", "sources", "adapterData", "checksums"}
"""Of a source, `path` finds it; the others describe it. There are no sources by reference."""

OBEYED: dict[str, set[str]] = {
    # What a client says of itself asks for nothing; `supports...` is accepted as well.
    "initialize": {
        *("linesStartAt1", "columnsStartAt1", "pathFormat"),
        *("adapterID", "clientID", "clientName", "locale"),
    },
    "configurationDone": set(),
    "restart": {"arguments"},
    "disconnect": {"restart", "terminateDebuggee"},
    "terminate": {"restart"},
    "threads": set(),
    "loadedSources": set(),
    "continue": {"threadId", "singleThread"},
    "next": {"threadId", "singleThread", "granularity"},
    "stepIn": {"threadId", "singleThread", "granularity"},
    "stepOut": {"threadId", "singleThread", "granularity"},
    "pause": {"threadId"},
    "exceptionInfo": {"threadId"},
    "setBreakpoints": {"source", "breakpoints", "lines", "sourceModified"},
    "setFunctionBreakpoints": {"breakpoints"},
    "setInstructionBreakpoints": {"breakpoints"},
    "setDataBreakpoints": {"breakpoints"},
    "setExceptionBreakpoints": {"filters"},
    "dataBreakpointInfo": {"variablesReference", "name", "frameId"},
    "breakpointLocations": {"source", "line", "column", "endLine", "endColumn"},
    "stackTrace": {"threadId", "startFrame", "levels"},
    "scopes": {"frameId"},
    "variables": {"variablesReference", "filter", "start", "count", "format"},
    "setVariable": {"variablesReference", "name", "value", "format"},
    "setExpression": {"expression", "value", "frameId", "format"},
    "evaluate": {"expression", "frameId", "context", "format"},
    "completions": {"frameId", "text", "column", "line"},
    "disassemble": {
        *("memoryReference", "offset", "instructionOffset", "instructionCount", "resolveSymbols"),
    },
    # Parts of requests.
    "source": _SOURCE,
    "format": {"hex"},
    "line breakpoint": {"line", "condition", "hitCondition", "logMessage"},
    "function breakpoint": {"name", "condition", "hitCondition"},
    "instruction breakpoint": {"instructionReference", "offset", "condition", "hitCondition"},
    "data breakpoint": {"dataId", "accessType", "condition", "hitCondition"},
}
CHECKED_ELSEWHERE = ("launch", "attach")  # by sim/debug/asip_dbg/dap_launch.py
PARTS = ("source", "format")


class FieldError(Exception):
    """A request asks for something that the adapter does not do; the message names the field."""


def refuse_others(what: str, fields: Mapping[str, Any]) -> None:
    """Refuse fields of a request, or of a part of one, that are not obeyed. Raises FieldError."""
    for name, value in fields.items():
        asks = value not in (None, False, "", [], {})
        supported = what == "initialize" and name.startswith("supports")
        if asks and name not in OBEYED[what] and not supported:
            known = ", ".join(sorted(OBEYED[what])) or "none"
            raise FieldError(f"{what}: '{name:.40}' is not supported; supported are {known}")
        if name in PARTS and name in OBEYED[what] and isinstance(value, Mapping):
            refuse_others(name, value)


def check_request(command: str, arguments: Mapping[str, Any]) -> None:
    """Refuse what the adapter does not obey. Raises FieldError, KeyError for unknown requests."""
    if command in CHECKED_ELSEWHERE:
        return
    refuse_others(command, arguments)
    for name, allowed in (
        ("threadId", (1,)),
        ("granularity", ("statement", "line", "instruction")),
        ("pathFormat", ("path",)),
        ("filter", ("indexed", "named")),
        ("context", ("watch", "repl", "hover", "clipboard", "variables")),
    ):
        if arguments.get(name) not in (None, *allowed):
            values = ", ".join(str(value) for value in allowed)
            raise FieldError(f"{command}: {name} {arguments[name]!r:.40} is none of {values}")
    if command == "disconnect" and arguments.get("terminateDebuggee") is False:
        raise FieldError("disconnect: 'terminateDebuggee' false is not supported; the core stops")
    if command == "setExceptionBreakpoints" and arguments.get("filters"):
        raise FieldError("setExceptionBreakpoints: there are no filters; every fault stops")
