# SPDX-License-Identifier: Apache-2.0
"""Commands asip-as and asip-objdump: files, summary, exit codes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from asip_asm.cli_as import main as asip_as
from asip_asm.cli_objdump import main as asip_objdump
from asip_asm.image import Image

SOURCE = """.program "sum"
.input x, y
.param gain = 2.0
.state last = 0.0
.output F1, safe = 1.0
.export t
        fadd    t, x, y         ; (3)
        fmul    u, t, gain
        mov     last, u
        mov     F1, u
        halt
"""


@pytest.fixture
def source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = Path("sum.s")
    path.write_text(SOURCE, encoding="utf-8")
    return path


def test_as__good_source__writes_the_image_and_a_summary(source, capsys) -> None:
    assert asip_as(["sum.s", "-O0", "-o", "out/sum.asip.json"]) == 0
    assert capsys.readouterr().out == (
        "out/sum.asip.json: fast, 4 bundles, 4 operations, 2 inputs, 1 constant, 1 output, "
        f"about {Image.load(Path('out/sum.asip.json')).cycles} cycles\n"
    )


def test_as__without_o__writes_beside_the_source(source) -> None:
    assert asip_as(["sum.s"]) == 0
    assert asip_as(["sum.s", "--format", "ihex"]) == 0
    assert Path("sum.asip.json").exists() and Path("sum.hex").exists()


def test_as__options__choose_configuration_parameters_and_folders(source) -> None:
    Path("inc").mkdir()
    Path("inc/rest.inc").write_text("        halt\n", encoding="utf-8")
    text = SOURCE.replace("        halt", '.include "rest.inc"')
    source.write_text(text, encoding="utf-8")
    arguments = ["sum.s", "--config", "small", "-D", "gain=3.5", "-I", "inc"]
    assert asip_as(arguments) == 0
    image = Image.load(Path("sum.asip.json"))
    assert image.configuration == "small"
    assert [(c.name, c.bits) for c in image.constants] == [("gain", "40600000")]


def test_as__parameter_file__acts_at_once_and_another_replaces_it(source) -> None:
    source.write_text(SOURCE.replace(".param gain = 2.0", '.params "own.toml"'), encoding="utf-8")

    def gain(*arguments: str) -> str:
        assert asip_as(["sum.s", *arguments]) == 0
        return Image.load(Path("sum.asip.json")).constants[0].bits

    Path("own.toml").write_text("gain = 2.0\n", encoding="utf-8")
    assert gain() == "40000000"
    Path("own.toml").write_text('[gain]\nvalue = 4\nunit = "1"\n', encoding="utf-8")
    assert gain() == "40800000"
    Path("other.toml").write_text("gain = 8.0\n", encoding="utf-8")
    assert gain("--params", "other.toml") == "41000000"
    assert gain("--params", "other.toml", "-D", "gain=1.0") == "3f800000"


def test_as__optimised__puts_independent_operations_into_one_bundle(source) -> None:
    text = SOURCE.replace("fmul    u, t, gain", "fmul    u, x, gain")
    source.write_text(text, encoding="utf-8")
    assert asip_as(["sum.s", "-O0", "-o", "slow.json"]) == 0
    assert asip_as(["sum.s", "-O", "-o", "quick.json"]) == 0
    slow, quick = Image.load(Path("slow.json")), Image.load(Path("quick.json"))
    assert len(quick.bundles) < len(slow.bundles)


def test_as__listing__shows_addresses_cycles_words_source_and_equations(source) -> None:
    arguments = ["sum.s", "-O0", "--listing", "sum.lst", "--symbols", "sum.sym"]
    assert asip_as(arguments) == 0
    image = Image.load(Path("sum.asip.json"))
    rows = Path("sum.lst").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "; sum"
    assert rows[3].split() == ["0000", "0", image.bundles[0]]
    assert rows[4].split() == "0: fadd t, x, y ; sum.s:7 (3)".split()
    assert rows[-2].split()[-1] == "halt"
    symbols = Path("sum.sym").read_text(encoding="utf-8").splitlines()
    assert [row.split()[:3] for row in symbols] == [
        ["input", "k0", "x"],
        ["input", "k1", "y"],
        ["constant", "k2", "gain"],
        ["output", "o0", "F1"],
        ["state", "c0", "last"],
        ["export", image.exports[0].register, "t"],
    ]


def test_as__errors_in_source__prints_them_and_writes_nothing(source, capsys) -> None:
    source.write_text(SOURCE.replace("fadd ", "fad "), encoding="utf-8")
    assert asip_as(["sum.s"]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("sum.s:7:9: error: unknown operation 'fad'\n")
    assert captured.err.endswith("asip-as: 1 error, nothing written\n")
    assert not Path("sum.asip.json").exists()


def test_as__missing_file__is_an_error_without_traceback(source, capsys) -> None:
    assert asip_as(["nothing.s"]) == 1
    assert capsys.readouterr().err == "asip-as: error: nothing.s: No such file or directory\n"


@pytest.mark.parametrize(
    "arguments",
    [[], ["sum.s", "--config", "huge"], ["sum.s", "-D", "gain"], ["sum.s", "--format", "elf"]],
)
def test_as__wrong_command_line__exits_with_two(arguments: list[str], source) -> None:
    with pytest.raises(SystemExit) as caught:
        asip_as(arguments)
    assert caught.value.code == 2


def test_objdump__disassembly__reassembles_to_the_same_words(source, capsys) -> None:
    assert asip_as(["sum.s"]) == 0
    capsys.readouterr()
    assert asip_objdump(["-d", "sum.asip.json"]) == 0
    Path("again.s").write_text(capsys.readouterr().out, encoding="utf-8")
    assert asip_as(["again.s"]) == 0
    first, again = Image.load(Path("sum.asip.json")), Image.load(Path("again.asip.json"))
    again.sources = first.sources
    assert again == first


def test_objdump__header_and_symbols__show_sizes_and_names(source, capsys) -> None:
    assert asip_as(["sum.s", "-O0"]) == 0
    capsys.readouterr()
    assert asip_objdump(["-h", "-t", "sum.asip.json"]) == 0
    shown = capsys.readouterr().out
    assert "title          sum\n" in shown
    assert "outputs        1, mask 00000001\n" in shown
    assert "constant k2    gain" in shown


def test_objdump__no_image__is_an_error_without_traceback(source, capsys) -> None:
    assert asip_objdump(["-d", "sum.s"]) == 1
    assert capsys.readouterr().err.startswith("asip-objdump: error: sum.s: not a JSON file")
    assert asip_objdump(["-d", "nothing.json"]) == 1
    assert capsys.readouterr().err.endswith("nothing.json: No such file or directory\n")


def test_objdump__illegal_bundle__names_it(source, capsys) -> None:
    assert asip_as(["sum.s", "-O0"]) == 0
    image = Image.load(Path("sum.asip.json"))
    image.bundles[2] = "0" * 32
    image.save(Path("sum.asip.json"))
    capsys.readouterr()
    assert asip_objdump(["-d", "sum.asip.json"]) == 1
    assert capsys.readouterr().err == (
        "asip-objdump: error: bundle 2: opcode 0x00 does not exist\n"
    )


def test_objdump__nothing_to_show__exits_with_two(source) -> None:
    with pytest.raises(SystemExit) as caught:
        asip_objdump(["sum.asip.json"])
    assert caught.value.code == 2


@pytest.mark.parametrize("module", ["cli_as", "cli_objdump"])
def test_command__help__shows_examples(module: str) -> None:
    result = subprocess.run(
        [sys.executable, "-m", f"asip_asm.{module}", "--help"],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parents[2],
        env=os.environ | {"COLUMNS": "100"},
    )
    assert result.returncode == 0
    assert "examples:" in result.stdout and "exit status:" in result.stdout
