#include "check.h"

Test* Test::first = nullptr;
uint32_t Test::damaged_frames = 1000000;

int main(int count_of_words, char** words) {
  if (count_of_words > 1) Test::damaged_frames = static_cast<uint32_t>(atol(words[1]));
  int count = 0;
  for (const Test* test = Test::first; test != nullptr; test = test->next, count++) {
    printf("%s\n", test->name);
    fflush(stdout);
    test->body();
  }
  printf("%d tests passed\n", count);
}
