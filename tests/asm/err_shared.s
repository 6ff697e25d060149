; Names that pass from part to part, and pinned states.
.input  x
.state  s = 0, pin A
.state  u = 0, pin C
        fmul    t, x, x
        mov     s, x ; error: state 's' is pinned to bank A, mov cannot write there => pin C, or write it with a multiply-add operation
        fadd    u, x, x ; error: state 'u' is pinned to bank C, fadd cannot write there => pin another bank, or insert mov
        bz      x, skip
        mov     t, 1.0 ; error: 't' keeps its value from one part of the program to another, but mov writes another bank than fmul in tests/asm/err_shared.s:5 => insert mov: write another name and mov it to 't'
skip:   fadd    v, t, x
        halt
