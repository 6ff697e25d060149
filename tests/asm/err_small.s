; assemble: --config small
; Configuration small has no bank B and one slot.
.input  x
.state  s = 0, pin B ; error: configuration 'small' has no bank B => use bank A
        { fadd b1, x, x } ; error: configuration 'small' has no bank B => use bank A
        { fadd t, b2, x } ; error: configuration 'small' has no bank B => use bank A
        { fadd t, x, x | mov c1, x } ; error: no slot left for fadd: configuration 'small' has slots any; mov takes slot 0 => put this multiply-add operation into another bundle
        halt
