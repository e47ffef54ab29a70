// The dead man's switch: no array has come for too long (docs/firmware.md).
#pragma once

#include "../robot.h"
#include "ticks.h"

class Switch {
 public:
  // An array has come.
  void hear(Ticks now) {
    heard_ = now;
    armed_ = true;
  }

  // Returns whether to stop what is not held: once for every `STOP_AFTER_MS` without an array.
  // Before the first array there is nothing to stop.
  bool trips(Ticks now) {
    if (!armed_ || now - heard_ < milliseconds(robot::STOP_AFTER_MS)) return false;
    heard_ = now;  // says so again, should the echo be lost
    return true;
  }

 private:
  Ticks heard_ = 0;
  bool armed_ = false;
};
