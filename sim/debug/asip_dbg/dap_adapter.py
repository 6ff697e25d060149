# SPDX-License-Identifier: Apache-2.0
"""Requests of a client of the Debug Adapter Protocol, carried out on a session.

Requests come in on one thread; what lets the core go runs on another, so that `pause` is heard.
"""

from __future__ import annotations

import argparse
import contextlib
import threading
from collections.abc import Callable
from typing import Any

from asip_asm.debug_map import DebugMapError
from asip_asm.diagnostics import AssemblyError
from asip_asm.image import ImageError
from sim.debug import guard
from sim.debug.asip_dbg.command_table import CommandError, Quit, find_command
from sim.debug.asip_dbg.commands import REFUSALS, Commands
from sim.debug.asip_dbg.completion import completions, last_word
from sim.debug.asip_dbg.dap_breakpoints import ClientBreakpoints
from sim.debug.asip_dbg.dap_fields import FieldError, check_request
from sim.debug.asip_dbg.dap_launch import launch_options
from sim.debug.asip_dbg.dap_messages import Message, Sender
from sim.debug.asip_dbg.dap_views import THREAD, Body, Views
from sim.debug.asip_dbg.expressions import is_name
from sim.debug.asip_dbg.options import open_session
from sim.debug.asip_dbg.program import ProgramError
from sim.debug.asip_dbg.session import Session, Stop
from sim.debug.asip_dbg.values import ValueMissing, format_word, text_of

CAPABILITIES = (
    *("ConfigurationDoneRequest", "RestartRequest", "TerminateRequest", "ExceptionInfoRequest"),
    *("LoadedSourcesRequest", "BreakpointLocationsRequest", "CompletionsRequest"),
    *("DisassembleRequest", "FunctionBreakpoints", "ConditionalBreakpoints", "DataBreakpoints"),
    *("InstructionBreakpoints", "EvaluateForHovers", "SetVariable", "SetExpression"),
    *("SteppingGranularity", "ValueFormattingOptions"),
    *("HitConditionalBreakpoints", "LogPoints"),
)
"""What is supported, as the protocol names it."""
REASONS = {
    "breakpoint": "breakpoint",
    "watch": "data breakpoint",
    "step": "step",
    "start": "entry",
    "interrupt": "pause",
    "end": "end of tick",
    "fault": "exception",
}
"""`reason` of a stopped event by the kind of a stop."""

ERRORS = (*REFUSALS, CommandError, ImageError, DebugMapError, ProgramError, OSError)
"""What a request can fail with; the text is for the user."""


class RequestError(Exception):
    """The request does not fit the state of the session."""


class Adapter:
    """One client. `ended` when it has disconnected."""

    def __init__(
        self, sender: Sender, options: argparse.Namespace, token: guard.Token | None = None
    ) -> None:
        """token: what a client must give to launch a program, None on a private stream."""
        self.sender = sender
        self.options = options
        self._token = token
        self.ended = False
        self._session: Session | None = None
        self._worker: threading.Thread | None = None
        self._busy = False
        self._quiet = False
        self._first: Callable[[], Stop] | None = None
        self._launched: Body = {}
        self._counted_from = (1, 1)  # lines, columns

    # ------------------------------------------------------------------ requests
    def handle(self, request: Message) -> None:
        """Answer one request."""
        command = request.get("command")
        method = getattr(self, f"do_{command}", None)
        arguments = request.get("arguments")
        if request.get("type") != "request" or method is None:
            self.sender.failure(request, f"no request '{str(command):.40}'")
            return
        try:
            given = arguments if isinstance(arguments, dict) else {}
            check_request(str(command), given)
            body = method(given)
        except AssemblyError as error:
            self.sender.failure(request, error.report())
        except (*ERRORS, RequestError, FieldError) as error:
            self.sender.failure(request, str(error))
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
            self.sender.failure(request, f"{command}: an argument is missing or wrong: {error!r}")
        else:
            self.sender.response(request, body)
            self._after(str(command))

    def _after(self, command: str) -> None:
        """What follows an answer."""
        if command in ("launch", "attach"):
            self.sender.event("initialized")
        elif command in ("configurationDone", "restart") and self._first is not None:
            self._go(self._first)

    @property
    def session(self) -> Session:
        """The session. Raises RequestError before `launch`."""
        if self._session is None:
            raise RequestError("no program: `launch` or `attach` comes first")
        return self._session

    def _halted(self) -> Session:
        """The session while the core is halted. Raises RequestError while it runs."""
        session = self.session
        if self._busy:
            raise RequestError("the core runs; pause it first")
        return session

    # ------------------------------------------------------------------ life
    def do_initialize(self, arguments: Body) -> Body:
        self._counted_from = (
            int(arguments.get("linesStartAt1", True)),
            int(arguments.get("columnsStartAt1", True)),
        )
        return {f"supports{name}": True for name in CAPABILITIES}

    def do_launch(self, arguments: Body) -> None:
        if self._session is not None:
            raise RequestError("a program is launched already; restart it, or disconnect")
        self._check_token(arguments)
        session = open_session(launch_options(arguments, self.options))
        self._session = session
        session.log = lambda text: self._output(text + "\n")
        self._launched = dict(arguments)
        self.views = Views(session, *self._counted_from)
        self.points = ClientBreakpoints(session, self.views)
        self._answer: list[str] | None = None  # takes what a command of the console writes
        self.commands = Commands(session, self._write)
        stop_on_entry = bool(arguments.get("stopOnEntry", False))
        self._first = session.start if stop_on_entry else session.run
        for file in session.program.changed_files():
            self._output(f"{file} was changed since the program was assembled\n", "important")

    def _check_token(self, arguments: Body) -> None:
        """Raises RequestError; a wrong guess ends the connection."""
        given = arguments.pop("token", None)
        if self._token is None and given is not None:
            raise RequestError('"token" is for a server on a port; leave it out')
        if self._token is not None and not guard.same_token(given, self._token.text):
            self.ended = True
            raise RequestError('launch and attach need the "token" that the server has printed')

    def do_attach(self, arguments: Body) -> None:
        if not isinstance(arguments.get("connect"), str):
            raise RequestError('attach needs "connect": "tcp://localhost:2331" or "serial:PATH"')
        self.do_launch(arguments)

    def do_configurationDone(self, arguments: Body) -> None:
        self._halted()

    def do_restart(self, arguments: Body) -> None:
        if arguments.get("arguments") not in (None, self._launched):
            raise RequestError("other arguments than at launch; disconnect, and launch again")
        self._pause_quietly()
        self._halted().reset()

    def do_disconnect(self, arguments: Body) -> None:
        self.close()
        self.ended = True

    def do_terminate(self, arguments: Body) -> None:
        self.close()
        self.sender.event("terminated")

    def close(self) -> None:
        """Stop the core and leave it."""
        if self._session is not None:
            self._pause_quietly()
            self._session.target.close()
            self._session = None

    # ------------------------------------------------------------------ running
    def _go(self, action: Callable[[], Stop]) -> None:
        """Let the core go on a thread of its own, and report when and why it stops."""
        session = self.session

        def work() -> None:
            try:
                stop = action()
            except Exception as error:
                self._busy = False
                if not isinstance(error, ERRORS):
                    guard.LOG.exception("an error while the core ran")
                with contextlib.suppress(OSError, ValueError):  # the client may have gone
                    self._output(f"{error}\n", "stderr")
                    self.sender.event("terminated")
                return
            self._busy = False  # before the client hears of it
            if not self._quiet:
                self._stopped(stop)

        session.pause.clear()
        self._quiet, self._busy = False, True
        self._worker = threading.Thread(target=work, daemon=True)
        self._worker.start()

    def _stopped(self, stop: Stop) -> None:
        body: Body = {
            "reason": REASONS[stop.kind],
            "description": stop.text.splitlines()[0],
            "threadId": THREAD,
            "allThreadsStopped": True,
        }
        if stop.kind == "fault":
            body["text"] = stop.text
            self._output(stop.text + "\n", "stderr")
        if stop.breakpoints:
            body["hitBreakpointIds"] = list(stop.breakpoints)
        self.sender.event("stopped", body)

    def _pause_quietly(self) -> bool:
        """Stop a core that runs without an event; whether it ran."""
        if not self._busy:
            return False
        self._quiet = True
        self.session.pause.set()
        assert self._worker is not None
        self._worker.join()
        return True

    def _output(self, text: str, category: str = "console") -> None:
        self.sender.event("output", {"category": category, "output": text})

    def do_continue(self, arguments: Body) -> Body:
        session = self._halted()
        self._go(session.resume if session.in_run else session.run)
        return {"allThreadsContinued": True}

    def do_next(self, arguments: Body) -> None:
        self._step(arguments, self._halted().step_calls)

    def do_stepIn(self, arguments: Body) -> None:
        self._step(arguments, self._halted().step_lines)

    def _step(self, arguments: Body, way: Callable[[], Stop]) -> None:
        single = arguments.get("granularity") == "instruction"
        self._go(self.session.step_bundles if single else way)

    def do_stepOut(self, arguments: Body) -> None:
        session = self._halted()
        self._go(session.finish if session.in_run else session.run)

    def do_pause(self, arguments: Body) -> None:
        if self._busy:
            self.session.pause.set()

    # ------------------------------------------------------------------ breakpoints
    def _change(self, change: Callable[[], list[Body]]) -> Body:
        """Change breakpoints, with the core halted for the moment if it runs."""
        session = self.session
        ran = self._pause_quietly()
        try:
            return {"breakpoints": change()}
        finally:
            if ran:
                self._resume(session)

    def _resume(self, session: Session) -> None:
        """Go on after a halt that nobody shall see."""
        last = session.last_stop
        if session.in_run and last is not None and last.kind == "interrupt":
            self._go(session.resume)
        elif last is not None:
            self._stopped(last)

    def do_setBreakpoints(self, arguments: Body) -> Body:
        path = str(arguments["source"]["path"])
        wanted = arguments.get("breakpoints")
        if wanted is None:
            wanted = [{"line": line} for line in arguments.get("lines") or []]
        modified = bool(arguments.get("sourceModified"))
        return self._change(lambda: self.points.lines(path, wanted, modified))

    def do_setFunctionBreakpoints(self, arguments: Body) -> Body:
        return self._change(lambda: self.points.functions(arguments["breakpoints"]))

    def do_setInstructionBreakpoints(self, arguments: Body) -> Body:
        return self._change(lambda: self.points.instructions(arguments["breakpoints"]))

    def do_setDataBreakpoints(self, arguments: Body) -> Body:
        return self._change(lambda: self.points.data(arguments["breakpoints"]))

    def do_dataBreakpointInfo(self, arguments: Body) -> Body:
        name = str(arguments["name"])
        program = self.session.program
        values = program.map.named(name)
        try:
            address = None if values else self.session.values.data_address(name)
        except ValueMissing as error:
            return {"dataId": None, "description": str(error)}
        stored = address is not None and bool(program.stores(address))
        if not stored and not any(value.writes for value in values):
            return {"dataId": None, "description": f"{name} is never written by the program"}
        return {"dataId": name, "description": name, "accessTypes": ["write"]}

    def do_setExceptionBreakpoints(self, arguments: Body) -> Body:
        return {"breakpoints": []}  # the core itself stops at every fault

    def do_breakpointLocations(self, arguments: Body) -> Body:
        program = self.session.program
        file = program.file_of(str(arguments["source"]["path"]))
        views = self.views
        first = views.own_line(int(arguments["line"]))
        last = views.own_line(int(arguments["endLine" if "endLine" in arguments else "line"]))
        if "column" in arguments and views.own_column(int(arguments["column"])) > 1:
            first += 1  # A location is at the first column of its line.
        lines = program.code_lines(file) if file else {}
        found = [n for n in sorted(lines) if first <= n <= last]
        return {"breakpoints": [{"line": views.line(n)} for n in found]}

    # ------------------------------------------------------------------ looking
    def do_threads(self, arguments: Body) -> Body:
        return {"threads": [{"id": THREAD, "name": "core"}]}

    def do_stackTrace(self, arguments: Body) -> Body:
        self._halted()
        frames = self.views.frames()
        first = int(arguments.get("startFrame", 0))
        count = int(arguments.get("levels", 0)) or len(frames)
        return {"stackFrames": frames[first : first + count], "totalFrames": len(frames)}

    def do_scopes(self, arguments: Body) -> Body:
        return {"scopes": self.views.scopes()} if self._halted() else {}

    def do_variables(self, arguments: Body) -> Body:
        self._halted()
        reference = int(arguments["variablesReference"])
        found = self.views.variables(reference, _form(arguments))
        if arguments.get("filter") == "indexed":
            found = []  # All variables have names.
        first = int(arguments.get("start") or 0)
        count = int(arguments.get("count") or 0) or len(found)
        return {"variables": found[first : first + count]}

    def do_setVariable(self, arguments: Body) -> Body:
        return self._set(str(arguments["name"]), arguments)

    def do_setExpression(self, arguments: Body) -> Body:
        return self._set(str(arguments["expression"]), arguments)

    def _set(self, name: str, arguments: Body) -> Body:
        reading = self._halted().set(name, str(arguments["value"]))
        value = format_word(reading.word, reading.type, _form(arguments))
        return {"value": value, "type": reading.type}

    def do_evaluate(self, arguments: Body) -> Body:
        session = self._halted()
        text = str(arguments["expression"]).strip()
        if arguments.get("context") == "repl":
            return self._command(text)
        form = _form(arguments)
        if is_name(text) or text in session.values.names():
            reading = session.values.read(text)
            value = text_of(reading, form)
            return {"result": value, "type": reading.type, "variablesReference": 0}
        result = session.evaluate(text)
        if isinstance(result, bool):
            shown = str(result).lower()
        elif form:
            kind = "int" if isinstance(result, int) else "float"
            shown = format_word(session.values.word(text, kind, result), kind, form)
        else:
            shown = f"{result:.9g}" if isinstance(result, float) else str(result)
        return {"result": shown, "variablesReference": 0}

    def _command(self, line: str) -> Body:
        """A line of the client's console: a command of asip-dbg."""
        word = line.split("/")[0].split()[:1]
        if word and find_command(word[0]).runs:

            def run() -> Stop:
                self.commands.execute(line)
                assert self.session.last_stop is not None
                return self.session.last_stop

            self._go(run)
            return {"result": "", "variablesReference": 0}
        lines: list[str] = []
        self._answer = lines
        try:
            self.commands.execute(line)
        except Quit:
            self.sender.event("terminated")
        finally:
            self._answer = None
        return {"result": "\n".join(lines), "variablesReference": 0}

    def _write(self, text: str) -> None:
        """A line that a command writes: a part of its answer, or output while the core goes on."""
        if self._answer is None:
            self._output(text + "\n")
        else:
            self._answer.append(text)

    def do_completions(self, arguments: Body) -> Body:
        rows = str(arguments["text"]).split("\n")
        row = self.views.own_line(int(arguments.get("line", self.views.line(1))))
        if not 1 <= row <= len(rows):
            raise RequestError(f"completions: the text has no line {row}")
        text = rows[row - 1][: self.views.own_column(int(arguments["column"])) - 1]
        length = len(last_word(text))
        place = {"start": len(text) - length, "length": length}
        words = completions(self.session, text)
        return {"targets": [{"label": word} | place for word in words[:200]]}

    def do_loadedSources(self, arguments: Body) -> Body:
        return {"sources": [self.views.source(file) for file in self.session.program.map.files]}

    def do_disassemble(self, arguments: Body) -> Body:
        first = int(str(arguments["memoryReference"]), 0) + int(arguments.get("offset", 0))
        first += int(arguments.get("instructionOffset", 0))
        count = min(int(arguments["instructionCount"]), 4096)
        return {"instructions": self.views.instructions(first, count)}

    def do_exceptionInfo(self, arguments: Body) -> Body:
        stop = self._halted().last_stop
        if stop is None or stop.kind != "fault":
            raise RequestError("the core is in no fault")
        cause = stop.text.split(":")[0]
        return {"exceptionId": cause, "description": stop.text, "breakMode": "always"}


def _form(arguments: dict[str, Any]) -> str:
    form = arguments.get("format")
    return "x" if isinstance(form, dict) and form.get("hex") else ""
