// Keeps the compiler from moving reads and writes of memory across this point.
#pragma once

inline void barrier() { __asm__ __volatile__("" ::: "memory"); }
