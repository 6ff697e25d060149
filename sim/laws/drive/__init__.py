# SPDX-License-Identifier: Apache-2.0
"""The current law of the drives and its clocks."""
