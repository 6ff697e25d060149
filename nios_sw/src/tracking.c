/* SPDX-License-Identifier: Apache-2.0 */
/* The tracking law, every equation evaluated as it is printed: nothing is shared between equations,
 * and a subexpression that an equation repeats is computed again (AGAIN, arithmetic.h). Numbers in
 * parentheses are those of the paper. Every operation is one binary32 operation, from left to right;
 * parameters, and what is computed of parameters alone, are data (struct tracking_parameters). */
#include "tracking.h"

#include "arithmetic.h"

/* In .sdata because start-up clears .sbss, and the host writes before it. */
struct tracking_parameters tracking_parameters __attribute__((section(".sdata")));
struct axis_state tracking_state[AXES];
struct joint_motion tracking_desired;

#define ROBOT tracking_parameters

/* Tool position, velocity or acceleration. */
struct vector {
  float x, y, z;
};

/* The same vector for another evaluation, see AGAIN. */
#define VECTOR_AGAIN(v, place, leg) \
  ((struct vector){AGAIN((v).x, place, leg), AGAIN((v).y, place, leg), AGAIN((v).z, place, leg)})

/* ------------------------------------------------------------------ inverse kinematics */

/* x - x_pi; x_p1 = 0 is not subtracted. */
ALWAYS_INLINE float from_x(int leg, float x) { return leg == 0 ? x : x - ROBOT.xp[leg]; }
ALWAYS_INLINE float from_y(int leg, float y) { return y - ROBOT.yp[leg]; }

/* Q = (x-xp)^2 + (y-yp)^2 + z^2 */
ALWAYS_INLINE float squared_length(int leg, struct vector p) {
  return from_x(leg, p.x) * from_x(leg, p.x) + from_y(leg, p.y) * from_y(leg, p.y) + p.z * p.z;
}

/* S = 2(x-xp)vx + 2(y-yp)vy + 2z vz */
ALWAYS_INLINE float numerator(int leg, struct vector p, struct vector v) {
  return 2.0f * from_x(leg, p.x) * v.x + 2.0f * from_y(leg, p.y) * v.y + 2.0f * p.z * v.z;
}

/* (7): l = sqrt(Q) */
ALWAYS_INLINE float length(int leg, struct vector p) {
  return square_root(squared_length(leg, VECTOR_AGAIN(p, 1, leg)));
}

/* (8): v = 1/2 S/sqrt(Q) */
ALWAYS_INLINE float velocity(int leg, struct vector p, struct vector v) {
  float s = numerator(leg, VECTOR_AGAIN(p, 2, leg), v);
  return 0.5f * (s / square_root(squared_length(leg, VECTOR_AGAIN(p, 3, leg))));
}

/* (9)-(11): a = -1/4 S^2/Q^(3/2)
 *               + 1/2 (2vx^2 + 2(x-xp)ax + 2vy^2 + 2(y-yp)ay + 2vz^2 + 2z az)/sqrt(Q),
 * Q^(3/2) = Q sqrt(Q) */
ALWAYS_INLINE float acceleration(int leg, struct vector p, struct vector v, struct vector a) {
  float s = numerator(leg, VECTOR_AGAIN(p, 4, leg), VECTOR_AGAIN(v, 4, leg));
  float q = squared_length(leg, VECTOR_AGAIN(p, 5, leg));
  float first = -(0.25f * (s * s / (q * square_root(q))));
  p = VECTOR_AGAIN(p, 6, leg);
  v = VECTOR_AGAIN(v, 6, leg);
  float second = 2.0f * (v.x * v.x) + 2.0f * from_x(leg, p.x) * a.x + 2.0f * (v.y * v.y) +
                 2.0f * from_y(leg, p.y) * a.y + 2.0f * (v.z * v.z) + 2.0f * p.z * a.z;
  return first + 0.5f * (second / square_root(squared_length(leg, VECTOR_AGAIN(p, 7, leg))));
}

/* ------------------------------------------------------------------ forward kinematics */

/* Measured lengths l1, l2, l3; the same ones for another evaluation. */
struct legs {
  float l1, l2, l3;
};
#define LEGS_AGAIN(l, place) \
  ((struct legs){AGAIN((l).l1, place, 0), AGAIN((l).l2, place, 0), AGAIN((l).l3, place, 0)})

/* (14) */
ALWAYS_INLINE float forward_x(struct legs l) {
  return -(ROBOT.root3 * (l.l2 * l.l2 - l.l3 * l.l3)) / ROBOT.r6;
}

ALWAYS_INLINE float forward_y(struct legs l) {
  return -(2.0f * (l.l1 * l.l1) - l.l2 * l.l2 - l.l3 * l.l3) / ROBOT.r6;
}

/* (15) */
ALWAYS_INLINE float forward_z(struct legs l) {
  float d = l.l2 * l.l2 - l.l3 * l.l3;
  struct legs k = LEGS_AGAIN(l, 12);
  float s = (2.0f * (k.l1 * k.l1) - k.l2 * k.l2 - k.l3 * k.l3) / ROBOT.r6 + ROBOT.r;
  return square_root(l.l1 * l.l1 - d * d / ROBOT.rr12 - s * s);
}

/* ------------------------------------------------------------------ dynamics */

/* c = (li^2 + lj^2 - 3R^2)/(2 li lj), squared */
ALWAYS_INLINE float cosine_squared(float li, float lj) {
  float c = (li * li + lj * lj - ROBOT.rr3) / (2.0f * li * lj);
  return c * c;
}

/* m_j,ij = (J_a + m_s (lj - l_c)^2)(1 - c^2)/lj^2 */
ALWAYS_INLINE float swung_mass(float lj, float c2) {
  float reach = lj - ROBOT.l_c;
  return (ROBOT.j_a + ROBOT.m_s * (reach * reach)) * (1.0f - c2) / (lj * lj);
}

/* (23): M = m_s + m_p + m_r,ij + m_r,ik + m_j,ij + m_j,ik with m_r = m_s c^2; place: constant, one
 * for each leg */
ALWAYS_INLINE float reduced_mass(float li, float lj, float lk, int place) {
  float cij = cosine_squared(AGAIN(li, place, 0), AGAIN(lj, place, 0));
  float cik = cosine_squared(AGAIN(li, place, 1), AGAIN(lk, place, 1));
  return ROBOT.m_s + ROBOT.m_p + ROBOT.m_s * cij + ROBOT.m_s * cik +
         swung_mass(AGAIN(lj, place, 2), cij) + swung_mass(AGAIN(lk, place, 3), cik);
}

/* (25): m_z = m_p + sum (m_s (l - l_c) - m_c r_c)/l */
ALWAYS_INLINE float carried_mass(struct legs l) {
  return ROBOT.m_p + (ROBOT.m_s * (l.l1 - ROBOT.l_c) - ROBOT.mr_c) / l.l1 +
         (ROBOT.m_s * (l.l2 - ROBOT.l_c) - ROBOT.mr_c) / l.l2 +
         (ROBOT.m_s * (l.l3 - ROBOT.l_c) - ROBOT.mr_c) / l.l3;
}

/* Direction of a leg: w = ((x-xp)/l, (y-yp)/l, z/l) */
ALWAYS_INLINE struct vector direction(int leg, struct vector p, float l) {
  p = VECTOR_AGAIN(p, 20, leg);
  return (struct vector){from_x(leg, p.x) / l, from_y(leg, p.y) / l, p.z / l};
}

/* (24): sum of w_i G_i = (0, 0, m_z g) by Cramer's rule, the determinant along its third row */
ALWAYS_INLINE void gravity(struct vector p, struct legs l, float weight, float force[LEGS]) {
  struct vector w1 = direction(0, p, l.l1);
  struct vector w2 = direction(1, p, l.l2);
  struct vector w3 = direction(2, p, l.l3);
  float c1 = w2.x * w3.y - w3.x * w2.y;
  float c2 = w3.x * w1.y - w1.x * w3.y;
  float c3 = w1.x * w2.y - w2.x * w1.y;
  float determinant = w1.z * c1 + w2.z * c2 + w3.z * c3;
  force[0] = weight * c1 / determinant;
  force[1] = weight * c2 / determinant;
  force[2] = weight * c3 / determinant;
}

/* ------------------------------------------------------------------ law of one axis */

/* phi_c = phi_t + 1, (30)-(32); t_c by (33) */
ALWAYS_INLINE float boost(int axis, float t_c, float e) {
  if (t_c >= ROBOT.t_c || t_c <= 0.0f) return 1.0f;
  if (t_c <= ROBOT.half_t_c) return ROBOT.boost + 1.0f;
  if (fabsf(e) < ROBOT.e_c[axis]) return 1.0f;
  return ROBOT.ramp * (1.0f - t_c / ROBOT.t_c) + 1.0f;
}

/* (28)-(37): demand before masses and gravity. T_c / T_s and more ticks all end the boost, so the
 * count may stick at 2^24, where floats end to count. */
ALWAYS_INLINE float demand(int axis, float p_d, float v_d, float a_d, float p) {
  struct axis_state *state = &tracking_state[axis];
  float v = (p - state->position) / ROBOT.t_s;
  float e = p_d - p;
  float e_v = v_d - v;
  float sign = signum(v_d);
  float ticks = sign == state->sign ? state->ticks + 1.0f : 0.0f;
  float phi_c = boost(axis, ticks * ROBOT.t_s, e);
  float s_c = saturate(state->s_c + phi_c * e * ROBOT.t_s, ROBOT.s_max[axis]);
  state->position = p;
  state->sign = sign;
  state->ticks = ticks;
  state->s_c = s_c;
  return a_d + ROBOT.k_p[axis] * e + ROBOT.k_v[axis] * e_v + ROBOT.k_i[axis] * s_c;
}

/* ------------------------------------------------------------------ one tick */

ALWAYS_INLINE float measured(int axis, int32_t count) {
  return float_of_int(count) * ROBOT.resolution[axis];
}

void tracking_start(const volatile struct tick_input *in) {
  for (int axis = 0; axis < AXES; ++axis) {
    tracking_state[axis] = (struct axis_state){
        .position = measured(axis, in->count[axis]),
        .ticks = INFINITY, /* no reversal yet */
    };
  }
}

void tracking_tick(const volatile struct tick_input *in, volatile struct tick_output *out) {
  struct joint_motion *d = &tracking_desired;
  const struct vector p = {in->x, in->y, in->z};
  const struct vector v = {in->vx, in->vy, in->vz};
  const struct vector a = {in->ax, in->ay, in->az};

#define INVERSE(leg)                              \
  d->position[leg] = length(leg, p);              \
  d->velocity[leg] = velocity(leg, p, v);         \
  d->acceleration[leg] = acceleration(leg, p, v, a);
  INVERSE(0)
  INVERSE(1)
  INVERSE(2)

  const struct legs l = {measured(0, in->count[0]), measured(1, in->count[1]),
                         measured(2, in->count[2])};
  const float theta4 = measured(3, in->count[3]);
  const float theta5 = measured(4, in->count[4]);

  const struct vector tool = {forward_x(LEGS_AGAIN(l, 9)), forward_y(LEGS_AGAIN(l, 10)),
                              forward_z(LEGS_AGAIN(l, 11))};
  float g[LEGS];
  gravity(tool, l, carried_mass(l) * ROBOT.g, g);

#define FORCE(axis, mass, p_d, v_d, a_d, p, gravity)                           \
  out->force[axis] = saturate((mass)*demand(axis, p_d, v_d, a_d, p) gravity,   \
                              ROBOT.output_max[axis]);
#define LEG(leg, mass, p) \
  FORCE(leg, mass, d->position[leg], d->velocity[leg], d->acceleration[leg], p, +g[leg])
  LEG(0, reduced_mass(l.l1, l.l2, l.l3, 13), l.l1)                                    /* (28) */
  LEG(1, reduced_mass(l.l2, l.l1, l.l3, 14), l.l2)
  LEG(2, reduced_mass(l.l3, l.l1, l.l2, 15), l.l3)
  FORCE(3, ROBOT.table_inertia[0], in->alpha, in->w_alpha, in->eps_alpha, theta4, /* (36) */
        +ROBOT.tilt_weight * sine(theta4))
  FORCE(4, ROBOT.table_inertia[1], in->gamma, in->w_gamma, in->eps_gamma, theta5, )
}
