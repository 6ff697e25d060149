# SPDX-License-Identifier: Apache-2.0
"""State of a program between two blocks: modes, position, coordinate systems and parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

from sim.motion.gcode import table_frame
from sim.motion.gcode.block import SYSTEMS
from sim.motion.gcode.compensation import Compensation
from sim.motion.gcode.errors import Mistakes
from sim.motion.gcode.expressions import Key, NoValueError
from sim.motion.gcode.tools import Tool
from sim.motion.gcode.words import Word
from sim.motion.geometry.moves import AXES, Plane, Pose, pose_of
from sim.motion.geometry.rotation import Rotation

# Parameters of the coordinate systems (LinuxCNC, "Numbered parameters"), in the order of AXES.
_AXIS_PARAMETER = (0, 1, 2, 3, 5)
_HOME, _G92_ACTIVE, _G92, _SYSTEM, _SYSTEM_1, _POSITION = 5161, 5210, 5211, 5220, 5221, 5420
_PROBED, _TOUCHED = 5061, 5070
_INPUT, _TOOL = 5399, 5400
_NAMED: dict[Key, int] = {f"_{letter}": _POSITION + n for n, letter in enumerate("xyzabcuvw")}
_ROTATION = 9  # its number after the first one of a coordinate system
_ZERO: Pose = (0.0,) * 5


@dataclass
class Modes:
    """What M70 saves: LinuxCNC's list where it has an effect here; the motion is not in it.

    tolerance and merge [mm], exact_stop, override: as of a Move; speed: S [1/min]; turning: M3,
    M4 or empty; per_turn: G95, F counts per turn of the spindle.
    """

    plane: Plane = Plane.XY
    mm_per_unit: float = 1.0
    incremental: bool = False
    absolute_centres: bool = False
    inverse_time: bool = False
    per_turn: bool = False
    diameter: bool = False
    feed: float | None = None  # the F number as programmed
    feed_mm_per_unit: float = 1.0
    tolerance: float = 0.0
    merge: float = 0.0
    exact_stop: bool = False
    override: bool = True
    speed: float = 0.0
    turning: str = ""
    retract_to_r: bool = True
    system_index: int = 0
    in_table_frame: bool = False
    tool_offset: Pose = _ZERO

    @property
    def rate(self) -> float:
        """The F number of a block that has one in force; under G95 that of a minute."""
        assert self.feed is not None
        return self.feed * self.speed if self.per_turn else self.feed


def _tens(code: str) -> float:
    """A G word as LinuxCNC's predefined parameters show it: 10 times its number."""
    return round(float(code[1:]) * 10)


PREDEFINED: dict[Key, Callable[[State], float]] = {
    "_task": lambda state: 0.0,  # 1 where LinuxCNC runs a machine, 0 where it plans or previews
    "_vmajor": lambda state: 2.9,
    "_vminor": lambda state: 0.0,
    "_metric_machine": lambda state: 1.0,
    "_plane": lambda state: _tens(state.modes.plane.value),
    "_metric": lambda state: state.modes.mm_per_unit == 1.0,
    "_imperial": lambda state: state.modes.mm_per_unit != 1.0,
    "_absolute": lambda state: not state.modes.incremental,
    "_incremental": lambda state: state.modes.incremental,
    "_inverse_time": lambda state: state.modes.inverse_time,
    "_units_per_minute": lambda state: not (state.modes.inverse_time or state.modes.per_turn),
    "_units_per_rev": lambda state: state.modes.per_turn,
    "_coord_system": lambda state: _tens(SYSTEMS[state.modes.system_index]),
    "_tool_offset": lambda state: any(state.modes.tool_offset),
    "_retract_r_plane": lambda state: state.modes.retract_to_r,
    "_retract_old_z": lambda state: not state.modes.retract_to_r,
    "_ijk_absolute_mode": lambda state: state.modes.absolute_centres,
    "_lathe_diameter_mode": lambda state: state.modes.diameter,
    "_lathe_radius_mode": lambda state: not state.modes.diameter,
    "_spindle_on": lambda state: bool(state.modes.turning),
    "_spindle_cw": lambda state: state.modes.turning == "M3",
    "_feed_override": lambda state: state.modes.override,
    "_rpm": lambda state: state.modes.speed,
    "_current_tool": lambda state: state.loaded,
    "_selected_tool": lambda state: state.chosen,
}
"""Parameters that show the state (LinuxCNC, "Predefined Named Parameters"), 1 for yes."""


def _parameters() -> dict[Key, float]:
    parameters: dict[Key, float] = {_G92_ACTIVE: 0.0, _SYSTEM: 1.0}
    for first in (_HOME, _G92, *(_SYSTEM_1 + 20 * n for n in range(9))):
        for number in range(10 if _SYSTEM_1 <= first else 9):
            parameters[first + number] = 0.0
    return parameters


@dataclass
class State:
    """position [mm, degree]: of the machine; pivot [mm]: of the table; tools: by number.

    compensation: from G41 or G42 to G40; position is then on the contour, not that of the tool.
    parameters: numbered ones, and names that begin with an underscore, which are known everywhere;
    names: others, of the subroutine that runs or of the main program. mistakes: of the text so far,
    and its line under work.
    """

    position: Pose
    pivot: table_frame.Point
    tools: dict[int, Tool]
    mistakes: Mistakes
    names: dict[Key, float] = field(default_factory=dict)
    modes: Modes = field(default_factory=Modes)
    motion: str | None = None
    sticky: dict[str, float] = field(default_factory=dict)  # numbers a cycle keeps, in mm and s
    initial_level: float = 0.0  # of a series of cycles
    chosen: int = 0  # tools, 0 for none
    loaded: int = 0
    system: Pose = _ZERO  # offset of the coordinate system
    rotation: Rotation = field(default_factory=Rotation)  # of the coordinate system
    shift: Pose = _ZERO  # of G92
    compensation: Compensation | None = None
    parameters: dict[Key, float] = field(default_factory=_parameters)

    def __post_init__(self) -> None:
        self._summed: tuple[tuple[Pose, ...], Pose] = ((), _ZERO)  # parts and sum of offset
        self.store_home()

    def report(self, word: Word, what: str, expected: str, help: str) -> None:
        """Takes a mistake, as WordReport."""
        self.mistakes.report(word.column, word.text, what, expected, help)

    @property
    def block(self) -> tuple[int, str]:
        """Number and text of the block under work."""
        return self.mistakes.line, self.mistakes.source.strip()

    # Saved modes

    def saved(self) -> Modes:
        """A copy of the modes (M70)."""
        return replace(self.modes)

    def restore(self, modes: Modes) -> None:
        """The modes as they were when they were saved (M72); their copy stays as it is."""
        self.modes = replace(modes)
        self.select_system(modes.system_index)

    # Parameters

    def read(self, key: Key) -> float | None:
        """Value of a parameter, of the position in the unit in force; None for a name without one.

        Raises NoValueError where the position is not known.
        """
        if isinstance(key, str):
            if key in PREDEFINED:
                return float(PREDEFINED[key](self))
            if key not in _NAMED:
                return self._of(key).get(key)
            key = _NAMED[key]
        if _TOOL <= key < _TOOL + 14:
            return self._of_the_tool(key - _TOOL)
        if not _POSITION <= key < _POSITION + 9:
            return self.parameters.get(key, 0.0)
        if key - _POSITION not in _AXIS_PARAMETER:
            return 0.0
        if self.compensation is not None:
            raise NoValueError(
                f"the position #{key} is not known during cutter compensation",
                "a read before G41 or G42, or after G40",
                "keep the number in a parameter of your own",
            )
        index = _AXIS_PARAMETER.index(key - _POSITION)
        value = self.programmed()[index]
        return value / (self.modes.mm_per_unit if index < 3 else 1.0)

    def _of_the_tool(self, number: int) -> float:
        """Parameters #5400 to #5413 of the tool in the spindle: number, offsets, diameter, Q."""
        tool = self.tools.get(self.loaded, Tool())
        if 1 <= number <= 9:
            at = number - 1
            return tool.offset[_AXIS_PARAMETER.index(at)] if at in _AXIS_PARAMETER else 0.0
        others = {0: self.loaded, 10: tool.diameter, 13: tool.orientation}
        return float(others.get(number, 0))

    def write(self, key: Key, value: float) -> None:
        """Set a number or name."""
        self._of(key)[key] = value

    def _of(self, key: Key) -> dict[Key, float]:
        own = isinstance(key, str) and not key.startswith("_")
        return self.names if own else self.parameters

    @staticmethod
    def is_read_only(key: Key) -> bool:
        """Whether a parameter shows the state and cannot be set: position, system, tool, modes."""
        if isinstance(key, str):
            return key in _NAMED or key in PREDEFINED
        return key == _SYSTEM or _POSITION <= key < _POSITION + 9 or _TOOL <= key < _TOOL + 14

    def _store(self, first: int, pose: Pose) -> None:
        for offset, value in zip(_AXIS_PARAMETER, pose, strict=True):
            self.parameters[first + offset] = value

    def _stored(self, first: int) -> Pose:
        return pose_of(self.parameters[first + offset] for offset in _AXIS_PARAMETER)

    # Coordinates

    @property
    def offset(self) -> Pose:
        """Of programmed coordinates without a rotation: coordinate system, G92 and tool."""
        parts = self.system, self.shift, self.modes.tool_offset
        if self._summed[0] != parts:
            total = pose_of(s + g + t for s, g, t in zip(*parts, strict=True))
            self._summed = parts, total
        return self._summed[1]

    def programmed(self) -> Pose:
        """The position in the coordinates of the program [mm, degree]."""
        return self.of_frame(self.frame_position())

    def frame_position(self) -> Pose:
        """The position in the frame that the offsets count in: the machine's, or the table's."""
        if self.modes.in_table_frame:
            return table_frame.from_machine(self.position, self.pivot)
        return self.position

    def of_frame(self, frame: Sequence[float]) -> Pose:
        """Programmed coordinates of a point of the frame."""
        if not self.rotation:
            return pose_of(p - o for p, o in zip(frame, self.offset, strict=True))
        parts = zip(frame, self.system, self.modes.tool_offset, strict=True)
        turned = self.rotation.turned_back([p - s - t for p, s, t in parts])
        return pose_of(p - g for p, g in zip(turned, self.shift, strict=True))

    def in_frame(self, programmed: Sequence[float]) -> Pose:
        """Coordinates in the frame of a programmed point."""
        if not self.rotation:
            return pose_of(p + o for p, o in zip(programmed, self.offset, strict=True))
        turned = self.rotation.turned([p + g for p, g in zip(programmed, self.shift, strict=True)])
        parts = zip(turned, self.system, self.modes.tool_offset, strict=True)
        return pose_of(p + s + t for p, s, t in parts)

    def end_in_frame(self, programmed: Sequence[float]) -> Pose:
        """As `in_frame`; axes that do not move have their present coordinate to the last bit."""
        end, here, at = self.in_frame(programmed), self.programmed(), self.frame_position()
        stays = [p == h for p, h in zip(programmed, here, strict=True)]
        if self.rotation:
            stays[:2] = [stays[0] and stays[1]] * 2
        return pose_of(a if stay else e for e, a, stay in zip(end, at, stays, strict=True))

    def machine(self, programmed: Sequence[float]) -> Pose:
        """Machine pose of a point in the coordinates of the program."""
        frame = self.in_frame(programmed)
        return table_frame.to_machine(frame, self.pivot) if self.modes.in_table_frame else frame

    def axis_values(self, values: dict[str, Word]) -> list[tuple[int, float]]:
        """Axis words of a block as (index in AXES, value [mm, degree])."""
        scale = self.modes.mm_per_unit
        return [
            (index, values[letter].value * (scale if index < 3 else 1.0))
            for index, letter in enumerate(AXES)
            if letter in values
        ]

    @property
    def home(self) -> Pose:
        """Machine pose that G28 goes to."""
        return self._stored(_HOME)

    def store_home(self) -> None:
        """G28.1: the position is the pose that G28 goes to."""
        self._store(_HOME, self.position)

    def store_probed(self) -> None:
        """A probing move has ended at its end: nothing touched the probe on the way (#5070)."""
        for index, value in enumerate(self.programmed()):
            scale = self.modes.mm_per_unit if index < 3 else 1.0
            self.parameters[_PROBED + _AXIS_PARAMETER[index]] = value / scale
        self.parameters[_TOUCHED] = 0.0

    def store_input(self) -> None:
        """M66 has read an input: there is none, and 0 is what an open one reads (#5399)."""
        self.parameters[_INPUT] = 0.0

    def select_system(self, index: int) -> None:
        """G54 to G59.3, index from 0."""
        self.modes.system_index = index
        self.parameters[_SYSTEM] = float(index + 1)
        self.system = self._stored(_SYSTEM_1 + 20 * index)
        self.rotation = self._rotation_of(index)

    def _rotation_of(self, index: int) -> Rotation:
        return Rotation(self.parameters[_SYSTEM_1 + 20 * index + _ROTATION])

    def set_data(self, word: Word, values: dict[str, Word]) -> None:
        """G10 L1, L10 or L11 (tools), L2 or L20 (coordinate systems), as `word`."""
        kind, number = values.get("L"), values.get("P")
        if kind is None or kind.value not in (1.0, 2.0, 10.0, 11.0, 20.0):
            self.report(
                kind or word,
                "G10 without a known L",
                "L2 (offsets), L20 (coordinates of the position), or L1, L10, L11 (a tool)",
                "write for instance G10 L2 P1 X10",
            )
        elif kind.value in (2.0, 20.0):
            self._set_system(kind, number, values)
        else:
            self._set_tool(kind, number, values)

    def _set_system(self, kind: Word, number: Word | None, values: dict[str, Word]) -> None:
        if number is None or number.value not in range(10):
            self.report(
                number or kind,
                "G10 without a coordinate system",
                "P1 to P9 for G54 to G59.3, P0 for the present one",
                "write for instance G10 L2 P1 X10",
            )
            return
        present = self.modes.system_index
        index = int(number.value) - 1 if number.value else present
        first = _SYSTEM_1 + 20 * index
        if kind.value == 2.0:
            offsets = list(self._stored(first))
            for axis, value in self.axis_values(values):
                offsets[axis] = value
            if "R" in values:
                self.parameters[first + _ROTATION] = values["R"].value
        else:
            offsets = self._calculated(index, values)
        self._store(first, pose_of(offsets))
        if index == present:
            self.select_system(index)

    def _set_tool(self, kind: Word, number: Word | None, values: dict[str, Word]) -> None:
        """Offsets of a tool: those of the words (L1), or those with which the position has the
        coordinates of the words, in the present system (L10) or in G59.3 without G92 (L11). They
        act from the next G43 on."""
        tool = self.tools.get(int(number.value)) if number and number.value.is_integer() else None
        if tool is None or number is None:
            self.report(
                number or kind,
                "G10 without a tool",
                f"P with a tool of the table, which has {len(self.tools)}",
                "write for instance G10 L1 P1 Z12.5, and give the tool table",
            )
            return
        given = dict(self.axis_values(values))
        offset = list(tool.offset)
        if kind.value == 1.0:
            for axis, value in given.items():
                offset[axis] = value
        else:
            index = 8 if kind.value == 11.0 else self.modes.system_index
            shift = _ZERO if kind.value == 11.0 else self.shift
            rotation, system = self._rotation_of(index), self._stored(_SYSTEM_1 + 20 * index)
            place = [p - s for p, s in zip(self.frame_position(), system, strict=True)]
            here, wanted = rotation.turned_back(place), [*rotation.turned_back(offset)]
            for axis, value in given.items():
                wanted[axis] = here[axis] - shift[axis] - value
            turned = rotation.turned(wanted)
            for axis in range(len(AXES)):
                both = bool(rotation) and axis < 2 and (0 in given or 1 in given)
                if axis in given or both:
                    offset[axis] = turned[axis]
        changed = replace(tool, offset=pose_of(offset))
        if "R" in values:
            changed = replace(changed, diameter=2 * values["R"].value * self.modes.mm_per_unit)
        if "Q" in values:
            if values["Q"].value not in range(10):
                self.report(
                    values["Q"], "the orientation of a lathe tool", "Q from 0 to 9", "write Q0"
                )
                return
            changed = replace(changed, orientation=int(values["Q"].value))
        if not given and not {"R", "Q"} & values.keys():
            self.report(
                kind,
                f"G10 {kind.text.upper()} without a number of the tool",
                "X Y Z A C, R (radius) or Q (orientation)",
                "write for instance G10 L1 P1 Z12.5",
            )
        self.tools[int(number.value)] = changed

    def _calculated(self, index: int, values: dict[str, Word]) -> list[float]:
        """Offsets of a system with which the position has the coordinates of the words (L20)."""
        offsets = list(self._stored(_SYSTEM_1 + 20 * index))
        rotation, given = self._rotation_of(index), dict(self.axis_values(values))
        parts = zip(self.frame_position(), self.modes.tool_offset, strict=True)
        place = [p - t for p, t in parts]
        wanted = [*rotation.turned_back([p - o for p, o in zip(place, offsets, strict=True)])]
        for axis, value in given.items():
            wanted[axis] = value + self.shift[axis]
        turned = rotation.turned(wanted)
        for axis in range(len(AXES)):
            both = bool(rotation) and axis < 2 and (0 in given or 1 in given)
            if axis in given or both:
                offsets[axis] = place[axis] - turned[axis]
        return offsets

    def set_shift(self, word: Word, values: dict[str, Word]) -> None:
        """G52, or G92 to G92.3, as `word`."""
        if word.code in ("G52", "G92"):
            here, shift = self.programmed(), list(self.shift)
            given = self.axis_values(values)
            if not given:
                self.report(
                    word,
                    f"{word.code} without axis words",
                    "the offset of the axes"
                    if word.code == "G52"
                    else "the coordinates that the position shall have",
                    f"write for instance {word.code} X0",
                )
            for axis, value in given:
                shift[axis] = value if word.code == "G52" else shift[axis] + here[axis] - value
            self.shift = pose_of(shift)
            self._store(_G92, self.shift)
            self.parameters[_G92_ACTIVE] = 1.0
        elif word.code == "G92.3":
            self.shift = self._stored(_G92)
            self.parameters[_G92_ACTIVE] = 1.0
        else:
            self.shift = _ZERO
            self.parameters[_G92_ACTIVE] = 0.0
            if word.code == "G92.1":
                self._store(_G92, self.shift)
