/* SPDX-License-Identifier: Apache-2.0 */
/* Products of integer and float matrices. */
#include "test.h"

enum { N = 8 };

void test(void) {
  static int32_t a[N][N], b[N][N];
  static float f[N][N], g[N][N];
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      a[i][j] = (int32_t)draw() >> 16;
      b[i][j] = (int32_t)draw() >> 16;
      f[i][j] = (float)a[i][j] * 0.01f;
      g[i][j] = (float)b[j][i] / 7.0f;
    }
  }
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      uint32_t sum = 0;
      float total = 0.0f;
      for (int k = 0; k < N; ++k) {
        sum += (uint32_t)(a[i][k] * b[k][j]);
        total += f[i][k] * g[k][j];
      }
      add(sum);
      add_float(total);
    }
  }
}
