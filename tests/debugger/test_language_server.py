# SPDX-License-Identifier: Apache-2.0
"""`microtick lsp`: errors at their characters, cycles of each line, through a client of pygls."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

import pytest
from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient

from asip_asm.assemble import assemble
from asip_asm.isa import default_isa
from sim.debug.language_server import (
    check,
    describe,
    in_words,
    issue_cycles,
    lenses,
    serve,
    word_at,
)

GOOD = """.program "two products"
.input x, y
.output z, safe = 0
fmul a, x, y
fmadd b, a, x, y   ; waits for a
mov z, b
halt
"""


def saved(folder: Path, text: str = GOOD, name: str = "law.s") -> Path:
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return file


def test_cycles__are_those_of_the_listing(tmp_path):
    file = saved(tmp_path)
    checked = check(file)
    assert checked.problems == {file: []}
    assert checked.cycles == issue_cycles(assemble(file), file)
    first, second, third = (checked.cycles[line][0] for line in (4, 5, 6))
    assert first < second < third
    assert checked.summary.endswith(f"{assemble(file).configuration}")
    assert [lens.range.start.line for lens in lenses(checked)] == [0, 3, 4, 5]
    assert lenses(checked)[1].command.title == in_words([first])


@pytest.mark.parametrize(
    ("cycles", "text"),
    [
        ([4], "cycle 4"),
        ([1, 2, 3, 7], "cycles 1-3, 7"),
        ([1, 3, 5, 7, 9], "cycles 1, 3, 5, 7, ..."),
    ],
)
def test_words__join_cycles_that_follow_each_other(cycles, text):
    assert in_words(cycles) == text


def test_error__is_at_its_characters__with_its_help(tmp_path):
    text = GOOD.replace("fmul a, x, y", "\tfmul a, x, yy")
    file = saved(tmp_path, text)
    (problem,) = check(file).problems[file]
    assert problem.severity == lsp.DiagnosticSeverity.Error and "help: " in problem.message
    line = text.splitlines()[problem.range.start.line]
    assert line[problem.range.start.character : problem.range.end.character] == "yy"
    assert check(file).cycles == {} and lenses(check(file)) == []


def test_warning__has_its_code(tmp_path):
    file = saved(tmp_path, GOOD.replace("mov z, b", "fmul c, x, x\nmov z, b"))
    (problem,) = check(file).problems[file]
    assert problem.severity == lsp.DiagnosticSeverity.Warning
    assert problem.code == "-Wunused-result"


def test_error_of_an_included_file__is_reported_there(tmp_path):
    part = saved(tmp_path, "fmul a, x\n", "part.s")
    file = saved(tmp_path, GOOD.replace("fmul a, x, y", '.include "part.s"'))
    problems = check(file).problems
    assert problems[file] == [] or all("a" in each.message for each in problems[file])
    assert [each.range.start.line for each in problems[part]] == [0]


def test_hover__every_operation_has_a_text():
    operations = default_isa().operations
    assert all(record.doc in describe(record) for record in operations.values())
    assert "latency" in describe(operations["fmul"])
    assert word_at("a\nfmul a, x", 1, 2) == "fmul" and word_at("a", 3, 0) == ""


def test_client__gets_errors_and_cycles__and_none_of_unsaved_text(tmp_path):
    asyncio.run(asyncio.wait_for(_session(tmp_path), 60))


def test_client_that_is_gone__is_sent_each_message_once(tmp_path):
    class Closed:
        writes = 0

        def write(self, data: bytes) -> None:
            self.writes += 1
            raise ValueError("write to closed file")

    server, writer = serve(), Closed()
    server.protocol.set_writer(writer)
    server.assembled(saved(tmp_path).as_uri())
    assert writer.writes == 2  # The problems, and the request to ask for cycles again.


async def _session(folder: Path) -> None:
    file = saved(folder)
    uri, published = file.as_uri(), asyncio.Queue()
    client = LanguageClient("test", "1")
    refreshed = asyncio.Event()

    @client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
    def publish(parameters: lsp.PublishDiagnosticsParams) -> None:
        published.put_nowait(parameters)

    @client.feature(lsp.WORKSPACE_CODE_LENS_REFRESH)
    def refresh(parameters) -> None:
        refreshed.set()

    await client.start_io(sys.executable, "-m", "sim.debug.language_server")
    capabilities = await client.initialize_async(
        lsp.InitializeParams(capabilities=lsp.ClientCapabilities(), root_uri=folder.as_uri())
    )
    assert capabilities.capabilities.code_lens_provider
    client.initialized(lsp.InitializedParams())

    async def cycles() -> list[str]:
        document = lsp.TextDocumentIdentifier(uri)
        found = await client.text_document_code_lens_async(lsp.CodeLensParams(document))
        return [lens.command.title for lens in found or []]

    item = lsp.TextDocumentItem(uri, "asip", 1, GOOD)
    client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))
    assert list((await published.get()).diagnostics) == []
    await refreshed.wait()
    whole = await cycles()
    assert "bundle" in whole[0] and whole[1].startswith("cycle ")

    wrong = GOOD.replace("fmul a", "fmull a")
    change = lsp.DidChangeTextDocumentParams(
        lsp.VersionedTextDocumentIdentifier(2, uri),
        [lsp.TextDocumentContentChangeWholeDocument(wrong)],
    )
    client.text_document_did_change(change)
    assert list(await cycles()) == []
    saved(folder, wrong)
    client.text_document_did_save(lsp.DidSaveTextDocumentParams(lsp.TextDocumentIdentifier(uri)))
    (problem,) = (await published.get()).diagnostics
    assert "fmull" in problem.message and problem.range.start.line == 3

    await client.shutdown_async(None)
    client.exit(None)
    await client.stop()
