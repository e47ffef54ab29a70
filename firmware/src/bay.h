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

  // Sets up, once. After a hang the held slots are as they were and all others at zero; otherwise
  // every motor is set to rest.
  void start(bool restarted_by_watchdog);

  // To be called at least every millisecond. It never waits.
  void step(Ticks now);

 private:
  void take_array(Ticks now);
  void put_in_force(Ticks now);
  void say(Ticks now);
  void greet();

  Node node_;
  Cycle cycle_;
  Switch switch_;
  Kept& kept_;
  Array in_force_;
  bool restored_ = false;
  bool to_echo_ = false;   // whether what is in force must still be echoed
  Ticks since_ = 0;        // since when it is in force
  bool refused_ = false;   // whether an array was refused, which the host is still to be told
  uint8_t greeted_ = 0;    // how many lines of greeting the host has been sent
};
