# SPDX-License-Identifier: Apache-2.0
"""Campaigns of the debugger: mutated scripts, command lines, and messages of its DAP server."""

from __future__ import annotations

import argparse
import io
import json
from pathlib import Path
from random import Random

from sim.debug.asip_dbg import __main__ as asip_dbg
from sim.debug.asip_dbg.dap_server import serve_client
from tests.fuzz.asip import FILES, files, images
from tests.fuzz.engine import Campaign
from tests.fuzz.mutate import command_lines, mutated_json, mutated_text

PROGRAMS = Path(__file__).parents[1] / "debugger"
SCRIPT = """\
break (28)
tbreak e if t > 0.2
watch f@2
display/x q
run
print 2*q - abs(t) + sqrt(z)
print/x $a3
x/4f table
set q = 0.5 + 1e3
set x = 0f3f800000
info registers a0 c1
info values f
list 14
disassemble 2 9
stepi 3
next
condition
continue
finish
tick 3
info line (30)
delete 1
disable 2
enable 2
undisplay 1
kill
reset
source s.dbg
assert 1 < 2
echo done
help x
quit 4
"""
WORDS = "break run print x set info list stepi tick source / ( ) * if @ [ ] $ = e t f q (28) 1e999"


def request(command: str, **arguments: object) -> dict[str, object]:
    """Command and arguments of a message to the server."""
    return {"command": command} | ({"arguments": arguments} if arguments else {})


REQUESTS = [
    request("initialize", adapterID="asip"),
    request("launch", program="x.s", iss=True, set={"x": 0.3}),
    request("setBreakpoints", source={"path": "x.s"}, breakpoints=[{"line": 16}]),
    request("setFunctionBreakpoints", breakpoints=[{"name": "(28)"}]),
    request("configurationDone"),
    request("stackTrace", threadId=1),
    request("scopes", frameId=1),
    request("variables", variablesReference=1),
    request("evaluate", expression="2*t", context="watch"),
    request("evaluate", expression="stepi 2", context="repl"),
    request("setVariable", variablesReference=1, name="t", value="1"),
    request("next", threadId=1),
    request("pause", threadId=1),
    request("disassemble", memoryReference="0x1", instructionCount=9),
    request("completions", text="pr", column=3),
    request("restart"),
    request("continue", threadId=1),
    request("disconnect"),
]


def _program(rng: Random) -> None:
    name = rng.choice(("leg.s", "loop.s"))
    Path("x.s").write_text((PROGRAMS / name).read_text(encoding="utf-8"))


def script(rng: Random) -> int | None:
    """A mutated script on a good program."""
    _program(rng)
    lines = SCRIPT.splitlines()
    chosen = [rng.choice(lines) for _ in range(rng.randrange(1, 20))]
    text = mutated_text(rng, "\n".join(chosen), WORDS.split())
    Path("s.dbg").write_text(text, encoding="utf-8", errors="surrogatepass")
    arguments = ["x.s", "--iss", "--batch"]
    for line in text.splitlines()[:8]:  # one by one too, so that an error does not end it
        arguments += ["-ex", f" {line}"]
    status = asip_dbg.main([*arguments, "-x", "s.dbg"])
    return min(status, 9)  # `quit N` may end with any status


def messages(rng: Random) -> int | None:
    """A session of mutated messages."""
    _program(rng)
    stream = io.BytesIO()
    for number, body in enumerate(REQUESTS, 1):
        message: object = {"seq": number, "type": "request"} | body
        if rng.random() < 0.3:
            message = mutated_json(rng, message)
        data = json.dumps(message).encode()
        length = len(data) if rng.random() < 0.98 else rng.randrange(len(data) * 2)
        stream.write(b"Content-Length: %d\r\n\r\n" % length + data)
    stream.seek(0)
    options = argparse.Namespace(program=None, iss=True)
    return serve_client(stream, io.BytesIO(), options)


LINES = ("x.s --iss --batch -ex run", "x.json --iss --batch", "x.s --iss --inputs in.csv -x empty")
OPTIONS = "--iss --batch -x -ex run --set x=1 --state --inputs --config small -O0 print =1 quit"

CAMPAIGNS = (
    Campaign("asip-dbg-script", 5_000, script),
    Campaign("asip-dbg-dap", 5_000, messages),
    command_lines("asip-dbg", asip_dbg.main, LINES, f"{OPTIONS} {FILES}", files, images),
)
