# SPDX-License-Identifier: Apache-2.0
"""Software of the Nios II systems without their RTL: memory map, images, the law on a host."""

from __future__ import annotations

import ctypes
import dataclasses
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from asip_asm.assemble import assemble
from asip_asm.interface import PROGRAMS
from scripts import gen_nios_system
from sim.bench.run.nios import Sample, sampled
from sim.core.controller import EXPORTED
from sim.robot import float32
from sim.robot.records import OUTPUTS
from sim.rtl import nios_image
from sim.rtl.nios_map import SYSTEM_TOML, SystemMapError, load_system_map
from tests.asip.tracking_path import reversing_path
from tests.bench.commands import output
from tests.bench.copies import edited
from tests.bench.needs import find, needs, require
from tests.bench.seed import SEED

ROOT = Path(__file__).resolve().parents[2]
SOFTWARE = ROOT / "nios_sw"


# ---------------------------------------------------------------------- memory map
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("base = 0x10040000", "base = 0x10000000", "itcm and dtcm overlap"),
        ('words = 16384\ndoc = "tightly coupled data', 'words = 16383\ndoc = "x', "power of two"),
        ("exception_vector = 0x10000020", "exception_vector = 0x10000040", "32 bytes above"),
        ("reset_vector = 0x10000000", "reset_vector = 0x10000010", "must be the base of itcm"),
        ("bytes = 1024", "bytes = 512", "1024 bytes hold the registers"),
        ("clock_mhz = 100\n", "", "clock_mhz is missing"),
        ("bytes = 1024", "bites = 1024", "bites"),
        ('interface = "tracking"', 'interface = "planning"', "No such file or directory"),
    ],
)
def test_contradicting_map_is_refused_by_name(tmp_path, old, new, message):
    with pytest.raises(SystemMapError, match=re.escape(message)):
        load_system_map(edited(SYSTEM_TOML, tmp_path, old, new))


def test_map_has_the_words_of_the_tracking_programs_in_their_order():
    system = load_system_map()
    image = assemble(PROGRAMS / "tracking_optimised.s", configuration="small")
    assert system.inputs == tuple(entry.name for entry in image.inputs)
    assert system.outputs == tuple(entry.name for entry in image.outputs) == OUTPUTS


def test_changed_generated_file_is_noticed(tmp_path, capsys):
    for name, text in gen_nios_system.generate().items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    assert gen_nios_system.main(["--check", "--root", str(tmp_path)]) == 0
    (tmp_path / "nios_sw/include/gen/parameters.h").write_text("  float mass;\n")
    assert gen_nios_system.main(["--check", "--root", str(tmp_path)]) == 1
    assert "-  float mass;" in capsys.readouterr().out


# ---------------------------------------------------------------------- images
def test_image_is_what_its_elf_file_holds(tmp_path, capsys):
    assert nios_image.main(["tracking_fpga2", "--output", str(tmp_path)]) == 0
    assert str(tmp_path / "tracking_fpga2.lst") in capsys.readouterr().out
    program = nios_image.load("tracking_fpga2")
    for name, words in program.memories.items():
        text = (tmp_path / f"tracking_fpga2.{name}.hex").read_text()
        assert tuple(int(line, 16) for line in text.split()) == words
    listing = (tmp_path / "tracking_fpga2.lst").read_text()
    code = program.memories["itcm"]
    assert len(re.findall(r"^[ 0-9a-f]{8}:\t", listing, re.M)) == len(code)
    assert re.search(rf"^{program.address('main'):08x} <main>:$", listing, re.M)
    assert not re.search(r"\t\.word 0x[0-9a-f]*[1-9a-f]", listing)


@pytest.mark.parametrize("image", sorted(nios_image.IMAGES.glob("**/*.elf")), ids=lambda p: p.stem)
def test_gp__reaches_all_data_with_16_bits(image):
    data = load_system_map().memories["dtcm"]
    gp = nios_image.read_elf(image).address("_gp")
    assert (data.base, data.base + 4 * data.words - 1) == (gp - 0x8000, gp + 0x7FFF)


def test_program_outside_of_the_memories_is_refused(tmp_path):
    small = SYSTEM_TOML.read_text().replace("words = 16384", "words = 64")
    path = tmp_path / "system.toml"
    path.write_text(small)
    with pytest.raises(nios_image.ImageError, match="are in no memory; link with"):
        nios_image.read_elf(SOFTWARE / "images/tests/sort_quick.elf", load_system_map(path))


def test_missing_or_damaged_image_is_refused(tmp_path):
    with pytest.raises(
        nios_image.ImageError, match="no such program; `microtick nios-sw` builds them"
    ):
        nios_image.load("nothing", tmp_path)
    whole = (SOFTWARE / "images/tracking_fpga2.elf").read_bytes()
    (tmp_path / "bad.elf").write_bytes(whole[:2000])
    with pytest.raises(nios_image.ImageError, match="bad.elf: error: "):
        nios_image.load("bad", tmp_path)
    assert nios_image.main([str(tmp_path / "bad.elf"), "--output", str(tmp_path)]) == 1
    assert not (tmp_path / "bad.lst").exists()


def test_unknown_symbol_is_named():
    with pytest.raises(nios_image.ImageError, match="tracking_fpga2: error: no symbol 'nothing'"):
        nios_image.load("tracking_fpga2").address("nothing")


def test_missing_cross_compiler_is_reported_with_its_cure():
    done = subprocess.run(
        ["make", "-C", SOFTWARE, "TOOLCHAIN=/nowhere", "all"], capture_output=True, text=True
    )
    assert done.returncode != 0
    assert "error: no cross compiler at /nowhere/bin/nios2-elf-gcc" in done.stderr
    assert "make tools T=nios-toolchain builds it" in done.stderr


def test_toolchain_script_refuses_an_unknown_argument():
    done = subprocess.run(
        [ROOT / "scripts/nios_toolchain.sh", "--prefx"], capture_output=True, text=True
    )
    assert done.returncode == 2
    assert "error: unknown argument '--prefx'" in done.stderr


def toolchain() -> Path:
    """Folder of the cross compiler; skips without it."""
    return require("nios-gcc").parents[1]


def build(target: str, build_folder: Path, prefix: Path, source: Path = SOFTWARE) -> None:
    """Run make in nios_sw or a copy of it with a cross compiler."""
    command = ["make", "-C", source, "-s", target, f"TOOLCHAIN={prefix}", f"BUILD={build_folder}"]
    output(*command, f"PY={ROOT / '.venv/bin/python'}", env=os.environ | {"PYTHONPATH": ROOT})


def files(folder: Path) -> dict[str, bytes]:
    """Contents of the files below a folder by their names."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def different_images(prefix: Path, folder: Path) -> list[str]:
    """Images that a build in an empty folder makes otherwise than the committed ones."""
    copy = folder / "somewhere/else/nios_sw"
    shutil.copytree(SOFTWARE, copy, ignore=shutil.ignore_patterns("images"))
    build("images", folder / "build", prefix, copy)
    committed, built = files(SOFTWARE / "images"), files(copy / "images")
    return sorted(n for n in committed | built if committed.get(n) != built.get(n))


@pytest.mark.full
def test_images_are_rebuilt_byte_for_byte(tmp_path):
    assert different_images(toolchain(), tmp_path) == []


@needs("apt-get")
@pytest.mark.full
def test_compiler_from_an_empty_cache_makes_the_images_byte_for_byte(tmp_path):
    """The whole toolchain once more, in another folder: 10 to 20 minutes on two processors."""
    environment = os.environ | {"NIOS2_TOOLCHAIN": tmp_path / "cache", "JOBS": "2"}
    output(ROOT / "scripts/nios_toolchain.sh", env=environment)
    assert different_images(tmp_path / "cache/install", tmp_path) == []


def test_committed_images_hold_no_folder_of_the_machine_that_built_them():
    found = {
        name: re.findall(rb"/(?:home|root|tmp|work|usr|build|\.cache)/[ -~]+", content)
        for name, content in files(SOFTWARE / "images").items()
    }
    assert {name: paths for name, paths in found.items() if paths} == {}


# ---------------------------------------------------------------------- law on this machine
@pytest.fixture(scope="module")
def law(tmp_path_factory):
    """The C law, compiled for this machine, with one rounding per operation."""
    library = tmp_path_factory.mktemp("law") / "libtracking.so"
    options = "-std=c11 -O2 -ffp-contract=off -fPIC -shared -fno-math-errno".split()
    command = [os.environ.get("CC", "gcc"), *options, f"-I{SOFTWARE / 'include'}"]
    output(*command, SOFTWARE / "src/tracking.c", "-lm", "-o", library)
    return ctypes.CDLL(str(library))


def words_of_ticks(robot, ticks):
    """Path with reversals, words of each tick for the C program, and the float32 model on them."""
    path, counts = reversing_path(robot, ticks)
    counts = counts.astype(np.int32)
    single = float32.run(robot, path, counts)
    boosted = (single.ticks > 0) & (single.ticks < robot.boost_ticks)
    assert boosted.sum() > ticks // 4 and (single.ticks == 0).any()
    words = path.words().astype(np.float32).view(np.uint32)
    return np.concatenate([words, counts.view(np.uint32)], axis=1), single


def parameter_words(robot):
    """The parameter block of a robot."""
    return np.concatenate(list(float32.Constants(robot).block().values()))


def assert_same_words(single, exported, outputs):
    """Rows of the C program against the model's."""
    for names, values in ((EXPORTED, exported), (OUTPUTS, outputs)):
        for name, ours in zip(names, values.T, strict=True):
            theirs = single.row(name)
            # the sine of a C library may be off by its last bit
            limit = 4.0 * np.spacing(np.abs(theirs).max()) if name == "tau4" else 0.0
            assert np.abs(ours - theirs).max() <= limit, name


@needs("qemu", "nios-gcc")
@pytest.mark.full
def test_law_in_soft_float_under_qemu_gives_the_words_of_the_float32_model(robot, tmp_path):
    data, single = words_of_ticks(robot, 2_000)
    program = tmp_path / "build/tracking_check.elf"
    build(str(program), tmp_path / "build", toolchain())
    (tmp_path / "tracking.in").write_bytes(parameter_words(robot).tobytes() + data.tobytes())
    options = "-M nios2-generic-nommu -display none -monitor none -serial none -semihosting".split()
    command = [find("qemu"), *options, "-kernel", program]
    output(*command, cwd=tmp_path, stdin=subprocess.DEVNULL, timeout=300)
    rows = np.frombuffer((tmp_path / "tracking.out").read_bytes(), np.float32).reshape(-1, 14)
    assert len(rows) == len(data)
    assert_same_words(single, rows[:, :9], rows[:, 9:])


def run_law(law, robot, data):
    """Desired motion (N, 9) and outputs (N, 5) of the C law for words of ticks (N, 20)."""
    parameters = parameter_words(robot)
    (ctypes.c_float * len(parameters)).in_dll(law, "tracking_parameters")[:] = parameters.tolist()
    outputs = np.zeros((len(data), 5), np.float32)
    exported = np.zeros((len(data), len(EXPORTED)), np.float32)
    desired = np.ctypeslib.as_array((ctypes.c_float * 9).in_dll(law, "tracking_desired"))
    first, row, result = data.ctypes.data, data.strides[0], outputs.strides[0]
    law.tracking_start(ctypes.c_void_p(first))
    for tick in range(len(data)):
        law.tracking_tick(
            ctypes.c_void_p(first + tick * row),
            ctypes.c_void_p(outputs.ctypes.data + tick * result),
        )
        exported[tick] = desired
    return exported, outputs


def test_law_in_c_gives_the_words_of_the_float32_model_over_a_path_with_reversals(law, robot):
    data, single = words_of_ticks(robot, 2_000)
    assert_same_words(single, *run_law(law, robot, data))


@pytest.mark.parametrize("number", range(20))
def test_law_in_c_gives_the_words_of_the_float32_model_for_any_robot(law, robot, number):
    """Parameters act by their words alone; the boost ends at the same tick for every period."""
    other = any_robot(robot, SEED + number)
    data, single = words_of_ticks(other, 800)
    assert_same_words(single, *run_law(law, other, data))


def any_robot(robot, seed):
    """The robot with every parameter between 0.8 and 1.25 times its value, another period."""
    rng = np.random.default_rng(seed)
    changed = {
        name: value * rng.uniform(0.8, 1.25)
        for name, value in robot.values().items()
        if name != "xi_c"
    }
    changed["T_s"] = rng.choice([50e-6, 100e-6, 200e-6])
    changed["T_c"] = changed["T_s"] * rng.integers(50, 300)
    changed["z_max"] = changed["z_min"] + 0.5
    return dataclasses.replace(robot, **changed)


# ---------------------------------------------------------------------- sample
def test_sample_has_first_last_and_most_boosted_tick_once_each():
    boosted = np.zeros(10_000, int)
    boosted[4321] = 3
    windows = sampled(10_000, boosted, Sample(closed_loop=0, windows=5, window=100))
    ticks = [tick for window in windows for tick in window]
    assert {0, 4321, 9_999} <= set(ticks)
    assert len(ticks) == len(set(ticks)) == 600
    assert ticks == sorted(ticks)


def test_sample_of_a_short_path_is_the_whole_path():
    windows = sampled(70, np.zeros(70, int), Sample(closed_loop=0, windows=5, window=100))
    assert windows == [range(70)]
