# SPDX-License-Identifier: Apache-2.0
"""Words of a control tick and process data to and from the application on this machine (`Host`)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sim.bus.device import INPUT_WORDS
from sim.bus.machine import AXES, FLAGS, INDEX, POWER, SWITCHES, TORQUE_ONLY
from tests.ethercat.host import DEVICE, Host


class HostWords:
    """The words of a control tick, to and from the application on this machine."""

    def __init__(self, host: Host) -> None:
        self.host = host
        self.inputs, self.outputs = np.zeros(INPUT_WORDS, np.uint32), np.zeros(29, np.uint32)

    def tick(self) -> None:
        feedback, command = self.host.feedback, self.host.command
        axes = np.ctypeslib.as_array(feedback.axis)
        axes["position"] = self.inputs[:AXES].view(np.int32)
        axes["torque"], axes["fault"] = (
            self.inputs[AXES : 2 * AXES].view(np.uint16).reshape(-1, 2).T
        )
        feedback.pose[:] = self.inputs[2 * AXES : 3 * AXES].view(np.float32).tolist()
        digital, counts = int(self.inputs[3 * AXES]), int(self.inputs[3 * AXES + 1])
        feedback.digital_inputs = digital & 0xFF
        axes["switches"] = [digital >> SWITCHES + 3 * n & 7 for n in range(AXES)]
        axes["index_count"] = [counts >> 6 * n & 63 for n in range(AXES)]
        axes["index_position"] = self.inputs[INDEX].view(np.int32)
        feedback.edge_age[:] = self.inputs[4 * AXES + 2 :].view(np.uint16).tolist()
        self.host.held = set(range(AXES))
        self.host.cycle()
        axes = np.ctypeslib.as_array(command.axis)
        names = ("position", "fraction", "velocity", "acceleration")
        self.outputs[: 4 * AXES] = np.concatenate([axes[n].copy().view(np.uint32) for n in names])
        torques = axes["torque"].astype(np.uint16)
        self.outputs[FLAGS] = torques | POWER * axes["power"] | TORQUE_ONLY * axes["torque_only"]
        place = command.setting_index << 8 | command.setting_subindex
        value = np.float32(command.setting_value).view(np.uint32)
        self.outputs[5 * AXES :] = command.digital_outputs, command.setting_number, place, value


class HostLink:
    """Process data as they come over the wire: taken by the pass after the one they meet."""

    def __init__(self, host: Host) -> None:
        self.host, self.rtl = host, HostWords(host)
        self.words: list[np.ndarray] = []

    def cycle(self, data: bytes, ticks: int, tick: Callable[[], None]) -> bytes:
        back = self.host.read(0x1800, DEVICE.bytes("tx"))
        for n in range(ticks):
            tick()
            self.words.append(self.rtl.outputs.copy())
            if n == 0:
                self.host.write(0x1200, data)
        return back
