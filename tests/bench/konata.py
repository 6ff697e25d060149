# SPDX-License-Identifier: Apache-2.0
"""Reader of pipeline logs for Konata."""

from __future__ import annotations

from collections import defaultdict


class KonataReader:
    """Reads a log by the rules of the format and asserts them on the way."""

    def __init__(self, text: str) -> None:
        header, *rows = text.splitlines()
        assert header == "Kanata\t0004"
        assert rows[0].split("\t")[0] == "C="
        self.now = int(rows[0].split("\t")[1])
        self.open: dict[int, dict[str, int]] = {}
        self.labels: dict[int, list[str]] = defaultdict(list)
        self.stages: dict[int, list[tuple[str, int, int]]] = defaultdict(list)
        self.retired: dict[int, int] = {}
        self.orders: list[int] = []
        for row in rows[1:]:
            kind, *fields = row.split("\t")
            getattr(self, f"read_{kind}")(*fields)

    def read_C(self, cycles: str) -> None:
        assert int(cycles) > 0
        self.now += int(cycles)

    def read_I(self, number: str, program: str, thread: str) -> None:
        assert int(number) == len(self.open), "numbers rise by one"
        assert int(program) >= 0 and thread == "0"
        self.open[int(number)] = {}

    def read_L(self, number: str, kind: str, text: str) -> None:
        assert self._alive(number) and kind in ("0", "1") and text
        self.labels[int(number)].append(text)

    def read_S(self, number: str, lane: str, stage: str) -> None:
        assert self._alive(number) and lane == "0"
        assert not self.open[int(number)], "one stage at a time"
        self.open[int(number)][stage] = self.now

    def read_E(self, number: str, lane: str, stage: str) -> None:
        assert self._alive(number) and lane == "0"
        self.stages[int(number)].append((stage, self.open[int(number)].pop(stage), self.now))

    def read_W(self, consumer: str, producer: str, kind: str) -> None:
        assert self._alive(consumer) and int(producer) < int(consumer) and kind == "0"

    def read_R(self, number: str, order: str, kind: str) -> None:
        assert self._alive(number) and kind == "0"
        assert not self.open[int(number)], "no stage stays open"
        self.retired[int(number)] = self.now
        self.orders.append(int(order))

    def _alive(self, number: str) -> bool:
        return int(number) in self.open and int(number) not in self.retired
