#include "check.h"

Test* Test::first = nullptr;

int main() {
  int count = 0;
  for (const Test* test = Test::first; test != nullptr; test = test->next, count++) {
    printf("%s\n", test->name);
    fflush(stdout);
    test->body();
  }
  printf("%d tests passed\n", count);
}
