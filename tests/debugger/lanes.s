; Two vectors, summed over their lanes: y = 10*x0 + 26*x1.
.program "lanes"
.config wide
.input x0, x1
.output y, safe = 0.0
.vectors W, pin A = 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0
seek W
vfmul v, W+, x0
vfmadd v2, W+, x1, v
vout p, zero, v2, 0
vout q, p, v2, 1
vout r, q, v2, 2
vout s, r, v2, 3
mov y, s
halt
