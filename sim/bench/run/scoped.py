# SPDX-License-Identifier: Apache-2.0
"""The closed loop of the robot as a source of asip-scope: its channels, its gains, its tap."""

from __future__ import annotations

import dataclasses
import functools
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.assemble import assemble
from asip_asm.image import ConstantEntry, Image
from sim.core.backends import number
from sim.core.closed_loop import Machine
from sim.core.controller import EXPORTED, AsipController
from sim.debug.scope.source import (
    CYCLES,
    VERSION,
    Channel,
    Description,
    Gain,
    Scene,
    SourceError,
    StepInput,
    checked,
)
from sim.debug.scope.tap import Place, Tap, Tuned
from sim.motion.geometry.workspace import pivot_of
from sim.report.curves import envelope
from sim.robot.parameters import ParameterError, Robot
from sim.robot.records import COUNTS, OUTPUTS, SET_POINTS, TRACKING, SetPoints

# Parameters of the robot's file that its controller knows, and that words of bank K follow.
TUNABLE = (
    *("f_legs", "f_table", "s_max_legs", "s_max_table", "xi_c", "e_c_legs", "e_c_table"),
    *("F_max", "tau_max_4", "tau_max_5"),
    *("m_p", "m_s", "J_a", "l_c", "mr_c", "J_44", "J_55", "m_4", "r_4"),
)
TOOL = ("tool_x", "tool_y", "tool_z")
TABLE = ("table_alpha", "table_gamma")
DEVIATIONS = {"dev_x": "x", "dev_y": "y", "dev_z": "z", "dev_alpha": "alpha", "dev_gamma": "gamma"}
STEPS = {"x": 50e-6, "y": 50e-6, "z": 50e-6, "alpha": 2e-3, "gamma": 2e-3}  # m, rad
SHOWN = ["dev_x", "dev_y", "dev_z", "dev_alpha", "dev_gamma", *OUTPUTS]
PATH_POINTS = 1500
_IDENTIFIER = re.compile(r"[A-Za-z_]\w*")


def watched(image: Image) -> list[str]:
    """States and exports that the tap reads besides what the main job reads."""
    exports = [e.name for e in image.exports if not e.register.startswith("k")]
    states = [state.name for state in image.states if state.type == "float"]
    return [name for name in (*states, *exports) if name not in EXPORTED.values()]


def channels(image: Image) -> list[Channel]:
    """Of a row: the program's signals in the order of `LoopTap.done`, then the plant's."""
    about = {signal.name: signal for signal in TRACKING.signals}

    def of(names: tuple[str, ...] | list[str], group: str) -> list[Channel]:
        signals = [(name, about.get(name)) for name in names]
        return [
            Channel(name, s.unit if s else "", group, s.meaning if s else "") for name, s in signals
        ]

    counts = [Channel(name, "count", "encoders", "as the program gets it") for name in COUNTS]
    return [
        *of(SET_POINTS, "set-points"),
        *counts,
        *of(OUTPUTS, "outputs"),
        *of(tuple(EXPORTED.values()), "exports"),
        *of(watched(image), "states"),
        *(Channel(name, "m", "machine", "exact place of the tool") for name in TOOL),
        *(Channel(name, "rad", "machine", "exact angle of the table") for name in TABLE),
        *(
            Channel(name, about[of].unit, "deviation", f"{of}: where it is less where the path is")
            for name, of in DEVIATIONS.items()
        ),
        Channel(CYCLES, "1", "core", "clock cycles of the tick"),
        Channel(VERSION, "1", "core", "version of the gains that the tick used"),
    ]


class RobotTuner:
    """Words of bank K of a tracking program for other parameters and constants.

    The program is assembled again with the parameters; only words of bank K may differ.
    """

    def __init__(self, robot: Robot, source: Path, image: Image) -> None:
        self._robot, self._source, self._image = robot, source, image
        self._parameters: dict[str, float] = {}
        self._constants: dict[str, float] = {}

    def gains(self, meanings: Mapping[str, str]) -> list[Gain]:
        """What can be changed, with the values that the program has now."""
        units = {f.name: f.metadata["unit"] for f in dataclasses.fields(Robot)}
        found = [
            Gain(name, units[name], getattr(self._robot, name), "parameter", meanings[name])
            for name in TUNABLE
        ]
        for entry in self._named(self._image):
            value = number(int(entry.bits, 16), entry.type)
            found.append(Gain(entry.name, "", value, "constant", f"word k{entry.index}"))
        return found

    def tuned(self, values: Mapping[str, float]) -> Tuned:
        """Raises SourceError."""
        return self._tuned(*self._merged(values))

    def commit(self, values: Mapping[str, float]) -> Tuned:
        """Raises SourceError."""
        self._parameters, self._constants = self._merged(values)
        return self._tuned(self._parameters, self._constants)

    def _named(self, image: Image) -> list[ConstantEntry]:
        """Constants with a name of their own and a word of their own."""
        places = [entry.index for entry in image.constants]
        parameters = self._robot.values()
        return [
            entry
            for entry in image.constants
            if _IDENTIFIER.fullmatch(entry.name)
            and entry.name not in parameters
            and entry.type == "float"
            and places.count(entry.index) == 1
        ]

    def _merged(self, values: Mapping[str, float]) -> tuple[dict[str, float], dict[str, float]]:
        """Parameters and constants changed so far. A parameter that moves a constant takes it back
        from an earlier change of that constant alone."""
        parameters = self._parameters | {n: v for n, v in values.items() if n in TUNABLE}
        before, after = (self._bits(changed) for changed in (self._parameters, parameters))
        constants = {n: v for n, v in self._constants.items() if before[n] == after[n]}
        return parameters, constants | {n: v for n, v in values.items() if n not in TUNABLE}

    def _bits(self, parameters: Mapping[str, float]) -> dict[str, str]:
        image = self._assembled(parameters)
        return {entry.name: entry.bits for entry in self._named(image)}

    def _assembled(self, parameters: Mapping[str, float]) -> Image:
        if not parameters:
            return self._image
        return self._image_of(tuple(sorted(parameters.items())))

    @functools.lru_cache(maxsize=8)  # noqa: B019  one tuner a process
    def _image_of(self, parameters: tuple[tuple[str, float], ...]) -> Image:
        try:
            robot = dataclasses.replace(self._robot, **dict(parameters))
        except ParameterError as error:
            raise SourceError(str(error)) from None
        image = assemble(
            self._source, configuration=self._image.configuration, defines=robot.values()
        )
        shape, same = (
            (made.bundles, [entry.index for entry in made.constants])
            for made in (image, self._image)
        )
        if shape != same:
            names = ", ".join(f"{name} = {value:g}" for name, value in parameters)
            raise SourceError(
                f"with {names} the program itself is another one; put it into the robot's file and "
                "start again"
            )
        return image

    def _tuned(self, parameters: Mapping[str, float], constants: Mapping[str, float]) -> Tuned:
        image = self._assembled(parameters)
        words = {entry.index: int(entry.bits, 16) for entry in image.constants}
        places = {entry.name: entry.index for entry in self._named(image)}
        for name, value in constants.items():
            words[places[name]] = int(np.float32(checked(name, value)).view(np.uint32))
        values = {name: getattr(self._robot, name) for name in TUNABLE} | dict(parameters)
        values |= {name: number(words[k], "float") for name, k in places.items()}
        return Tuned(values, words)


def description(
    title: str, robot: Robot, robot_file: Path, path: SetPoints, image: Image, tuner: RobotTuner
) -> Description:
    """What the scope shows of a closed loop on a path."""
    tables = tomllib.loads(robot_file.read_text(encoding="utf-8"))
    meanings = {name: table["meaning"] for name, table in tables.items()}
    units = {signal.name: signal.unit for signal in TRACKING.inputs}
    kept = np.unique(np.concatenate([envelope(c, PATH_POINTS // 3) for c in path.position.T]))
    return Description(
        title=title,
        period=robot.T_s,
        channels=channels(image),
        shown=SHOWN,
        gains=tuner.gains(meanings),
        steps=[
            StepInput(name, units[name], deviation, STEPS[name])
            for deviation, name in DEVIATIONS.items()
        ],
        inputs=list(SET_POINTS),
        scene=Scene(
            legs=[[*leg, 0.0] for leg in robot.legs],
            tool=list(TOOL),
            path=path.position[kept].T.tolist(),
            pivot=[value / 1e3 for value in pivot_of(robot)],
            height=robot.h,
            table=list(TABLE),
        ),
        ticks=len(path),
    )


class LoopTap:
    """The tap of a closed loop; made where the loop runs, a `closed_loop.Tap`."""

    def __init__(self, place: Place, path: SetPoints, controller: AsipController) -> None:
        self._core, self._controller = controller.core, controller
        self._path = np.hstack([path.position, path.table_position])
        count = len(channels(controller.image))
        self.tap = Tap(place, count, self._write)
        self._taken: NDArray[np.floating] = np.zeros(len(SET_POINTS))

    def _write(self, words: Mapping[int, int]) -> None:
        for index, word in words.items():
            self._core.write(f"k{index}", word)

    def words(self, words: NDArray[np.floating]) -> NDArray[np.floating]:
        """Set-points (15,) with what the scope adds."""
        offsets, puts = self.tap.inputs()
        self._taken = words
        if offsets or puts:
            self._taken = words.copy()
            for name, value in offsets.items():
                self._taken[SET_POINTS.index(name)] += value
            for name, value in puts.items():
                self._taken[SET_POINTS.index(name)] = value
        return self._taken

    def done(self, tick: int, counts: NDArray[np.int32], plant: Machine) -> None:
        """A row of `channels`."""
        row, seen = self.tap.row, self._controller.seen
        behind = len(SET_POINTS) + len(COUNTS)
        row[: len(SET_POINTS)] = self._taken.astype(np.float32)
        row[len(SET_POINTS) : behind] = counts[: len(COUNTS)]
        row[behind : behind + len(seen)] = seen
        place = (*plant.tool, *plant.table)
        rest = row[behind + len(seen) :]
        rest[:5] = place
        rest[5:10] = place - self._path[tick]
        rest[10] = self._controller.cycles
        rest[11] = self.tap.version
        self.tap.done()

    def fault(self, tick: int, counts: NDArray[np.int32], plant: Machine) -> None:
        """The row of the tick that stopped, and why."""
        self.done(tick, counts, plant)
        self.tap.fault(self._controller.fault_text())

    def end(self) -> tuple[str, ...]:
        """No tick comes any more; what was done to the loop."""
        self.tap.end("the path is at its end")
        return tuple(self.tap.touched)
