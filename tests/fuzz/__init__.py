# SPDX-License-Identifier: Apache-2.0
"""Mutated inputs for the commands: none may end in a traceback, hang or take memory without end.

`python -m tests.fuzz` runs the campaigns. A campaign (`engine.Campaign`) is a function that makes
case n from a seeded generator and gives it to the tool; `campaigns.py` lists them.
"""
