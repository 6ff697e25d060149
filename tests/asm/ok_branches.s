; assemble: -O0
; Branches, labels, a loop whose values pass from part to part, data memory.
.input  n : int
.data   table = 1.0, 2.0, 0f40400000
.data   4.0
.space  scratch, 2
.output sum, safe = 0.0
        mov     i, n
        mov     total, zero
loop:   ld      v, table[i]
        fadd    s, total, v
        mov     total, s
        st      s, scratch+1
        isub    i, i, 1
        bnz     i, loop
        ld      w, scratch+1
        bz      w, empty
        jmp     done
empty:
done:   mov     sum, total
        halt
; = 009c0400000004000000000400000000
; = 009c0800000004000000000400000000
; = 00dc1001800004000000000400000000
; = 000400000000040000000060030400c2
; = 009c0900000004000000000400000000
; = 00140100000504000000000400000000
; = 00b80302020004000000000400000000
; = 00100300000204000000000400000000
; = 00dc1800000504000000000400000000
; = 000c030c000b04000000000400000000
; = 00080000000b04000000000400000000
; = 019e0304000004000000000400000000
