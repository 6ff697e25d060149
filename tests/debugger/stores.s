; Stores by a computed address and by a constant one, the last in the last bundle.
.program  "stores"
.input    x
.output   y, safe = 0.0
.const    second = 1 : int
.data     table = 0.0, 0.0, 0.0
.data     other = 0.0

        mov     i, second
        st      x, table[i]
        fadd    t, x, x
        fmul    u, t, x
        st      u, other
        fmul    v, u, x
        mov     y, t
        st      v, table+2
        halt
