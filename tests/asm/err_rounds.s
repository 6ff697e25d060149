; Rounds of a loop are a constant.
.input  x
.const  half = 0.5
.const  n = 3
.output F, safe = 0.0
        repeat  3 ; error: unknown operation 'repeat' => did you mean 'loop'?
        loop    0 ; error: a loop of 0 rounds => the number of rounds is an integer constant, 1..16384
        loop    n+half ; error: a loop of 3.5 rounds => the number of rounds is an integer constant, 1..16384
        loop    16385 ; error: a loop of 16385 rounds => the number of rounds is an integer constant, 1..16384
        loop    x ; error: 'x' is not the name of a constant => declare it above with .const or .param
        { fmul s, x, x | endloop } ; error: 'endloop' is no operation of a bundle => write it in its own line
        loop    n ; error: configuration 'fast' has no loops => loops are in .config stream or wide
        fmul    s, x, x
        endloop
        mov     F, x
        halt
