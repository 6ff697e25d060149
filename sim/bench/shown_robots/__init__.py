# SPDX-License-Identifier: Apache-2.0
"""Every robot shown: compiled, proved, its loop closed; with its goals."""
