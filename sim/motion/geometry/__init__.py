# SPDX-License-Identifier: Apache-2.0
"""Geometry of programs: moves (mm, degree), their curves in five axes (m, rad), blends, NURBS."""
