# SPDX-License-Identifier: Apache-2.0
"""What was made of a URDF: axes, followers, held joints, and what nothing used."""

from __future__ import annotations

from sim.laws.laws import Settings, count_scale
from sim.laws.tree import Tree


def account(tree: Tree, settings: Settings) -> str:
    """Lines of the report of a robot's law."""
    description, stated = tree.description, tree.stated
    lines = [f"robot {tree.name}, {description.file}"]
    for i, joint in enumerate(tree.axes):
        unit = "rad" if joint.kind == "revolute" else "m"
        limits = "no range" if joint.lower is None else f"{joint.lower:g} to {joint.upper:g} {unit}"
        effort = "no effort" if joint.effort is None else f"effort {joint.effort:g}"
        scale = count_scale(joint, settings)
        lines.append(
            f"  axis {i}: {joint.name}, {limits}, {effort}; a count is {scale:.6g} {unit}, count 0 "
            f"is at {joint.zero:g} {unit}"
        )
    for joint in tree.joints:
        leader = tree.joints[joint.leader]
        if joint is not leader:
            lines.append(
                f"  {joint.name} follows {leader.name}: {joint.multiplier:g} times, plus "
                f"{joint.shift:g}; its own limits and effort are not used"
            )
    for name, position in stated.locked.items():
        lines.append(f"  {name} is held at {position:g}")
    if not stated.motor_encoders:
        for one in description.transmissions:
            if one.reduction != 1 or one.offset:
                lines.append(
                    f"  not used: reduction {one.reduction:g} and offset {one.offset:g} of "
                    f"transmission '{one.name}' ({one.kind}); --encoder motor uses them"
                )
    counted = (f"{name} ({n})" for name, n in sorted(description.unused.items()) if n)
    lines.append(f"  not used of the file: {', '.join(counted) or 'nothing'}")
    lines += [f"  warning: {text}" for text in description.warnings]
    return "\n".join(lines) + "\n"
