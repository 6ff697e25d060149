# SPDX-License-Identifier: Apache-2.0
"""What the tests of the processor share."""

from __future__ import annotations

import pytest

from tests.asip.core_bench import CONFIGURATIONS


@pytest.fixture(params=CONFIGURATIONS)
def configuration(request) -> str:
    """Each configuration of the core."""
    return request.param
