# SPDX-License-Identifier: Apache-2.0
"""From a whole program to one set-point of five axes per control tick.

`program` takes it as programmed (entry `plan`), `exact_stop` with a rest at each corner;
`path_limits` reports what limits the speed. Run: python -m sim.motion.trajectory part.ngc
"""
