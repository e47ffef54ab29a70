// Tests in plain C++: each is a function that registers itself.
#pragma once

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

struct Test {
  Test(const char* name, void (*body)()) : name(name), body(body), next(first) { first = this; }
  const char* name;
  void (*body)();
  Test* next;
  static Test* first;
  static uint32_t damaged_frames;  // how many are tried
};

#define TEST(name)                    \
  static void name();                 \
  static Test test_##name(#name, name); \
  static void name()

#define CHECK(condition)                                                \
  do {                                                                  \
    if (!(condition)) {                                                 \
      fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition); \
      exit(1);                                                          \
    }                                                                   \
  } while (false)
