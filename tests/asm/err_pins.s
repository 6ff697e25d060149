; Words and registers that the source places.
.input  x, y
.const  A = 1.0, pin k1 ; error: k1 holds the input 'y' => pin constants to k2 or higher
.const  B = 2.0, pin k5
.const  C = 3.0, pin k5 ; error: k5 holds another constant => declared at tests/asm/err_pins.s:4
.const  k6 = 1.0
.const  k6 = 2.0 ; error: k6 holds another constant => declared at tests/asm/err_pins.s:6
.const  k128 = 2.0 ; error: there is no register 'k128' => bank K is k0..k127
.const  k7 = 2.0, pin k8 ; error: a constant cannot be pinned to 'k8' => pin k0..k127
.state  s = 0, pin c3
.state  t = 0, pin c3 ; error: c3 is the register of state 's' already
.state  u = 0, pin b64 ; error: there is no register 'b64' => bank B is b0..b63
.export e = 3 ; error: expected a physical register, found '3'
.export g = zero ; error: 'zero' is no physical register => a0.., b0.., c0.. or k0..
.export h = x ; error: 'x' is no physical register => a0.., b0.., c0.. or k0..
.export i = a64 ; error: there is no register 'a64' => bank A is a0..a63
        fadd    s, x, x ; error: fadd cannot write 's': its results go to bank A or B => copy with mov
        halt
