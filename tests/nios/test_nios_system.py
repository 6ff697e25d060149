# SPDX-License-Identifier: Apache-2.0
"""The Nios II systems as RTL: tracking program, C programs against this machine, timer, host."""

from __future__ import annotations

import os
import re
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from sim.bench.run.nios import NiosController
from sim.core.controller import EXPORTED, LawTicks
from sim.robot import float32
from sim.robot.published import Published
from sim.robot.records import OUTPUTS, TrackingResult
from sim.rtl.build import WAIVERS, verilator_driver
from sim.rtl.nios_dhrystone import measure
from sim.rtl.nios_image import IMAGES, Program, load, read_elf
from sim.rtl.nios_profile import profile
from sim.rtl.nios_rtl import FILES, PLATFORMS, NiosError, NiosRtl
from sim.rtl.sources import sources_of
from tests.asip.tracking_path import reversing_path
from tests.bench.commands import output

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "nios_sw/tests"
PROGRAMS = sorted(path.stem for path in (IMAGES / "tests").glob("*.elf"))
LIMIT = 2_000_000
BREAK_1 = 0x003DA07A  # the instruction that ends a program under a debugger


# ---------------------------------------------------------------------- RTL files
def test_file_list_is_exactly_what_the_system_needs():
    listed = (ROOT / "rtl" / FILES).read_text().split()
    needed = {str(path.relative_to(ROOT)) for path in sources_of("n2_system")}
    assert sorted(set(listed) ^ needed) == []
    assert len(listed) == len(needed)


@pytest.mark.parametrize("platform", PLATFORMS.values())
def test_system_elaborates_without_a_warning(platform):
    files = (ROOT / "rtl" / FILES).read_text().split()
    options = ["--lint-only", "-Wall", "--quiet", "--top-module", "n2_system"]
    options += [f"-GPlatform={platform}", WAIVERS]
    output(verilator_driver(), *options, *files, cwd=ROOT)


def test_fork__forgets_the_model_and_does_not_wait_for_its_threads():
    model = NiosRtl("fpga1")
    model.start()
    model.clock(100)
    time.sleep(0.5)  # its threads wait for work
    child = os.fork()
    if child == 0:
        status = 1
        try:
            model.close()
            status = 0
        finally:
            os._exit(status)  # never back into pytest
    end = time.monotonic() + 30
    while (ended := os.waitpid(child, os.WNOHANG)) == (0, 0) and time.monotonic() < end:
        time.sleep(0.05)
    if ended == (0, 0):
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    assert ended == (child, 0), "the copy of the process waits"
    model.clock(100)
    model.close()


# ---------------------------------------------------------------------- tracking program
@pytest.fixture(scope="module")
def track(robot):
    """A path with reversals, counts near it, and the float32 model on them."""
    path, counts = reversing_path(robot, 600)
    return robot, path, counts, float32.run(robot, path, counts)


def check_words(
    result: LawTicks, single: TrackingResult, start: int, limit: NDArray[np.floating]
) -> None:
    """Ticks from `start` on are those of the float32 model. Raises AssertionError.

    limit: of tau4 in each tick [N m]; every other word is equal.
    """
    ticks = slice(start, start + len(result.outputs))
    for names, values in ((EXPORTED, result.exported), (OUTPUTS, result.outputs)):
        for name, ours in zip(names, values.T, strict=True):
            theirs = single.row(name)[ticks]
            most = limit if name == "tau4" else 0.0
            different = np.flatnonzero(~(np.abs(ours - theirs) <= most))  # NaN too
            assert different.size == 0, f"{name} at tick {start + different[0]}"


@pytest.mark.parametrize(("platform", "ticks"), [("fpga1", 40), ("fpga2", 200)])
def test_tracking_program_gives_the_words_of_the_float32_model(track, platform, ticks):
    robot, path, counts, single = track
    boosted = (single.ticks > 0) & (single.ticks < robot.boost_ticks)
    middle = max(int(np.argmax(boosted.sum(axis=1))), ticks)
    controller = NiosController(platform, robot)
    words = path.words()
    controller.prime(words[0], counts[0])
    for start in (0, middle - ticks // 2, 600 - ticks):
        if start:
            controller.preset(single, start - 1)
        chunk = slice(start, start + ticks)
        result = controller.batch(words[chunk], counts[chunk])
        # both sines are right except for their last bit, so here the torque's sum is within two
        limit = 2.0 * np.spacing(np.abs(single.row("tau4")[chunk]))
        check_words(result, single, start, limit)
        assert result.cycles.max() < Published.load().time[platform.upper()]["cycles"]
    assert not controller.core.overrun


def ticks_of(track, platform: str, image: str, chunk: slice) -> LawTicks:
    """Some ticks of the path by a program, from the states of the float32 model on."""
    robot, path, counts, single = track
    words = path.words()
    controller = NiosController(platform, robot, load(image))
    controller.prime(words[0], counts[0])
    controller.preset(single, chunk.start - 1)
    return controller.batch(words[chunk], counts[chunk])


def test_shared_subexpressions_change_no_word_and_save_time(track):
    images = ("tracking_fpga2", "tracking_shared_fpga2")
    printed, shared = (ticks_of(track, "fpga2", image, slice(500, 540)) for image in images)
    assert np.array_equal(printed.outputs, shared.outputs)
    assert np.array_equal(printed.exported, shared.exported)
    assert shared.cycles.max() < printed.cycles.min()


def longest_tick(track, platform: str, image: str) -> int:
    """Cycles of the longest of some ticks; the forces must be those of the float32 model."""
    chunk = slice(500, 505)
    result = ticks_of(track, platform, image, chunk)
    for name, ours in zip(OUTPUTS[:3], result.outputs.T, strict=False):
        assert np.array_equal(ours, track[3].row(name)[chunk]), name
    return int(result.cycles.max())


def test_published_time_of_fpga1_lies_between_two_builds(track):
    """As docs/nios_systems.md says."""
    published = Published.load().time["FPGA1"]["cycles"]
    assert longest_tick(track, "fpga1", "tracking_fpga1") < published
    assert longest_tick(track, "fpga1", "tracking_unoptimised_fpga1") < published
    assert longest_tick(track, "fpga1", "tracking_double_fpga1") > published


def test_square_roots_in_the_c_library_cost_fpga2_hundreds_of_cycles_each(track):
    own = longest_tick(track, "fpga2", "tracking_fpga2")
    library = longest_tick(track, "fpga2", "tracking_soft_sqrt_fpga2")
    assert library - own > 13 * 200


def test_profile_accounts_for_every_cycle_of_the_ticks(track):
    robot, path, counts, _ = track
    controller = NiosController("fpga2", robot)
    words = path.words()
    controller.prime(words[0], counts[0])
    controller.core.profile()
    cycles = controller.batch(words[:20], counts[:20]).cycles
    result = profile(controller.core, controller.program, 20, float(cycles.mean()))
    for lines in (result.functions, result.kinds):
        # an instruction on the border of a tick belongs to it or not
        assert sum(line.cycles for line in lines) == pytest.approx(cycles.mean(), abs=10)
    kinds = {line.name: line.instructions for line in result.kinds}
    assert (kinds["custom fsqrt"], kinds["custom fsin"], kinds["custom floatis"]) == (13, 1, 5)


# ---------------------------------------------------------------------- C programs
@pytest.fixture(scope="module")
def host_digests(tmp_path_factory):
    """Digest of each test program by this machine's compiler and C library."""
    compiler = [os.environ.get("CC", "gcc"), "-std=c11", "-O1", "-ffp-contract=off", f"-I{TESTS}"]
    folder = tmp_path_factory.mktemp("host")
    digests = {}
    for name in PROGRAMS:
        program = folder / name
        output(*compiler, TESTS / f"{name}.c", TESTS / "runner.c", "-lm", "-o", program)
        digests[name] = int(output(program), 16)
    return digests


def test_every_c_test_has_its_image():
    sources = {path.stem for path in TESTS.glob("*.c")} - {"runner"}
    assert sorted(sources) == PROGRAMS
    assert len(PROGRAMS) >= 30


def test_c_programs_compute_what_this_machine_computes(host_digests):
    core = NiosRtl("fpga2")
    wrong = {}
    for name in PROGRAMS:
        core.load(read_elf(IMAGES / "tests" / f"{name}.elf"))
        core.start()
        digest = core.execute(LIMIT)
        if digest != host_digests[name]:
            wrong[name] = f"{digest:08x}, must be {host_digests[name]:08x}"
    assert wrong == {}


def test_dhrystone_ends_with_the_right_values():
    result = measure("fpga2")
    assert result.runs > 0
    assert 1.1 <= result.dmips_per_mhz < 2.0  # the goal; a plausible single-issue processor


def test_dhrystone_says_how_it_was_compiled():
    """What the committed image prints is what the makefile says and the rules ask for."""
    result = measure("fpga1")
    makefile = (ROOT / "nios_sw/Makefile").read_text().replace("\\\n", " ")
    said = dict(re.findall(r"^(MACHINE|CODE|PLAIN) := (.*)$", makefile, re.MULTILINE))
    said["CODE"] = said["CODE"].replace("$(MACHINE)", said["MACHINE"])
    assert result.options.split() == f"{said['CODE']} {said['PLAIN']}".split()
    assert "-fno-inline" in result.options.split()
    assert "-flto" not in result.options.split()


@pytest.mark.parametrize("phase", range(5))
def test_second_program_on_the_same_model_runs_to_its_own_end(phase):
    """The first one ends again and again, up to the reset: `break 1` in the vector of break."""
    core = NiosRtl("fpga2")
    ends = Program("ends", {"itcm": (BREAK_1,) * 16, "dtcm": ()}, core.map.reset_vector, {})
    core.load(ends)
    core.start()
    core.execute(LIMIT)
    core.clock(phase)
    core.load(load("demo_timer_fpga2"))
    core.start()
    before = core.cycles
    assert core.execute(LIMIT) == 0
    assert core.cycles - before > 1000
    assert "interrupts every " in core.console


# ---------------------------------------------------------------------- timer and host port
def test_timer_interrupts_and_ticks():
    core = NiosRtl("fpga2")
    core.load(load("demo_timer_fpga2"))
    core.start()
    assert core.execute(200_000) == 0, core.console
    assert core.console.startswith("interrupts every ")


def test_tick_while_one_is_pending_is_an_overrun(robot):
    core = NiosController("fpga2", robot).core
    core.start(enable=True)
    core.clock(5_000)
    core.tick()
    core.clock(100)
    assert not core.overrun
    core.tick()
    core.clock(2)
    assert core.overrun


def test_program_that_never_ends_is_reported(robot):
    core = NiosController("fpga2", robot).core
    core.start()
    with pytest.raises(NiosError, match="tracking_fpga2 did not end within 1000 cycles"):
        core.execute(1_000)
    # without the host's wish for control the program does not answer ticks
    with pytest.raises(NiosError, match="fpga2: tick 0 of 1 did not end"):
        core.ticks(np.zeros((1, 20), np.uint32))
    with pytest.raises(ValueError, match="19 input words, must be 20"):
        core.ticks(np.zeros((1, 19), np.uint32))


def test_program_ends_when_the_host_takes_control_away(robot):
    core = NiosController("fpga2", robot).core
    core.start(enable=True)
    core.clock(5_000)
    core.start(enable=False)
    assert core.execute(1_000) == 0


def test_tracking_program_without_a_robot_refuses_to_run():
    core = NiosRtl("fpga2")
    core.load(load("tracking_fpga2"))
    core.start(enable=True)
    assert core.execute(20_000) == 1
    assert core.console == "no robot in tracking_parameters: write it before the start\n"


def test_host_reads_what_it_wrote_to_both_memories():
    core = NiosRtl("fpga2")
    words = np.random.default_rng(1).integers(0, 2**32, 16, dtype=np.uint32)
    for memory in core.map.memories.values():
        last = memory.base + 4 * (memory.words - len(words))
        core.write(memory.base, words)
        core.write(last, words[::-1])
        assert core.read(memory.base, 16).tolist() == words.tolist()
        assert core.read(last, 16).tolist() == words[::-1].tolist()
