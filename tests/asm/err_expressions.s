; Constant expressions.
.const  A = 1/0 ; error: division by zero in an expression
.const  B = sqrt(0 - 4) ; error: square root of the negative number -4
.const  C = 1e39 ; error: 1e+39 is not a finite binary32 number => constants are finite; the largest magnitude is 3.40282347e+38
.const  D = 2* ; error: expected a number, a name or '(', found the end of the line
.const  E = (1 + 2 ; error: expected ')' to close the parenthesis, found the end of the line
.const  F = tan(1) ; error: unknown function 'tan' => functions are sqrt, sin, cos, abs
.const  G = squrt(2) ; error: unknown function 'squrt' => did you mean 'sqrt'?
.const  radius = 0.5
.const  H = raduis*2 ; error: 'raduis' is not the name of a constant => did you mean 'radius'?
.const  I = t ; error: 't' is not the name of a constant => declare it above with .const or .param
.const  J = 1e300*1e300 ; error: the result of '*' is not finite => expressions are evaluated in double precision, up to 1.8e308
.param  K ; error: expected '=' after the name, found the end of the line
.const  L = abs(1, 2) ; error: expected ')' to close abs(, found ','
        halt
