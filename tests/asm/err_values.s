; Operands that cannot be meant.
.input  s
.data   tab = 1.0, 2.0
.output F, safe = 0.0
        fadd    f, s, s
        mov     g, f
        ld      t, tab[f] ; error: 'f' is a float (fadd writes it), an index is an int32 => convert it with f2i or f2it
        ld      u, tab[g] ; error: 'g' is a float (mov writes it), an index is an int32 => convert it with f2i or f2it
        f2i     n, f
        ld      v, tab[n]
        fsat    w, s, 2.0, 1.0 ; error: fsat saturates to 2..1: the lower bound is above the upper => fsat dst, a, lower, upper
        mov     F, w
        halt
