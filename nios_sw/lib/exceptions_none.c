/* SPDX-License-Identifier: Apache-2.0 */
/* Programs that expect no exception end at the first one, with a status that no test returns. */
#include <stdint.h>

void program_exit(uint32_t status) __attribute__((noreturn));

void exception_handler(uint32_t pending, uint32_t address);
void exception_handler(uint32_t pending, uint32_t address) {
  (void)pending, (void)address;
  program_exit(0xFFu);
}
