/* SPDX-License-Identifier: Apache-2.0 */
/* A double of the slave controller, see esc_double.h. */
#include "esc_double.h"

#include <string.h>

#include "esc.h"

#define MANAGERS 8
#define MAILBOX 2u /* mode of a sync manager */
#define READ 1     /* command of the SII */
/* Whether a byte is that one of the registers of a sync manager. */
#define IS_SM(at, name) (registers_of(at) >= 0 && (at) == ESC_SM_##name((unsigned)registers_of(at)))

static uint8_t memory[DOUBLE_BYTES];
static uint8_t latest[MANAGERS][0x400], taken[MANAGERS][0x400]; /* of three buffers two are seen */
static bool open[MANAGERS][2]; /* for the application, the master: from the first byte to the last */
static uint8_t image[2048];
static uint32_t until_sync0_ns;
static uint64_t since_write_ns;
static bool watched, pulses;
static uint8_t late[DOUBLE_BYTES];
static uint16_t late_address, late_bytes;

static uint16_t word(uint16_t address) { return (uint16_t)(memory[address] | memory[address + 1] << 8); }

static void set_word(uint16_t address, unsigned value) {
  memory[address] = (uint8_t)value;
  memory[address + 1] = (uint8_t)(value >> 8);
}

static bool active(int n) {
  return memory[ESC_SM_ACTIVATE(n)] & ESC_SM_ACTIVATE_ENABLE_MASK &&
         !(memory[ESC_SM_PDI(n)] & ESC_SM_PDI_DISABLE_MASK);
}

/* The sync manager whose registers have the byte, -1 for none. */
static int registers_of(uint16_t at) {
  if (at < ESC_SM_START(0) || at >= ESC_SM_START(MANAGERS)) return -1;
  return (int)((at - ESC_SM_START(0)) / (ESC_SM_START(1) - ESC_SM_START(0)));
}

/* The sync manager whose area has the byte, -1 for none. */
static int manager_of(uint16_t address) {
  for (int n = 0; n < MANAGERS; ++n) {
    uint16_t start = word((uint16_t)ESC_SM_START(n)), length = word((uint16_t)ESC_SM_LENGTH(n));
    if (active(n) && length && address >= start && address < start + length) return n;
  }
  return -1;
}

static bool is_mailbox(int n) {
  return (memory[ESC_SM_CONTROL(n)] & ESC_SM_CONTROL_MODE_MASK) == MAILBOX << ESC_SM_CONTROL_MODE_LSB;
}
/* Written by the master. */
static bool by_master(int n) { return memory[ESC_SM_CONTROL(n)] & 1u << ESC_SM_CONTROL_DIRECTION_LSB; }
static bool full(int n) { return memory[ESC_SM_STATUS(n)] & ESC_SM_STATUS_FULL_MASK; }

static void set_full(int n, bool now) {
  if (now) memory[ESC_SM_STATUS(n)] |= ESC_SM_STATUS_FULL_MASK;
  if (!now) memory[ESC_SM_STATUS(n)] &= (uint8_t)~ESC_SM_STATUS_FULL_MASK;
}

static void event(int n, bool now) {
  unsigned at = ESC_AL_EVENT_SM_LSB + (unsigned)n, bit = 1u << at % 8;
  uint8_t *events = &memory[ESC_AL_EVENT + at / 8];
  *events = (uint8_t)(now ? *events | bit : *events & ~bit);
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
  if (!master && at == 0) event(n, false);
  taken[n][at] = value;
  if (at != last) return true;
  memcpy(latest[n], taken[n], last + 1u);
  if (is_mailbox(n)) set_full(n, true);
  if (master) {
    event(n, true);
    if (memory[ESC_SM_CONTROL(n)] & ESC_SM_CONTROL_WATCHDOG_MASK) {
      watched = true;
      since_write_ns = 0;
      memory[ESC_WATCHDOG_STATUS] = ESC_WATCHDOG_STATUS_ALIVE_MASK;
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
  if (!master && at == 0) event(n, false);
  *value = latest[n][at];
  if (at != last) return true;
  if (is_mailbox(n)) set_full(n, false);
  if (master) event(n, true);
  return true;
}

void double_reset(void) {
  memset(memory, 0, sizeof memory);
  memset(open, 0, sizeof open);
  memory[ESC_TYPE] = 0x4D;
  memory[ESC_FMMUS] = 8;
  memory[ESC_SYNC_MANAGERS] = MANAGERS;
  memory[ESC_RAM_SIZE] = 8;
  memory[ESC_PORTS] = 0x0F;
  memory[ESC_FEATURES] = ESC_FEATURES_DC_MASK | ESC_FEATURES_DC64_MASK;
  /* Link on port 0; ports 2 and 3 do not exist: binary 0101. */
  set_word(ESC_DL_STATUS, ESC_DL_STATUS_OPERATIONAL_MASK | 1u << ESC_DL_STATUS_LINK_LSB |
                              ESC_DL_STATUS_COMMUNICATION0_MASK | ESC_DL_STATUS_LOOP1_MASK |
                              5u << ESC_DL_STATUS_OTHERS_LSB);
  memory[ESC_WATCHDOG_STATUS] = ESC_WATCHDOG_STATUS_ALIVE_MASK;
  set_word(ESC_WATCHDOG_DATA, 1000);
  watched = false;
  until_sync0_ns = 0;
  pulses = true;
  late_bytes = 0;
}

void double_sync0(bool now) { pulses = now; }

static void pass_sync0(uint32_t ns) {
  const uint8_t on = ESC_SYNC_ACTIVATION_CYCLIC_MASK | ESC_SYNC_ACTIVATION_SYNC0_MASK;
  if ((memory[ESC_SYNC_ACTIVATION] & on) != on) {
    until_sync0_ns = 0;
  } else if (until_sync0_ns > ns) {
    until_sync0_ns -= ns;
  } else {
    if (pulses) memory[ESC_AL_EVENT] |= ESC_AL_EVENT_SYNC0_MASK;
    until_sync0_ns += (word(ESC_SYNC0_CYCLE) | (uint32_t)word(ESC_SYNC0_CYCLE + 2) << 16) - ns;
  }
}

void double_time(uint32_t ns) {
  uint64_t limit = word(ESC_WATCHDOG_DATA) * 100000ull;
  pass_sync0(ns);
  if (!watched || !limit) return;
  since_write_ns += ns;
  if (since_write_ns > limit) memory[ESC_WATCHDOG_STATUS] = 0;
}

void double_sii(const uint8_t *from, uint32_t bytes) { memcpy(image, from, bytes < 2048 ? bytes : 2048); }

static void sii_command(void) {
  unsigned command = (word(ESC_SII_CONTROL) & ESC_SII_CONTROL_COMMAND_MASK) >> ESC_SII_CONTROL_COMMAND_LSB;
  uint32_t at = 2u * word(ESC_SII_ADDRESS);
  bool beyond = at + 8 > sizeof image;
  if (command == READ && !beyond) memcpy(&memory[ESC_SII_DATA], image + at, 8);
  set_word(ESC_SII_CONTROL, ESC_SII_CONTROL_EIGHT_BYTES_MASK |
                                (command == READ && beyond ? ESC_SII_CONTROL_COMMAND_ERROR_MASK : 0u));
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
  return at >= ESC_STATION_ADDRESS && at != ESC_AL_STATUS && at != ESC_AL_STATUS + 1 &&
         at != ESC_AL_STATUS_CODE && at != ESC_AL_STATUS_CODE + 1 &&
         !(at >= ESC_DL_STATUS && at < ESC_DL_STATUS + 2) && !(at >= ESC_AL_EVENT && at < ESC_AL_EVENT + 4) &&
         at != ESC_WATCHDOG_STATUS && !IS_SM(at, STATUS) && !IS_SM(at, PDI);
}

bool double_write(uint16_t address, const uint8_t *from, uint16_t bytes) {
  bool any = false, commands_sii = false;
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
    if (at == ESC_AL_CONTROL) memory[ESC_AL_EVENT] |= ESC_AL_EVENT_AL_CONTROL_MASK;
    if (registers_of(at) >= 0) memory[ESC_AL_EVENT] |= ESC_AL_EVENT_SM_CHANGE_MASK;
    if (IS_SM(at, ACTIVATE) && !(from[i] & ESC_SM_ACTIVATE_ENABLE_MASK)) {
      set_full(registers_of(at), false);
      open[registers_of(at)][0] = open[registers_of(at)][1] = false;
    }
    if (at == ESC_SII_CONTROL + ESC_SII_CONTROL_COMMAND_LSB / 8) commands_sii = true;
  }
  if (commands_sii) sii_command(); /* the address came with the same access */
  return any;
}

void double_write_late(uint16_t address, const uint8_t *from, uint16_t bytes) {
  memcpy(late, from, bytes);
  late_address = address;
  late_bytes = bytes;
}

/* The application's side. */
void esc_read(uint16_t address, void *to, uint16_t bytes) {
  uint8_t *out = to;
  for (uint16_t i = 0; i < bytes; ++i) {
    uint16_t at = (uint16_t)(address + i);
    int n = at >= 0x1000 && at < DOUBLE_BYTES ? manager_of(at) : -1;
    out[i] = at < DOUBLE_BYTES ? memory[at] : 0;
    if (n >= 0) manager_read(n, at, &out[i], false);
    if (at == ESC_SYNC_STATUS_0) memory[ESC_AL_EVENT] &= (uint8_t)~ESC_AL_EVENT_SYNC0_MASK;
    if (at == ESC_AL_CONTROL) memory[ESC_AL_EVENT] &= (uint8_t)~ESC_AL_EVENT_AL_CONTROL_MASK;
    if (IS_SM(at, ACTIVATE)) memory[ESC_AL_EVENT] &= (uint8_t)~ESC_AL_EVENT_SM_CHANGE_MASK;
  }
  if (address == ESC_AL_EVENT && late_bytes) {
    double_write(late_address, late, late_bytes);
    late_bytes = 0;
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
      if (IS_SM(at, PDI) && in[i] & ESC_SM_PDI_DISABLE_MASK) set_full(registers_of(at), false);
    }
  }
}
