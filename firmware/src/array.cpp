#include "array.h"

#include <string.h>

#include "numbers.h"

using namespace robot;

Array Array::at_rest() {
  Array rest = {};
  rest.hold = HELD_WITHOUT_MASK;
  return rest;
}

bool Array::read(const uint8_t* payload, uint8_t length, Array& into) {
  if (length != ARRAY_BYTES) return false;
  if (ARRAY_COUNTED && read_number(payload + ARRAY_VALUES_AT - 4, 4) != SLOTS) return false;
  Array found = {};
  const uint8_t* value = payload + ARRAY_VALUES_AT;
  for (uint8_t slot = 0; slot < SLOTS; slot++, value += ARRAY_VALUES_BYTES) {
    const int32_t count = read_signed(value, ARRAY_VALUES_BYTES);
    if (count < -LIMITS[slot] || count > LIMITS[slot]) return false;
    found.values[slot] = static_cast<int16_t>(count);
  }
  found.id = read_number(payload + ARRAY_ID_AT, ARRAY_ID_BYTES);
  found.hold = ARRAY_HOLD_BYTES == 0
                   ? HELD_WITHOUT_MASK
                   : read_number(payload + ARRAY_HOLD_AT, ARRAY_HOLD_BYTES) >> ARRAY_HOLD_SHIFT;
  into = found;
  return true;
}

uint32_t Array::held() const {
  const bool is_mask = (hold & OWN_CONTROLLER) == OWN_CONTROLLER;
  return is_mask ? hold : HELD_WITHOUT_MASK | OWN_CONTROLLER;
}

void Array::stop() {
  for (uint8_t slot = 0; slot < SLOTS; slot++) {
    if ((held() >> slot & 1) == 0) values[slot] = 0;
  }
}

void Array::write(uint8_t* payload) const {
  memset(payload, 0, ARRAY_BYTES);
  write_number(payload + ARRAY_ID_AT, ARRAY_ID_BYTES, id);
  if (ARRAY_COUNTED) write_number(payload + ARRAY_VALUES_AT - 4, 4, SLOTS);
  uint8_t* value = payload + ARRAY_VALUES_AT;
  for (uint8_t slot = 0; slot < SLOTS; slot++, value += ARRAY_VALUES_BYTES) {
    write_number(value, ARRAY_VALUES_BYTES, static_cast<uint32_t>(static_cast<int32_t>(values[slot])));
  }
  if (ARRAY_HOLD_BYTES > 0 && ARRAY_HOLD_AT != ARRAY_ID_AT) {
    write_number(payload + ARRAY_HOLD_AT, ARRAY_HOLD_BYTES, hold);
  }
}
