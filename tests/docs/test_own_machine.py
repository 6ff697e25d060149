# SPDX-License-Identifier: Apache-2.0
"""docs/own_machine.md word for word: its files and commands in an empty folder, what they print,
and what the page claims of them."""

from __future__ import annotations

import importlib.util
import os
import re

import numpy as np
import pytest

from asip_asm.assemble import assemble
from scripts.doc_blocks import code_blocks, write_files
from sim import Core
from sim.rtl.build import ROOT
from tests.bench.commands import output

PAGE = ROOT / "docs/own_machine.md"
BLOCKS = code_blocks(PAGE)
MARK = "### next block"
LOOP_LINES = 15


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """An empty folder and a home with the checkout as the page expects them, the files written."""
    home = tmp_path_factory.mktemp("home")
    (home / "microtick").symlink_to(ROOT)
    work = home / "my machine"
    work.mkdir()
    write_files(PAGE, work)
    return work


@pytest.fixture(scope="module")
def printed(folder):
    """What the shell blocks print, each with the text block that follows it (None without)."""
    shell = [i for i, block in enumerate(BLOCKS) if block.language == "sh"]
    script = f"echo '{MARK}'\n".join(BLOCKS[i].text for i in shell)
    environment = {"HOME": str(folder.parent), "PATH": os.environ["PATH"], "MPLBACKEND": "Agg"}
    same = ("MODEL_OPTIMISATION", "OPENBLAS_NUM_THREADS")  # as in tests/conftest.py
    environment |= {name: os.environ[name] for name in same}
    said = output("sh", "-e", input=script, cwd=folder, env=environment, timeout=900)
    outputs = said.split(f"{MARK}\n")
    assert len(outputs) == len(shell)
    following = [BLOCKS[i + 1] if i + 1 < len(BLOCKS) else None for i in shell]
    return {
        BLOCKS[i].text: (part, after.text if after and after.language == "text" else None)
        for i, part, after in zip(shell, outputs, following, strict=True)
    }


def output_of(printed, command: str) -> tuple[str, str | None]:
    (found,) = [pair for text, pair in printed.items() if text.rstrip().endswith(command)]
    return found


@pytest.mark.quick("python fault.py")
@pytest.mark.parametrize("command", ["python axis.py", "python batch.py", "python fault.py"])
def test_python_block__prints_what_the_page_shows(printed, command):
    said, shown = output_of(printed, command)
    assert said == shown


def test_first_loop__whole_in_fifteen_lines():
    (loop,) = [block for block in BLOCKS if block.title == "axis.py"]
    assert len(loop.text.splitlines()) <= LOOP_LINES


def test_c__prints_what_the_page_shows__the_same_as_python(printed):
    said, shown = output_of(printed, "./main")
    assert shown is not None and said.endswith(shown)
    assert shown.removeprefix("ok: ") == output_of(printed, "python axis.py")[0]


def test_c__on_hardware__one_line_changes(printed, folder):
    """Compiled, not run: the address is nobody's here."""
    (line,) = [block.text for block in BLOCKS if block.language == "c" and not block.title]
    text = (folder / "main.c").read_text().replace('#include "sim_bus.h"\n', "")
    text, count = re.subn(r"^  asip core = .*\n", line, text, flags=re.M)
    assert count == 1
    (folder / "board.c").write_text(text)
    options = ("-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{ROOT / 'sim/core/host'}")
    output("cc", *options, "-fsyntax-only", "board.c", cwd=folder)


def figures(text: str) -> tuple[list[int], list[float], list[float]]:
    """[ticks, cycles], largest errors and differences from the law, (4,) each, of track.py."""
    first, error, off = (line.partition("(")[0] for line in text.splitlines())
    counts = [int(number) for number in re.findall(r"\d+", first)]
    return counts, *([float(n) for n in row.partition(":")[2].split()] for row in (error, off))


def test_scara__cycles_of_the_image__errors_within_bounds__as_the_page_shows(printed, folder):
    said, shown = output_of(printed, "python track.py")
    counts, error, off = figures(said)
    assert counts == [4000, assemble(folder / "scara.s").cycles]
    assert len(error) == len(off) == 4
    assert max(error) < 100  # urad, um
    assert max(off) < 5e-4  # positions in binary32 times the gains
    shown_counts, shown_error, shown_off = figures(shown)
    assert counts == shown_counts
    assert error == pytest.approx(shown_error, abs=1)  # the plant's last bits may differ
    assert off == pytest.approx(shown_off, rel=0.5)


def test_scara__plot__drawn(printed, folder):
    from matplotlib.image import imread  # here: it takes long, and every worker loads this file

    picture = imread(folder / "track.png")
    colours = {tuple(pixel) for pixel in np.round(picture[..., :3], 1).reshape(-1, 3).tolist()}
    assert picture.shape[0] > 500 and len(colours) > 10


def test_scara__law_at_random_set_points__core_agrees_in_batches(folder):
    """The law of scara.py on states that the path never visits, saturation included."""
    spec = importlib.util.spec_from_file_location("scara", folder / "scara.py")
    scara = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scara)
    rng = np.random.default_rng(7)
    n = 300
    qd = rng.uniform(-1.5, 1.5, (n, 4)) * [1, 1, 0.1, 1]
    vd = rng.uniform(-3.9, 3.9, (n, 4)) * [1, 1, 0.2, 1]
    ad = rng.uniform(-30, 30, (n, 4))
    counts = np.rint((qd + rng.uniform(-1e-4, 1e-4, (n, 4))) / scara.COUNT).astype(int)
    counts[1:] = counts[:-1] + np.rint(vd[1:] * scara.PERIOD / scara.COUNT).astype(int)
    qd[1:] = counts[1:] * scara.COUNT + rng.uniform(-1e-4, 1e-4, (n - 1, 4))
    vd[1:] = np.diff(counts, axis=0) * scara.COUNT / scara.PERIOD
    names = [f"{kind}{joint}" for kind in ("qd", "vd", "ad") for joint in (1, 2, 3, 4)]
    inputs = dict(zip(names, np.hstack([qd, vd, ad]).T, strict=True))
    inputs |= {f"count{joint + 1}": counts[:, joint] for joint in range(4)}
    with Core(folder / "scara.s") as core:
        ticks = core.batch(inputs)
        got = np.stack([ticks[name] for name in core.outputs], axis=1)
    wanted = [scara.law(qd[i], vd[i], ad[i], counts[i], counts[i - 1]) for i in range(1, n)]
    off = np.abs(got[1:] - np.array(wanted))
    assert off.max() < 5e-3, f"tick {off.max(axis=1).argmax() + 1}, seed 7"
    assert (np.abs(got) < scara.LIMIT).any(axis=0).all()
