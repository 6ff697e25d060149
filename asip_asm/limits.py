# SPDX-License-Identifier: Apache-2.0
"""Limits of the assembler, so that any input ends within seconds and bounded memory.

A full program memory (1024 bundles of three operations, 100 characters each) needs a third of
`TEXT_CHARACTERS`. The table of docs/assembly.md states them all.
"""

TEXT_CHARACTERS = 1 << 20
"""Characters of a program with all that it includes and expands."""
LINE_CHARACTERS = 1 << 14
"""Characters of a line, also after macro parameters are replaced."""
INCLUDE_DEPTH = 32
"""Files open in one another."""
MACRO_DEPTH = 64
"""Macro calls open in one another."""
EXPANSIONS = 10_000
"""Macro calls of a program."""
NESTING = 64
"""Parentheses and calls open in one another in an expression."""
BUNDLE_LINES = 64
"""Lines of one bundle in braces."""
ERRORS = 200
"""Errors after which the assembler gives up."""
ERRORS_SHOWN = 20
"""Errors printed, each cause once."""
