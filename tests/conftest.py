# SPDX-License-Identifier: Apache-2.0
"""Every model that a test builds carries the assertions of sim/assertions."""

from sim.harness import build

build.assertions = True
