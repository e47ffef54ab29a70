// Arrays of setpoints, as the robot's message texts lay them out.
//
// An array in memory is one that was whole and in range: nothing else makes one. So nothing else
// can come into force.
#pragma once

#include <stdint.h>

#include "../robot.h"

struct Array {
  uint32_t id;                    // as on the wire, with the mask if it is in there
  uint32_t hold;                  // the mask as received; `held()` is what it means
  int16_t values[robot::SLOTS];   // in counts of the wire

  // The array in force before the first one came: every motor at rest, and the slots whose boards
  // have a controller of their own are not known.
  static Array at_rest();

  // Reads the payload; returns false, and changes nothing, unless it has exactly the length of an
  // array, as many values as there are slots, and each within the limits of its slot.
  static bool read(const uint8_t* payload, uint8_t length, Array& into);

  // The slots that the dead man's switch keeps, one bit each. A mask without the slots that have a
  // controller of their own is none, because a host always sets these: everything is held then but
  // what must stop.
  uint32_t held() const;

  // Sets every slot to 0 that is not held. *Never all of them*: a clamp that lets go drops
  // the robot.
  void stop();

  // Writes the payload of its echo, which has the same fields.
  void write(uint8_t* payload) const;
};
