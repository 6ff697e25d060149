# SPDX-License-Identifier: Apache-2.0
"""Shape of error reports, the limit of 20, and errors of whole programs that exceed the core."""

from pathlib import Path

import pytest

from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError


def report(tmp_path: Path, text: str, monkeypatch: pytest.MonkeyPatch, **options: object) -> str:
    monkeypatch.chdir(tmp_path)
    Path("x.s").write_text(text, encoding="utf-8")
    with pytest.raises(AssemblyError) as caught:
        assemble("x.s", **options)
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


LIMITS = {
    "inputs": (
        "".join(f".input i{i}\n" for i in range(129)) + "halt\n",
        "too many inputs: bank K has 128 words",
    ),
    "outputs": (
        "".join(f".output f{i}, safe = 0\n mov f{i}, 1.0\n" for i in range(33)) + "halt\n",
        "too many outputs: the core has 32",
    ),
    "constants": (
        "".join(f" mov r{i}, {i}.5\n" for i in range(129)) + "halt\n",
        "too many constants: bank K has 128 words for inputs and constants",
    ),
    "data": (".space a, 1000\n.space b, 25\nhalt\n", "too many data words: data memory has 1024"),
    "bundles": (
        " mov c0, 1.0\n" * 1025 + "halt\n",
        "too many bundles: the program has 1025, the core's program memory holds 1024",
    ),
    "states": (
        "".join(f".state s{i} = 0\n" for i in range(65)) + "halt\n",
        "bank C has no register left",
    ),
}


@pytest.mark.parametrize("name", LIMITS)
def test_limit__one_too_many__is_an_error(name: str, tmp_path, monkeypatch) -> None:
    text, message = LIMITS[name]
    assert message in report(tmp_path, text, monkeypatch, optimise=False)


def test_source__not_utf8__is_an_error(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("x.s").write_bytes(b"\xff\n")
    with pytest.raises(AssemblyError, match="x.s is not a UTF-8 text"):
        assemble("x.s")


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
