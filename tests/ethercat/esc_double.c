/* SPDX-License-Identifier: Apache-2.0 */
/* A double of the slave controller, see esc_double.h. */
#include "esc_double.h"

#include <string.h>

#include "esc.h"

#define MANAGERS 8

static uint8_t memory[DOUBLE_BYTES];
static uint8_t latest[MANAGERS][0x400], taken[MANAGERS][0x400]; /* of three buffers two are seen */
static bool open[MANAGERS][2]; /* for the application, the master: from the first byte to the last */
static uint8_t image[2048];
static uint32_t since_write_us;
static bool watched;

static uint16_t word(uint16_t address) { return (uint16_t)(memory[address] | memory[address + 1] << 8); }

static bool active(int n) {
  return memory[ESC_SM_ACTIVATE(n)] & 1 && !(memory[ESC_SM_PDI(n)] & 1);
}

/* The sync manager whose area has the byte, -1 for none. */
static int manager_of(uint16_t address) {
  for (int n = 0; n < MANAGERS; ++n) {
    uint16_t start = word((uint16_t)ESC_SM_START(n)), length = word((uint16_t)ESC_SM_LENGTH(n));
    if (active(n) && length && address >= start && address < start + length) return n;
  }
  return -1;
}

static bool is_mailbox(int n) { return (memory[ESC_SM_CONTROL(n)] & 3) == 2; }
static bool by_master(int n) { return memory[ESC_SM_CONTROL(n)] & 4; } /* written by the master */
static bool full(int n) { return memory[ESC_SM_STATUS(n)] & ESC_SM_STATUS_FULL_MASK; }

static void set_full(int n, bool now) {
  if (now) memory[ESC_SM_STATUS(n)] |= ESC_SM_STATUS_FULL_MASK;
  if (!now) memory[ESC_SM_STATUS(n)] &= (uint8_t)~ESC_SM_STATUS_FULL_MASK;
}

static void event(int n, bool now) {
  uint8_t *events = &memory[ESC_AL_EVENT + 1];
  *events = (uint8_t)(now ? *events | 1 << n : *events & ~(1 << n));
}

/* Whether the area is open for this side at a byte; the last one closes it. */
static bool is_open(int n, bool master, uint16_t at, uint16_t last) {
  bool now = at == 0 || open[n][master];
  open[n][master] = now && at != last;
  return now;
}

/* One byte through a sync manager; whether it was allowed. */
static bool manager_write(int n, uint16_t address, uint8_t value, bool master) {
  uint16_t start = word((uint16_t)ESC_SM_START(n)), last = (uint16_t)(word((uint16_t)ESC_SM_LENGTH(n)) - 1);
  uint16_t at = (uint16_t)(address - start);
  if (by_master(n) != master || at >= sizeof latest[0]) return false;
  if (is_mailbox(n) && full(n)) return false;
  if (!is_open(n, master, at, last)) return false;
  taken[n][at] = value;
  if (at != last) return true;
  memcpy(latest[n], taken[n], last + 1u);
  if (is_mailbox(n)) set_full(n, true);
  if (master) {
    event(n, true);
    if (memory[ESC_SM_CONTROL(n)] & 0x40) {
      watched = true;
      since_write_us = 0;
      memory[ESC_WATCHDOG_STATUS] = 1;
    }
  }
  return true;
}

static bool manager_read(int n, uint16_t address, uint8_t *value, bool master) {
  uint16_t start = word((uint16_t)ESC_SM_START(n)), last = (uint16_t)(word((uint16_t)ESC_SM_LENGTH(n)) - 1);
  uint16_t at = (uint16_t)(address - start);
  if (by_master(n) == master || at >= sizeof latest[0]) return false;
  if (is_mailbox(n) && !full(n)) return false;
  if (!is_open(n, master, at, last)) return false;
  *value = latest[n][at];
  if (at != last) return true;
  if (is_mailbox(n)) set_full(n, false);
  event(n, master);
  return true;
}

void double_reset(void) {
  memset(memory, 0, sizeof memory);
  memset(open, 0, sizeof open);
  memory[0] = 0x4D;
  memory[4] = 8;
  memory[5] = 8;
  memory[6] = 8;
  memory[7] = 0x0F;
  memory[8] = 0x0C;
  memory[0x0110] = 0x11; /* DL status: operational, link on port 0 */
  memory[0x0111] = 0x56; /* loop of port 1 closed, communication on port 0 */
  memory[ESC_WATCHDOG_STATUS] = 1;
  memory[0x0420] = 1000 & 0xFF;
  memory[0x0421] = 1000 >> 8;
  watched = false;
}

void double_time(uint32_t us) {
  uint32_t limit = word(0x0420) * 100u;
  if (!watched || !limit) return;
  since_write_us += us;
  if (since_write_us > limit) memory[ESC_WATCHDOG_STATUS] = 0;
}

void double_sii(const uint8_t *from, uint32_t bytes) { memcpy(image, from, bytes < 2048 ? bytes : 2048); }

static void sii_command(void) {
  uint8_t command = memory[0x0503] & 7;
  uint32_t at = 2u * word(0x0504);
  if (command == 1 && at + 8 <= sizeof image) memcpy(&memory[0x0508], image + at, 8);
  memory[0x0502] = 0x40; /* reads give 8 bytes */
  memory[0x0503] = command == 1 && at + 8 > sizeof image ? 0x20 : 0;
}

bool double_read(uint16_t address, uint8_t *to, uint16_t bytes) {
  bool any = false;
  for (uint16_t i = 0; i < bytes; ++i) {
    uint16_t at = (uint16_t)(address + i);
    int n = at >= 0x1000 ? manager_of(at) : -1;
    to[i] = 0;
    if (at >= DOUBLE_BYTES) continue;
    if (n >= 0) {
      any |= manager_read(n, at, &to[i], true);
    } else {
      to[i] = memory[at];
      any = true;
    }
  }
  return any;
}

static bool writable_by_master(uint16_t at) {
  return at >= 0x0010 && at != ESC_AL_STATUS && at != ESC_AL_STATUS + 1 && at != ESC_AL_STATUS_CODE &&
         at != ESC_AL_STATUS_CODE + 1 && !(at >= 0x0110 && at < 0x0112) && !(at >= 0x0220 && at < 0x0224) &&
         at != ESC_WATCHDOG_STATUS && !(at >= 0x0800 && at < 0x0880 && ((at & 7) == 5 || (at & 7) == 7));
}

bool double_write(uint16_t address, const uint8_t *from, uint16_t bytes) {
  bool any = false;
  for (uint16_t i = 0; i < bytes; ++i) {
    uint16_t at = (uint16_t)(address + i);
    int n = at >= 0x1000 ? manager_of(at) : -1;
    if (at >= DOUBLE_BYTES) continue;
    any = true;
    if (n >= 0) {
      if (!manager_write(n, at, from[i], true)) return false;
    } else if (writable_by_master(at)) {
      memory[at] = from[i];
    }
    if (at == ESC_AL_CONTROL) memory[ESC_AL_EVENT] |= 1;
    if (at >= 0x0800 && at < 0x0880) {
      memory[ESC_AL_EVENT] |= 0x10;
      if ((at & 7) == 6 && !(from[i] & 1)) {
        set_full((at - 0x0800) / 8, false);
        open[(at - 0x0800) / 8][0] = open[(at - 0x0800) / 8][1] = false;
      }
    }
    if (at == 0x0503) sii_command();
  }
  return any;
}

/* The application's side. */
void esc_read(uint16_t address, void *to, uint16_t bytes) {
  uint8_t *out = to;
  for (uint16_t i = 0; i < bytes; ++i) {
    uint16_t at = (uint16_t)(address + i);
    int n = at >= 0x1000 && at < DOUBLE_BYTES ? manager_of(at) : -1;
    out[i] = at < DOUBLE_BYTES ? memory[at] : 0;
    if (n >= 0) manager_read(n, at, &out[i], false);
    if (at == ESC_AL_CONTROL) memory[ESC_AL_EVENT] &= 0xFE;
    if (at >= 0x0800 && at < 0x0880 && (at & 7) == 6) memory[ESC_AL_EVENT] &= 0xEF;
  }
}

void esc_write(uint16_t address, const void *from, uint16_t bytes) {
  const uint8_t *in = from;
  for (uint16_t i = 0; i < bytes; ++i) {
    uint16_t at = (uint16_t)(address + i);
    int n = at >= 0x1000 && at < DOUBLE_BYTES ? manager_of(at) : -1;
    if (n >= 0) {
      manager_write(n, at, in[i], false);
    } else if (at < DOUBLE_BYTES) {
      memory[at] = in[i];
      if (at >= 0x0800 && at < 0x0880 && (at & 7) == 7 && in[i] & 1) set_full((at - 0x0800) / 8, false);
    }
  }
}
