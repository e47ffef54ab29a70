// What outlives a restart by the watchdog, in memory that nothing initialises.
//
// Boot loaders clear the flags that say why the controller restarted. So the hang itself is
// written down here, by the timer's interrupt, before the watchdog restarts the controller. After
// power-on or a reset by the host's port the mark is not there, and nothing is restored.
#pragma once

#include <stdint.h>

#include "array.h"
#include "numbers.h"

class Kept {
 public:
  void keep(const Array& array) {
    array_ = array;
    sum_ = sum();
  }

  // The main loop hangs; it has come round after all.
  void mark_hang() { mark_ = HUNG; }
  void clear_mark() { mark_ = 0; }

  // Copies the array that was in force, and returns true, if the controller restarted out of a
  // hang and the array is as it was written; `certain`: it is known otherwise that it did. Says so
  // once.
  bool recall(Array& into, bool certain) {
    const bool found = (certain || mark_ == HUNG) && sum_ == sum();
    if (found) into = array_;
    mark_ = 0;
    sum_ = static_cast<uint16_t>(~sum());
    return found;
  }

 private:
  static constexpr uint16_t HUNG = 0x4A9E;  // unlikely in memory after power-on

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
};
