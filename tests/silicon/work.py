# SPDX-License-Identifier: Apache-2.0
"""What a module does while its netlist is next to it: work that an existing test gives it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import pytest

from sim.bench.motion import show_path
from sim.bench.motion.step_stream import Steps
from sim.bench.run.nios import NiosController, torque_limit
from sim.bus.datagram import APRD, APWR, single
from sim.bus.device import DeviceRtl
from sim.bus.gen import esc_regmap
from sim.bus.line import Line
from sim.robot import float32
from sim.robot.parameters import Robot
from sim.robot.records import COUNTS, SET_POINTS
from sim.rtl.asip_rtl import HARNESS, AsipRtl
from sim.rtl.board.model import BOARDS, BoardRtl
from sim.rtl.build import build_library
from sim.rtl.custom_table import load as custom_instructions
from sim.rtl.nios_map import default_system_map
from sim.rtl.nios_rtl import PLATFORMS
from sim.rtl.sources import sources_of
from tests.asip.tracking_path import reversing_path
from tests.bench.seed import SEED
from tests.ethercat.test_frames import run_chains
from tests.motion.test_step_stream import SHORT
from tests.motion_rtl.test_path import run_commands
from tests.nios.test_nios_system import check_words
from tests.servo.test_chain import chain
from tests.silicon import ticks
from tests.silicon.lockstep import CLOCK, RESET
from tests.silicon.netlist import ROOT
from tests.silicon.test_board import AXES, connected, runs_as_the_core, stepped, turned

START_NS = 3_000_000  # until the program of the device runs
PATH_TICKS = 600  # of the reversing path: every part of the law acts


@dataclass(frozen=True)
class Work:
    """top: the module, in a model with these parameters; do: so much of the work.

    `do` raises AssertionError where the RTL does its work wrong. Outputs are compared at the rising
    edges of `clock` while `reset` is 1.
    """

    top: str
    do: Callable[[int], None]
    parameters: Mapping[str, int] = field(default_factory=dict)
    clock: str = CLOCK
    reset: str = RESET


def run_tests(*files: str, only: str = "", marks: str = "not full") -> None:
    """Tests of these files with these marks, `only` those of an expression of pytest.

    Raises AssertionError if one fails or there is none.
    """
    options = ["-q", "-s", "-x", "-n0", "-m", marks, "-p", "no:cacheprovider"]
    options += ["-k", only] if only else []
    done = pytest.main([*options, *(str(ROOT / "tests" / file) for file in files)])
    assert done == pytest.ExitCode.OK, "a test fails, or there is none"


def frames(count: int) -> None:
    """Tests of frames, disturbances and clocks, an interrupt, then so many chains of datagrams."""
    run_tests(*(f"ethercat/test_{name}.py" for name in ("frames", "disturbed", "clocks")))
    interrupt()
    run_chains(count, SEED)


def interrupt() -> None:
    """The master asks for a state, and the application hears it."""
    with Line() as line:
        line.write(esc_regmap.AL_EVENT_MASK, esc_regmap.AL_EVENT.word(al_control=1))
        asked = esc_regmap.AL_CONTROL.word(state=1).to_bytes(2, "little")
        line.exchange(single(APWR, 0, esc_regmap.AL_CONTROL.address, asked))


def control_periods(count: int) -> None:
    """Start-up of five drives and so many control periods of 12 500 clocks on a path."""
    machine, _ = chain(True, "tracking_optimised")
    machine.advance(count)
    machine.system.close()


def path_commands(count: int) -> None:
    """Tests of lines and arcs on the step lines, so many random commands, a G64 program.

    The program moves five axes by records, the commands by the interpolators.
    """
    run_tests("motion_rtl/test_path.py", only="not without_interpolators")
    run_commands(count, SEED)
    drawn = show_path.run(SHORT, Steps(leg=5e5))
    assert all(row.agrees for row in show_path.results(drawn))


def control_ticks(platform: str, count: int) -> None:
    """The tracking law in C on a system: so many ticks of a path with reversals."""
    robot = Robot.load()
    path, counts = reversing_path(robot, max(count, PATH_TICKS))
    controller = NiosController(platform, robot)
    words = path.words()
    controller.prime(words[0], counts[0])
    result = controller.batch(words[:count], counts[:count])
    single = float32.run(robot, path, counts)
    check_words(result, single, 0, torque_limit(single, slice(0, count)))
    controller.core.close()


def core_ticks(configuration: str, count: int, rtl: type[AsipRtl] = AsipRtl) -> None:
    """So many ticks of each tracking program on the core, of a path with reversals."""
    core = rtl(configuration)
    data = ticks.inputs(max(count, PATH_TICKS))[:count]
    for name in ticks.PROGRAMS:
        core.reset()
        image = ticks.program(name, configuration)
        core.load(image)
        reads = core.output_addresses([output.name for output in image.outputs])
        result = core.run(core.input_addresses([*SET_POINTS, *COUNTS]), data, reads)
        assert (result.fault, len(result.cycles)) == ("NONE", count)
        assert (result.cycles == image.cycles).all()
    core.close()


class De3Rtl(AsipRtl):
    """The board top of the DE3 with the bench of the core on its bus."""

    def _library(self, parameters: Mapping[str, int]) -> Path:
        files = [*sources_of("asip_de3"), Path(__file__).with_name("asip_on_de3.sv")]
        flags = ("--prefix", "Vasip")
        return build_library("asip_on_de3", files, HARNESS, parameters, model_flags=flags)


class PairRtl(AsipRtl):
    """The pair in lockstep with the bench of one core."""

    def _library(self, parameters: Mapping[str, int]) -> Path:
        top = "asip_lockstep"
        flags = ("--prefix", "Vasip")
        return build_library(top, sources_of(top), HARNESS, parameters, model_flags=flags)


def board_commands(name: str, count: int) -> None:
    """A program over the board's serial port, `count` turns of its last encoder, steps."""
    board, last = BoardRtl(name), AXES[name] - 1
    client = connected(board, BOARDS[name].divider)
    runs_as_the_core(board)
    client = connected(board, BOARDS[name].divider)
    assert turned(board, client, last, count) == [0] * last + [4 * count]
    assert stepped(board, client, last) == (10, 1 << last)
    board.close()


def device_ticks(count: int) -> None:
    """So many control ticks of the device, and one, each with a frame that reads its registers."""
    device = DeviceRtl()
    device.run(START_NS)
    device.take_machine()
    frame = single(APRD, 0, 0, bytes(64))
    for _ in range(count + 1):
        device.send(frame)
        device.tick()
    assert device.counts()["returned"] >= count
    device.close()


def core_parameters(platform: str) -> dict[str, int]:
    """Parameters of the core in a system as `NiosRtl` builds it."""
    system = default_system_map()
    code, data = system.memories["itcm"], system.memories["dtcm"]
    return {
        "ItcmBase": code.base,
        "ItcmBytes": 4 * code.words,
        "DtcmBase": data.base,
        "DtcmBytes": 4 * data.words,
        "ResetVector": system.reset_vector,
        "ExceptionVector": system.exception_vector,
        "BreakVector": system.exception_vector,
        "CiCombinational": custom_instructions()[platform].combinational,
        "Debug": 0,
        "Trace": 1,
    }


WORK = {
    "ethercat_slave": Work("ethercat_slave", frames),
    "drive_front_end": Work("drive_front_end", control_periods),
    "motion_front_end": Work("motion_front_end", path_commands, {"Interpolators": 1}),
    **{
        f"n2_core_{platform}": Work(
            "n2_core", partial(control_ticks, platform), core_parameters(platform)
        )
        for platform in PLATFORMS
    },
}


def tests_only(*files: str, only: str = "", marks: str = "not full") -> Callable[[int], None]:
    """Work that is the tests of some files, whatever the count."""
    return lambda _: run_tests(*files, only=only, marks=marks)


def _board(name: str) -> Work:
    pins = BOARDS[name]
    return Work(pins.module, partial(board_commands, name), {}, pins.clock, pins.reset)


SMALL = {"FmaPipes": 1, "Slots": 1}
OWN_SIZE = "not single_reads and not instant and not halves"  # tests with the default parameters
ON_ECPIX5 = partial(board_commands, "ecpix5")
# Work of each top that `microtick plain` writes, by its name; `asip_small` is another one.
PLAIN_WORK = {
    "asip": Work("asip", partial(core_ticks, "fast")),
    "asip_small": Work("asip", partial(core_ticks, "small"), SMALL),
    "asip_de3": Work(
        "asip_de3", partial(core_ticks, "fast", rtl=De3Rtl), {}, "OSC1_50", "BUTTON_N"
    ),
    "asip_ecp5": Work("asip_ecp5", ON_ECPIX5, {"PllFeedback": 1}, "osc_i", "button_ni"),
    **{work.top: work for work in map(_board, BOARDS)},
    "asip_lockstep": Work("asip_lockstep", partial(core_ticks, "fast", rtl=PairRtl)),
    "asip_axil": Work("asip_axil", tests_only("asip/test_axil.py", only="scenario and fast")),
    "motion_axil": Work("motion_axil", tests_only("motion_rtl/test_axil.py", marks="full")),
    "n2_core": WORK["n2_core_fpga2"],
    "n2_system": Work("n2_system", partial(control_ticks, "fpga2"), {"Platform": 2, "Trace": 1}),
    "dual_asip": Work("dual_asip", tests_only("dual/test_hand_over.py")),
    "debug_asip": Work("debug_asip", tests_only("debug/test_block.py", only="not small")),
    "drive_front_end": WORK["drive_front_end"],
    "ethercat_slave": WORK["ethercat_slave"],
    "mii_to_rgmii": Work("mii_to_rgmii", tests_only("ethercat/test_rgmii.py")),
    "ethercat_nios": Work("ethercat_nios", device_ticks),
    "drive_chain": Work("drive_chain", control_periods),
    "ssi_port": Work("ssi_port", tests_only("servo/test_ssi.py", only="port__line_breaks")),
    "endat_port": Work("endat_port", tests_only("servo/test_endat.py", only="port__frames")),
    "absolute_position": Work(
        "absolute_position", tests_only("servo/test_absolute_position.py", only="own_size")
    ),
    "sincos_position": Work(
        "sincos_position", tests_only("servo/test_sincos_position.py", only="own_size")
    ),
    "hall_decoder": Work("hall_decoder", tests_only("servo/test_hall_decoder.py", only="own_size")),
    "biss_port": Work("biss_port", tests_only("servo/test_biss_port.py", only=OWN_SIZE)),
}
