; assemble: --config small
; Configuration small: one slot, 48-bit bundles, multiply-add results in bank A.
.config small
.input  x
.output F1, safe = 0.0
        { fmul a0, x, x }
        { fabs o0, a0 } halt
; = 005004020000
; = 019601000000
