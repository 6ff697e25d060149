# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the model tests."""

import pytest

from sim.model.parameters import Robot


@pytest.fixture(scope="session")
def robot() -> Robot:
    return Robot.load()
