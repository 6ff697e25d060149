# SPDX-License-Identifier: Apache-2.0
"""What a run of LinuxCNC came to: errors, lost servo periods, states after a fault."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sim.bus.linuxcnc.config import LinuxcncError
from sim.bus.linuxcnc.master import LOG
from sim.bus.path_run import DELAY, FOLLOWING_ERROR, TICKS, Curves

FOLLOWING_TEXT = "following error"  # in LinuxCNC's message
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Run:
    """Files of a run's folder. events: lines of the screen; log: records of frames; places,
    powered: of each tick; machine: the simulation's last report."""

    events: list[dict[str, Any]]
    log: NDArray[Any]
    places: Floats
    powered: NDArray[np.bool_]
    machine: dict[str, Any]

    @classmethod
    def read(cls, folder: Path, machine: dict[str, Any]) -> Run:
        """Of a run that is over."""
        with np.load(folder / "machine.npz") as found:
            places, powered = found["places"], found["powered"]
        lines = (folder / "screen.jsonl").read_text(encoding="utf-8").splitlines()
        log = np.fromfile(folder / "log", LOG)
        return cls([json.loads(line) for line in lines], log, places, powered, machine)

    def first(self, event: str) -> dict[str, Any]:
        """The first line of this kind, empty if there is none."""
        return next((line for line in self.events if line["event"] == event), {})

    @property
    def messages(self) -> list[str]:
        """LinuxCNC's to its operator, and why the screen gave up."""
        return [line["text"] for line in self.events if line["event"] in ("message", "failed")]

    def frames(self) -> tuple[int, int]:
        """Of the program: first frame, and the one after the last; up to a fault.

        Raises LinuxcncError with LinuxCNC's words if it has run none."""
        begin, end = self.first("begin"), self.first("over")
        if not begin or not end:
            raise LinuxcncError(f"LinuxCNC has run no program: {'; '.join(self.messages)}")
        last = min(end["periods"], len(self.log) - DELAY // TICKS - 1)
        tick = self.machine["fault_tick"]
        if tick is None and (fault := self.first("fault")):
            tick = TICKS * fault["periods"]
        if tick is not None:
            last = min(last, tick // TICKS - DELAY // TICKS - 1)
        return begin["periods"], last

    def curves(self) -> Curves:
        """LinuxCNC's targets and the exact tool and table DELAY ticks later, in each tick. Between
        two targets, which are a period apart, a straight line counts."""
        begin, end = self.frames()
        target = self.log["target"][begin:end]
        ticks = np.arange(TICKS * (len(target) - 1) + 1)
        at = TICKS * np.arange(len(target))
        wanted = np.stack([np.interp(ticks, at, axis) for axis in target.T], axis=1)
        places = self.places[TICKS * begin + DELAY + ticks]
        return Curves(wanted[:, :3], places[:, :3], wanted[:, 3:], places[:, 3:])

    def report(self) -> dict[str, Any]:
        """Errors in m and rad; `following`: LinuxCNC's, target minus position; lost: servo periods
        without process data, up to a fault."""
        begin, end = self.frames()
        log, curves = self.log[begin:end], self.curves()
        away = np.abs(log["target"] - log["position"]).max(axis=0)
        gaps = int((np.diff(self.log["number"]) != 1).sum())
        kinds = [line["event"] for line in self.events]
        before = self.events[: kinds.index("fault") if "fault" in kinds else None]
        texts = [line for line in before if FOLLOWING_TEXT in line.get("text", "")]
        return {
            "periods": int(end - begin),
            "tool_error": curves.tool_error,
            "table_error": curves.table_error,
            "following": away.tolist(),
            "following_faults": len(texts) + int((log["error"] == FOLLOWING_ERROR).any()),
            "lost": int((self.log["right"][:end] == 0).sum()) + gaps,
            "ended": self.first("over")["state"],
            "messages": self.messages,
            "end": self.first("rest").get("position"),
            "after_fault": self.after_fault(),
            **self.machine,
        }

    def after_fault(self) -> dict[str, Any] | None:
        """From the fault on, in ticks: until the robot is at rest, until the brakes are closed; how
        far the tool went [m]; the state that LinuxCNC is in, and its messages."""
        fault = self.first("fault")
        if not fault:
            return None
        begin = self.machine["fault_tick"] or TICKS * fault["periods"]
        tool = self.places[begin:, :3]
        moved = np.linalg.norm(np.diff(tool, axis=0), axis=1) > 1e-9
        off = ~self.powered[begin:]
        return {
            "kind": fault["kind"],
            "stands_after": int(np.nonzero(moved)[0][-1]) + 1 if moved.any() else 0,
            "brakes_after": int(np.argmax(off)) if off.any() else None,
            "distance": float(np.linalg.norm(np.diff(tool, axis=0), axis=1).sum()),
            "linuxcnc": (self.first("rest") or self.events[-1])["state"],
            "messages": [line["text"] for line in self.events if line["event"] == "message"],
        }


def away_from(path: Floats, points: Floats) -> float:
    """Largest distance of points (N, 3) from a path, the lines between its points (M, 3)."""
    _, nearest = cKDTree(path).query(points)
    best = np.full(len(points), np.inf)
    for side in (0, -1):
        start = np.clip(nearest + side, 0, len(path) - 2)
        line = path[start + 1] - path[start]
        size = np.maximum((line**2).sum(axis=1), 1e-30)
        part = np.clip(((points - path[start]) * line).sum(axis=1) / size, 0.0, 1.0)
        foot = path[start] + part[:, None] * line
        best = np.minimum(best, np.linalg.norm(points - foot, axis=1))
    return float(best.max())
