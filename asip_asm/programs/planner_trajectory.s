; SPDX-License-Identifier: Apache-2.0
; Trajectory generator: one run per tick. A run with start != 0 takes over the move on the inputs and
; gives its first set-point; the following runs go on along it, whatever the inputs are, and stay at
; its end. The move is planned anew in every tick, so every tick takes the same cycles. A refused
; move gives its error code and p = v = a = 0, over = 1, until the next start. Before the first start
; the error is 1: there is no move.

.program  "S-curve trajectory"
.include  "planner_law.inc"
.interface "planner_trajectory.interface.toml"

        sel     held_v0, start, v0, held_v0
        sel     held_vm, start, vm, held_vm
        sel     held_tr, start, tr, held_tr
        sel     held_tm, start, tm, held_tm
        sel     held_L, start, L, held_L
        sel     now, start, zero, ticks
        plan    held_v0, held_vm, held_tr, held_tm, held_L
        sample  now, T_s, held_L, held_v0, p_vp, p_am, p_J, p_t1, p_t2, p_t4, p_s1, p_s2, p_s3
        sel     p, p_good, q_p, 0.0
        sel     v, p_good, q_v, 0.0
        sel     a, p_good, q_a, 0.0
        sel     phase, p_good, q_phase, 0.0
        sel     over, p_good, q_over, 1.0
        mov     error, p_error
        sel     step, q_over, 0.0, 0f00000001
        iadd    ticks, now, step
        halt
