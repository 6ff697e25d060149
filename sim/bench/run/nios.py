# SPDX-License-Identifier: Apache-2.0
"""The tracking program on the Nios II systems FPGA1 and FPGA2, measured next to the ASIP.

The systems take thousands of cycles per tick, so the main job runs a stated sample of the path: the
first and the last ticks, windows between them and one where most integrators are boosted. At the
start of a window the program gets the state that the float32 model (`sim.robot.float32`) has there,
whose formulas the program evaluates. Words are exchanged as raw binary32.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.bench.run import results
from sim.core import closed_loop
from sim.core.controller import EXPORTED, ControllerFault, LawTicks
from sim.motion.gcode.interpreter import parse_file
from sim.motion.trajectory.exact_stop import MotionSettings, generate
from sim.motion.trajectory.program import AGH, set_points
from sim.robot import float32
from sim.robot.errors import max_abs_error
from sim.robot.parameters import Robot
from sim.robot.records import OUTPUTS, Counts, Floats, SetPoints, TrackingResult
from sim.robot.tracking import joint_path
from sim.rtl.nios_image import Program, load
from sim.rtl.nios_map import default_system_map
from sim.rtl.nios_profile import Profile, profile
from sim.rtl.nios_rtl import NiosError, NiosRtl

AXES = 5
START_CYCLES = 20_000  # more than the program needs from reset to its first poll
CHUNK = 100  # ticks between two progress calls


@dataclass(frozen=True)
class Sample:
    """How many ticks of a path a platform takes: closed loop from the start, then windows."""

    closed_loop: int
    windows: int
    window: int


# About half a minute of simulation each on one processor.
SAMPLES = {"fpga1": Sample(1500, 12, 100), "fpga2": Sample(1500, 24, 400)}
# Images of other builds of the same source, per platform: key in results.json -> image.
VARIANTS = {
    "fpga1": {
        "shared_subexpressions": "tracking_shared_fpga1",
        "unoptimised": "tracking_unoptimised_fpga1",
        "double_library": "tracking_double_fpga1",
    },
    "fpga2": {
        "shared_subexpressions": "tracking_shared_fpga2",
        "software_square_root": "tracking_soft_sqrt_fpga2",
    },
}
VARIANT_TICKS = 100  # their ticks, where most axes are boosted


class NiosController:
    """One system with a tracking program for one robot, the interface of `AsipController`.

    program: by default the committed image; it holds no parameters, they are written here. Ticks
    are counted from 0 for messages. Raises ControllerFault.
    """

    def __init__(self, platform: str, robot: Robot, program: Program | None = None) -> None:
        self.core = NiosRtl(platform)
        self.program = program or load(f"tracking_{platform}")
        self.core.load(self.program)
        parameters = np.concatenate(list(float32.Constants(robot).block().values()))
        self.core.write(self.program.address("tracking_parameters"), parameters.view(np.uint32))
        self._input = self.core.map.base("inputs")
        self._state = self.program.address("tracking_state")
        desired = self.program.address("tracking_desired")
        self._exported = [desired + 4 * i for i in range(len(EXPORTED))]
        self.tick = 0

    def prime(self, words: Floats, counts: Counts) -> None:
        """Enable control with the first measurement as the last one."""
        self.core.write(self._input, _words(np.atleast_2d(words), np.atleast_2d(counts))[0])
        self.core.start(enable=True)
        self.core.clock(START_CYCLES)

    def preset(self, result: TrackingResult, tick: int) -> None:
        """Give the program the state after `tick` of a float32 run."""
        state = np.empty((AXES, 4), np.float32)
        state[:, 0] = result.position[tick]
        state[:, 1] = result.sign[tick]
        state[:, 2] = result.ticks[tick]
        state[:, 3] = result.s_c[tick]
        self.core.write(self._state, state.view(np.uint32).ravel())
        self.tick = tick + 1

    def step(self, words: Floats, counts: Counts) -> LawTicks:
        """One tick: 15 set-points (rounded to binary32 here) and five counts."""
        return self.batch(np.asarray(words)[np.newaxis], np.asarray(counts)[np.newaxis])

    def batch(self, words: NDArray[np.floating], counts: NDArray[np.integer]) -> LawTicks:
        """Consecutive ticks, words (N, 15) and counts (N, 5)."""
        try:
            result = self.core.ticks(_words(words, counts), self._exported)
        except NiosError as error:
            raise ControllerFault(f"after tick {self.tick}: {error}") from error
        self.tick += len(words)
        outputs, extra = result.outputs.view(np.float32), result.extra.view(np.float32)
        return LawTicks(outputs, extra, result.cycles)


def _words(words: NDArray[np.floating], counts: NDArray[np.integer]) -> NDArray[np.uint32]:
    return np.concatenate(
        [words.astype(np.float32).view(np.uint32), counts.astype(np.int32).view(np.uint32)], axis=1
    )


def profile_path(platform: str, program: Program, first: int, ticks: int) -> Profile:
    """Profile of `ticks` ticks of the path A-G-H from tick `first` >= 1 on, at ideal counts.

    Raises ValueError if the path is shorter, NiosError, BuildError.
    """
    robot = Robot.load()
    trajectory = generate(parse_file(AGH, robot=robot), MotionSettings(robot))
    n = first + ticks
    if n > len(trajectory.position):
        raise ValueError(f"the path has {len(trajectory.position)} ticks, {n} requested")
    path = set_points(trajectory, n)
    joints = joint_path(robot, path)[0]
    counts = np.floor(joints / np.array(robot.resolution) + 0.5).astype(np.int32)
    controller = NiosController(platform, robot, program)
    words = path.words()
    controller.prime(words[0], counts[0])
    controller.preset(float32.run(robot, path, counts), first - 1)
    controller.core.profile()
    result = controller.batch(words[first:], counts[first:])
    return profile(controller.core, program, ticks, float(result.cycles.mean()))


@dataclass(frozen=True)
class Beginning:
    """Closed loop over the first ticks of a path: largest tracking errors, cycles of every tick;
    simulated: clock cycles."""

    ticks: int
    tracking: closed_loop.Tracking
    cycles: NDArray[np.uint32]
    simulated: int


@dataclass(frozen=True)
class NiosRun:
    """Measurements of one platform on given counts. ticks: indices (N,) into the path; results at
    them; cycles of the other builds; simulated: clock cycles."""

    platform: str
    ticks: NDArray[np.int64]
    results: LawTicks
    variant_cycles: dict[str, NDArray[np.uint32]]
    simulated: int


def sampled(ticks: int, boosted: NDArray[np.integer], sample: Sample) -> list[range]:
    """Windows of a path of `ticks` ticks in ascending order, without overlap.

    boosted: number of boosted axes per tick; the window of its maximum is one of them.
    """
    length = min(sample.window, ticks)
    starts = np.linspace(0, ticks - length, sample.windows).round().astype(int).tolist()
    starts.append(min(max(int(np.argmax(boosted)) - length // 2, 0), ticks - length))
    return merged(range(start, start + length) for start in starts)


def merged(parts: Iterable[range]) -> list[range]:
    """Ranges in ascending order, those that meet or overlap as one, without empty ones."""
    found: list[range] = []
    for part in sorted(filter(len, parts), key=lambda part: part.start):
        if found and part.start <= found[-1].stop:
            found[-1] = range(found[-1].start, max(found[-1].stop, part.stop))
        else:
            found.append(part)
    return found


def _boosted(robot: Robot, single: TrackingResult) -> NDArray[np.integer]:
    return ((single.ticks > 0) & (single.ticks < robot.boost_ticks)).sum(axis=1)


def beginning_ticks(platform: str, ticks: int) -> int:
    """Ticks that `follow_beginning` takes of a path of so many."""
    return min(SAMPLES[platform].closed_loop, ticks)


def window_ticks(platform: str, ticks: int, full: bool) -> int:
    """Most ticks that `run` takes of a path of so many."""
    sample = SAMPLES[platform]
    return ticks if full else min((sample.windows + 1) * sample.window, ticks)


def follow_beginning(
    robot: Robot, path: SetPoints, platform: str, progress: Callable[[int], None]
) -> Beginning:
    """Closed loop over the first ticks. Raises ControllerFault, ImageError, BuildError."""
    part = SetPoints.from_words(path.words()[: beginning_ticks(platform, len(path))])
    controller = NiosController(platform, robot)
    recording = closed_loop.run(robot, part, controller, progress)
    tracking = closed_loop.tracking_error(robot, part, joint_path(robot, part)[0], recording)
    return Beginning(len(part), tracking, recording.ticks.cycles, controller.core.cycles)


def run(
    robot: Robot,
    path: SetPoints,
    counts: NDArray[np.int32],
    single: TrackingResult,
    platform: str,
    full: bool,
    progress: Callable[[int], None],
) -> NiosRun:
    """The sample of the ticks (full: every tick) on the given counts.

    single: the float32 run on `counts`. Raises ControllerFault, ImageError, BuildError.
    """
    sample = SAMPLES[platform]
    n = len(path)
    windows = [range(n)] if full else sampled(n, _boosted(robot, single), sample)
    words = path.words()
    controller = NiosController(platform, robot)
    controller.prime(words[0], counts[0])
    parts = []
    for window in windows:
        if window.start > 0:
            controller.preset(single, window.start - 1)
        for start in range(window.start, window.stop, CHUNK):
            chunk = slice(start, min(start + CHUNK, window.stop))
            parts.append(controller.batch(words[chunk], counts[chunk]))
            progress(chunk.stop - chunk.start)
    cycles = controller.core.cycles

    first = int(np.argmax(_boosted(robot, single))) - VARIANT_TICKS // 2
    first = max(min(first, n - VARIANT_TICKS), 1)
    chunk = slice(first, first + VARIANT_TICKS)
    variants = {}
    for name, image in VARIANTS[platform].items() if first < n else ():
        other = NiosController(platform, robot, load(image))
        other.prime(words[0], counts[0])
        other.preset(single, first - 1)
        variants[name] = other.batch(words[chunk], counts[chunk]).cycles
        cycles += other.core.cycles
    return NiosRun(
        platform,
        np.concatenate([np.arange(w.start, w.stop) for w in windows]),
        closed_loop.concatenate(parts),
        variants,
        cycles,
    )


def timing(cycles: NDArray[np.uint32]) -> dict[str, float]:
    """As that of the ASIP's programs, and the number of ticks."""
    return results.timing(cycles, default_system_map().clock_mhz) | {"ticks": len(cycles)}


def at(result: TrackingResult, ticks: NDArray[np.int64]) -> TrackingResult:
    """The given ticks of a result over a whole path."""
    return TrackingResult(
        **{name: np.asarray(value)[ticks] for name, value in vars(result).items()}
    )


def different_words(run: NiosRun, single: TrackingResult) -> dict[str, int]:
    """Row -> ticks whose word is not that of the float32 model, only rows with such ticks."""
    names = [*EXPORTED, *OUTPUTS]
    ours = np.concatenate([run.results.exported, run.results.outputs], axis=1).T
    found = {}
    for name, values in zip(names, ours, strict=True):
        wanted = np.ascontiguousarray(single.row(name)[run.ticks])
        different = int((np.ascontiguousarray(values) != wanted).sum())
        if different:
            found[name] = different
    return found


def torque_limit(
    single: TrackingResult, ticks: NDArray[np.integer] | slice
) -> NDArray[np.floating]:
    """What the last bit of the sine explains of a difference of tau4 [N m] to the float32 model.

    Two sines within an ulp give products within two spacings of the gravity torque, and one more
    rounding of the sum, which may be much smaller.
    """
    gravity, wanted = single.gravity[ticks, 3], single.row("tau4")[ticks]
    return 2.0 * np.spacing(np.abs(gravity)) + np.spacing(np.abs(wanted))


def torque_to_pc(run: NiosRun, single: TrackingResult) -> float:
    """Largest difference of tau4 to the float32 model over `torque_limit`."""
    off = np.abs(run.results.outputs[:, 3] - single.row("tau4")[run.ticks])
    return float(np.max(off / torque_limit(single, run.ticks)))


def add_results(
    data: dict[str, Any],
    runs: Sequence[tuple[Beginning, NiosRun]],
    path: SetPoints,
    reference: TrackingResult,
    single: TrackingResult,
) -> None:
    """Enter the measurements into the content of build/results.json."""
    data["nios"] = {}
    words = path.words()
    for beginning, run in runs:
        cycles = np.concatenate([beginning.cycles, run.results.cycles])
        data["platforms"][run.platform] = timing(cycles)
        sampled_path = SetPoints.from_words(words[run.ticks])
        errors = results.row_errors(at(reference, run.ticks), sampled_path, run.results)
        for row, error in errors.items():
            data["errors"][row][run.platform] = error
        same = max_abs_error(at(reference, run.ticks), at(single, run.ticks))
        data["nios"][run.platform] = {
            "closed_loop_ticks": beginning.ticks,
            "replayed_ticks": len(run.ticks),
            "tracking": vars(beginning.tracking),
            "pc_float32_same_ticks": same,
            "words_other_than_pc_float32": different_words(run, single),
            "tau4_to_pc_of_limit": torque_to_pc(run, single),
            "variants": {name: timing(found) for name, found in run.variant_cycles.items()},
        }
