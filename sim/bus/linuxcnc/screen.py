#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC's user interface without a display: switches on, homes, plays a program, and reports.

LinuxCNC starts it, with the Python of the system, in the folder of the configuration. task.json
says what to do; screen.jsonl takes one line of JSON for each thing that happens.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

POLL_S = 0.02
START_PERIODS = 1000  # after the order to run, within which a program begins
LAST_POLLS = 50
SETTLE_PERIODS = {False: 40, True: 150}  # after the program; after a fault


class Screen:
    """What an operator does. cnc, hal: LinuxCNC's modules."""

    def __init__(self, cnc: Any, hal: Any, log: Path, task: dict[str, Any]) -> None:
        self.cnc, self.hal, self.log, self.task = cnc, hal, log, task
        self.command, self.status, self.errors = cnc.command(), cnc.stat(), cnc.error_channel()
        self.pins = task["pins"]
        self.panel = hal.component("panel")
        self.panel.newpin("home", hal.HAL_BIT, hal.HAL_OUT)
        self.panel.ready()
        if task["drives_home"]:
            hal.new_sig("home-drives", hal.HAL_BIT)
            hal.connect("panel.home", "home-drives")
            hal.connect(self.pins + "home", "home-drives")

    def say(self, event: str, **values: Any) -> None:
        """A line to the log, with the state that LinuxCNC is in."""
        self.status.poll()
        states = {
            self.cnc.STATE_ESTOP: "ESTOP",
            self.cnc.STATE_ESTOP_RESET: "ESTOP_RESET",
            self.cnc.STATE_OFF: "OFF",
            self.cnc.STATE_ON: "ON",
        }
        line = {
            "event": event,
            "periods": self.pin("periods"),
            "lost": self.pin("lost"),
            "state": states.get(self.status.task_state, str(self.status.task_state)),
            **values,
        }
        with self.log.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")

    def pin(self, name: str) -> Any:
        """Value of a pin of the component."""
        return self.hal.get_value(self.pins + name)

    def messages(self) -> None:
        """What LinuxCNC reports to its operator: errors, and texts of the program."""
        wrong = (self.cnc.NML_ERROR, self.cnc.OPERATOR_ERROR)
        while found := self.errors.poll():
            self.say("message" if found[0] in wrong else "note", text=found[1].strip())

    def clock(self) -> int:
        """Servo periods, those without an answer too."""
        return self.pin("periods") + self.pin("lost")

    def until(self, what: str, holds: Callable[[], bool], periods: int = 3000) -> None:
        """Wait for it. Raises RuntimeError after so many servo periods."""
        end = self.clock() + periods
        while not holds():
            self.messages()
            if self.clock() > end:
                raise RuntimeError(f"LinuxCNC did not come to: {what}")
            time.sleep(POLL_S)
            self.status.poll()

    def state(self, wanted: int, what: str) -> None:
        """Ask for a state and wait for it."""
        self.command.state(wanted)
        self.until(what, lambda: self.status.task_state == wanted)

    def ready(self) -> None:
        """From emergency stop to homed."""
        cnc = self.cnc
        self.until("the bus answers", lambda: self.pin("periods") > 0)
        self.state(cnc.STATE_ESTOP_RESET, "emergency stop reset")
        self.state(cnc.STATE_ON, "machine on")
        self.until("drives enabled", lambda: self.pin("enabled"))
        self.say("enabled")
        if self.task["drives_home"]:
            self.panel["home"] = True
            self.until("drives homed", lambda: self.pin("homed"))
            self.panel["home"] = False
            self.until("drives enabled", lambda: self.pin("enabled"))
        self.command.home(-1)
        self.until("joints homed", lambda: all(self.status.homed[:5]))
        self.say("homed")

    def position(self) -> list[float]:
        """Actual x, y, z, a, c [mm, degrees]."""
        self.status.poll()
        return [self.status.actual_position[n] for n in (0, 1, 2, 3, 5)]

    def play(self) -> None:
        """The program, to its end or to what stops it."""
        cnc, task = self.cnc, self.task
        self.command.mode(cnc.MODE_AUTO)
        self.until("automatic mode", lambda: self.status.task_mode == cnc.MODE_AUTO)
        self.command.program_open(str(Path(task["program"]).absolute()))
        begin = self.clock()
        self.say("begin")
        self.command.auto(cnc.AUTO_RUN, 0)
        self.until("the program runs", lambda: self.runs() or not self.on(), START_PERIODS)
        shown = 0.0
        fault, most = task["fault"], task["periods"]
        while self.on() and (self.runs() or not self.status.inpos):
            self.messages()
            passed = self.clock() - begin
            if fault and passed >= task["fault_after"]:
                self.say("fault", kind=fault, position=self.position())
                if fault == "estop":
                    self.command.state(cnc.STATE_ESTOP)
                else:
                    Path("fault_now").touch()
                fault = ""
            if self.status.task_paused:
                self.say(
                    "note", text=f"the program stops at line {self.status.motion_line}, resumed"
                )
                self.command.auto(cnc.AUTO_RESUME)
                self.until("the program goes on", lambda: not self.status.task_paused)
            if most and passed >= most:
                self.say("cut")
                self.command.abort()
                most = 0
            if time.monotonic() - shown > 1.0:
                shown = time.monotonic()
                self.say("line", line=self.status.motion_line)
            time.sleep(POLL_S)
            self.status.poll()
        self.say("over")

    def runs(self) -> bool:
        """Whether the program does."""
        return self.status.interp_state != self.cnc.INTERP_IDLE

    def on(self) -> bool:
        """Whether the machine is."""
        return self.status.task_state == self.cnc.STATE_ON

    def leave(self) -> None:
        """The drives come to rest; then LinuxCNC switches them off."""
        end = self.clock() + SETTLE_PERIODS[bool(self.task["fault"])]
        self.until("the rest", lambda: self.clock() >= end)
        for _ in range(LAST_POLLS):  # LinuxCNC's task hands messages on by the clock of the day
            self.messages()
            time.sleep(POLL_S)
        self.say("rest", position=self.position())
        if self.on():
            self.command.state(self.cnc.STATE_OFF)
            self.until("drives off", lambda: not self.pin("enabled"))


def main() -> None:
    """Do what task.json says."""
    import hal
    import linuxcnc

    task = json.loads(Path("task.json").read_text(encoding="utf-8"))
    screen = Screen(linuxcnc, hal, Path("screen.jsonl"), task)
    try:
        screen.ready()
        screen.play()
    except Exception as error:
        screen.say("failed", text=f"{type(error).__name__}: {error}")
    try:
        screen.leave()
    except Exception as error:
        screen.say("failed", text=f"{type(error).__name__}: {error}")
    screen.messages()
    screen.say("end")


if __name__ == "__main__":
    main()
