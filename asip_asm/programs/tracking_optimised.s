; SPDX-License-Identifier: Apache-2.0
; The tracking law of the five-axis robot, rearranged for the ASIP: inputs, outputs, exports and law
; are those of tracking_as_printed.s, the algebra is not. tracking_law.inc holds it; its comments name the equations of docs/law.md.
;
; - The error e = l_d - l is formed to about 1e-10 m although l_d alone has a rounding error of 3e-8
;   m (section 2).
; - v is the exact difference of two encoder counts times the constant resolution/T_s
;   (tracking_observer.s: an observer's).
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
.const    observer = 0
.const    stamps = 0
.include  "tracking_law.inc"
