# SPDX-License-Identifier: Apache-2.0
"""A slave controller for the tests."""

import pytest

from sim.bus.line import Line


@pytest.fixture
def line():
    """One slave at a master's port."""
    with Line() as made:
        yield made
