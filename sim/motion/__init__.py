# SPDX-License-Identifier: Apache-2.0
"""From G-code to set-points: gcode (text) -> path (curves) -> scurve (speed) -> trajectory."""
