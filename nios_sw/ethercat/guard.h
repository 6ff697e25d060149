/* SPDX-License-Identifier: Apache-2.0 */
/* What the control pass and the background both touch. On the Nios II system the pass is an interrupt that the
 * background never interrupts; a section between guard_enter and guard_leave is not divided by it, so it is
 * to be short. Sections nest. On a host nothing interrupts. */
#ifndef ETHERCAT_GUARD_H
#define ETHERCAT_GUARD_H

#ifdef __nios2__

/* Status as it was: bit 0 allows interrupts. */
static inline int guard_enter(void) {
  int before = __builtin_rdctl(0);
  __builtin_wrctl(0, before & ~1);
  __asm__ volatile("" ::: "memory");
  return before;
}

static inline void guard_leave(int before) {
  __asm__ volatile("" ::: "memory");
  __builtin_wrctl(0, before);
}

#else

static inline int guard_enter(void) { return 0; }
static inline void guard_leave(int before) { (void)before; }

#endif

#endif
