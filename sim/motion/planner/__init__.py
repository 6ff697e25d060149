# SPDX-License-Identifier: Apache-2.0
"""Speed along one move: S-curves with set times, time-optimal moves, override; all one-dimensional.

`scurve` has the closed forms, `ramp_time` evaluates them exactly, `optimal` and `override` plan
under limits, `core` runs the planner on the ASIP, `pulse_records` makes integers for the hardware.
See docs/motion.md. Run: python -m sim.motion.planner --help
"""
