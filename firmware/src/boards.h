// What the firmware needs of the bus to the robot's boards. A lab with another bus implements this
// class, and names its own in `mega.cpp`; `rs485.h` is the one that is here.
//
// One exchange with one board is under way at a time, and nothing waits for it.
#pragma once

#include <stdint.h>

#include "../robot.h"
#include "ticks.h"

// What a board answers: the setpoints that it has in force, and its channels where it was asked for
// them.
struct Answer {
  int16_t in_force[robot::MOST_SLOTS];
  int32_t channels[robot::MOST_CHANNELS + 1];  // no array of C++ may be empty
};

class Boards {
 public:
  enum Outcome : uint8_t {
    NONE,      // no exchange is under way
    BUSY,      // the board has not answered yet
    ANSWERED,  // it has; said once
    FAILED     // it has not, or what came is damaged; said once
  };

  // Begins to set those slots of the board whose bits are set.
  virtual void write(uint8_t board, uint8_t slots, const int16_t* values, Ticks now) = 0;

  // Begins to ask for the board's channels.
  virtual void read(uint8_t board, Ticks now) = 0;

  // Says what has become of the exchange, and fills `answer` where it is `ANSWERED`.
  virtual Outcome outcome(Ticks now, Answer& answer) = 0;
};
