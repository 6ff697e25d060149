# SPDX-License-Identifier: Apache-2.0
"""Drive and feed-forward study of the CNC paper: `position_loop`, `servo`, `robot`, `figures`."""
