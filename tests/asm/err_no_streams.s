; A core without streams.
.input  x
.output F, safe = 0.0
.stream W, pin A = 1.0 ; error: the stream of pipe A has 1 word, configuration 'fast' holds 0 => streams are in .config stream or wide
        seek    W ; error: configuration 'fast' has no streams => streams are in .config stream or wide
        fmul    p, W+, x ; error: configuration 'fast' has no streams => streams are in .config stream or wide
        mov     F, p
        halt
