; Loops: how deep, what may not be inside, what is not the same in every round.
.config stream
.input  x
.output F, safe = 0.0 ; error: output 'F' is not written on every path => write it once: mov F, value
.output G, safe = 0.0 ; error: output 'G' is not written on every path => write it once: mov G, value
.stream U, pin A = 1.0, 2.0, 3.0, 4.0
.stream V, pin A = 5.0, 6.0
        endloop ; error: endloop without a loop => remove it
        fmul    s, x, x
        loop    2 ; error: the loop has no operation => remove it
        endloop
        seek    U
        loop    2
        fmul    t, U+, x
        fmadd   s, U+, x, t
        endloop
        seek    U+1
        loop    2
        fmul    t, U+, x
        fmadd   s, U+, x, t ; error: 'U' has no word left of its 4 => seek U before it, or add words
        endloop
        loop    3
        seek    V
        fmul    t, V+, x
        fmadd   s, V+, x, t
        endloop
        loop    2
        loop    2
        loop    2
        loop    2 ; error: a loop inside 3 others => the core has 3 levels of loops: write out the innermost body
        fmul    s, s, x
        endloop
        endloop
        endloop
        endloop
        loop    2
        bz      x, out ; error: bz inside the loop of tests/asm/err_loops.s:36 => a loop has a fixed number of rounds: choose values with sel, fmin or fsat
        mov     F, x ; error: output 'F' is written in every round of a loop => write a register in the loop, and the output once after it
        fmul    r, q, x ; error: 'q' is not written on every path before it is read => its first write is in tests/asm/err_loops.s:40
        fmul    q, x, x
        endloop
        loop    3
there:  fmul    s, s, x ; error: label 'there' inside the loop of tests/asm/err_loops.s:42 => a loop has a fixed number of rounds: choose values with sel, fmin or fsat
        endloop
        { loop 2 | fmul s, s, x } halt ; error: loop in a bundle that ends the run
out:    mov     G, s
        loop    4 ; error: loop without endloop => add endloop after its body
        fmul    s, s, x
        halt ; error: halt inside the loop of tests/asm/err_loops.s:47 => a loop has a fixed number of rounds: choose values with sel, fmin or fsat
