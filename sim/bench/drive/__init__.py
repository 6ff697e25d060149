# SPDX-License-Identifier: Apache-2.0
"""Motor drives: the current loops' program, and the plant of inverters and motors."""
