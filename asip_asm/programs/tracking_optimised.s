; SPDX-License-Identifier: Apache-2.0
; The tracking law of the five-axis robot, rearranged for the ASIP: inputs, outputs, exports and law
; are those of tracking_as_printed.s, the algebra is not. Comments name the equations of docs/law.md.
;
; - The error e = l_d - l is formed to about 1e-10 m although l_d alone has a rounding error of 3e-8
;   m (section 2).
; - v is the exact difference of two encoder counts times the constant resolution/T_s.
; - Measured lengths are counts: the resolution is part of the constants.
; - Squares of measured lengths are taken less 3R^2/2. Then sums of two of them are the numerators of
;   the cosines, and little cancels in z.
; - Statics in closed form; masses as M_ii = m_p + 3 m_s - D_j sin^2(i,j) - D_k sin^2(i,k),
;   D_j = m_s - J_j/l_j^2.
; - The integrators are branch-free and hold K_I s_c [m/s^2, rad/s^2].
;
; Counts must stay below 2^24 in magnitude (4.19 m, 64 turns), where they are exact as floats.

.program  "tracking, optimised"
.interface "tracking_optimised.interface.toml"

; -------------------------------- 1. measured lengths
; Resolutions as a single float and the rest: multiplying by 2^29 + 1 rounds a double to 24 bits
; (Veltkamp).
.const    q = encoder_legs
.const    qh = (q*536870913) - ((q*536870913) - q)
.const    ql = q - qh
.const    q_table = 2*pi/turn_table
.const    q_tableh = (q_table*536870913) - ((q_table*536870913) - q_table)
.const    q_tablel = q_table - q_tableh

        i2f     n_1, count1                        ; (28)
        i2f     n_2, count2                        ; (28)
        i2f     n_3, count3                        ; (28)
        i2f     n_4, count4                        ; (28)
        i2f     n_5, count5                        ; (28)

        ; w = 1/(2l), for the Newton step of l_d and for masses and gravity
        fdiv    w1, (1/(2*q)), n_1                 ; (23)
        fdiv    w2, (1/(2*q)), n_2                 ; (23)
        fdiv    w3, (1/(2*q)), n_3                 ; (23)

        ; p = (l^2 - 3R^2/2)/q^2, and their sums
.const    p0 = 3*R*R/(2*q*q)
        fmsub   p1, n_1, n_1, p0                   ; (14)
        fmsub   p2, n_2, n_2, p0                   ; (14)
        fmsub   p3, n_3, n_3, p0                   ; (14)
        fadd    p12, p1, p2                        ; (23)
        fadd    p13, p1, p3                        ; (23)
        fadd    p23, p2, p3                        ; (23)
        fadd    sum, p12, p3                       ; (14)

; -------------------------------- 2. inverse kinematics, desired position
; With Q = l_d^2: Q_1 = x^2 + (y - R)^2 + z^2, and Q_2, Q_3 = Q_1 + 3 R y -+ 2 xp x exactly. Start
; points are (0, R) and (+-xp, -yp).
; Coordinates and constants are split into a multiple of 2^-11, name ending in h, and the rest, name
; ending in l; adding and subtracting 1.5*2^41 rounds a double to 2^-11.
.const    xp = sqrt(3)/2*R
.const    xp2h = (2*xp + 3298534883328) - 3298534883328
.const    xp2l = 2*xp - xp2h
.const    yp = R/2
.const    Rh = (R + 3298534883328) - 3298534883328
.const    Rl = R - Rh
.const    R3h = (3*R + 3298534883328) - 3298534883328
.const    R3l = 3*R - R3h
.const    grid = 6144                              ; 1.5*2^12: adding it rounds to 2^-11

        ; offsets from the start points, and from them lengths good to a few roundings
        fadd    dx2, x, (-xp)                      ; (7)
        fadd    dx3, x, xp                         ; (7)
        fsub    dy1, y, R                          ; (7)
        fadd    dy2, y, yp                         ; (7)
        fmul    zz, z, z                           ; (7)
        fmadd   yz1, dy1, dy1, zz                  ; (7)
        fmadd   Q1, x, x, yz1                      ; (7)
        fmadd   yz2, dy2, dy2, zz                  ; (7)
        fmadd   Q2, dx2, dx2, yz2                  ; (7)
        fmadd   Q3, dx3, dx3, yz2                  ; (7)
        fsqrt   l1_0, Q1                           ; (7)
        fsqrt   l2_0, Q2                           ; (7)
        fsqrt   l3_0, Q3                           ; (7)

        ; set-point as multiples of 2^-11 and exact rests (that of z is not needed)
        fadd    xg, x, grid                        ; (7)
        fsub    xh, xg, grid                       ; (7)
        fsub    xl, x, xh                          ; (7)
        fadd    yg, y, grid                        ; (7)
        fsub    yh, yg, grid                       ; (7)
        fsub    yl, y, yh                          ; (7)
        fadd    zg, z, grid                        ; (7)
        fsub    zh, zg, grid                       ; (7)

        ; Qh: squares and sums of multiples of 2^-11 below 4 are exact
        fsub    dy1h, yg, (grid + Rh)              ; (7)
        fmul    zzh, zh, zh                        ; (7)
        fmadd   xzh, xh, xh, zzh                   ; (7)
        fmadd   Q1h, dy1h, dy1h, xzh               ; (7)
        fmadd   Q23h, yh, R3h, Q1h                 ; (7)
        fnmsub  Q2h, xh, xp2h, Q23h                ; (7)
        fmadd   Q3h, xh, xp2h, Q23h                ; (7)

        ; Ql = Q - Qh: d^2 - dh^2 = dl (d + dh), of z in one operation; then 3 R y and 2 xp x
        fmsub   zzl, z, z, zzh                     ; (7)
        fadd    x_s, x, xh                         ; (7)
        fmadd   xzl, xl, x_s, zzl                  ; (7)
        fsub    dy1l, yl, Rl                       ; (7)
        fadd    dy1_s, dy1, dy1h                   ; (7)
        fmadd   Q1l, dy1l, dy1_s, xzl              ; (7)
        fmul    y3, y, R3l                         ; (7)
        fmadd   y3, yl, R3h, y3                    ; (7)
        fmul    x2, x, xp2l                        ; (7)
        fmadd   x2, xl, xp2h, x2                   ; (7)
        fadd    Q23l, Q1l, y3                      ; (7)
        fsub    Q2l, Q23l, x2                      ; (7)
        fadd    Q3l, Q23l, x2                      ; (7)

        ; rest = Q - l_0^2; one Newton step gives l_d = l_0 + rest/(2l), more than a float
        ; holds; the measured l serves for so small a step
        fnmsub  rest1h, l1_0, l1_0, Q1h            ; (7)
        fadd    rest1, rest1h, Q1l                 ; (7)
        fmadd   l1, rest1, w1, l1_0                ; (7)
        fnmsub  rest2h, l2_0, l2_0, Q2h            ; (7)
        fadd    rest2, rest2h, Q2l                 ; (7)
        fmadd   l2, rest2, w2, l2_0                ; (7)
        fnmsub  rest3h, l3_0, l3_0, Q3h            ; (7)
        fadd    rest3, rest3h, Q3l                 ; (7)
        fmadd   l3, rest3, w3, l3_0                ; (7)

        ; v = ((x-xp)vx + (y-yp)vy + z vz)/l_0
        fmul    s0, z, vz                          ; (8)
        fmadd   s1, dy1, vy, s0                    ; (8)
        fmadd   s1, x, vx, s1                      ; (8)
        fmadd   s23, dy2, vy, s0                   ; (8)
        fmadd   s2, dx2, vx, s23                   ; (8)
        fmadd   s3, dx3, vx, s23                   ; (8)
        fdiv    v1, s1, l1_0                       ; (8)
        fdiv    v2, s2, l2_0                       ; (8)
        fdiv    v3, s3, l3_0                       ; (8)

        ; a = (vx^2 + vy^2 + vz^2 + (x-xp)ax + (y-yp)ay + z az - v^2)/l_0
        fmul    n0, vx, vx                         ; (9)
        fmadd   n0, vy, vy, n0                     ; (9)
        fmadd   n0, vz, vz, n0                     ; (9)
        fmadd   n0, z, az, n0                      ; (9)
        fmadd   n1, dy1, ay, n0                    ; (9)
        fmadd   n1, x, ax, n1                      ; (9)
        fmadd   n23, dy2, ay, n0                   ; (9)
        fmadd   n2, dx2, ax, n23                   ; (9)
        fmadd   n3, dx3, ax, n23                   ; (9)
        fnmsub  n1, v1, v1, n1                     ; (9)
        fnmsub  n2, v2, v2, n2                     ; (9)
        fnmsub  n3, v3, v3, n3                     ; (9)
        fdiv    acc1, n1, l1_0                     ; (9)
        fdiv    acc2, n2, l2_0                     ; (9)
        fdiv    acc3, n3, l3_0                     ; (9)

; -------------------------------- 3. errors of position and velocity

; e = l_d - l: l_0 - l is exact up to one rounding of the small difference
.macro leg_error e, l_0, rest, w, n
        fnmsub  e\@, \n, qh, \l_0                  ; (28)
        fnmsub  e\@, \n, ql, e\@                   ; (28)
        fmadd   \e, \rest, \w, e\@                 ; (28)
.endm

        leg_error e1, l1_0, rest1, w1, n_1
        leg_error e2, l2_0, rest2, w2, n_2
        leg_error e3, l3_0, rest3, w3, n_3

; e = theta_d - theta
.macro table_error e, desired, n
        fnmsub  e\@, \n, q_tableh, \desired        ; (36)
        fnmsub  \e, \n, q_tablel, e\@              ; (36)
.endm

        table_error e4, alpha, n_4
        table_error e5, gamma, n_5

; e_v = v_d - (n - before) resolution/T_s
.macro speed_error e_v, v_d, n, before, resolution
        fsub    d\@, \n, \before                   ; (28)
        mov     \before, \n                        ; (28)
        fnmsub  \e_v, d\@, (\resolution/T_s), \v_d ; (28)
.endm

        speed_error e_v1, v1, n_1, count1_before, q
        speed_error e_v2, v2, n_2, count2_before, q
        speed_error e_v3, v3, n_3, count3_before, q
        speed_error e_v4, w_alpha, n_4, count4_before, q_table
        speed_error e_v5, w_gamma, n_5, count5_before, q_table

; -------------------------------- 4. gravity
; With l^2 = q^2 p + 3R^2/2, P = p1 + p2 + p3:
;   x^2 + y^2 = q^4 (3 (p1^2 + p2^2 + p3^2) - P^2)/(18R^2)
;   z^2 = (l1^2 + l2^2 + l3^2)/3 - R^2 - (x^2 + y^2)
;       = R^2/2 + P (q^2/3 + P q^4/(18R^2)) - q^4 (p1^2 + p2^2 + p3^2)/(6R^2)
;   b_i = 1/3 + q^2 (P - 3p_i)/(9R^2)
;   m_z = m_p + 3m_s - (m_s l_c + m_c r_c)(1/l_1 + 1/l_2 + 1/l_3)

        fmul    pp, p1, p1                         ; (15)
        fmadd   pp, p2, p2, pp                     ; (15)
        fmadd   pp, p3, p3, pp                     ; (15)
        fmadd   zz_s, sum, (q*q*q*q/(18*R*R)), (q*q/3) ; (15)
        fmadd   zz_m, sum, zz_s, (R*R/2)           ; (15)
        fnmsub  zz_m, pp, (q*q*q*q/(6*R*R)), zz_m  ; (15)
        fsqrt   z_m, zz_m                          ; (15)

        fadd    w_sum, w1, w2                      ; (25)
        fadd    w_sum, w_sum, w3                   ; (25)
        fnmsub  weight, w_sum, (2*g*q*(m_s*l_c + mr_c)), (g*q*(m_p + 3*m_s)) ; (25)
        fdiv    press, weight, z_m                 ; (24)

        fmadd   share, sum, (q*q/(9*R*R)), (1/3)   ; (24)
.macro statics G, n, p
        fnmsub  b_\@, \p, (q*q/(3*R*R)), share     ; (24)
        fmul    t\@, b_\@, \n                      ; (24)
        fmul    \G, t\@, press                     ; (24)
.endm

        statics G1, n_1, p1
        statics G2, n_2, p2
        statics G3, n_3, p3

        fmul    theta4, n_4, q_table               ; (27)
        fsin    tilt, theta4                       ; (27)
        fmul    G4, tilt, (r_4*m_4*g)              ; (27)

; -------------------------------- 5. reduced masses
; cos = (p_i + p_j)/(2 n_i n_j) of the angle between two legs; here cos/(2q^2), sin^2/(4q^4)
.macro sine2 s, wi, wj, p_ij
        fmul    w\@, \wi, \wj                      ; (23)
        fmul    cos\@, \p_ij, w\@                  ; (23)
        fnmsub  \s, cos\@, cos\@, (1/(4*q*q*q*q))  ; (23)
.endm
; 4q^4 D = 4q^4 (m_s - (J_a + m_s (l - l_c)^2)/l^2) = 16q^4 w (m_s l_c - w (J_a + m_s l_c^2))
.macro relief D, w
        fnmsub  d\@, \w, (16*q*q*q*q*(J_a + m_s*l_c*l_c)), (16*q*q*q*q*m_s*l_c) ; (23)
        fmul    \D, d\@, \w                        ; (23)
.endm

        sine2   s12, w1, w2, p12
        sine2   s13, w1, w3, p13
        sine2   s23_, w2, w3, p23
        relief  D1, w1
        relief  D2, w2
        relief  D3, w3
        fnmsub  M1, D2, s12, (m_p + 3*m_s)         ; (23)
        fnmsub  M1, D3, s13, M1                    ; (23)
        fnmsub  M2, D1, s12, (m_p + 3*m_s)         ; (23)
        fnmsub  M2, D3, s23_, M2                   ; (23)
        fnmsub  M3, D1, s13, (m_p + 3*m_s)         ; (23)
        fnmsub  M3, D2, s23_, M3                   ; (23)

; -------------------------------- 6. tracking law
; n: ticks since the reversal; that of the reversal itself has no boost and counts as N_c = T_c/T_s
.macro since_reversal n, sign, ticks, v_d
        fsgn    s_g\@, \v_d                        ; (35)
        feq     same\@, s_g\@, \sign               ; (37)
        mov     \sign, s_g\@                       ; (37)
        fmadd   \ticks, \ticks, same\@, same\@     ; (33)
        sel     \n, \ticks, \ticks, (T_c/T_s)      ; (33)
.endm

; phi_c K_I T_s is the line 1 + 2(xi_c - 1)(1 - n/N_c) between 1 and xi_c, times K_I T_s: the
; saturation makes its first half and its end. The condition abs(e) >= e_c holds from n > N_c/2 on.
; Of the legs e comes late: both integrals are made, then one is selected. Up to N_c/2 the threshold
; min(e_c, n - N_c/2 - 1/4) is negative (N_c odd or even, e_c up to 1/4).
.macro integrate_leg integral, sign, ticks, e, v_d
        since_reversal n\@, \sign, \ticks, \v_d
        fnmsub  line\@, n\@, (KI_legs*T_s*2*(xi_c - 1)*T_s/T_c), (KI_legs*T_s*(1 + 2*(xi_c - 1))) ; (31)
        fsat    phi\@, line\@, (KI_legs*T_s), (KI_legs*T_s*xi_c) ; (30)
        fsub    h\@, n\@, (T_c/T_s/2 + 0.25)       ; (32)
        fmin    h\@, h\@, e_c_legs                 ; (32)
        fabs    size\@, \e                         ; (32)
        fle     large\@, h\@, size\@               ; (32)
        fmadd   fast\@, phi\@, \e, \integral       ; (29)
        fmadd   slow\@, \e, (KI_legs*T_s), \integral ; (29)
        sel     next\@, large\@, fast\@, slow\@    ; (29)
        fsat    \integral, next\@, (-(KI_legs*s_max_legs)), (KI_legs*s_max_legs) ; (29)
.endm

; Of the table e comes early. A line through the same point at N_c/2, so steep that it is below 1 half
; a tick later, stands for abs(e) < e_c.
.macro integrate_table integral, sign, ticks, e, v_d
        since_reversal n\@, \sign, \ticks, \v_d
        fsub    h\@, n\@, (T_c/T_s/2)              ; (31)
        fabs    size\@, \e                         ; (32)
        fle     large\@, e_c_table, size\@         ; (32)
        sel     fall\@, large\@, (KI_table*T_s*2*(xi_c - 1)*T_s/T_c), (KI_table*T_s*4*(xi_c - 1)) ; (32)
        fnmsub  line\@, h\@, fall\@, (KI_table*T_s*xi_c) ; (31)
        fsat    phi\@, line\@, (KI_table*T_s), (KI_table*T_s*xi_c) ; (30)
        fmadd   next\@, phi\@, \e, \integral       ; (29)
        fsat    \integral, next\@, (-(KI_table*s_max_table)), (KI_table*s_max_table) ; (29)
.endm

; F = M (a_d + K_V e_v) + G + M (K_P e + K_I s_c), in the order in which the operands come
.macro drive F, M, G, a_d, e, e_v, integral, KP, KV, F_max
        fmadd   soon\@, \e_v, \KV, \a_d            ; (28)
        fmadd   part\@, \M, soon\@, \G             ; (28)
        fmadd   late\@, \e, \KP, \integral         ; (28)
        fmadd   force\@, \M, late\@, part\@        ; (28)
        fsat    \F, force\@, (-\F_max), \F_max     ; (28)
.endm

.const    w_l = 2*pi*f_legs
.const    KP_legs = 3*w_l*w_l
.const    KV_legs = 3*w_l
.const    KI_legs = w_l*w_l*w_l
.const    w_t = 2*pi*f_table
.const    KP_table = 3*w_t*w_t
.const    KV_table = 3*w_t
.const    KI_table = w_t*w_t*w_t

        integrate_leg integral1, sign1, ticks1, e1, s1
        integrate_leg integral2, sign2, ticks2, e2, s2
        integrate_leg integral3, sign3, ticks3, e3, s3
        integrate_table integral4, sign4, ticks4, e4, w_alpha
        integrate_table integral5, sign5, ticks5, e5, w_gamma

        drive   F1, M1, G1, acc1, e1, e_v1, integral1, KP_legs, KV_legs, F_max
        drive   F2, M2, G2, acc2, e2, e_v2, integral2, KP_legs, KV_legs, F_max
        drive   F3, M3, G3, acc3, e3, e_v3, integral3, KP_legs, KV_legs, F_max
        drive   tau4, J_44, G4, eps_alpha, e4, e_v4, integral4, KP_table, KV_table, tau_max_4
        drive   tau5, J_55, zero, eps_gamma, e5, e_v5, integral5, KP_table, KV_table, tau_max_5
        halt
