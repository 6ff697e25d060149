; The run must end.
.input  x
        fadd    t, x, x
        mov     u, t ; error: the program ends without halt => add halt after the last operation
