# SPDX-License-Identifier: Apache-2.0
"""Titles, meanings and names from outside in every text that asip-model and asip-as write."""

from __future__ import annotations

import html.parser
import re
from pathlib import Path

import casadi as ca
import pytest

from asip_asm import cli_as, cli_objdump
from asip_asm.assemble import assemble
from asip_asm.assembly_text import note, quoted, unquoted
from asip_asm.diagnostics import Line
from asip_asm.disassemble import disassemble
from asip_asm.image import Image
from asip_asm.lexer import split_comment, tokenize
from asip_asm.listing import listing
from asip_asm.model.c_code import to_c_code
from asip_asm.model.compiler import Options, compile_law
from asip_asm.model.law import Law, Port
from asip_asm.model.program import build
from asip_asm.model.read import ModelError
from sim.debug.asip_run import __main__ as asip_run
from sim.laws.asip_model.__main__ import main
from sim.laws.native.law import NativeLaw

SECRET = "text of a file that nobody named"
TEXTS = {
    "quote": 'the "left" arm\'s',
    "directive": '"\n.include "secret.txt"\n;',
    "return": 'x\r.include "secret.txt"',
    "line separator": 'x\u2028.include "secret.txt"\x85.include "secret.txt"\x0b',
    "comment of C": "*/ int stolen; /* // \\",
    "end of C": '"; system("id"); //',
    "backslash": "C:\\new\\",
    "last backslash": "\\",
    "macro": "\\title \\@ ??/ ??'",
    "comment": "; # -Wno-unused-input: -Wno-type:",
    "shell": "$(id) `id` %s {0} | > out",
    "HTML": '<script>alert("x")</script> & <b>',
    "Markdown": "| a | [x](http://x) ![y](z) `",
    "zero": "a\0b\x1b[2J",
    "not ASCII": "Gelenk 1 µ°é\ud800",
    "long": "a" * 3000,
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_string_is_read_as_it_was_written(text):
    shown = "".join(c if c.isprintable() else " " for c in text)
    line = Line("x.s", 1, f".program {quoted(text)} ; {note(text)}")
    code, comment = split_comment(line.text)
    assert "\n" not in line.text and len(line.text.splitlines()) == 1
    assert comment.startswith("; ") and "-Wno-" not in comment
    tokens = tokenize(line)
    assert [token.kind for token in tokens] == ["directive", "string", "end"]
    assert tokens[1].text == shown == unquoted(quoted(text))


def law(text: str) -> Law:
    x, s = ca.SX.sym("x"), ca.SX.sym("s")
    function = ca.Function("f", [x, s], [2 * x + s, s + x], ["x", "s"], ["y", "s_next"])
    return Law(
        text,
        function,
        [
            Port("input", "x", text, text),
            Port("state", "s", text, text),
            Port("parameter", "k", text, text, initial=2.0),
            Port("output", "y", text, text),
        ],
        text,
    )


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_every_generator_quotes_what_a_law_says(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("secret.txt").write_text(f"{SECRET}\n")
    try:
        compiled = compile_law(law(text))
        built = build(compiled, Path("law.s"))
    except ModelError as error:
        pytest.fail(f"refused: {error}")
    written = [Path("law.s").read_text()]
    assert built.image.title == "".join(c if c.isprintable() else " " for c in text)
    Path("law.asip.json").write_text(built.image.dumps())
    assert Image.load(Path("law.asip.json")) == built.image
    # The program again, from its own disassembly.
    Path("again.s").write_text(disassemble(built.image))
    again = assemble(Path("again.s"), optimise=False)
    assert again.title == built.image.title and again.bundles == built.image.bundles
    for form, name in (("c", "law.h"), ("readmemh", "law.hex"), ("ihex", "law.ihex")):
        options = ["law.s", "--format", form, "-o", name, "--listing", "law.lst", "--report"]
        assert cli_as.main(options) == 0
        written.append(Path(name).read_text())
    written.append(Path("law.lst").read_text())
    for row in listing(built.image).splitlines()[2:]:
        assert row.startswith((" ", ";"))
    assert cli_objdump.main(["-d", "-h", "-t", "law.asip.json"]) == 0
    NativeLaw(compiled)  # compiles with -Wall -Wextra -Werror
    texts = to_c_code(compiled, "law.tick.h")
    for c_text in (*texts, Path("law.h").read_text()):
        assert c_text.isascii() and "stolen;" not in without_comments(c_text)
    assert SECRET not in "".join((*written, *texts))


def without_comments(text: str) -> str:
    """C as its compiler sees it, without comments and strings."""
    return re.sub(r'/\*.*?\*/|"(?:[^"\\]|\\.)*"', "", text, flags=re.DOTALL)


RECORD = """
title = {title}
[[input]]
names = [{name}]
unit = "1"
meaning = {meaning}
[[output]]
names = ["y"]
unit = "1"
safe = 0
meaning = "result"
"""


@pytest.mark.parametrize("where", ("title", "meaning", "name"))
@pytest.mark.parametrize("text", [t for t in TEXTS.values() if t.isascii()], ids=lambda t: None)
def test_a_record_is_refused_in_its_own_terms_or_obeyed(where, text, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path("secret.txt").write_text(f"{SECRET}\n")
    x = ca.SX.sym("x")
    ca.Function("f", [x], [2 * x], ["x"], ["y"]).save("law.casadi")
    values = {"title": '"plain"', "meaning": '"plain"', "name": '"x"'}
    escaped = "".join(c if c.isalnum() else f"\\u{ord(c):04x}" for c in text)
    Path("law.toml").write_text(RECORD.format(**(values | {where: f'"{escaped}"'})))
    status = main(["law.casadi", "law.toml", "-o", "out", "--c"])
    shown = capfd.readouterr()
    assert SECRET not in shown.out + shown.err
    if where == "name":
        assert status == 1 and shown.err.startswith("asip-model: error: ")
    if not text.isprintable() or (where == "name" and not text.isidentifier()):
        assert status == 1 and re.match(r"asip-model: error: law\.toml:\d+: error: ", shown.err)
        assert "out.s" not in shown.err
    elif where != "name":
        assert status == 0, shown.err


@pytest.mark.parametrize("name", ('a"b', "a\nb", "a\\b"))
def test_a_header_that_c_cannot_include_is_refused(name):
    compiled = compile_law(law("plain"))
    with pytest.raises(ModelError, match="cannot be included by C"):
        to_c_code(compiled, f"{name}.tick.h")


class Tags(html.parser.HTMLParser):
    """The elements of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.found: set[str] = set()

    def handle_starttag(self, tag, attrs) -> None:
        self.found.add(tag)


def page_tags(text: str, folder: Path) -> set[str]:
    build(compile_law(law(text), Options()), folder / "law.s")
    page = folder / "law.html"
    assert asip_run.main([str(folder / "law.s"), "--set", "x=1", "--gantt", str(page)]) == 0
    tags = Tags()
    tags.feed(page.read_text())
    return tags.found


@pytest.mark.parametrize("text", [TEXTS["HTML"], TEXTS["quote"]])
def test_the_timing_page_has_the_elements_of_any_title(text, tmp_path):
    plain = page_tags("plain", tmp_path)
    assert len(plain) > 5 and page_tags(text, tmp_path) == plain
