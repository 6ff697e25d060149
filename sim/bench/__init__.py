# SPDX-License-Identifier: Apache-2.0
"""Jobs, goals and comparisons: what puts the other rooms together."""
