; Force of one leg, with a wrong sign in it.
.program  "leg force"
.input    x, y, z                  ; position [m]
.input    l                        ; measured length [m]
.const    R = 0.5
.param    K = 400
.state    last = 0.0
.output   F, safe = 0.0
.data     table = 1.0, 2.0, 4.0, 8.0

        fsub    dy, y, R           ; (7)
        fmul    t, x, x            ; (7)
        fmadd   t, dy, dy, t       ; (7)
        fnmsub  q, z, z, t         ; (7)
        fsqrt   l_d, q             ; (7)
        fsub    e, l_d, l          ; (28)
        fsub    de, e, last        ; (29)
        fmul    f, K, e            ; (30)
        fmadd   f, 20.0, de, f     ; (30)
        fsat    F, f, -100.0, 100.0
        mov     last, e
        halt
