; Registers and names as destinations and sources.
.input  x
.const  R = 0.5
.output F1, safe = 0.0
.data   table = 1
.state  count : int = 0
        mov     F1, x
        fadd    a64, x, x ; error: there is no register 'a64' => bank A is a0..a63
        mov     k3, x ; error: 'k3' cannot be written => banks A, B and C can
        mov     zero, x ; error: 'zero' cannot be written => banks A, B and C can
        mov     pi, x ; error: 'pi' is a constant and cannot be written
        mov     a3, x ; error: mov cannot write 'a3': its results go to bank C
        fadd    c3, x, x ; error: fadd cannot write 'c3': its results go to bank A or B => copy with mov
        mov     x, R ; error: 'x' is an input and cannot be written
        mov     R, x ; error: 'R' is a constant and cannot be written
        mov     table, x ; error: 'table' is data memory and cannot be written
        fadd    t1, F1, x ; error: the output 'F1' cannot be read => write a register, read that, and mov it to the output
        fadd    t2, o0, x ; error: the output 'o0' cannot be read => write a register, read that, and mov it to the output
        mov     o7, x ; error: there is no output 'o7' => 1 declared with .output
        fadd    t3, k128, x ; error: there is no register 'k128' => bank K is k0..k127
        fadd    F1, x, x ; error: fadd cannot write the output 'F1' => only auxiliary operations write outputs: write a register and mov it
        fadd    count, x, x ; error: 'count' is of type int, fadd writes type float => write a symbolic register first and convert it
        halt
