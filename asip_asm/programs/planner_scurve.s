; SPDX-License-Identifier: Apache-2.0
; Plans one S-curve move: one run per move. Meaning, units and error codes: planner_law.inc. With an
; error every other output is 0. Lengths may be m, mm or rad.
;   asip-run asip_asm/programs/planner_scurve.s --set v0=0.1 --set vm=0.6 --set tr=0.6 \
;            --set tm=0.15 --set L=0.8

.program  "S-curve planner"
.include  "planner_law.inc"
.interface "planner_scurve.interface.toml"

        plan    v0, vm, tr, tm, L
        mov     error, p_error
        sel     class, p_good, p_class, 0.0
        sel     t1, p_good, p_t1, 0.0
        sel     t2, p_good, p_t2, 0.0
        sel     t4, p_good, p_t4, 0.0
        sel     s1, p_good, p_s1, 0.0
        sel     s2, p_good, p_s2, 0.0
        sel     s3, p_good, p_s3, 0.0
        sel     s4, p_good, p_s4, 0.0
        sel     vp, p_good, p_vp, 0.0
        sel     am, p_good, p_am, 0.0
        sel     J, p_good, p_J, 0.0
        halt
