# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC, unmodified, at one end of the bus; the simulated machine at the other."""
