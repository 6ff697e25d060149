# SPDX-License-Identifier: Apache-2.0
"""Shape of error reports, the limit of 20, and errors of whole programs that exceed the core."""

from pathlib import Path

import pytest

from asip_asm import limits
from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError
from asip_asm.lint import WARNINGS


def report(
    tmp_path: Path,
    text: str,
    monkeypatch: pytest.MonkeyPatch,
    optimise: bool = True,
    beside: bytes = b"",
) -> str:
    tmp_path.mkdir(exist_ok=True)
    monkeypatch.chdir(tmp_path)
    Path("y.inc").write_bytes(beside)
    Path("x.s").write_text(text, encoding="utf-8")
    with pytest.raises(AssemblyError) as caught:
        assemble("x.s", optimise=optimise)
    return caught.value.report()


def test_report__shows_place_line_caret_and_help(tmp_path, monkeypatch) -> None:
    text = ".input x\n        fmul    t, x, raduis ; note\n        halt\n.const radius = 1\n"
    assert report(tmp_path, text, monkeypatch) == (
        "x.s:2:23: error: unknown name 'raduis'\n"
        "    2 |         fmul    t, x, raduis ; note\n"
        "      |                       ^^^^^^  help: did you mean 'radius'?"
    )


def test_report__in_macro__shows_replaced_text_and_the_calls(tmp_path, monkeypatch) -> None:
    text = ".macro inner d\n  fmul \\d, 1.0, q\\@\n.endm\n.macro outer d\n  inner \\d\n.endm\n"
    assert report(tmp_path, text + "  outer t\n  halt\n", monkeypatch) == (
        "x.s:2:16: error: unknown name 'q2'\n"
        "    2 |   fmul t, 1.0, q2\n"
        "      |                ^^  help: it is neither declared nor written\n"
        "      = in macro inner at x.s:5\n"
        "      = in macro outer at x.s:7"
    )


def test_report__many_errors__shows_twenty_and_counts_the_rest(tmp_path, monkeypatch) -> None:
    text = "".join(f"        op{i} x\n" for i in range(23))
    shown = report(tmp_path, text, monkeypatch)
    assert shown.count(": error: unknown operation") == 20
    assert shown.endswith("\nand 3 more errors")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"halt\n\xff\n", "line 2 is not UTF-8 text: byte 0xff"),
        ("halt\n".encode("utf-16"), "is UTF-16 text; save it as UTF-8"),
        (b"\x7fELF\0\0", "is a binary file, a source text is UTF-8 text"),
        (b";" * ((1 << 20) + 1), "larger than 1048576 bytes, the most that a source text may have"),
    ],
)
def test_source__no_text__is_an_error(data, message, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("x.s").write_bytes(data)
    with pytest.raises(OSError) as caught:
        assemble("x.s")
    assert (caught.value.strerror, caught.value.filename) == (message, "x.s")
    shown = report(tmp_path / "y", '.include "y.inc"\n halt\n', monkeypatch, beside=data)
    assert f"x.s:1:10: error: cannot read 'y.inc': {message}\n" in shown


def test_source__with_byte_order_mark_and_any_line_ends__is_read(tmp_path) -> None:
    (tmp_path / "x.s").write_bytes(b"\xef\xbb\xbf.input x\r\n mov c0, x\r halt\n")
    assert len(assemble(tmp_path / "x.s", optimise=False).bundles) == 1


HOSTILE = {
    "inputs": (
        "".join(f".input i{i}\n" for i in range(129)),
        "too many inputs: bank K has 128 words",
    ),
    "outputs": (
        "".join(f".output f{i}, safe = 0\n mov f{i}, 1.0\n" for i in range(33)),
        "too many outputs: the core has 32",
    ),
    "constants": (
        "".join(f" mov r{i}, {i}.5\n" for i in range(129)),
        "too many constants: bank K has 128 words for inputs and constants",
    ),
    "data": (".space a, 1000\n.space b, 25", "too many data words: data memory has 1024"),
    "bundles": (
        " mov c0, 1.0\n" * 1025,
        "too many bundles: the program needs 1025 or more (1025 operations for 1 of its slots), "
        "the core's program memory holds 1024",
    ),
    "states": (
        "".join(f".state s{i} = 0\n" for i in range(65)),
        "bank C has no register left",
    ),
    "parentheses": (" mov c0, " + "(" * 300 + "1" + ")" * 300, "more than 64 parentheses are open"),
    "calls": (".const a = " + "sin(" * 300 + "1" + ")" * 300, "more than 64 parentheses are open"),
    "infinity": (".const a = sin(1e308*10)", "the result of '*' is not finite"),
    "digits": (".const a = 1" + "0" * 4301, "is not a finite number"),
    "hexadecimal": (".const a = 0x" + "f" * 4301, "is not a finite number"),
    "register": (" mov a" + "1" * 5000 + ", 1.0", "there is no register 'a111111'"),
    "macro": (".macro m a\n m \\a\\a\n.endm\n m 1", "characters, 16384 are allowed"),
    "doubling": (
        "".join(f".macro m{i}\n m{i - 1}\n m{i - 1}\n.endm\n" for i in range(1, 32))
        + ".macro m0\n.endm\n m31",
        "more than 10000 macro calls",
    ),
    "words": (".macro m a\n m \\a, 1\n.endm\n m 1", "macro 'm' takes 1 argument, found 2"),
    "errors": ("".join(f" op{i} x\n" for i in range(9000)), "gave up after 200 errors"),
    "conditions": (".if 1\n" * 20_000, "gave up after 200 errors"),
    "operations": (" mov c0, 1.0\n" * 60_000, "more than 3072 operations: program memory holds"),
    "text": (
        ".macro m\n" + " ;" + "x" * 9000 + "\n.endm\n" + " m\n" * 200,
        "the program has more than 1048576 characters with all that it includes",
    ),
    "line": (".input " + ", ".join(f"i{i}" for i in range(4000)), "characters, 16384 are allowed"),
    "bundle": ("{ mov c0, 1.0\n" + " | nop\n" * 5000, "bundle without closing brace within 64"),
    "name": (" mov c0, " + "x" * 9000 + "y\n mov c1, " + "x" * 9000 + "z", "unknown name 'xxxx"),
}


@pytest.mark.parametrize("optimise", [True, False])
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_source__ends_at_a_stated_limit(name, optimise, tmp_path, monkeypatch) -> None:
    text, message = HOSTILE[name]
    shown = report(tmp_path, text + "\n halt\n", monkeypatch, optimise)
    assert message in shown
    assert len(shown) < 20_000


def test_unary_minus__two_thousand__is_a_number(tmp_path) -> None:
    (tmp_path / "x.s").write_text(f".const a = {'-' * 2001}1\n mov c0, a\n halt\n")
    assert [c.bits for c in assemble(tmp_path / "x.s", optimise=False).constants] == ["bf800000"]


def test_include__chain_of_250_files__stops_at_the_limit(tmp_path, monkeypatch) -> None:
    for i in range(250):
        (tmp_path / f"i{i}").write_text(f'.include "i{i + 1}"\n')
    shown = report(tmp_path, '.include "i0"\n halt\n', monkeypatch)
    assert "i30:1:10: error: more than 32 files include one another" in shown


def test_report__one_cause_in_many_places__stands_once_with_their_number(
    tmp_path, monkeypatch
) -> None:
    text = ".config small\n" + " mov b1, 1.0\n" * 55 + " fad c1, zero\n halt\n"
    shown = report(tmp_path, text, monkeypatch)
    assert shown.count("error: ") == 2
    assert "      = the same 54 more times: x.s:3, x.s:4, x.s:5, " in shown


def test_include__file_that_cannot_be_read__is_an_error(tmp_path, monkeypatch) -> None:
    (tmp_path / "bad.inc").write_bytes(b"\xff\n")
    assert "cannot read 'bad.inc'" in report(tmp_path, '.include "bad.inc"\n halt\n', monkeypatch)


def test_include__cycle_over_two_files__names_the_chain(tmp_path, monkeypatch) -> None:
    (tmp_path / "a.inc").write_text('.include "b.inc"\n', encoding="utf-8")
    (tmp_path / "b.inc").write_text('.include "a.inc"\n', encoding="utf-8")
    shown = report(tmp_path, '.include "a.inc"\n halt\n', monkeypatch)
    assert "b.inc:1:10: error: file 'a.inc' includes itself" in shown
    assert "help: x.s -> a.inc -> b.inc -> a.inc" in shown


def test_string__without_closing_quote__is_an_error(tmp_path, monkeypatch) -> None:
    assert report(tmp_path, '.program "open ; x\n halt\n', monkeypatch) == (
        "x.s:1:10: error: string without closing quote\n"
        '    1 | .program "open ; x\n'
        '      |          ^^^^^^^^^  help: add "'
    )


def test_page__states_every_limit_and_every_warning() -> None:
    page = (Path(__file__).parents[2] / "docs" / "assembly.md").read_text(encoding="utf-8")
    rows = dict(
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in page.splitlines()
        if line.startswith("| ") and line.count("|") == 3
    )
    for code, meaning in WARNINGS.items():
        assert rows[f"`{code}`"] == meaning
    numbers = {
        "characters of a program with all it includes and expands": limits.TEXT_CHARACTERS,
        "characters of a line, also after macro parameters are replaced": limits.LINE_CHARACTERS,
        "files that include one another": limits.INCLUDE_DEPTH,
        "macro calls inside one another": limits.MACRO_DEPTH,
        "macro calls of a program": limits.EXPANSIONS,
        "parentheses and calls open in an expression": limits.NESTING,
        "lines of a bundle in braces": limits.BUNDLE_LINES,
    }
    for what, number in numbers.items():
        assert rows[what] == f"{number:,}".replace(",", " "), what
    shown = f"{limits.ERRORS}, {limits.ERRORS_SHOWN}"
    assert rows["errors before the assembler gives up, causes shown"] == shown


def test_message__with_characters_that_a_terminal_obeys__shows_others(
    tmp_path, monkeypatch
) -> None:
    source = '.program "x"\n.input x\n bogus\x1b]0;title\x07 \u202e\x9b y\n halt\n'
    said = report(tmp_path, source, monkeypatch)
    assert not set(said) & set("\x1b\x07\x9b\u202e")
    first, line, caret = said.splitlines()[:3]
    assert first == "x.s:3:7: error: character U+001B means nothing here"
    assert line.endswith(" bogus\ufffd]0;title\ufffd \ufffd\ufffd y")
    assert caret.index("^") == line.index("\ufffd")


@pytest.mark.parametrize("character", ["\x1b", "\t", "\x7f"])
def test_string__with_a_control_character__is_refused(character, tmp_path, monkeypatch) -> None:
    """No image may have one."""
    source = f'.program "a{character}b"\n.input x\n.output F, safe = 0.0\n mov F, x\n halt\n'
    said = report(tmp_path, source, monkeypatch)
    assert f"error: a string has no character U+{ord(character):04X}" in said
