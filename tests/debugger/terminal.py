# SPDX-License-Identifier: Apache-2.0
"""asip-dbg on a terminal of its own, as a user has it."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import select
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path

from asip_asm.project import ROOT

PROMPT = "(asip-dbg)"
TIMEOUT = 60.0  # guard against a hang


class Terminal:
    """A process whose terminal this is; `home` gets its history. Used as a context manager: nothing
    is left behind by a test that fails.
    """

    def __init__(self, home: Path, *arguments: str) -> None:
        self._master, slave = pty.openpty()
        environment = {**os.environ, "HOME": str(home), "TERM": "xterm", "COLUMNS": "120"}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "sim.debug.asip_dbg", *arguments],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            cwd=ROOT,
            env=environment,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),  # so that Ctrl-C is a signal
        )
        os.close(slave)

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *error: object) -> None:
        self.process.kill()  # nothing if it has ended
        self.process.wait()
        with contextlib.suppress(OSError):
            os.close(self._master)

    def wait_for(self, text: str, again: str = "") -> str:
        """What the terminal got up to this text, with it; `again` is typed every second."""
        got = ""
        end = time.monotonic() + TIMEOUT
        while text not in got:
            ready, _, _ = select.select([self._master], [], [], 1.0)
            assert time.monotonic() < end, f"no '{text}' in {got!r}"
            if not ready:
                self.type(again)
                continue
            try:
                data = os.read(self._master, 65536)
            except OSError:  # the other end is closed
                data = b""
            assert data, f"ended before '{text}': {got!r}"
            got += data.decode(errors="replace")
            if "\x1b[6n" in data.decode(errors="replace"):
                self.type("\x1b[1;1R")  # where the cursor is, as a terminal answers when asked
        return got

    def type(self, text: str) -> None:
        os.write(self._master, text.encode())

    def close(self) -> int:
        """Exit status of the process, when it has ended by itself or by SIGHUP."""
        try:
            return self.process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self.process.send_signal(signal.SIGHUP)
            return self.process.wait(timeout=TIMEOUT)
