# SPDX-License-Identifier: Apache-2.0
"""asip-scope: a running controller in the browser: curves, trigger, gains, black box, exports.

A source (source.py) gives every tick as a row of channels; the session keeps them in a ring and
does what an oscilloscope does; the server shows it to pages on this computer.
"""
