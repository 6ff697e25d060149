# SPDX-License-Identifier: Apache-2.0
"""asip-dbg: the debugger of the ASIP's programs, as a command line and as a server of the Debug
Adapter Protocol (docs/debugger.md).

`session` knows program, debug map and target, and is all that both faces use.
"""
