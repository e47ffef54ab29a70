// What outlives a restart, in memory that nothing initialises, and what it says of the restart.
//
// Many boot loaders clear the flags that say why the controller restarted. So a hang is written down
// here, by the timer's interrupt, before the watchdog restarts the controller.
#pragma once

#include <stdint.h>

#include "array.h"
#include "numbers.h"

// Flags of a restart, in MCUSR [ATmega2560 data sheet, 12.5.1].
constexpr uint8_t POWER_ON = 1 << 0;
constexpr uint8_t EXTERNAL = 1 << 1;  // the host's port, or the button
constexpr uint8_t WATCHDOG = 1 << 3;

enum Restart : uint8_t {
  BY_HAND,  // power-on, or the reset pin: hands are near
  HUNG,     // the main loop hung, and it is known what was in force
  UNKNOWN   // neither is known
};

class Kept {
 public:
  void keep(const Array& array) {
    array_ = array;
    sum_ = sum();
  }

  // A millisecond has passed; the main loop has come round. In between, the loop hangs.
  void pass_millisecond() {
    if (ms_in_loop_ < HANGS_AFTER_MS) {
      ms_in_loop_++;
    } else {
      mark_ = MARK;
    }
  }
  void come_round() {
    ms_in_loop_ = 0;
    mark_ = 0;
  }

  // Returns why the controller restarted, with these flags, and copies the array that was in force
  // unless hands are near or it is not as it was written. Says so once.
  Restart recall(Array& into, uint8_t flags) {
    const bool by_hand = flags & (POWER_ON | EXTERNAL);
    const bool intact = sum_ == sum();
    const bool hung = intact && (flags & WATCHDOG || mark_ == MARK);
    if (intact && !by_hand) into = array_;
    come_round();
    sum_ = static_cast<uint16_t>(~sum());
    return by_hand ? BY_HAND : hung ? HUNG : UNKNOWN;
  }

 private:
  // A main loop that has not come round for so long hangs [assumed]; it takes less than 1 ms. The
  // watchdog restarts the controller at 250 ms.
  static constexpr uint8_t HANGS_AFTER_MS = 100;

  static constexpr uint16_t MARK = 0x4A9E;  // unlikely in memory after power-on

  // Of the array and of the tables that it belongs to.
  uint16_t sum() const {
    uint16_t crc = crc_of(reinterpret_cast<const uint8_t*>(&array_), sizeof array_);
    for (const char* letter = robot::TABLES; *letter != '\0'; letter++) {
      crc = crc_of(static_cast<uint8_t>(*letter), crc);
    }
    return crc;
  }

  Array array_;
  uint16_t sum_;
  volatile uint16_t mark_;
  volatile uint8_t ms_in_loop_;
};
