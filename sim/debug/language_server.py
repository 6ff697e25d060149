# SPDX-License-Identifier: Apache-2.0
"""`microtick lsp`: assembly in an editor, with its errors and the cycles of each line.

Speaks the Language Server Protocol on standard input and output, by the package pygls. For a file
as it was saved last, the editor gets

- the errors and warnings of the assembler, at their characters, with the help of each;
- above each line with operations the cycles in which these issue, and above the first line the
  cycles of the whole program;
- for a mnemonic under the pointer what it does, its latency and its unit.

The issue cycle is that of a run in which no branch is taken and loops have one round, as in the
listing of `microtick asm`. While the text differs from the saved one, no cycles are shown.
"""

from __future__ import annotations

import re
import sys
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException, JsonRpcInternalError, PyglsError
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path

from asip_asm.assemble import build_program, encode
from asip_asm.command import command, command_parser
from asip_asm.diagnostics import AssemblyError, Diagnostic, counted
from asip_asm.disassemble import decode_bundle
from asip_asm.image import Image
from asip_asm.isa import OperationRecord, default_isa
from asip_asm.machine import load_machine

NAME = "microtick"
WORD = re.compile(r"[A-Za-z_]\w*")
RANGES_SHOWN = 4
"""Runs of cycles that a line shows, such as 3-5; a macro called often has many."""


@dataclass
class Checked:
    """What the assembler says of a file.

    problems: by absolute path, for the file itself and for those that it includes; cycles: line of
    the file, from 1, to the cycles in which operations of it issue, rising; summary: of the whole
    program, empty where it has errors.
    """

    problems: dict[Path, list[lsp.Diagnostic]] = field(default_factory=dict)
    cycles: dict[int, list[int]] = field(default_factory=dict)
    summary: str = ""


def check(path: Path, configuration: str | None = None, optimise: bool = True) -> Checked:
    """Assemble a file. Raises OSError if it cannot be read."""
    try:
        program, machine = build_program(path, configuration=configuration, optimise=optimise)
        image = encode(program, machine, path)
    except AssemblyError as error:
        return Checked(_by_file(error.diagnostics, path))
    found = Checked(_by_file(program.warnings, path), issue_cycles(image, path))
    length = counted(image.cycles, "cycle") if image.cycles is not None else "with branches"
    bundles = counted(len(image.bundles), "bundle")
    found.summary = f"{length}, {bundles} on {image.configuration}"
    return found


def issue_cycles(image: Image, path: Path) -> dict[int, list[int]]:
    """Line of the file, from 1, to the cycles in which operations of it issue."""
    isa, machine = default_isa(), load_machine(image.configuration)
    bundles = [decode_bundle(int(word, 16), image.configuration, isa) for word in image.bundles]
    lines: dict[int, set[int]] = {}
    for issue, entries in zip(machine.issue_cycles(bundles), image.sources, strict=True):
        for entry in entries:
            if Path(entry.file).resolve() == path.resolve():
                lines.setdefault(entry.line, set()).add(issue.cycle)
    return {line: sorted(cycles) for line, cycles in lines.items()}


def in_words(cycles: Sequence[int]) -> str:
    """Cycles as runs: `cycle 4`, `cycles 4-6, 9`."""
    runs: list[list[int]] = []
    for cycle in cycles:
        if runs and cycle == runs[-1][-1] + 1:
            runs[-1][1:] = [cycle]
        else:
            runs.append([cycle])
    shown = ["-".join(map(str, run)) for run in runs[:RANGES_SHOWN]]
    more = ", ..." if len(runs) > RANGES_SHOWN else ""
    return f"cycle{'s' if len(cycles) > 1 else ''} {', '.join(shown)}{more}"


def _by_file(diagnostics: Sequence[Diagnostic], path: Path) -> dict[Path, list[lsp.Diagnostic]]:
    """Diagnostics of the protocol. One without a place is at the first line of the file."""
    found: dict[Path, list[lsp.Diagnostic]] = {path.resolve(): []}
    for diagnostic in diagnostics:
        place = diagnostic.place
        file = (Path(place.line.file) if place else path).resolve()
        line = place.line.number - 1 if place else 0
        text = place.line.text if place else ""
        begin, end = (place.column, place.column + place.length) if place else (0, 0)
        expanded = "".join(f"\nin macro {name}" for name in place.line.expansions) if place else ""
        found.setdefault(file, []).append(
            lsp.Diagnostic(
                range=_range(line, _units(text[:begin]), _units(text[:end])),
                message=diagnostic.message
                + (f"\nhelp: {diagnostic.help}" if diagnostic.help else "")
                + expanded,
                severity=lsp.DiagnosticSeverity.Warning
                if diagnostic.code
                else lsp.DiagnosticSeverity.Error,
                code=f"-W{diagnostic.code}" if diagnostic.code else None,
                source=NAME,
            )
        )
    return found


def _units(text: str) -> int:
    """Length of a text as the protocol counts it, in units of UTF-16."""
    return len(text.encode("utf-16-le")) // 2


def _range(line: int, begin: int = 0, end: int = 0) -> lsp.Range:
    return lsp.Range(lsp.Position(line, begin), lsp.Position(line, end))


def lenses(checked: Checked) -> list[lsp.CodeLens]:
    """The summary above the first line, and the cycles of each line above it."""

    def lens(line: int, text: str) -> lsp.CodeLens:
        return lsp.CodeLens(range=_range(line), command=lsp.Command(title=text, command=""))

    head = [lens(0, checked.summary)] if checked.summary else []
    return head + [lens(line - 1, in_words(at)) for line, at in sorted(checked.cycles.items())]


def word_at(text: str, line: int, column: int) -> str:
    """The word of a text at a place, from 0; empty where there is none."""
    lines = text.splitlines()
    words = WORD.finditer(lines[line]) if line < len(lines) else ()
    return next((w.group() for w in words if w.start() <= column <= w.end()), "")


def describe(record: OperationRecord) -> str:
    """What an operation does, as Markdown."""
    unit = default_isa().units[record.unit]
    form = f"{record.name} {', '.join(record.operands)}".strip()
    rows = [f"```\n{form}\n```", record.doc, f"unit `{record.unit}`: {unit.doc}"]
    latency = load_machine("wide").units[record.unit].latency
    if record.writes and latency is not None:
        rows.append(f"latency {counted(latency, 'cycle')}")
    return "\n\n".join(rows)


class Server(LanguageServer):
    """The server; configuration and optimise: of every program, as for `check`."""

    def __init__(self, configuration: str | None = None, optimise: bool = True) -> None:
        super().__init__(NAME, version("microtick"))
        self.configuration, self.optimise = configuration, optimise
        self.checked: dict[str, Checked] = {}
        self.reported: dict[str, set[str]] = {}
        self.turn = threading.Lock()

    def report_server_error(
        self, error: Exception, source: type[PyglsError] | type[JsonRpcException]
    ) -> None:
        """Show an error to the client, but not that a message could not be sent: its message would
        fail in the same way, without end. pygls logs it.
        """
        if source is not JsonRpcInternalError:
            super().report_server_error(error, source)

    def assembled(self, uri: str) -> None:
        """Assemble the saved file of a document and publish what is wrong in it."""
        name = to_fs_path(uri)
        if name is None:
            return
        with self.turn:  # The last save is the last to be shown.
            try:
                checked = check(Path(name), self.configuration, self.optimise)
            except OSError as error:
                text = f"{name}: {error.strerror}"
                self.window_show_message(lsp.ShowMessageParams(lsp.MessageType.Error, text))
                return
            self.checked[uri] = checked
            self.publish(uri, checked.problems)
        self.workspace_code_lens_refresh(None)

    def publish(self, uri: str, problems: Mapping[Path, Sequence[lsp.Diagnostic]]) -> None:
        """Show problems by file in place of those that this document had before."""
        now = {from_fs_path(str(file)) or "": list(found) for file, found in problems.items()}
        gone: dict[str, list[lsp.Diagnostic]] = {
            other: [] for other in self.reported.get(uri, set()) - now.keys()
        }
        self.reported[uri] = set(now)
        for file, found in (gone | now).items():
            self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(file, found))


def serve(configuration: str | None = None, optimise: bool = True) -> Server:
    """A server with its answers."""
    server = Server(configuration, optimise)

    @server.feature(lsp.TEXT_DOCUMENT_DID_OPEN)
    @server.thread()
    def opened(parameters: lsp.DidOpenTextDocumentParams) -> None:
        server.assembled(parameters.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_SAVE)
    @server.thread()
    def saved(parameters: lsp.DidSaveTextDocumentParams) -> None:
        server.assembled(parameters.text_document.uri)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def changed(parameters: lsp.DidChangeTextDocumentParams) -> None:
        server.checked.pop(parameters.text_document.uri, None)

    @server.feature(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def closed(parameters: lsp.DidCloseTextDocumentParams) -> None:
        uri = parameters.text_document.uri
        server.checked.pop(uri, None)
        server.publish(uri, {})

    @server.feature(lsp.TEXT_DOCUMENT_CODE_LENS)
    def code_lens(parameters: lsp.CodeLensParams) -> list[lsp.CodeLens]:
        return lenses(server.checked.get(parameters.text_document.uri, Checked()))

    @server.feature(lsp.TEXT_DOCUMENT_HOVER)
    def hover(parameters: lsp.HoverParams) -> lsp.Hover | None:
        document = server.workspace.get_text_document(parameters.text_document.uri)
        at = parameters.position
        record = default_isa().operations.get(word_at(document.source, at.line, at.character))
        if record is None:
            return None
        return lsp.Hover(lsp.MarkupContent(lsp.MarkupKind.Markdown, describe(record)))

    return server


@command("microtick lsp")
def main(argv: list[str] | None = None) -> int:
    """Command line; returns at the end of the input."""
    parser = command_parser(
        "microtick lsp",
        __doc__,
        "Set an editor to run this command for files that end in .s; docs/assembly.md shows how.",
    )
    parser.add_argument(
        "--config",
        choices=list(default_isa().configurations),
        help="configuration of the core, where a program does not name one",
    )
    parser.add_argument(
        "-O0", dest="optimise", action="store_false", help="one operation per bundle, as written"
    )
    options = parser.parse_args(argv)
    serve(options.config, options.optimise).start_io()
    return 0


if __name__ == "__main__":
    sys.exit(main())
