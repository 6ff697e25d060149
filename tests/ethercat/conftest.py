# SPDX-License-Identifier: Apache-2.0
"""Models of the controller carry the assertions of sim/assertions."""

import pytest

from sim.ethercat.line import Line
from sim.harness import build


@pytest.fixture(autouse=True, scope="package")
def with_assertions():
    """A violation ends the process with the file and the line."""
    before, build.assertions = build.assertions, True
    yield
    build.assertions = before


@pytest.fixture
def line():
    """One slave behind a master's port."""
    with Line() as made:
        yield made
