# SPDX-License-Identifier: Apache-2.0
"""Messages between LinuxCNC's component and the master of the bus: microtick_bus.comp has the same.

One request and one answer in each servo period, in the order of bytes of the machine.
"""

from __future__ import annotations

import io
import struct
from dataclasses import dataclass

AXES = 5
REQUEST = struct.Struct(f"=II{AXES}d")
ANSWER = struct.Struct(f"=4I{AXES}II{AXES}d")
TO_MASTER, FROM_MASTER = "to_master", "from_master"  # pipes in LinuxCNC's folder
LINK, ENABLED, HOMED = 1, 2, 4
ENABLE = (1 << AXES) - 1
ESTOP_OK, HOME = 0x100, 0x200


@dataclass(frozen=True)
class Request:
    """What LinuxCNC wants in a period. target: mm, degrees; flags: ENABLE, ESTOP_OK, HOME."""

    number: int
    flags: int
    target: tuple[float, ...]

    @classmethod
    def unpack(cls, data: bytes) -> Request:
        """From the pipe."""
        number, flags, *target = REQUEST.unpack(data)
        return cls(number, flags, tuple(target))


def answer(
    number: int,
    flags: int,
    lost: int,
    faults: int,
    errors: list[int],
    position: list[float],
) -> bytes:
    """To the pipe. faults: bit n of axis n; position: mm, degrees."""
    return ANSWER.pack(number, flags, lost, faults, *errors, 0, *position)


def receive(pipe: io.RawIOBase, size: int) -> bytes:
    """So many bytes; fewer when the other side is gone."""
    data = b""
    while len(data) < size and (more := pipe.read(size - len(data))):
        data += more
    return data
