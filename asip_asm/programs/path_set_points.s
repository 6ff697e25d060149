; SPDX-License-Identifier: Apache-2.0
; Trajectory of a path in five axes: one run per tick gives the 15 set-points that the tracking
; programs take. Moves are straight lines or arcs that start and end at rest. They wait as records in
; a ring in data memory; the host writes records ahead and then raises `moves`, the number of records
; written so far. A move that is over is followed at once by the next record, else its end is held.
; Record 0 must be there before the first run. A move without a plan (planner_law.inc says which) makes
; x a NaN, so the core stops with fault NOT_FINITE.
;
; Record, 32 words from 32*(number modulo 32) on: duration (int, ticks), v0, vm, tr, tm, L as in
; planner_scurve.s, k; then five axes each of start, end, and direction (way per unit of L); then for
; an arc x, y, z each of the radius vector at the start, the one at the end, and the unit normal. An arc
; turns by 2 k per unit of L about the normal; a line has k = 0. Word 31 is free.
;
; Everything is counted from the nearer end, d from -L/2 to L/2, so both ends are exact:
;   q = end + direction d + radius (cos 2kd - 1) + (normal x radius) sin 2kd

.program  "set-points of a path"
.include  "planner_law.inc"

.interface "path_set_points.interface.toml"
.space    ring, 1024
.const    record_words = 32 : int
.const    ring_end = 1024.0
.const    one = 1 : int

        ; ---- which record, which tick of it
        ld      duration, ring[place]
        iadd    following, tick, one
        isub    left_int, duration, following
        i2f     left, left_int
        isub    waiting_int, moves, taken
        i2f     waiting, waiting_int
        sel     other, waiting, 1.0, 0.0
        selgt   change, left, 0.0, other           ; 1: the next record begins
        iadd    place_up, place, record_words
        i2f     place_f, place_up
        fsub    beyond, place_f, ring_end
        sel     place_next, beyond, place_up, 0.0
        sel     place, change, place_next, place
        iadd    taken_up, taken, one
        sel     taken, change, taken_up, taken
        selgt   tick_here, left, following, duration
        sel     tick, change, 0.0, tick_here
        selgt   running, left, 1.0, change         ; 0: at the end, waiting

        ; ---- along the move: d from the nearer end, speed and acceleration
        ld      v0, ring+1[place]
        ld      vm, ring+2[place]
        ld      tr, ring+3[place]
        ld      tm, ring+4[place]
        ld      L, ring+5[place]
        plan    v0, vm, tr, tm, L
        sample  tick, T_s, L, v0, p_vp, p_am, p_J, p_t1, p_t2, p_t4, p_s1, p_s2, p_s3
        fneg    d_fall, q_pu
        sel     d_some, q_falling, d_fall, q_pu
        sel     d, running, d_some, 0.0
        sel     v, running, q_v, 0.0
        sel     a, running, q_a, 0.0
        fnmsub  near_end, running, q_falling, running  ; 1: counted from the start
        fdiv    bad, 0.0, p_good                   ; NaN for a move without a plan

        ; ---- arc: sine and cosine of 2kd by those of kd
        ld      k, ring+6[place]
        fmul    h, k, d
        fsin    S, h
        fcos    C, h
        fmul    turn, k, 2.0
        fmul    S2, S, 2.0
        fmul    sine, S2, C
        fnmul   versine, S2, S                     ; cos 2kd - 1
        fadd    cosine, versine, 1.0
        fmul    v_k, v, turn
        fmul    a_k, a, turn
        fmul    vk_k, v_k, v_k
        ; radial and tangential parts of velocity and acceleration
        fnmul   vr, v_k, sine
        fmul    vt, v_k, cosine
        fmul    ar1, a_k, sine
        fnmadd  ar, vk_k, cosine, ar1
        fmul    at1, vk_k, sine
        fmsub   at, a_k, cosine, at1

        ld      nx, ring+28[place]
        ld      ny, ring+29[place]
        ld      nz, ring+30[place]
        ld      rxs, ring+22[place]
        ld      rxe, ring+25[place]
        ld      rys, ring+23[place]
        ld      rye, ring+26[place]
        ld      rzs, ring+24[place]
        ld      rze, ring+27[place]
        sel     rx, near_end, rxs, rxe
        sel     ry, near_end, rys, rye
        sel     rz, near_end, rzs, rze
        fmul    tx1, nz, ry
        fmsub   tx, ny, rz, tx1
        fmul    ty1, nx, rz
        fmsub   ty, nz, rx, ty1
        fmul    tz1, ny, rx
        fmsub   tz, nx, ry, tz1

.macro straight p, pd, pdd, axis
        ld      from\@, ring+7+\axis[place]
        ld      to\@, ring+12+\axis[place]
        ld      way\@, ring+17+\axis[place]
        sel     base\@, near_end, from\@, to\@
        fmadd   \p, way\@, d, base\@
        fmul    \pd, way\@, v
        fmul    \pdd, way\@, a
.endm
.macro curved out_p, out_v, out_a, r, t, axis
        ld      from\@, ring+7+\axis[place]
        ld      to\@, ring+12+\axis[place]
        ld      way\@, ring+17+\axis[place]
        sel     base\@, near_end, from\@, to\@
        ; the way from the end is added in one piece, so that the sum is rounded once
        fmul    wl\@, way\@, d
        fmadd   wr\@, \r, versine, wl\@
        fmadd   w\@, \t, sine, wr\@
        fadd    \out_p, base\@, w\@
        fmul    vl\@, way\@, v
        fmadd   vp\@, \r, vr, vl\@
        fmadd   \out_v, \t, vt, vp\@
        fmul    al\@, way\@, a
        fmadd   ap\@, \r, ar, al\@
        fmadd   \out_a, \t, at, ap\@
.endm

        curved  q_x, q_vx, q_ax, rx, tx, 0
        curved  q_y, q_vy, q_ay, ry, ty, 1
        curved  q_z, q_vz, q_az, rz, tz, 2
        straight q_al, q_wal, q_eal, 3
        straight q_ga, q_wga, q_ega, 4
        fadd    q_xg, q_x, bad

        mov     x, q_xg
        mov     y, q_y
        mov     z, q_z
        mov     vx, q_vx
        mov     vy, q_vy
        mov     vz, q_vz
        mov     ax, q_ax
        mov     ay, q_ay
        mov     az, q_az
        mov     alpha, q_al
        mov     gamma, q_ga
        mov     w_alpha, q_wal
        mov     w_gamma, q_wga
        mov     eps_alpha, q_eal
        mov     eps_gamma, q_ega
        mov     begun, taken
        halt
