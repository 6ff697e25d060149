# SPDX-License-Identifier: Apache-2.0
"""Goals that a run of the main job can check by itself, beside what it measured."""

from __future__ import annotations

from typing import Any

# Tracking errors and cycles of the published case, the letters A, G, H with exact stops.
TRACKING = (
    ("largest tracking error of a leg", "max_leg_error_m", "m", 1e-6),
    ("largest tracking error of the tool", "max_tool_error_m", "m", 5e-6),
    ("largest tracking error of a table axis", "max_table_error_rad", "rad", 50e-6),
)


def goals(data: dict[str, Any]) -> list[dict[str, Any]]:
    """Name, value, unit, target and whether it is met; data: the content of results.json."""
    found = []

    def add(name: str, value: float, unit: str, target: float) -> None:
        met = value <= target
        found.append({"name": name, "value": value, "unit": unit, "target": target, "met": met})

    if data["tracking"]:
        for name, key, unit, target in TRACKING:
            add(name, data["tracking"][key], unit, target)
    period = data["robot"]["values"]["T_s"] * 1e6
    for platform, timing in data["platforms"].items():
        programs = {"": timing} if "time_us" in timing else timing
        for program, times in programs.items():
            name = f"longest tick of {platform.upper()} {program.replace('_', ' ')}".strip()
            add(name, times["time_us"], "us", period)
    return found
