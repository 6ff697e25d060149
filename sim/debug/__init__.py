# SPDX-License-Identifier: Apache-2.0
"""The debug block from the host's side: packets, links, and a client that debuggers build on.

`client.connect` is the way in; docs/debug_block.md has the packets, docs/debug_regmap.md the
registers after them.
"""
