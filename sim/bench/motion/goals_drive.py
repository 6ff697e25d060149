# SPDX-License-Identifier: Apache-2.0
"""Goals that are figures of `microtick motion`: step axes of a path, drive study, robot."""

from __future__ import annotations

from sim.bench.motion.goal import Counts, Features, Measured, Rows, figures

FEATURES = Features()

FEATURES.feature(
    "G64 program on five step axes (RTL)",
    "-",
    "0 steps off at the end; <= 1 on the way",
    "make test T=test_step_stream",
)(figures("five axes: final counts off", "five axes: steps off the plan"))


FEATURES.feature(
    "following error, 1st-order loop: none, v, v+a, S-curve",
    "2.5; < 0.1; less; -",
    "2.5; < 0.1; < 0.025; < 0.01 mm",
    "make test T=test_drive",
)(
    figures(
        "1st-order loop: no feed-forward",
        "1st-order loop: velocity",
        "1st-order loop: velocity and acceleration",
        "1st-order loop: velocity and acceleration, S-curve",
    )
)


FEATURES.feature("current spikes", "yes", ">= 5 times lower", "make test T=test_drive")(
    figures("1st-order loop: peak dI/dt, trapezoid over S-curve")
)


def _robot(case: str, rows: Rows) -> Measured:
    name = next((n for n in rows if n.startswith(f"{case}: tool error")), case)
    return figures(name)(Counts(), rows)


@FEATURES.feature("robot on AGH, 2 m/min: law; drives", "-", "< 10 um", "microtick motion --full")
def robot(counts: Counts, rows: Rows) -> Measured:
    """Largest tool errors of the computed-torque law and of the drives."""
    law = _robot("computed torque", rows)
    drives = _robot("drives, velocity and acceleration", rows)
    return f"{law[0]}; {drives[0]}", law[1] and drives[1]


FEATURES.feature("load step of 1.8 N m", "3.58 um", "within 2 times", "make test T=test_drive")(
    figures("load step 1.8 N m; 160 Hz read as i-p")
)


FEATURES.feature(
    "+-1 increment of 34.7 nm", "held", "held, 5 of 5 targets", "make test T=test_drive"
)(
    figures(
        "+-1 of 144 000 counts under 0.0 N m: targets met",
        "+-1 of 144 000 counts under 1.8 N m: targets met",
    )
)
