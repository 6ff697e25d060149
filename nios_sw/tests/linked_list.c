/* SPDX-License-Identifier: Apache-2.0 */
/* A list and a binary tree of allocated nodes. */
#include <stdlib.h>

#include "test.h"

struct node {
  struct node *left, *right;
  uint32_t key, count;
};

static struct node *insert(struct node *tree, uint32_t key) {
  if (!tree) {
    tree = calloc(1, sizeof *tree);
    if (tree) tree->key = key;
  }
  if (tree && tree->key == key) {
    ++tree->count;
  } else if (tree && key < tree->key) {
    tree->left = insert(tree->left, key);
  } else if (tree) {
    tree->right = insert(tree->right, key);
  }
  return tree;
}

static uint32_t walk(const struct node *tree, uint32_t depth) {
  if (!tree) return depth;
  uint32_t left = walk(tree->left, depth + 1);
  add(tree->key);
  add(tree->count);
  uint32_t right = walk(tree->right, depth + 1);
  return left > right ? left : right;
}

void test(void) {
  struct node *tree = NULL;
  for (int i = 0; i < 120; ++i) tree = insert(tree, draw_below(80));
  add(walk(tree, 0));
}
