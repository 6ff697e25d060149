# SPDX-License-Identifier: Apache-2.0
"""Command asip-run: what it prints, its exit status, its messages."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from asip_asm.assemble import assemble
from sim.debug.asip_run.__main__ import main
from sim.debug.asip_run.show import value_text

SOURCE = """\
.program "filter"
.input x, y
.input n : int
.state sum = 1.5
.state seen : int = 7
.const two = 2
.output F, safe = 0.25
.export q, x
        fmadd q, x, x, y    ; (7)
        fadd sum, sum, q
        iadd seen, seen, n
        i2f t, n
        fdiv r, q, t
        mov F, r
        halt
"""
PLACES = ["--rtl", "--iss"]


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "filter.s"
    path.write_text(SOURCE)
    return path


@pytest.fixture(params=PLACES)
def place(request) -> str:
    """The option that says where the program runs."""
    return request.param


def run(capsys, *arguments: object) -> tuple[int, str, str]:
    """Exit status, standard output and error of the command."""
    try:
        status = main([str(argument) for argument in arguments])
    except SystemExit as stop:
        status = stop.code
    return status, *capsys.readouterr()


def test_source__one_run__outputs_exports_flags(place, configuration, source, capsys):
    status, out, err = run(
        capsys, source, place, "--config", configuration, "--set", "x=2", "--set", "n=3"
    )
    head, *rows = out.splitlines()
    assert (status, err) == (0, "")
    assert head.startswith("run 1: done, ") and head.endswith("flags NX")
    assert [row.split() for row in rows] == [
        ["F", "=", "1.3333334", "3faaaaab"],
        ["q", "=", "4", "40800000"],
        ["x", "=", "2", "40000000"],
    ]


def test_core_and_model__sine__last_bit_may_differ_and_a_note_says_so(tmp_path, capsys):
    path = tmp_path / "sine.s"
    path.write_text(".input x\n.output s, safe = 0.0\n fsin s, x\n halt\n")
    words = {}
    for place in PLACES:
        # An argument whose sine the unit rounds to the other neighbour.
        status, out, err = run(capsys, path, place, "--set", "x=0f4016bf97")
        assert status == 0
        assert ("docs/numerics.md" in err) == (place == "--iss")
        words[place] = int(out.split()[-1], 16)
    assert abs(words["--rtl"] - words["--iss"]) == 1


def test_core_and_model__several_runs__same_values_and_the_core_its_counters(source, capsys):
    arguments = ["--set", "x=1.5", "--set", "n=-2", "--ticks", 3, "--print", "F,sum,seen"]
    tables = {}
    for place in PLACES:
        status, out, _ = run(capsys, source, place, *arguments)
        assert status == 0
        tables[place] = [row for row in out.splitlines() if row.startswith(" ")]
        heads = [row for row in out.splitlines() if not row.startswith(" ")]
        assert len(heads) == 3
        assert all(("cycles " in head) == (place == "--rtl") for head in heads)
        assert all(("bundles " in head) == (place == "--iss") for head in heads)
    assert tables["--rtl"] == tables["--iss"]
    assert [row.split()[2] for row in tables["--rtl"]] == [
        *("-1.125", "3.75", "5"),
        *("-1.125", "6", "3"),
        *("-1.125", "8.25", "1"),
    ]


def test_image__as_source(place, source, capsys, tmp_path):
    image = tmp_path / "filter.asip.json"
    assemble(source).save(image)
    want = run(capsys, source, place, "--set", "n=3", "--set", "y=0f40400000")
    assert run(capsys, image, place, "--set", "n=3", "--set", "y=3.0") == want
    assert want[0] == 0 and "F = 1 " in want[1]


def test_inputs__csv_file__csv_table_with_a_row_per_run(place, source, capsys, tmp_path):
    table = tmp_path / "in.csv"
    table.write_text("n, x\n2, 1\n4, 0f40000000\n\n")
    status, out, err = run(
        capsys, source, place, "--inputs", table, "--set", "y=1", "--ticks", 3, "--print", "F,sum,q"
    )
    rows = [line.split(",") for line in out.splitlines()]
    counters = (
        "cycles,stall_operand,stall_port,stall_unit,stall_fetch,drain"
        if place == "--rtl"
        else "bundles"
    )
    assert (status, err) == (0, "")
    assert rows[0] == ["run", "F", "sum", "q", "fault", "flags", *counters.split(",")]
    assert [row[:6] for row in rows[1:]] == [
        ["1", "1", "3.5", "2", "NONE", "-"],
        ["2", "1.25", "8.5", "5", "NONE", "-"],
        ["3", "1.25", "13.5", "5", "NONE", "-"],  # the last row again
    ]
    if place == "--rtl":
        for row in rows[1:]:
            cycles, *stalls = map(int, row[6:])
            assert cycles > sum(stalls)


def test_state__given__is_the_first_run_s(place, source, capsys):
    status, out, _ = run(
        capsys,
        source,
        place,
        *("--set", "n=1", "--state", "sum=-1e-3", "--state", "seen=0xff"),
        *("--print", "sum,seen"),
    )
    assert status == 0
    assert [row.split()[2] for row in out.splitlines()[1:]] == ["-0.001", "256"]


def test_print__register__its_word(place, capsys, tmp_path):
    path = tmp_path / "p.s"
    path.write_text(".input x\n.output F, safe = 1.0\n{ mov c9, x }\n{ mov F, c9 } halt\n")
    status, out, _ = run(capsys, path, place, "--set", "x=-0.0", "--print", "c9")
    assert (status, out.splitlines()[1].split()) == (0, ["c9", "=", "-0", "80000000"])


def test_trace__every_write_of_every_run(place, source, capsys, tmp_path):
    trace = tmp_path / "writes.txt"
    status, _, _ = run(
        capsys, source, place, "--set", "n=2", "--set", "x=2", "--ticks", 2, "--trace", trace
    )
    lines = [line.split() for line in trace.read_text().splitlines()]
    assert status == 0 and len(lines) == 2 * 6
    assert {line[0] for line in lines} == {"1", "2"}
    assert ["1", "o0", "40000000", "2"] in lines


def test_fault__not_finite__names_output_and_source_line(place, source, capsys):
    status, out, err = run(capsys, source, place, "--set", "x=1")
    assert status == 1
    assert out.startswith("run 1: fault NOT_FINITE, ") and "F = 0.25" in out
    assert err.startswith(
        "asip-run: error: run 1: NOT_FINITE: NaN or infinity written to an output, "
    )
    assert err.endswith(
        "filter.s:14: mov F, r\n  possible causes: division by 0; a result above 3.4e38\n"
    )


def test_sine__beyond_its_range__is_named_as_the_cause(place, capsys, tmp_path):
    path = tmp_path / "sine.s"
    path.write_text(".input x\n.output F, safe = 0.0\n fsin F, x\n halt\n")
    assert run(capsys, path, place, "--set", "x=256")[0] == 0
    status, _, err = run(capsys, path, place, "--set", "x=257")
    assert status == 1 and "possible causes: sine or cosine of more than 256 rad (NaN);" in err


def test_keep_going__clears_the_fault_and_runs_the_rest(place, source, capsys, tmp_path):
    table = tmp_path / "in.csv"
    table.write_text("n,x\n2,2\n0,2\n0,2\n4,2\n")
    arguments = [source, place, "--inputs", table, "--print", "F"]
    status, out, err = run(capsys, *arguments)
    assert status == 1 and [row.split(",")[2] for row in out.splitlines()[1:]] == [
        *("NONE", "NOT_FINITE")
    ]
    status, out, err = run(capsys, *arguments, "--keep-going")
    rows = [row.split(",")[:3] for row in out.splitlines()[1:]]
    assert status == 1
    assert rows == [
        *(["1", "2", "NONE"], ["2", "0.25", "NOT_FINITE"]),
        *(["3", "0.25", "NOT_FINITE"], ["4", "1", "NONE"]),
    ]
    assert "error: run 2: NOT_FINITE: " in err and "error: run 3: NOT_FINITE: " in err
    assert err.endswith("asip-run: error: 2 of 4 runs ended with a fault\n")


def test_endless_loop__with_a_large_watchdog__is_stopped_by_max_cycles(place, capsys, tmp_path):
    path = tmp_path / "f.s"
    path.write_text(".watchdog 4294967295\n again: jmp again\n")
    status, _, err = run(capsys, path, place, "--max-cycles", 1000)
    assert status == 1 and err.endswith(
        "  stopped by --max-cycles 1000; the program's own watchdog is 4294967295\n"
    )
    status, _, err = run(capsys, path, place)
    assert status == 1 and "stopped by --max-cycles 500000" in err


def test_output_over_an_input__is_refused(source, capsys, tmp_path):
    before = source.read_text()
    for option in ("--trace", "--konata", "--gantt"):
        status, _, err = run(capsys, source, option, source)
        assert status == 1 and "would overwrite the input" in err
    assert source.read_text() == before


@pytest.mark.parametrize("cause", ["ADDRESS", "WATCHDOG"])
def test_fault__in_a_bundle__names_its_source_line(cause, place, capsys, tmp_path):
    operation = {
        "ADDRESS": "{ ld c1, 1023[k0] }",
        "WATCHDOG": "again: { bnz k0, again }",
    }[cause]
    path = tmp_path / "f.s"
    path.write_text(
        ".watchdog 50\n.input n : int\n.output F, safe = 1.0\n"
        f"{operation}\n{{ mov F, zero }} halt\n"
    )
    status, _, err = run(capsys, path, place, "--set", "n=1")
    assert status == 1
    assert f"run 1: {cause}: " in err and "bundle 0\n" in err
    assert f"/{path.parent.name}/{path.name}:4: " in err  # the folder may be given relative


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "z=1"], "the program has no input 'z'; it has x, y, n"),
        (["--set", "x"], "'x' is not NAME=VALUE"),
        (["--set", "x=one"], "input x: 'one' is not a number"),
        (["--set", "x=1e60"], "input x: 1e60 is too large for single precision"),
        (["--set", "x=0fzz"], "input x: '0fzz' is not 0f and 8 hexadecimal digits"),
        (["--set", "n=1.5"], "input n: '1.5' is not an integer"),
        (["--set", "n=4294967296"], "input n: 4294967296 does not fit in 32 bits"),
        (["--state", "sun=1"], "the program has no state 'sun'; did you mean 'sum'?"),
        (
            ["--print", "F,nothing"],
            "the program has no output, export, state or register 'nothing'; "
            "it has F, q, x, sum, seen",
        ),
        (["--ticks", "0"], "'0' is not a number 1..999999999"),
        (["--ticks", "many"], "'many' is not a number 1..999999999"),
        (["--rtl", "--iss"], "not allowed with argument"),
        (["--config", "huge"], "invalid choice: 'huge'"),
    ],
)
def test_wrong_command_line__one_message__status_2(arguments, message, source, capsys):
    status, out, err = run(capsys, source, *arguments)
    assert (status, out) == (2, "")
    assert message in err and "Traceback" not in err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "in.csv: empty, expected a header with names of inputs"),
        ("x,y\n", "in.csv: no row below the header"),
        ("x,w\n1,2\n", "in.csv:1: the program has no input 'w'"),
        ("x,y,x\n1,2,3\n", "in.csv:1: input 'x' stands in two columns"),
        ("x,y\n1\n", "in.csv:2: 1 values for 2 names"),
        ("x,y\n1,2\n1,b\n", "in.csv:3: y: 'b' is not a number"),
    ],
)
def test_wrong_csv_file__names_line_and_column__status_1(text, message, source, capsys, tmp_path):
    table = tmp_path / "in.csv"
    table.write_text(text)
    status, out, err = run(capsys, source, "--iss", "--inputs", table)
    assert (status, out) == (1, "")
    assert err.startswith("asip-run: error: ") and message in err


def test_wrong_files__one_message__status_1(source, capsys, tmp_path):
    status, _, err = run(capsys, tmp_path / "none.s")
    assert status == 1 and err.endswith("none.s: No such file or directory\n")
    bad = tmp_path / "bad.s"
    bad.write_text("fmul\n")
    status, _, err = run(capsys, bad)
    assert status == 1 and "bad.s:1:" in err
    image = tmp_path / "bad.asip.json"
    image.write_text("{}")
    status, _, err = run(capsys, image)
    assert status == 1 and "not a program image" in err
    assemble(source).save(image)
    status, _, err = run(capsys, image, "--config", "small")
    assert status == 1 and "is for configuration 'fast', not 'small'" in err
    status, _, err = run(capsys, source, "--iss", "--inputs", tmp_path / "none.csv")
    assert status == 1 and err.endswith("none.csv: No such file or directory\n")
    status, _, err = run(capsys, source, "--iss", "--trace", tmp_path / "no" / "t.txt")
    assert status == 1 and err.endswith("t.txt: No such file or directory\n")


def test_help__shows_an_example(capsys):
    status, out, _ = run(capsys, "--help")
    assert status == 0 and "asip-run leg.s --set x=0.3" in out


def test_command__without_arguments__says_how_to_use_it():
    done = subprocess.run(
        [sys.executable, "-m", "sim.debug.asip_run"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2 and done.stderr.startswith("usage: asip-run ")


def test_value_text__any_word__shortest_text_that_gives_it_again():
    words = (0x3DCCCCCD, 0x00000001, 0x7F7FFFFF, 0x80000000, 0x3F800000, 0x4B800001)
    texts = [value_text(word, "float") for word in words]
    assert texts == ["0.1", "1e-45", "3.4028235e+38", "-0", "1", "1.6777218e+07"]
    assert [value_text(word, "float") for word in (0x7F800000, 0x7FC00000)] == ["inf", "nan"]
    assert value_text(0xFFFFFFFF, "int") == "-1"
