# SPDX-License-Identifier: Apache-2.0
"""Outputs appear whole or not at all, and a full disk is named with its file."""

from __future__ import annotations

import errno
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from asip_asm.files import open_output, replaced, write_bytes, write_text
from asip_asm.project import ROOT

LIMIT = 4096  # bytes that a child may write into a file: its disk is full then


def limited(*words: str | Path) -> subprocess.CompletedProcess[str]:
    """A command whose files may not be longer than LIMIT."""

    def shorten() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, LIMIT))

    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, *words], cwd=ROOT, env=environment, preexec_fn=shorten,
        capture_output=True, text=True,
    )  # fmt: skip


WRITERS = {
    "text": "write_text(path, 'x' * 9000)",
    "bytes": "write_bytes(path, b'x' * 9000)",
    "stream": "[stream.write('x' * 9000) for stream in [own.enter_context(open_output(path))]]",
}


@pytest.mark.parametrize("kind", WRITERS)
def test_full_disk__names_the_file_and_leaves_the_old_one(kind, tmp_path):
    file = tmp_path / "out.json"
    file.write_text("old")
    program = (
        "import contextlib, pathlib, signal, sys\n"
        "from asip_asm.files import *\n"
        "from asip_asm.files import open_output, write_bytes, write_text\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        f"path = pathlib.Path({str(file)!r})\n"
        "with contextlib.ExitStack() as own:\n"
        f"    {WRITERS[kind]}\n"
    )
    done = limited("-c", program)
    assert done.returncode == 1 and f"'{file}'" in done.stderr.splitlines()[-1], done.stderr
    assert file.read_text() == "old" and os.listdir(tmp_path) == ["out.json"]


def test_assembler__with_a_full_disk__keeps_the_image_of_before(tmp_path):
    source = ROOT / "asip_asm/programs/tracking_optimised.s"
    image = tmp_path / "law.asip.json"
    image.write_text("old")
    done = limited("-m", "asip_asm.cli_as", source, "-o", image)
    assert done.returncode == 1 and str(image) in done.stderr and "Traceback" not in done.stderr
    assert image.read_text() == "old" and os.listdir(tmp_path) == [image.name]


COMMANDS = {
    "library": """
import sim.core.host.__main__ as tool
tool.simulated_core = lambda _: pathlib.Path({source!r})
sys.exit(tool.main(["-o", {out!r}]))
""",
    "token": """
from sim.rtl.private import write_secret
write_secret(pathlib.Path({out!r}), "x" * 9000)
""",
    "set-points": """
import sim.motion.trajectory.__main__ as tool
sys.exit(tool.main([{program!r}, "--csv", {out!r}]))
""",
    "picture": """
from sim.report.pictures import pyplot, save
plt = pyplot("test")
figure, axes = plt.subplots()
axes.plot(range(3000))
save(figure, pathlib.Path({out!r}))
""",
    "page": """
from sim.report.goals import write_goals
write_goals(pathlib.Path({out!r}), [{{"name": "x" * 9000}}])
""",
}


@pytest.mark.parametrize("name", COMMANDS)
def test_writer__with_a_full_disk__names_the_file_and_leaves_the_old_one(name, tmp_path):
    outputs = tmp_path / "outputs"
    outputs.mkdir()
    out = outputs / ("picture.svg" if name == "picture" else "result")
    out.write_text("old")
    source = tmp_path / "libcore.so"
    source.write_bytes(b"x" * 9000)
    program = tmp_path / "part.ngc"
    program.write_text("G21 G90 G1 X10 F600\nM2\n")
    head = "import pathlib, signal, sys\nsignal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    text = COMMANDS[name].format(out=str(out), source=str(source), program=str(program))
    done = limited("-c", head + text)
    assert done.returncode == 1 and str(out) in done.stderr.splitlines()[-1], done.stderr
    assert out.read_text() == "old" and os.listdir(outputs) == [out.name]


def test_output__that_is_interrupted__is_not_there(tmp_path):
    file = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt), open_output(file) as stream:
        stream.write("half")
        raise KeyboardInterrupt
    assert os.listdir(tmp_path) == []


def test_output__keeps_mode_and_link(tmp_path):
    file, link = tmp_path / "out", tmp_path / "link"
    file.write_text("old")
    file.chmod(0o640)
    link.symlink_to(file)
    write_text(link, "new")
    assert link.is_symlink() and file.read_text() == "new"
    assert file.stat().st_mode & 0o777 == 0o640


def test_output__into_a_folder_that_is_missing__names_the_file(tmp_path):
    with pytest.raises(FileNotFoundError) as error:
        write_bytes(tmp_path / "none/out", b"")
    assert error.value.errno == errno.ENOENT and str(tmp_path / "none/out") in str(error.value)


def test_outputs__to_one_file_at_a_time__are_whole(tmp_path):
    file = tmp_path / "out"
    with replaced(file) as first:
        first.write_text("first")
        assert not file.exists()
    assert file.read_text() == "first"
