.watchdog 4000000000
.input x
.output y, safe = 0.0
.const one = 1 : int
        mov i, one
again:
        iadd i, i, one
        bnz i, again
        mov y, x
        halt
