/* SPDX-License-Identifier: Apache-2.0 */
/* What newlib asks of a system without files: memory for malloc between the data and the stack, the
 * console for what is written, and calls that fail. */
#include <errno.h>
#include <stdint.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include "io.h"

#define STACK_RESERVE 8192

extern char end[], __stack_top[];

void *sbrk(ptrdiff_t bytes) {
  static uintptr_t top = (uintptr_t)end;
  uintptr_t start = top;
  uintptr_t limit = (uintptr_t)__stack_top - STACK_RESERVE;
  if (bytes > (ptrdiff_t)(limit - top) || bytes < (ptrdiff_t)((uintptr_t)end - top)) {
    errno = ENOMEM;
    return (void *)-1;
  }
  top += (uintptr_t)bytes;
  return (void *)start;
}

int close(int file) {
  (void)file;
  return -1;
}

int fstat(int file, struct stat *status) {
  (void)file;
  status->st_mode = S_IFCHR;
  return 0;
}

int isatty(int file) {
  (void)file;
  return 1;
}

off_t lseek(int file, off_t offset, int whence) {
  (void)file, (void)offset, (void)whence;
  return 0;
}

int read(int file, void *data, size_t bytes) {
  (void)file, (void)data, (void)bytes;
  return 0;
}

int write(int file, const void *data, size_t bytes) {
  (void)file;
  for (size_t i = 0; i < bytes; ++i) io_write(REG_CONSOLE, ((const uint8_t *)data)[i]);
  return (int)bytes;
}

int kill(int process, int signal) {
  (void)process, (void)signal;
  errno = EINVAL;
  return -1;
}

int getpid(void) { return 1; }

void _exit(int status) {
  program_exit((uint32_t)status);
}
