; Reads before writes, labels, unreachable code.
.input  x
.reg    later, never
.export unknown1, R, later ; error: 'unknown1' is exported but never written ; error: 'R' is a constant and cannot be exported => registers, states and inputs can ; error: 'later' is exported but not written on every path => its first write is in tests/asm/err_flow.s:12
.const  R = 1
        fadd    t1, early, x ; error: 'early' is not written on every path before it is read => its first write is in tests/asm/err_flow.s:7
        fadd    early, x, x
        fadd    t2, erly, x ; error: unknown name 'erly' => did you mean 'early'?
        fadd    t3, never, x ; error: 'never' is read but never written
again:  bz      x, skip
        mov     one, x
        mov     later, x
skip:   mov     t4, one ; error: 'one' is not written on every path before it is read => its first write is in tests/asm/err_flow.s:11
        mov     one, t4
        fmul    one, x, x
        bnz     one, agian ; error: label 'agian' is not defined => did you mean 'again'?
        jmp     end
        mov     t5, x ; error: this is never reached => the run ends or jumps away before it, and no branch leads to it
end:    halt
        mov     t6, x ; error: this is never reached => the run ends or jumps away before it, and no branch leads to it
last: ; error: label 'last' is before no operation => add halt after it
