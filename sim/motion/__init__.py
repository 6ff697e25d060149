# SPDX-License-Identifier: Apache-2.0
"""From G-code to set-points: programs, geometry, speeds, the planner."""
