# SPDX-License-Identifier: Apache-2.0
"""Control laws of robots, compiled, proved and run on the host."""
