/* SPDX-License-Identifier: Apache-2.0 */
/* Heap sort, insertion sort and merge sort written here agree. */
#include "test.h"

enum { N = 90 };

static void swap(uint16_t *a, uint16_t *b) {
  uint16_t kept = *a;
  *a = *b;
  *b = kept;
}

static void sift(uint16_t *v, int root, int n) {
  for (int child; (child = 2 * root + 1) < n; root = child) {
    if (child + 1 < n && v[child] < v[child + 1]) ++child;
    if (v[root] >= v[child]) return;
    swap(&v[root], &v[child]);
  }
}

static void heap_sort(uint16_t *v, int n) {
  for (int root = n / 2 - 1; root >= 0; --root) sift(v, root, n);
  for (int end = n - 1; end > 0; --end) {
    swap(&v[0], &v[end]);
    sift(v, 0, end);
  }
}

static void merge_sort(uint16_t *v, uint16_t *work, int n) {
  if (n < 2) return;
  int half = n / 2;
  merge_sort(v, work, half);
  merge_sort(v + half, work, n - half);
  for (int i = 0, a = 0, b = half; i < n; ++i) {
    work[i] = b >= n || (a < half && v[a] <= v[b]) ? v[a++] : v[b++];
  }
  for (int i = 0; i < n; ++i) v[i] = work[i];
}

void test(void) {
  static uint16_t a[N], b[N], c[N], work[N];
  for (int i = 0; i < N; ++i) a[i] = b[i] = c[i] = (uint16_t)draw();
  heap_sort(a, N);
  merge_sort(b, work, N);
  for (int i = 1; i < N; ++i) {
    uint16_t key = c[i];
    int j = i;
    for (; j > 0 && c[j - 1] > key; --j) c[j] = c[j - 1];
    c[j] = key;
  }
  for (int i = 0; i < N; ++i) {
    add(a[i]);
    add(b[i]);
    add(a[i] == b[i] && b[i] == c[i]);
  }
}
