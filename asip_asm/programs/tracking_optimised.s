; SPDX-License-Identifier: Apache-2.0
; The tracking law of the five-axis robot, rearranged for the ASIP: inputs, outputs, exports and law
; are those of tracking_as_printed.s, the algebra is not. Comments name the equations of docs/law.md.
;
; - The error e = l_d - l is formed to about 1e-10 m although l_d alone has a rounding error of 3e-8
;   m (section 1).
; - v is the exact difference of two encoder counts times the constant resolution/T_s.
; - Measured lengths are counts: the resolution is part of the constants.
; - Statics in closed form; masses as M_ii = m_p + 3 m_s - D_j sin^2(i,j) - D_k sin^2(i,k),
;   D_j = m_s - J_j/l_j^2.
; - The integrators are branch-free and hold K_I s_c [m/s^2, rad/s^2].
;
; Counts must stay below 2^24 in magnitude (4.19 m, 64 turns), where they are exact as floats.

.program  "tracking, optimised"
.interface "tracking_optimised.interface.toml"

; -------------------------------- 1. inverse kinematics, desired position
; Start points: leg 1 (0, R), legs 2 and 3 (+-xp, -yp). Each is split like the set-point (below)
; into a multiple of 2^-11, name ending in h, and the rest, ending in l; adding and subtracting
; 1.5*2^41 rounds a double to 2^-11.
.const    xp = sqrt(3)/2*R
.const    xph = (xp + 3298534883328) - 3298534883328
.const    xpl = xp - xph
.const    yp = R/2
.const    yph = (yp + 3298534883328) - 3298534883328
.const    ypl = yp - yph
.const    Rh = (R + 3298534883328) - 3298534883328
.const    Rl = R - Rh
.const    grid = 6144                              ; 1.5*2^12: adding it rounds to 2^-11

        ; offsets from the start points, once rounded
        fadd    dx2, x, (-xp)                      ; (7)
        fadd    dx3, x, xp                         ; (7)
        fsub    dy1, y, R                          ; (7)
        fadd    dy2, y, yp                         ; (7)

        ; Q, and from it leg lengths good to a rounding or two
        fmul    zz, z, z                           ; (7)
        fmadd   yz1, dy1, dy1, zz                  ; (7)
        fmadd   Q1, x, x, yz1                      ; (7)
        fmadd   yz2, dy2, dy2, zz                  ; (7)
        fmadd   Q2, dx2, dx2, yz2                  ; (7)
        fmadd   Q3, dx3, dx3, yz2                  ; (7)
        fsqrt   l1_0, Q1                           ; (7)
        fsqrt   l2_0, Q2                           ; (7)
        fsqrt   l3_0, Q3                           ; (7)
        fdiv    half_r1, 0.5, l1_0                 ; (7)
        fdiv    half_r2, 0.5, l2_0                 ; (7)
        fdiv    half_r3, 0.5, l3_0                 ; (7)

        ; set-point and offsets as multiples of 2^-11 and exact rests
        fadd    xg, x, grid                        ; (7)
        fsub    xh, xg, grid                       ; (7)
        fsub    xl, x, xh                          ; (7)
        fadd    yg, y, grid                        ; (7)
        fsub    yh, yg, grid                       ; (7)
        fsub    yl, y, yh                          ; (7)
        fadd    zg, z, grid                        ; (7)
        fsub    zh, zg, grid                       ; (7)
        fsub    zl, z, zh                          ; (7)
        fsub    dx2h, xg, (grid + xph)             ; (7)
        fsub    dx2l, xl, xpl                      ; (7)
        fsub    dx3h, xg, (grid - xph)             ; (7)
        fadd    dx3l, xl, xpl                      ; (7)
        fsub    dy1h, yg, (grid + Rh)              ; (7)
        fsub    dy1l, yl, Rl                       ; (7)
        fsub    dy2h, yg, (grid - yph)             ; (7)
        fadd    dy2l, yl, ypl                      ; (7)

        ; Qh: squares and sums of multiples of 2^-11 below 4 are exact
        fmul    zzh, zh, zh                        ; (7)
        fmadd   yz1h, dy1h, dy1h, zzh              ; (7)
        fmadd   Q1h, xh, xh, yz1h                  ; (7)
        fmadd   yz2h, dy2h, dy2h, zzh              ; (7)
        fmadd   Q2h, dx2h, dx2h, yz2h              ; (7)
        fmadd   Q3h, dx3h, dx3h, yz2h              ; (7)

        ; Ql = Q - Qh: d^2 - dh^2 = dl (d + dh) for each coordinate
        fadd    z_s, z, zh                         ; (7)
        fmul    zzl, zl, z_s                       ; (7)
        fadd    dy1_s, dy1, dy1h                   ; (7)
        fmadd   yz1l, dy1l, dy1_s, zzl             ; (7)
        fadd    x_s, x, xh                         ; (7)
        fmadd   Q1l, xl, x_s, yz1l                 ; (7)
        fadd    dy2_s, dy2, dy2h                   ; (7)
        fmadd   yz2l, dy2l, dy2_s, zzl             ; (7)
        fadd    dx2_s, dx2, dx2h                   ; (7)
        fmadd   Q2l, dx2l, dx2_s, yz2l             ; (7)
        fadd    dx3_s, dx3, dx3h                   ; (7)
        fmadd   Q3l, dx3l, dx3_s, yz2l             ; (7)

        ; rest = Q - l_0^2; one Newton step gives l_d = l_0 + rest/(2 l_0), more than a float holds
        fnmsub  rest1h, l1_0, l1_0, Q1h            ; (7)
        fadd    rest1, rest1h, Q1l                 ; (7)
        fmadd   l1, rest1, half_r1, l1_0           ; (7)
        fnmsub  rest2h, l2_0, l2_0, Q2h            ; (7)
        fadd    rest2, rest2h, Q2l                 ; (7)
        fmadd   l2, rest2, half_r2, l2_0           ; (7)
        fnmsub  rest3h, l3_0, l3_0, Q3h            ; (7)
        fadd    rest3, rest3h, Q3l                 ; (7)
        fmadd   l3, rest3, half_r3, l3_0           ; (7)

        ; v = ((x-xp)vx + (y-yp)vy + z vz)/l; the law takes v_0 and does not wait for the better l,
        ; the export v does
        fmul    s0, z, vz                          ; (8)
        fmadd   s1, dy1, vy, s0                    ; (8)
        fmadd   s1, x, vx, s1                      ; (8)
        fmadd   s23, dy2, vy, s0                   ; (8)
        fmadd   s2, dx2, vx, s23                   ; (8)
        fmadd   s3, dx3, vx, s23                   ; (8)
        fdiv    v1_0, s1, l1_0                     ; (8)
        fdiv    v1, s1, l1                         ; (8)
        fdiv    v2_0, s2, l2_0                     ; (8)
        fdiv    v2, s2, l2                         ; (8)
        fdiv    v3_0, s3, l3_0                     ; (8)
        fdiv    v3, s3, l3                         ; (8)

        ; a = (vx^2 + vy^2 + vz^2 + (x-xp)ax + (y-yp)ay + z az - v^2)/l
        fmul    n0, vx, vx                         ; (9)
        fmadd   n0, vy, vy, n0                     ; (9)
        fmadd   n0, vz, vz, n0                     ; (9)
        fmadd   n0, z, az, n0                      ; (9)
        fmadd   n1, dy1, ay, n0                    ; (9)
        fmadd   n1, x, ax, n1                      ; (9)
        fmadd   n23, dy2, ay, n0                   ; (9)
        fmadd   n2, dx2, ax, n23                   ; (9)
        fmadd   n3, dx3, ax, n23                   ; (9)
        fnmsub  n1, v1_0, v1_0, n1                 ; (9)
        fnmsub  n2, v2_0, v2_0, n2                 ; (9)
        fnmsub  n3, v3_0, v3_0, n3                 ; (9)
        fdiv    acc1, n1, l1                       ; (9)
        fdiv    acc2, n2, l2                       ; (9)
        fdiv    acc3, n3, l3                       ; (9)

; -------------------------------- 2. measured position and velocity

        i2f     n_1, count1                        ; (28)
        i2f     n_2, count2                        ; (28)
        i2f     n_3, count3                        ; (28)
        i2f     n_4, count4                        ; (28)
        i2f     n_5, count5                        ; (28)

; Resolutions as a single float and the rest: multiplying by 2^29 + 1 rounds a double to 24 bits
; (Veltkamp).
.const    q = encoder_legs
.const    qh = (q*536870913) - ((q*536870913) - q)
.const    ql = q - qh
.const    q_table = 2*pi/turn_table
.const    q_tableh = (q_table*536870913) - ((q_table*536870913) - q_table)
.const    q_tablel = q_table - q_tableh

; e = l_d - l: l_0 - l is exact up to one rounding of the small difference
.macro leg_error e, l_0, rest, half_r, n
        fnmsub  e\@, \n, qh, \l_0                  ; (28)
        fnmsub  e\@, \n, ql, e\@                   ; (28)
        fmadd   \e, \rest, \half_r, e\@            ; (28)
.endm

        leg_error e1, l1_0, rest1, half_r1, n_1
        leg_error e2, l2_0, rest2, half_r2, n_2
        leg_error e3, l3_0, rest3, half_r3, n_3

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

        speed_error e_v1, v1_0, n_1, count1_before, q
        speed_error e_v2, v2_0, n_2, count2_before, q
        speed_error e_v3, v3_0, n_3, count3_before, q
        speed_error e_v4, w_alpha, n_4, count4_before, q_table
        speed_error e_v5, w_gamma, n_5, count5_before, q_table

        fmul    p1, n_1, n_1                       ; (14)
        fmul    p2, n_2, n_2                       ; (14)
        fmul    p3, n_3, n_3                       ; (14)
        fadd    sum, p1, p2                        ; (14)
        fadd    sum, sum, p3                       ; (14)
        fdiv    w1, 1.0, n_1                       ; (23)
        fdiv    w2, 1.0, n_2                       ; (23)
        fdiv    w3, 1.0, n_3                       ; (23)

; -------------------------------- 3. gravity
; With p = l^2/q^2:
;   x^2 + y^2 = q^4 (p1^2 + p2^2 + p3^2 - p1p2 - p2p3 - p1p3)/(9R^2)
;             = q^4 ((p1-p2)(p1-p3) + (p2-p3)^2)/(9R^2)
;   z^2 = q^2 (p1+p2+p3)/3 - R^2 - (x^2 + y^2)
;   b_i = 1/3 + q^2 (p1+p2+p3 - 3p_i)/(9R^2)
;   m_z = m_p + 3m_s - (m_s l_c + m_c r_c)(1/l_1 + 1/l_2 + 1/l_3)

        fsub    p12, p1, p2                        ; (15)
        fsub    p13, p1, p3                        ; (15)
        fsub    p23, p2, p3                        ; (15)
        fmul    dev, p23, p23                      ; (15)
        fmadd   dev, p12, p13, dev                 ; (15)
        fmsub   zz_m, sum, (q*q/3), (R*R)          ; (15)
        fnmsub  zz_m, dev, (q*q*q*q/(9*R*R)), zz_m ; (15)
        fsqrt   z_m, zz_m                          ; (15)

        fadd    w_sum, w1, w2                      ; (25)
        fadd    w_sum, w_sum, w3                   ; (25)
        fnmsub  weight, w_sum, (g*(m_s*l_c + mr_c)), (g*q*(m_p + 3*m_s)) ; (25)
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

; -------------------------------- 4. reduced masses
; 2 cos = (p_i + p_j - 3R^2/q^2)/(n_i n_j), 4 sin^2 = 4 - (2 cos)^2, D/4 = (m_s - J/l^2)/4

        fsub    sum_R, sum, (3*R*R/(q*q))          ; (23)
; s = 4 sin^2 of the angle between two legs; p: square of the third
.macro sine2 s, wi, wj, p
        fsub    t\@, sum_R, \p                     ; (23)
        fmul    w\@, \wi, \wj                      ; (23)
        fmul    t\@, t\@, w\@                      ; (23)
        fnmsub  \s, t\@, t\@, 4.0                  ; (23)
.endm
; D = (m_s - (J_a + m_s (l - l_c)^2)/l^2)/4 = w (m_s l_c/2 - w (J_a + m_s l_c^2)/4)
.macro relief D, w
        fnmsub  t\@, \w, ((J_a + m_s*l_c*l_c)/(4*q*q)), (m_s*l_c/(2*q)) ; (23)
        fmul    \D, t\@, \w                        ; (23)
.endm

        sine2   s12, w1, w2, p3
        sine2   s13, w1, w3, p2
        sine2   s23_, w2, w3, p1
        relief  D1, w1
        relief  D2, w2
        relief  D3, w3
        fnmsub  M1, D2, s12, (m_p + 3*m_s)         ; (23)
        fnmsub  M1, D3, s13, M1                    ; (23)
        fnmsub  M2, D1, s12, (m_p + 3*m_s)         ; (23)
        fnmsub  M2, D3, s23_, M2                   ; (23)
        fnmsub  M3, D1, s13, (m_p + 3*m_s)         ; (23)
        fnmsub  M3, D2, s23_, M3                   ; (23)

; -------------------------------- 5. tracking law
; phi_c K_I T_s is the line 1 + 2(xi_c - 1)(1 - n/N_c) between 1 and xi_c, times K_I T_s: the
; saturation makes its first half and its end. n = 0, the tick of the reversal, has no boost and is
; replaced by N_c. The condition abs(e) >= e_c holds from n > N_c/2 on: before, the threshold
; min(e_c, n - N_c/2 - 1/4) is negative (N_c odd or even, e_c up to 1/4).
.macro integrate integral, sign, ticks, e, v_d, KI, e_c, s_max
        fsgn    s_g\@, \v_d                        ; (35)
        feq     same\@, s_g\@, \sign               ; (37)
        mov     \sign, s_g\@                       ; (37)
        fmadd   \ticks, \ticks, same\@, same\@     ; (33)
        sel     n\@, \ticks, \ticks, (T_c/T_s)     ; (33)
        fnmsub  line\@, n\@, (\KI*T_s*2*(xi_c - 1)*T_s/T_c), (\KI*T_s*(1 + 2*(xi_c - 1))) ; (31)
        fsat    phi\@, line\@, (\KI*T_s), (\KI*T_s*xi_c) ; (30)
        fsub    h\@, n\@, (T_c/T_s/2 + 0.25)       ; (32)
        fmin    h\@, h\@, \e_c                     ; (32)
        fabs    size\@, \e                         ; (32)
        fle     large\@, h\@, size\@               ; (32)
        fmadd   fast\@, phi\@, \e, \integral       ; (29)
        fmadd   slow\@, \e, (\KI*T_s), \integral   ; (29)
        sel     next\@, large\@, fast\@, slow\@    ; (29)
        fsat    \integral, next\@, (-(\KI*\s_max)), (\KI*\s_max) ; (29)
.endm

; demand = a_d + K_P e + K_V e_v + K_I s_c, in the order in which the operands come
.macro demand u, a_d, e, e_v, integral, KP, KV
        fmadd   late\@, \e, \KP, \integral         ; (28)
        fmadd   soon\@, \e_v, \KV, \a_d            ; (28)
        fadd    \u, late\@, soon\@                 ; (28)
.endm

.const    w_l = 2*pi*f_legs
.const    KP_legs = 3*w_l*w_l
.const    KV_legs = 3*w_l
.const    KI_legs = w_l*w_l*w_l
.const    w_t = 2*pi*f_table
.const    KP_table = 3*w_t*w_t
.const    KV_table = 3*w_t
.const    KI_table = w_t*w_t*w_t

        integrate integral1, sign1, ticks1, e1, s1, KI_legs, e_c_legs, s_max_legs
        integrate integral2, sign2, ticks2, e2, s2, KI_legs, e_c_legs, s_max_legs
        integrate integral3, sign3, ticks3, e3, s3, KI_legs, e_c_legs, s_max_legs
        integrate integral4, sign4, ticks4, e4, w_alpha, KI_table, e_c_table, s_max_table
        integrate integral5, sign5, ticks5, e5, w_gamma, KI_table, e_c_table, s_max_table

        demand  u1, acc1, e1, e_v1, integral1, KP_legs, KV_legs
        demand  u2, acc2, e2, e_v2, integral2, KP_legs, KV_legs
        demand  u3, acc3, e3, e_v3, integral3, KP_legs, KV_legs
        demand  u4, eps_alpha, e4, e_v4, integral4, KP_table, KV_table
        demand  u5, eps_gamma, e5, e_v5, integral5, KP_table, KV_table

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
