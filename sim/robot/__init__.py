# SPDX-License-Identifier: Apache-2.0
"""The robot: parameters, kinematics, dynamics, plant."""
