# SPDX-License-Identifier: Apache-2.0
"""One motor alone: its file, its simulated bench, alignment, identification, gains, responses."""
