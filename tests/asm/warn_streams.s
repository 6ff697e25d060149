; Blocks of streams that nothing reads.
.config stream
.input  x
.output F, safe = 0.0
.stream W, pin A = 1.0
.stream V, pin A = 2.0 ; warning: stream 'V' is never read [unused-stream]
.stream U, pin B = 3.0
        seek    W
        fmul    t, W+, x
        seek    B
        fmul    u, B+, t
        mov     F, u
        halt
