# SPDX-License-Identifier: Apache-2.0
"""Command nios-run: console, exit status, limits, profile, and files that are no program."""

from __future__ import annotations

import functools
import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sim.debug.nios_run import (
    FILE_STATUS,
    INTERRUPT_STATUS,
    LIMIT_STATUS,
    PIPE_STATUS,
    STRAY_STATUS,
    main,
)
from sim.rtl.n2_lockstep_program import LabelledWords
from sim.rtl.nios_image import IMAGES
from sim.rtl.nios_rtl import NiosRtl
from tests.bench.konata import KonataReader
from tests.bench.seed import SEED
from tests.fuzz import nios as fuzz
from tests.fuzz.engine import run_campaign
from tests.nios.elf_file import printing, write

SORT = IMAGES / "tests/sort_quick.elf"


def test_console_is_standard_output_and_the_rest_is_not(tmp_path, capfdbinary):
    elf = write(tmp_path / "hello.elf", printing("grüße\n", 42))
    assert main([str(elf)]) == 42
    out, err = capfdbinary.readouterr()
    assert out == "grüße\n".encode()
    assert b"nios-run: fpga2, " in err and b"exit status 42" in err


@pytest.mark.parametrize(("status", "shown"), [(0, 0), (255, 255), (256, 255), (0x1234, 0x34)])
def test_status_of_the_program_is_never_lost(tmp_path, status, shown):
    """A shell sees 8 bits: a status with only higher ones set must not look like success."""
    assert main([str(write(tmp_path / "end.elf", printing("", status)))]) == shown


@pytest.mark.quick("fpga2")
@pytest.mark.parametrize("system", ["fpga1", "fpga2"])
def test_hello_prints_and_calls_the_hardware_of_its_platform(system, capfdbinary):
    assert main(["--system", system, str(IMAGES / f"run/demo_hello_{system}.elf")]) == 0
    out, _ = capfdbinary.readouterr()
    assert out.startswith(f"square root of 2 on FPGA{system[-1]}: 1.4142135, ".encode())


def test_exception_that_nothing_handles_is_told_and_ends_the_program(capfdbinary):
    assert main([str(IMAGES / "run/demo_exception_fpga2.elf")]) == 128 + 6
    out, _ = capfdbinary.readouterr()
    text = rb"\nunhandled exception 6, misaligned data address, at 0x1000\w+, address 0x1004\w+\n"
    assert re.fullmatch(text, out)


@pytest.mark.parametrize("address", [0, 0x1000FFFC + 4, 0x10050000, 0x20000400, 0xFFFFFFFC])
@pytest.mark.parametrize("name", ["ldw", "stw"])
def test_access_where_there_is_nothing_stops_the_program(tmp_path, capfd, name, address):
    program = LabelledWords()
    program.li(2, (address + 8) & 0xFFFFFFFF)
    program.emit(name, 3, -8, 2)
    elf = write(tmp_path / "stray.elf", printing("never", 0, program))
    assert main([str(elf)]) == STRAY_STATUS
    out, err = capfd.readouterr()
    assert out == ""
    assert f"(start-up) at 0x10000008 accesses 0x{address:08x}, where there is neither" in err


def test_program_without_end_is_stopped_where_it_is(tmp_path, capfd):
    assert main(["--max-cycles", "3000", str(IMAGES / "tests/allocate.elf")]) == LIMIT_STATUS
    _, err = capfd.readouterr()
    assert re.search(r"allocate.elf did not end within 3000 cycles, it is in \w+ at 0x1000", err)
    assert "--max-cycles raises the limit" in err


def test_profile_names_functions_and_kinds_of_instructions(capfd):
    main(["--profile", str(SORT)])
    out, err = capfd.readouterr()
    assert out == ""
    assert "by function" in err and "quick" in err and "branches" in err


def traced(name, count, tmp_path):
    """Files of a trace of a committed program."""
    log, times = tmp_path / "log.konata", tmp_path / "times.json"
    files = ["--konata", str(log), "--timeline", str(times), "--trace", f"0:{count}"]
    main([*files, str(IMAGES / name)])
    return log.read_text(), json.loads(times.read_text())["traceEvents"]


def test_konata_shows_each_instruction_in_each_stage_and_waits_where_it_waits(tmp_path, capfd):
    elf = tmp_path / "divide.elf"
    program = LabelledWords()
    program.li(2, 84)
    program.li(3, 2)
    program.emit("div", 4, 2, 3)
    program.emit("add", 5, 4, 4)
    write(elf, printing("", 0, program))
    log, times = tmp_path / "log.konata", tmp_path / "times.json"
    main(["--konata", str(log), "--timeline", str(times), str(elf)])
    reader = KonataReader(log.read_text())
    assert reader.orders == list(range(len(reader.retired)))
    number = next(n for n, texts in reader.labels.items() if "div r4, r2, r3" in texts[0])
    after = next(n for n, texts in reader.labels.items() if "add r5, r4, r4" in texts[0])
    assert "r5 = 00000054" in reader.labels[after][1]
    for stages in reader.stages.values():
        assert [name for name, *_ in stages] == list("DEMA")
        assert [end for *_, end in stages[:-1]] == [start for _, start, _ in stages[1:]]
    long = {name: end - start for name, start, end in reader.stages[number]}
    assert (long["E"], long["M"]) == (1, 1) and long["A"] > 10
    # The sum waits in D until the quotient is in A, and executes right after it.
    decode, execute, *_ = reader.stages[after]
    assert decode[1] == reader.stages[number][1][1]
    assert execute[1] == reader.stages[number][3][2]


@pytest.mark.full
def test_konata_counts_the_cycles_of_the_program(tmp_path, capfd):
    log, _ = traced("tests/sort_quick.elf", 10_000_000, tmp_path)
    reader = KonataReader(log)
    said = capfd.readouterr().err
    cycles, instructions = map(int, re.search(r"(\d+) cycles .* (\d+) instr", said).groups())
    stopped = [n for n, texts in reader.labels.items() if texts[1].endswith("exception")]
    assert len(reader.retired) - len(stopped) == instructions and len(stopped) == 1  # `break`
    ends = sorted(reader.retired.values())
    assert len(set(ends)) == len(ends) and 0 < cycles - (ends[-1] - min(
        stages[0][1] for stages in reader.stages.values())) < 20  # fmt: skip


@pytest.mark.full
def test_timeline_opens_and_closes_each_function_in_its_caller(tmp_path, capfd):
    _, events = traced("tests/sort_quick.elf", 1_000_000, tmp_path)
    open_, names, last = [], set(), 0.0
    for event in events:
        assert event["ts"] >= last
        last = event["ts"]
        names.add(event["name"])
        if event["ph"] == "B":
            open_.append(event["name"])
        else:
            assert open_.pop() == event["name"]
    assert not open_ and {"main", "qsort", "by_digits"} <= names
    assert {"by_digits", "ascending"} & {name for name in inside(events, "qsort")}


def inside(events, name):
    """Functions that began while `name` was open."""
    open_ = 0
    for event in events:
        if event["name"] == name:
            open_ += 1 if event["ph"] == "B" else -1
        elif open_ and event["ph"] == "B":
            yield event["name"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--trace", "0:5"], "--trace: needs --konata FILE or --timeline FILE"),
        (["--konata", "k", "--trace", "5"], "'5': expected FIRST:COUNT"),
        (["--konata", "k", "--trace", "0:0"], "COUNT 1 to 10000000"),
        (["--timeline", "t", "--gdb", ":0"], "--konata, --timeline: not with --gdb"),
    ],
)
def test_trace_options_that_cannot_be_are_refused(options, said, capfd):
    with pytest.raises(SystemExit) as ended:
        main([*options, str(SORT)])
    assert ended.value.code == 2 and said in capfd.readouterr().err


def not_about_the_build(text: bytes) -> list[str]:
    """Lines but the first: a command builds its own model, without the assertions of tests."""
    return [line for line in text.decode().splitlines() if not line.startswith("nios-run: build")]


def test_ctrl_c_ends_the_command_without_a_traceback(tmp_path):
    NiosRtl("fpga2")  # built before the time counts
    elf = write(tmp_path / "spin.elf", printing("begin\n", None))
    command = [sys.executable, "-m", "sim.debug.nios_run", str(elf)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    # Ctrl-C reaches the command, even where the tests run in the background of a shell.
    heard = functools.partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen(command, **pipes, preexec_fn=heard) as process:
        assert process.stdout.readline() == b"begin\n"
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode == INTERRUPT_STATUS
    assert not_about_the_build(err) == ["nios-run: stopped by Ctrl-C"]


def test_reader_that_goes_away_is_no_error(tmp_path):
    NiosRtl("fpga2")
    elf = write(tmp_path / "spin.elf", printing("0123456789\n", None))
    command = [sys.executable, "-m", "sim.debug.nios_run", "--max-cycles", "9000000", str(elf)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.read(100)
        process.stdout.close()
        assert not_about_the_build(process.stderr.read()) == []
        assert process.wait(timeout=60) == PIPE_STATUS


# ---------------------------------------------------------------------- files that are no program
def refused(path: Path, capfd) -> str:
    """What the command says about a file that it must refuse."""
    assert main([str(path)]) == FILE_STATUS
    out, err = capfd.readouterr()
    assert out == "" and err.startswith(f"nios-run: {path}: error: ")
    return err.removeprefix(f"nios-run: {path}: error: ").strip()


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"machine": 62}, "for machine EM_X86_64, must be Nios II (EM_ALTERA_NIOS2)"),
        ({"type": 1}, "ET_REL is no linked program (ET_EXEC)"),
        ({"entry": 0x10000020}, "starts at 0x10000020, must be the reset vector 0x10000000"),
        ({"memory_size": 0x10004}, "65540 bytes at 0x10000000 are in no memory; link with"),
        ({"memory_size": 8}, "the segment at 0x10000000 is cut off"),
    ],
)
def test_program_for_something_else_is_refused_by_name(tmp_path, capfd, fields, message):
    elf = write(tmp_path / "wrong.elf", printing("x", 0), **fields)
    assert refused(elf, capfd).startswith(message)


def test_file_that_is_no_elf_file_is_refused(tmp_path, capfd):
    text = tmp_path / "text"
    text.write_text("int main(void) {}\n")
    assert refused(text, capfd) == "no little-endian 32-bit ELF file"
    assert refused(tmp_path / "nowhere.elf", capfd) == "no such file"
    assert refused(tmp_path, capfd) == "no file with a program"
    assert refused(Path("/dev/zero"), capfd) == "no file with a program"
    (tmp_path / "large").write_bytes(bytes((8 << 20) + 1))
    assert refused(tmp_path / "large", capfd) == "larger than 8 MiB, no program here"


@pytest.mark.full
def test_damaged_elf_files_give_a_message():
    """A short run of the campaign `python -m tests.fuzz elf`."""
    result = run_campaign(fuzz.CAMPAIGNS[0], 300, SEED)
    assert result.failures == []
    assert len(result.statuses) > 1  # refused ones, and ones that run
