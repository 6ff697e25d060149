# SPDX-License-Identifier: Apache-2.0
"""Goals that a run of the main job can check by itself, beside what it measured."""

from __future__ import annotations

from typing import Any

from sim.run.checks import TRACKING_TARGETS

AXES = {"leg": ("a leg", "m"), "tool": ("the tool", "m"), "table": ("a table axis", "rad")}


def goals(data: dict[str, Any], published_path: bool) -> list[dict[str, Any]]:
    """Name, value, unit, target and whether it is met; data: the content of results.json.

    published_path: the letters A, G, H, for which there are targets of the tracking errors.
    """
    found = []

    def add(name: str, value: float, unit: str, target: float) -> None:
        met = value <= target
        found.append({"name": name, "value": value, "unit": unit, "target": target, "met": met})

    programs = [errors for errors in data["tracking"].values() if isinstance(errors, dict)]
    if published_path and programs:
        for key, target in TRACKING_TARGETS.items():
            name, unit = AXES[key]
            worst = max(errors[key] for errors in programs)
            add(f"largest tracking error of {name}", worst, unit, target)
    period = data["robot"]["values"]["T_s"] * 1e6
    for platform, timing in data["platforms"].items():
        for program, times in ({"": timing} if "time_us" in timing else timing).items():
            name = f"longest tick of {platform.upper()} {program.replace('_', ' ')}".strip()
            add(name, times["time_us"], "us", period)
    return found
