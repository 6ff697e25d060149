# SPDX-License-Identifier: Apache-2.0
"""Two processors in parallel: set-points on one core, the tracking law on the other."""
