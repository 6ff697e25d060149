; Declarations and results that nothing reads.
.input  x, y ; warning: input 'y' is never read [unused-input]
.input  z ; -Wno-unused-input: the host writes it for another program
.const  gain = 2.0
.const  twice = 2*gain ; warning: constant 'twice' is never read [unused-constant]
.param  rate = 1.0 ; warning: constant 'rate' is never read [unused-constant]
.const  placed = 3.0, pin k9
.state  kept = 0.0 ; warning: state 'kept' is never read [unused-state]
.state  counted = 0.0
.output F, safe = 0.0
.export shown
        fadd    shown, x, x
        fmul    t, x, x ; warning: nothing reads this value of 't' => export it, or leave the operation out [unused-result]
        fmul    t, x, 3.0
        fadd    u, t, x
        fadd    t, x, u
        fadd    counted, x, 1.0
        mov     F, t
        halt
