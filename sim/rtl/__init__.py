# SPDX-License-Identifier: Apache-2.0
"""Models of the RTL: builds, harnesses, register maps, assertions, boards."""
