# SPDX-License-Identifier: Apache-2.0
"""Commands asip-as and asip-objdump: files, summary, exit codes."""

import os
import sys
from pathlib import Path

import pytest

from asip_asm.assemble import assemble
from asip_asm.cli_as import main as asip_as
from asip_asm.cli_objdump import main as asip_objdump
from asip_asm.image import Image
from asip_asm.project import ROOT
from sim.debug.asip_run.__main__ import main as asip_run
from tests.bench.commands import output

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


def assembled(*options: str) -> Image:
    """What asip-as makes of the source."""
    assert asip_as(["sum.s", *options]) == 0
    return Image.load(Path("sum.asip.json"))


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
    image = assembled("--config", "small", "-D", "gain=3.5", "-I", "inc")
    assert image.configuration == "small"
    assert [(c.name, c.bits) for c in image.constants] == [("gain", "40600000")]


def test_as__parameter_file__acts_at_once_and_another_replaces_it(source) -> None:
    source.write_text(SOURCE.replace(".param gain = 2.0", '.params "own.toml"'), encoding="utf-8")

    def gain(*options: str) -> str:
        return assembled(*options).constants[0].bits

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
    assert len(assembled("-O").bundles) < len(assembled("-O0").bundles)


def test_as__listing__shows_addresses_cycles_words_source_and_equations(source) -> None:
    image = assembled("-O0", "--listing", "sum.lst", "--symbols", "sum.sym")
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


@pytest.mark.parametrize("name", ["sum.s", "./sum.s", "hard.s", "soft.s", "soft_folder/sum.s"])
def test_as__output_is_the_source__is_refused_and_the_source_kept(name, source, capsys) -> None:
    Path("hard.s").hardlink_to(source)
    Path("soft.s").symlink_to(source)
    Path("soft_folder").symlink_to(".")
    for option in ("-o", "--listing", "--symbols"):
        assert asip_as(["sum.s", option, name]) == 1
        assert capsys.readouterr().err == (
            f"asip-as: error: {Path(name)}: would overwrite the input sum.s; name another\n"
        )
    assert source.read_text(encoding="utf-8") == SOURCE
    assert not Path("sum.asip.json").exists()


def test_as__output_is_an_included_file_or_named_twice__is_refused(source, capsys) -> None:
    Path("rest.inc").write_text("        halt\n", encoding="utf-8")
    source.write_text(SOURCE.replace("        halt", '.include "rest.inc"'), encoding="utf-8")
    assert asip_as(["sum.s", "-o", "rest.inc"]) == 1
    assert "rest.inc: would overwrite the input rest.inc" in capsys.readouterr().err
    assert Path("rest.inc").read_text(encoding="utf-8") == "        halt\n"
    assert asip_as(["sum.s", "-o", "x.json", "--listing", "x.json"]) == 1
    assert "x.json: is named for two different outputs" in capsys.readouterr().err
    assert not Path("x.json").exists()


def test_as__output_to_a_pipe_without_a_reader__is_refused(source, capsys) -> None:
    os.mkfifo("pipe")
    assert asip_as(["sum.s", "-o", "pipe"]) == 1
    assert capsys.readouterr().err == "asip-as: error: pipe: is a pipe that nothing reads\n"
    assert asip_run(["sum.s", "--iss", "--trace", "pipe"]) == 1
    assert capsys.readouterr().err == "asip-run: error: pipe: is a pipe that nothing reads\n"
    assert asip_as(["sum.s", "-o", "/dev/null"]) == 0


def test_as__warnings__are_shown_switched_off_or_taken_as_errors(source, capsys) -> None:
    source.write_text(SOURCE.replace(".input x, y", ".input x, y, z"), encoding="utf-8")
    warning = "sum.s:2:14: warning: input 'z' is never read [-Wunused-input]\n"
    assert asip_as(["sum.s"]) == 0
    assert capsys.readouterr().err.startswith(warning)
    assert asip_as(["sum.s", "-Wno-unused-input", "-Werror"]) == 0
    assert capsys.readouterr().err == ""
    Path("sum.asip.json").unlink()
    for option in ("-Werror", "--warn-error"):
        assert asip_as(["sum.s", option]) == 1
        shown = capsys.readouterr().err
        assert shown.startswith(warning)
        assert shown.endswith("asip-as: 1 warning taken as errors, nothing written\n")
        assert not Path("sum.asip.json").exists()
    with pytest.raises(SystemExit):
        asip_as(["sum.s", "-Wno-unused-inputs"])
    assert "did you mean 'no-unused-input'?" in capsys.readouterr().err


def test_assemble__warnings__go_to_the_logger(source, caplog) -> None:
    source.write_text(SOURCE.replace(".input x, y", ".input x, y, z"), encoding="utf-8")
    assemble(source)
    assert [(r.name, r.levelname) for r in caplog.records] == [("asip_asm", "WARNING")]
    assert "input 'z' is never read [-Wunused-input]" in caplog.text


def test_as__c_tables__take_the_prefix(source) -> None:
    assert asip_as(["sum.s", "--format", "c", "-o", "x.h", "--prefix", "left_leg"]) == 0
    text = Path("x.h").read_text(encoding="utf-8")
    assert "left_leg_image" in text and "LEFT_LEG_INPUT_X" in text and "sum_image" not in text


@pytest.mark.parametrize("name", ["folder", "zero", "pipe", "utf16.s", "binary.s", "empty.s"])
@pytest.mark.parametrize("command", [asip_as, asip_objdump, asip_run])
def test_command__input_that_is_no_text__is_an_error_of_one_line(
    command, name, source, capsys
) -> None:
    Path("folder").mkdir()
    Path("zero").symlink_to("/dev/zero")
    os.mkfifo("pipe")
    Path("utf16.s").write_bytes(SOURCE.encode("utf-16"))
    Path("binary.s").write_bytes(bytes(range(256)))
    Path("empty.s").write_bytes(b"")
    arguments = {asip_as: [name], asip_objdump: ["-d", name], asip_run: [name, "--iss"]}
    assert command(arguments[command]) == 1
    shown = capsys.readouterr()
    assert shown.out == "" and "error: " in shown.err and name in shown.err


@pytest.mark.parametrize(
    "arguments",
    [
        ["--prefix", "1x"],
        [],
        ["sum.s", "--config", "huge"],
        ["sum.s", "-D", "gain"],
        ["sum.s", "--format", "elf"],
    ],
)
def test_as__wrong_command_line__exits_with_two(arguments: list[str], source) -> None:
    with pytest.raises(SystemExit, match="^2$"):
        asip_as(arguments)


def test_objdump__disassembly__reassembles_to_the_same_words(source, capsys) -> None:
    first = assembled()
    capsys.readouterr()
    assert asip_objdump(["-d", "sum.asip.json"]) == 0
    Path("again.s").write_text(capsys.readouterr().out, encoding="utf-8")
    assert asip_as(["again.s"]) == 0
    again = Image.load(Path("again.asip.json"))
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
    image = assembled("-O0")
    image.bundles[2] = "0" * 32
    image.save(Path("sum.asip.json"))
    capsys.readouterr()
    assert asip_objdump(["-d", "sum.asip.json"]) == 1
    assert capsys.readouterr().err == (
        "asip-objdump: error: bundle 2: opcode 0x00 does not exist\n"
    )


def test_objdump__nothing_to_show__exits_with_two(source) -> None:
    with pytest.raises(SystemExit, match="^2$"):
        asip_objdump(["sum.asip.json"])


@pytest.mark.parametrize("module", ["cli_as", "cli_objdump"])
def test_command__help__shows_examples(module: str) -> None:
    columns = os.environ | {"COLUMNS": "100"}
    text = output(sys.executable, "-m", f"asip_asm.{module}", "--help", cwd=ROOT, env=columns)
    assert "examples:" in text and "exit status:" in text
