; What a beginner writes, and the help.
.input  x, y
.state  a = 0, b = 0 ; error: 'b' is a second name; this directive declares one => write .state b ... in a line of its own
.const  c = 1, d = 2 ; error: 'd' is a second name; this directive declares one => write .const d ... in a line of its own
.output F, safe = 0.0
again ; error: unknown operation 'again' => a label is written with a colon: again:
again   fadd t, x, y ; error: unknown operation 'again' => a label is written with a colon: again:
        add     t, x, y ; error: unknown operation 'add' => did you mean 'fadd', for integers 'iadd'?
        mul     u, x, y ; error: unknown operation 'mul' => did you mean 'fmul'?
        FADD    u, x, y ; error: unknown operation 'FADD' => operations are written in lower case: fadd
        move    F, x ; error: unknown operation 'move' => did you mean 'mov'?
        HALT ; error: unknown operation 'HALT' => operations are written in lower case: halt
        ret ; error: unknown operation 'ret' => did you mean 'halt'?
