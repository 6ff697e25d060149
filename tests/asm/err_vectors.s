; Vectors: words of every lane, one pipe each, no words of registers.
.config wide
.input  x
.output F, safe = 0.0
.export e
.state  h = 0.0
.stream U, pin A = 1.0, 2.0
.vectors W, pin A = 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0
.vectors V, pin B = 1.0, 2.0, 3.0, 4.0
.vectors Y, pin A = 1.0, 2.0 ; error: expected ',' a vector has 4 words, found the end of the line
.stream 5.0 ; error: 'Y' has vectors => .stream name, pin A = words begins another block
        seek    V
        seek    W
        vfmul   s, x, x ; error: vfmul multiplies the next vector of a stream => declare it with .vectors W, pin A = words, and write W+
        vfmul   s, U+, x ; error: 'U' holds words, vfmul takes the other kind => declare the words with .vectors
        fmul    t, W+, x ; error: 'W' holds vectors, fmul takes the other kind => declare the words with .stream
        vfmul   s, W+, x
        vfmadd  s, V+, x, s ; error: 's' is no vector of pipe B => vectors of pipe B come from its stream
        vfmul   h, W+, x ; error: state 'h' is one word => write another name
        vfmul   e, W+, x ; error: export 'e' is one word => export its lanes
        fadd    u, s, x ; error: 's' is a vector, fadd reads one word => take a lane of it: vout word, zero, s, 0
        fadd    s, x, x ; error: 's' is a vector already
        vbelow  w, 1.5, s ; error: operand a of vbelow is no vector => vfmul v, W+, word makes a vector of a word with a stream of ones
        vabove  w, x, s, s ; error: operand a of vabove is no vector => vfmul v, W+, word makes a vector of a word with a stream of ones
        vscale  w, s, x, s ; error: operand b of vscale is no vector => vfmul v, W+, word makes a vector of a word with a stream of ones
        vout    v, x, u, 1 ; error: 'u' is no vector => write it before with vfmul or vfmadd
        vout    v, x, s, 4 ; error: there is no lane 4 => lanes are 0..3
        vout    v, x, s, 3
        mov     F, v
        halt
