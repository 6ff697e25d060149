# SPDX-License-Identifier: Apache-2.0
"""Captures of the bus, decoded by tshark, the dissectors of Wireshark."""

from __future__ import annotations

import subprocess
from collections import Counter
from pathlib import Path

import pytest

from tests.bench.needs import needs, require
from tests.ethercat.masters import report_of

pytestmark = needs("tap")
CYCLES = 30
PCAP_HEAD, RECORD_HEAD, ETHERNET_HEAD = 24, 16, 14
DAMAGED = "_ws.malformed || _ws.expert.severity == error"


def tshark(capture: Path, *options: str) -> list[str]:
    """Lines that it prints of a capture."""
    command = [require("tshark"), "-r", str(capture), *options]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


@pytest.fixture(scope="module")
def capture(tmp_path_factory) -> Path:
    """Bring-up and `CYCLES` cycles of pysoem with a slave."""
    file = tmp_path_factory.mktemp("bus") / "bus.pcap"
    report_of("master_loop", "--cycles", CYCLES, "--capture", file, timeout=300)
    return file


def test_capture__every_frame_is_decoded_and_none_is_malformed(capture):
    frames = tshark(capture, "-T", "fields", "-e", "frame.protocols")
    assert len(frames) > 2 * CYCLES
    assert all(protocols.startswith("eth:ethertype:ecatf:ecat") for protocols in frames)
    assert tshark(capture, "-Y", DAMAGED) == []


def test_capture__process_data_come_back_with_their_counter(capture):
    fields = ("-T", "fields", "-e", "ecat.cmd", "-e", "ecat.cnt")
    found = Counter(tuple(line.split("\t")) for line in tshark(capture, *fields))
    logical = {key: n for key, n in found.items() if key[0].split(",")[0] == "0x0c"}
    sent = sum(n for (_, counter), n in logical.items() if counter.split(",")[0] == "0")
    back = sum(n for (_, counter), n in logical.items() if counter.split(",")[0] == "3")
    assert sent == back >= CYCLES and sent + back == sum(logical.values())


def test_capture__a_wrong_length_is_seen(capture, tmp_path):
    """That the check can fail: the first datagram is longer than its frame."""
    data = bytearray(capture.read_bytes())
    start = PCAP_HEAD + RECORD_HEAD + ETHERNET_HEAD
    data[start + 2 + 6] = 0xFF  # low byte of the length
    damaged = tmp_path / "damaged.pcap"
    damaged.write_bytes(data)
    assert len(tshark(damaged, "-Y", DAMAGED)) == 1
