// The firmware, without the controller that it runs on: bytes and the time go in, bytes and
// exchanges with boards come out. `mega.cpp` runs it on an Arduino Mega, the tests natively.
#pragma once

#include <stdint.h>

#include "array.h"
#include "boards.h"
#include "cycle.h"
#include "kept.h"
#include "node.h"
#include "ring.h"
#include "switch.h"
#include "ticks.h"

class Bay {
 public:
  Bay(FromHost& in, ToHost& out, Boards& boards, Kept& kept)
      : node_(in, out), cycle_(boards, node_), kept_(kept), in_force_(Array::at_rest()) {}

  // Sets up, once, after a restart with these flags. By hand, every motor is set to rest. After a
  // hang the held slots are as they were and all others at zero. If the cause is unknown, held slots are
  // left alone, because a clamp that lets go drops the robot, and all others are at zero.
  void start(uint8_t reset_flags);

  // To be called at least every millisecond. It never waits.
  void step(Ticks now);

 private:
  void take_array(Ticks now);
  void put_in_force();
  void say();
  void greet();

  Node node_;
  Cycle cycle_;
  Switch switch_;
  Kept& kept_;
  Array in_force_;
  Restart restart_ = BY_HAND;
  bool to_echo_ = false;   // whether what is in force must still be echoed
  bool refused_ = false;   // whether an array was refused, which the host is still to be told
  uint8_t greeted_ = 0;    // how many lines of greeting the host has been sent
};
