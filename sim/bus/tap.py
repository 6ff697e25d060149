# SPDX-License-Identifier: Apache-2.0
"""A TAP device in a network namespace: where a raw-socket master meets simulated slaves."""

from __future__ import annotations

import argparse
import fcntl
import os
import shutil
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from asip_asm.project import ROOT
from sim.rtl.processes import run_group

INTERFACE = "ec0"
TUNSETIFF, IFF_TAP, IFF_NO_PI = 0x400454CA, 0x0002, 0x1000
SIOCGIFFLAGS, SIOCSIFFLAGS, IFF_UP = 0x8913, 0x8914, 0x1


class NamespaceError(RuntimeError):
    """No network namespace or TAP device can be had here; the text says what to do."""


def open_tap(name: str = INTERFACE) -> int:
    """File descriptor, not blocking, of a new TAP device that is up. Raises NamespaceError."""
    quiet = Path("/proc/sys/net/ipv6/conf/default/disable_ipv6")
    if quiet.exists():
        quiet.write_text("1")  # the kernel's own packets would mix with the master's
    try:
        tap = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
        fcntl.ioctl(tap, TUNSETIFF, struct.pack("16sH", name.encode(), IFF_TAP | IFF_NO_PI))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plug:
            ask = struct.pack("16sH", name.encode(), 0)
            flags = struct.unpack("16sH", fcntl.ioctl(plug, SIOCGIFFLAGS, ask))[1]
            fcntl.ioctl(plug, SIOCSIFFLAGS, struct.pack("16sH", name.encode(), flags | IFF_UP))
    except OSError as error:
        raise NamespaceError(
            f"no TAP device {name}: {error.strerror}; run inside `unshare -rn`, with /dev/net/tun"
        ) from error
    return tap


def in_namespace(
    module: str, arguments: Sequence[str], timeout: float
) -> subprocess.CompletedProcess:
    """Run `python -m module` in a network namespace of its own. Raises NamespaceError."""
    tool = shutil.which("unshare")
    if not tool or not Path("/dev/net/tun").exists():
        raise NamespaceError("`unshare` (Debian: util-linux) and /dev/net/tun are needed")
    command = [tool, "-rn", sys.executable, "-m", module, *arguments]
    return run_group(command, timeout, cwd=ROOT)


def command_line(doc: str, example: str) -> argparse.ArgumentParser:
    """Of a module that runs inside `unshare -rn`; example: its name in sim.bus, options."""
    return argparse.ArgumentParser(
        description=doc.splitlines()[0],
        epilog=f"example: unshare -rn python -m sim.bus.{example}",
    )


def progress_of(cycles: int, every: int) -> Callable[[int], None]:
    """Takes cycles done and prints them, one in `every`, on a terminal."""
    began = time.monotonic()

    def progress(n: int) -> None:
        if n % every == 0 and sys.stderr.isatty():
            left = (time.monotonic() - began) / n * (cycles - n)
            print(f"\r{n} of {cycles} cycles, {left:.0f} s left", end="", file=sys.stderr)

    return progress


if __name__ == "__main__":  # whether a device can be had: its name, or an error
    os.close(open_tap())
    print(INTERFACE)
