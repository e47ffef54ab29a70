// Time, in ticks of Timer 1. A tick is 4 us: 16 MHz divided by 64 [ATmega2560 data sheet, 17.11].
// Ticks wrap after 4.8 hours; differences stay right.
#pragma once

#include <stdint.h>

typedef uint32_t Ticks;

constexpr uint8_t US_PER_TICK = 4;

constexpr Ticks microseconds(uint32_t us) { return us / US_PER_TICK; }
constexpr Ticks milliseconds(uint32_t ms) { return ms * (1000 / US_PER_TICK); }
