# SPDX-License-Identifier: Apache-2.0
"""One law on all platforms: its C on this machine and on FPGA2, next to the core."""
