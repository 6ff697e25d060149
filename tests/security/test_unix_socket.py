# SPDX-License-Identifier: Apache-2.0
"""GDB over a Unix socket: only this user may connect, and the file goes with the server."""

from __future__ import annotations

import signal
import socket
import stat
import subprocess
import sys

from asip_asm.project import ROOT

LIMIT_S = 60.0  # against a hang


def test_gdb__over_a_unix_socket__is_served_and_private(tmp_path):
    path = tmp_path / "gdb"
    server = subprocess.Popen(
        [sys.executable, "-m", "sim.debug.nios_run", "--gdb", str(path)],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        assert server.stdout is not None
        said = ""
        while f"target remote {path}" not in said:
            line = server.stdout.readline()
            assert line, said
            said += line
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
        for _ in range(2):  # the second client is served as the first
            with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as peer:
                peer.settimeout(LIMIT_S)
                peer.connect(str(path))
                peer.sendall(b"+$?#3f")
                answer = b""
                while b"T05" not in answer:
                    part = peer.recv(4096)
                    assert part, answer
                    answer += part
    finally:
        server.send_signal(signal.SIGINT)
        server.wait(LIMIT_S)
    assert not path.exists()
