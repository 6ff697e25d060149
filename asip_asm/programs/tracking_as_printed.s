; SPDX-License-Identifier: Apache-2.0
; The tracking law of the five-axis robot, every equation evaluated as it is printed: nothing is
; shared between equations, repeated subexpressions inside an equation are computed again. Comments
; name the equations of docs/law.md. Where rounding need not be the PC's, a multiplication and the
; addition after it are one fused operation.
;
; The states start as the law does: no sign, no boost running, empty integrators.

.program  "tracking, as printed"
.interface "tracking_as_printed.interface.toml"

.const    xp1 = 0
.const    xp2 = sqrt(3)/2*R
.const    xp3 = -(sqrt(3)/2*R)
.const    yp1 = R
.const    yp2 = -(R/2)
.const    yp3 = -(R/2)
.const    encoder_table = 2*pi/turn_table
; Constants in two parts: the high one is rounded to a multiple of 2^-20 or 2^-36 by adding and
; subtracting 2^52 times that step in double precision, so binary32 holds it exactly.
.const    xp2_high = (xp2 + 4294967296) - 4294967296
.const    xp2_low = xp2 - xp2_high
.const    xp3_high = (xp3 + 4294967296) - 4294967296
.const    xp3_low = xp3 - xp3_high
.const    encoder_high = (encoder_table + 65536) - 65536
.const    encoder_low = encoder_table - encoder_high
.const    KP_legs = 3*(2*pi*f_legs)*(2*pi*f_legs)
.const    KV_legs = 3*(2*pi*f_legs)
.const    KI_legs = (2*pi*f_legs)*(2*pi*f_legs)*(2*pi*f_legs)
.const    KP_table = 3*(2*pi*f_table)*(2*pi*f_table)
.const    KV_table = 3*(2*pi*f_table)
.const    KI_table = (2*pi*f_table)*(2*pi*f_table)*(2*pi*f_table)

; -------------------------------- inverse kinematics, desired position

; (8)-(11) are the bits of the same formulas compiled for a PC in single precision: only additions
; of twice or half a rounded value are fused, and doubling or halving is exact. x_p1 = 0 is not
; subtracted.

; l = sqrt((x-xp)^2 + (y-yp)^2 + z^2). The integrator adds up every constant error of l, so the sums
; of squares are fused, and with xp in two parts (x-xp)^2 is (x-high)^2 - 2 (x-high) low.
.macro length l, xp, xp_low, yp
.if \xp
        fsub    dx\@, x, \xp                       ; (7)
        fmul    px\@, (-2*\xp_low), dx\@           ; (7)
        fmadd   qx\@, dx\@, dx\@, px\@             ; (7)
.else
        fmul    qx\@, x, x                         ; (7)
.endif
        fsub    dy\@, y, \yp                       ; (7)
        fmadd   qxy\@, dy\@, dy\@, qx\@            ; (7)
        fmadd   q\@, z, z, qxy\@                   ; (7)
        fsqrt   \l, q\@                            ; (7)
.endm

; v = 1/2 (2(x-xp)vx + 2(y-yp)vy + 2z vz) / sqrt((x-xp)^2 + (y-yp)^2 + z^2)
.macro speed v, xp, yp
.if \xp
        fsub    dx\@, x, \xp                       ; (8)
        fmul    sx\@, dx\@, vx                     ; (8)
.else
        fmul    sx\@, x, vx                        ; (8)
.endif
        fsub    dy\@, y, \yp                       ; (8)
        fmul    sy\@, dy\@, vy                     ; (8)
        fmul    sz\@, z, vz                        ; (8)
        fmul    s2x\@, 2.0, sx\@                   ; (8)
        fmadd   s2xy\@, 2.0, sy\@, s2x\@           ; (8)
        fmadd   s\@, 2.0, sz\@, s2xy\@             ; (8)
        fmul    half\@, 0.5, s\@                   ; (8)
.if \xp
        fsub    ex\@, x, \xp                       ; (8)
        fmul    qx\@, ex\@, ex\@                   ; (8)
.else
        fmul    qx\@, x, x                         ; (8)
.endif
        fsub    ey\@, y, \yp                       ; (8)
        fmul    qy\@, ey\@, ey\@                   ; (8)
        fadd    qxy\@, qx\@, qy\@                  ; (8)
        fmul    qz\@, z, z                         ; (8)
        fadd    q\@, qxy\@, qz\@                   ; (8)
        fsqrt   root\@, q\@                        ; (8)
        fdiv    \v, half\@, root\@                 ; (8)
.endm

; a = -1/4 S^2/Q^(3/2) + 1/2 (2vx^2 + 2(x-xp)ax + 2vy^2 + 2(y-yp)ay + 2vz^2 + 2z az)/sqrt(Q),
; Q^(3/2) = Q sqrt(Q)
.macro acceleration a, xp, yp
.if \xp
        fsub    dx\@, x, \xp                       ; (9)
        fmul    sx\@, dx\@, vx                     ; (9)
.else
        fmul    sx\@, x, vx                        ; (9)
.endif
        fsub    dy\@, y, \yp                       ; (9)
        fmul    sy\@, dy\@, vy                     ; (9)
        fmul    sz\@, z, vz                        ; (9)
        fmul    s2x\@, 2.0, sx\@                   ; (9)
        fmadd   s2xy\@, 2.0, sy\@, s2x\@           ; (9)
        fmadd   s\@, 2.0, sz\@, s2xy\@             ; (9)
        fmul    ss\@, s\@, s\@                     ; (9)
.if \xp
        fsub    ex\@, x, \xp                       ; (9)
        fmul    qx\@, ex\@, ex\@                   ; (9)
.else
        fmul    qx\@, x, x                         ; (9)
.endif
        fsub    ey\@, y, \yp                       ; (9)
        fmul    qy\@, ey\@, ey\@                   ; (9)
        fadd    qxy\@, qx\@, qy\@                  ; (9)
        fmul    qz\@, z, z                         ; (9)
        fadd    q\@, qxy\@, qz\@                   ; (9)
        fsqrt   root\@, q\@                        ; (9)
        fmul    cube\@, q\@, root\@                ; (9)
        fdiv    third\@, ss\@, cube\@              ; (9)
        fmul    first\@, -0.25, third\@            ; (9)
        fmul    vvx\@, vx, vx                      ; (9)
        fmul    vvy\@, vy, vy                      ; (9)
        fmul    vvz\@, vz, vz                      ; (9)
.if \xp
        fsub    fx\@, x, \xp                       ; (9)
        fmul    ux\@, fx\@, ax                     ; (9)
.else
        fmul    ux\@, x, ax                        ; (9)
.endif
        fsub    fy\@, y, \yp                       ; (9)
        fmul    uy\@, fy\@, ay                     ; (9)
        fmul    uz\@, z, az                        ; (9)
        fmul    n\@, 2.0, vvx\@                    ; (9)
        fmadd   n\@, 2.0, ux\@, n\@                ; (9)
        fmadd   n\@, 2.0, vvy\@, n\@               ; (9)
        fmadd   n\@, 2.0, uy\@, n\@                ; (9)
        fmadd   n\@, 2.0, vvz\@, n\@               ; (9)
        fmadd   n\@, 2.0, uz\@, n\@                ; (9)
.if \xp
        fsub    gx\@, x, \xp                       ; (9)
        fmul    px\@, gx\@, gx\@                   ; (9)
.else
        fmul    px\@, x, x                         ; (9)
.endif
        fsub    gy\@, y, \yp                       ; (9)
        fmul    py\@, gy\@, gy\@                   ; (9)
        fadd    pxy\@, px\@, py\@                  ; (9)
        fmul    pz\@, z, z                         ; (9)
        fadd    p\@, pxy\@, pz\@                   ; (9)
        fsqrt   base\@, p\@                        ; (9)
        fdiv    second\@, n\@, base\@              ; (9)
        fmadd   \a, 0.5, second\@, first\@         ; (9)
.endm

        length  l1, xp1, 0, yp1
        length  l2, xp2_high, xp2_low, yp2
        length  l3, xp3_high, xp3_low, yp3
        speed   v1, xp1, yp1
        speed   v2, xp2, yp2
        speed   v3, xp3, yp3
        acceleration acc1, xp1, yp1
        acceleration acc2, xp2, yp2
        acceleration acc3, xp3, yp3

; -------------------------------- measured position and velocity

; l = float(count) / (counts per metre), which is exact but for one rounding, unlike a product with the
; resolution, whose own rounding would be a constant error of every length. v = (l - before)/T_s
.macro measure_leg position, v, before, count
        i2f     n\@, \count                        ; (28)
        fdiv    \position, n\@, (1/encoder_legs)   ; (28)
        fsub    d\@, \position, \before           ; (28)
        fdiv    \v, d\@, T_s                       ; (28)
        mov     \before, \position                 ; (28)
.endm

; theta = float(count) * resolution, the resolution in two parts for the same reason
.macro measure_table position, v, before, count
        i2f     n\@, \count                        ; (36)
        fmul    low\@, n\@, encoder_low            ; (36)
        fmadd   \position, n\@, encoder_high, low\@ ; (36)
        fsub    d\@, \position, \before           ; (36)
        fdiv    \v, d\@, T_s                       ; (36)
        mov     \before, \position                 ; (36)
.endm

        measure_leg   lm1, vm1, position1_before, count1
        measure_leg   lm2, vm2, position2_before, count2
        measure_leg   lm3, vm3, position3_before, count3
        measure_table theta4, omega4, position4_before, count4
        measure_table theta5, omega5, position5_before, count5

; -------------------------------- forward kinematics, measured position

        fmul    x_q3, lm3, lm3                     ; (14)
        fmsub   x_d, lm2, lm2, x_q3                ; (14)
        fmul    x_n, (-sqrt(3)), x_d               ; (14)
        fdiv    xm, x_n, (6*R)                     ; (14)

        fmul    y_t, 2.0, lm1                      ; (14)
        fmul    y_q2, lm2, lm2                     ; (14)
        fmsub   y_n, y_t, lm1, y_q2                ; (14)
        fnmsub  y_n, lm3, lm3, y_n                 ; (14)
        fdiv    ym, y_n, (-6*R)                    ; (14)

        fmul    z_q3, lm3, lm3                     ; (15)
        fmsub   z_d, lm2, lm2, z_q3                ; (15)
        fmul    z_dd, z_d, z_d                     ; (15)
        fdiv    z_x2, z_dd, (12*R*R)               ; (15)
        fmul    z_t, 2.0, lm1                      ; (15)
        fmul    z_q2, lm2, lm2                     ; (15)
        fmsub   z_n, z_t, lm1, z_q2                ; (15)
        fnmsub  z_n, lm3, lm3, z_n                 ; (15)
        fdiv    z_y, z_n, (6*R)                    ; (15)
        fadd    z_y, z_y, R                        ; (15)
        fmsub   z_r, lm1, lm1, z_x2                ; (15)
        fnmsub  z_r, z_y, z_y, z_r                 ; (15)
        fsqrt   zm, z_r                            ; (15)

; -------------------------------- reduced masses

; M = sum + m_r,ij + m_j,ij for one other leg j:
; c = (li^2 + lj^2 - 3R^2)/(2 li lj), m_r = m_s c^2, m_j = (J_a + m_s (lj - l_c)^2)(1 - c^2)/lj^2
.macro reduce M, sum, li, lj
        fmsub   n\@, \lj, \lj, (3*R*R)             ; (23)
        fmadd   n\@, \li, \li, n\@                 ; (23)
        fmul    d\@, 2.0, \li                      ; (23)
        fmul    d\@, d\@, \lj                      ; (23)
        fdiv    cos\@, n\@, d\@                    ; (23)
        fmul    mc\@, m_s, cos\@                   ; (23)
        fmadd   r\@, mc\@, cos\@, \sum             ; (23)
        fsub    h\@, \lj, l_c                      ; (23)
        fmul    mh\@, m_s, h\@                     ; (23)
        fmadd   J\@, mh\@, h\@, J_a                ; (23)
        fnmsub  u\@, cos\@, cos\@, 1.0             ; (23)
        fmul    Ju\@, J\@, u\@                     ; (23)
        fmul    q\@, \lj, \lj                      ; (23)
        fdiv    j\@, Ju\@, q\@                     ; (23)
        fadd    \M, r\@, j\@                       ; (23)
.endm

        reduce  M1_2, (m_s + m_p), lm1, lm2
        reduce  M1, M1_2, lm1, lm3
        reduce  M2_1, (m_s + m_p), lm2, lm1
        reduce  M2, M2_1, lm2, lm3
        reduce  M3_1, (m_s + m_p), lm3, lm1
        reduce  M3, M3_1, lm3, lm2

; -------------------------------- gravity

; m_zi = (m_s (li - l_c) - m_c r_c)/li
.macro carry m, li
        fsub    h\@, \li, l_c                      ; (25)
        fmsub   t\@, m_s, h\@, mr_c                ; (25)
        fdiv    \m, t\@, \li                       ; (25)
.endm

        carry   m_z1, lm1
        carry   m_z2, lm2
        carry   m_z3, lm3
        fadd    m_z, m_p, m_z1                     ; (25)
        fadd    m_z, m_z, m_z2                     ; (25)
        fadd    m_z, m_z, m_z3                     ; (25)
        fmul    weight, m_z, g                     ; (24)

; w = ((xm-xp)/l, (ym-yp)/l, zm/l)
.macro direction wx, wy, wz, xp, yp, l
.if \xp
        fsub    dx\@, xm, \xp                      ; (24)
        fdiv    \wx, dx\@, \l                      ; (24)
.else
        fdiv    \wx, xm, \l                        ; (24)
.endif
        fsub    dy\@, ym, \yp                      ; (24)
        fdiv    \wy, dy\@, \l                      ; (24)
        fdiv    \wz, zm, \l                        ; (24)
.endm

        direction wx1, wy1, wz1, xp1, yp1, lm1
        direction wx2, wy2, wz2, xp2, yp2, lm2
        direction wx3, wy3, wz3, xp3, yp3, lm3

; Cramer's rule: cofactors of the third row, determinant expanded along it
.macro cofactor C, xi, yj, xj, yi
        fmul    t\@, \xj, \yi                      ; (24)
        fmsub   \C, \xi, \yj, t\@                  ; (24)
.endm

        cofactor C1, wx2, wy3, wx3, wy2
        cofactor C2, wx3, wy1, wx1, wy3
        cofactor C3, wx1, wy2, wx2, wy1
        fmul    det, wz1, C1                       ; (24)
        fmadd   det, wz2, C2, det                  ; (24)
        fmadd   det, wz3, C3, det                  ; (24)
        fmul    n_G1, weight, C1                   ; (24)
        fdiv    G1, n_G1, det                      ; (24)
        fmul    n_G2, weight, C2                   ; (24)
        fdiv    G2, n_G2, det                      ; (24)
        fmul    n_G3, weight, C3                   ; (24)
        fdiv    G3, n_G3, det                      ; (24)

        fsin    tilt, theta4                       ; (27)
        fmul    G4, (r_4*m_4*g), tilt              ; (27)

; -------------------------------- tracking law

; e, then s_c by the integrator with its boost after a reversal. t_c goes on by T_s unless v_d
; changes its sign, then t_c = 0 and phi_t = 0: phi_t is computed for the first case while v_d is
; not known yet. phi_e is 0 or 1, its product is a selection; phi_c e = phi_t e + e;
; 2(xi_c - 1)(1 - t_c/T_c) = 2(xi_c - 1) - 2(xi_c - 1) t_c/T_c.
.macro integrate e, s_c, sign, ticks, desired, position, v_d, e_c, s_max
        fsub    \e, \desired, \position            ; (28)
        fadd    next\@, \ticks, 1.0                ; (33)
        fmul    t_c\@, next\@, T_s                 ; (33)
        fabs    size\@, \e                         ; (32)
        fle     phi_e\@, \e_c, size\@              ; (32)
        fdiv    part\@, t_c\@, T_c                 ; (31)
        fnmsub  ramp\@, (2*(xi_c - 1)), part\@, (2*(xi_c - 1)) ; (31)
        sel     phi_t\@, phi_e\@, ramp\@, zero     ; (31)
        flt     before\@, t_c\@, T_c               ; (31)
        sel     phi_t\@, before\@, phi_t\@, zero   ; (31)
        fle     early\@, t_c\@, (T_c/2)            ; (31)
        sel     phi_t\@, early\@, (xi_c - 1), phi_t\@ ; (31)
        fsgn    s_g\@, \v_d                        ; (35)
        feq     same\@, s_g\@, \sign               ; (37)
        mov     \sign, s_g\@                       ; (37)
        sel     \ticks, same\@, next\@, zero       ; (33)
        sel     phi_t\@, same\@, phi_t\@, zero     ; (31)
        fmadd   boosted\@, phi_t\@, \e, \e         ; (30)
        fmadd   sum\@, boosted\@, T_s, \s_c        ; (29)
        fsat    \s_c, sum\@, (-\s_max), \s_max     ; (29)
.endm

; demand = a_d + K_P e + K_V (v_d - v) + K_I s_c
.macro demand u, a_d, e, v_d, v, s_c, KP, KV, KI
        fsub    e_v\@, \v_d, \v                    ; (28)
        fmadd   u\@, \KP, \e, \a_d                 ; (28)
        fmadd   u\@, \KV, e_v\@, u\@               ; (28)
        fmadd   \u, \KI, \s_c, u\@                 ; (28)
.endm

        integrate e1, s_c1, sign1, ticks1, l1, lm1, v1, e_c_legs, s_max_legs
        integrate e2, s_c2, sign2, ticks2, l2, lm2, v2, e_c_legs, s_max_legs
        integrate e3, s_c3, sign3, ticks3, l3, lm3, v3, e_c_legs, s_max_legs
        integrate e4, s_c4, sign4, ticks4, alpha, theta4, w_alpha, e_c_table, s_max_table
        integrate e5, s_c5, sign5, ticks5, gamma, theta5, w_gamma, e_c_table, s_max_table

        demand  u1, acc1, e1, v1, vm1, s_c1, KP_legs, KV_legs, KI_legs
        demand  u2, acc2, e2, v2, vm2, s_c2, KP_legs, KV_legs, KI_legs
        demand  u3, acc3, e3, v3, vm3, s_c3, KP_legs, KV_legs, KI_legs
        demand  u4, eps_alpha, e4, w_alpha, omega4, s_c4, KP_table, KV_table, KI_table
        demand  u5, eps_gamma, e5, w_gamma, omega5, s_c5, KP_table, KV_table, KI_table

        fmadd   force1, M1, u1, G1                 ; (28)
        fmadd   force2, M2, u2, G2                 ; (28)
        fmadd   force3, M3, u3, G3                 ; (28)
        fmadd   torque4, J_44, u4, G4              ; (36)
        fmul    torque5, J_55, u5                  ; (36)

        fsat    F1, force1, (-F_max), F_max        ; (28)
        fsat    F2, force2, (-F_max), F_max        ; (28)
        fsat    F3, force3, (-F_max), F_max        ; (28)
        fsat    tau4, torque4, (-tau_max_4), tau_max_4 ; (36)
        fsat    tau5, torque5, (-tau_max_5), tau_max_5 ; (36)
        halt
