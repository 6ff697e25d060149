# SPDX-License-Identifier: Apache-2.0
"""Commands of `monitor` in GDB."""

from __future__ import annotations

from collections.abc import Callable

from sim.debug.gdb.system import NiosSystem


def _switch(words: list[str], what: str, value: bool) -> bool:
    if words not in ([], ["on"], ["off"]):
        raise ValueError(f"{what}: on or off")
    return words == ["on"] if words else value


def _tick(system: NiosSystem, words: list[str]) -> str:
    system.core.tick()
    return "a control tick waits for the program"


def _counters(system: NiosSystem, words: list[str]) -> str:
    return f"{system.spent} clock cycles, {system.core.retired} instructions since reset"


def _freeze(system: NiosSystem, words: list[str]) -> str:
    target = system.target
    target.freeze = _switch(words, "freeze", target.freeze)
    target.configure()
    return (
        f"timer and cycle counter of a halted core {'stand still' if target.freeze else 'run on'}"
    )


def _interrupts(system: NiosSystem, words: list[str]) -> str:
    target = system.target
    target.mask_interrupts = not _switch(words, "interrupts", not target.mask_interrupts)
    target.configure()
    return f"`stepi` takes {'no ' if target.mask_interrupts else ''}interrupts"


def _help(system: NiosSystem, words: list[str]) -> str:
    return "\n".join(f"monitor {usage:<20} {doc}" for usage, doc, _ in COMMANDS.values())


Command = Callable[[NiosSystem, list[str]], str]
COMMANDS: dict[str, tuple[str, str, Command]] = {
    "help": ("help", "this list", _help),
    "reset": (
        "reset",
        "start again: loads the program, halts before its first instruction",
        lambda system, words: system.reset(),
    ),
    "tick": ("tick", "start a control tick, as the set-point interface does", _tick),
    "counters": ("counters", "clock cycles and instructions since reset", _counters),
    "freeze": ("freeze [on|off]", "whether timers stand still while the core is halted", _freeze),
    "interrupts": ("interrupts [on|off]", "whether a single step takes interrupts", _interrupts),
    "comparators": (
        "comparators",
        "hardware breakpoints and watchpoints in use",
        lambda system, words: system.target.comparators(),
    ),
}


def command(system: NiosSystem, line: str) -> str:
    """Execute a line; what is to be shown, each line ended."""
    name, *words = line.split() or ["help"]
    found = [full for full in COMMANDS if full == name] or [
        full for full in COMMANDS if full.startswith(name)
    ]
    if len(found) != 1:
        return f"no command '{name}'; `monitor help` lists them\n"
    usage, _, act = COMMANDS[found[0]]
    if words and "[" not in usage:
        return f"usage: monitor {usage}\n"
    try:
        return act(system, words) + "\n"
    except ValueError as error:
        return f"{error}; usage: monitor {usage}\n"
