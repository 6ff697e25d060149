# SPDX-License-Identifier: Apache-2.0
"""A law's C compiled for this machine, its bits, and a controller of it."""
