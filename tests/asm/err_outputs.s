; Outputs are written exactly once on every path.
.input  x
.output F1, safe = 0.0
.output F2, safe = 0.0 ; error: output 'F2' is not written on every path => write it once: mov F2, value
.output F3, safe = 0.0
.output F4, safe = 0.0 ; error: output 'F4' is not written => write it once: mov F4, value
        mov     F1, x
        mov     F1, 1.0 ; error: output 'F1' is written twice => select the value first, then write the output once
        bz      x, other
        mov     F2, x
        jmp     join
other:  mov     F3, x
join:   mov     F3, 1.0 ; error: output 'F3' is written twice => select the value first, then write the output once
        halt
