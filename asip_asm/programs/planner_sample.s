; SPDX-License-Identifier: Apache-2.0
; Set-point of one tick of a planned move: inputs are v0, L and the outputs of planner_scurve.s,
; and the number of ticks since the start. Meaning: planner_law.inc.

.program  "S-curve sampler"
.include  "planner_law.inc"
.interface "planner_sample.interface.toml"

        sample  ticks, T_s, L, v0, vp, am, J, t1, t2, t4, s1, s2, s3
        mov     p, q_p
        mov     v, q_v
        mov     a, q_a
        mov     phase, q_phase
        mov     over, q_over
        halt
