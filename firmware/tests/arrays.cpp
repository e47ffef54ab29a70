// Arrays: only one that is whole and in range is read; what the switch does to one.
#include "../src/array.h"

#include <string.h>

#include "../src/kept.h"
#include "../src/numbers.h"
#include "../src/switch.h"
#include "check.h"
#include "desk.h"

using namespace robot;

namespace {

Array read_of(const Bytes& payload) {
  Array array = {};
  CHECK(Array::read(payload.data(), static_cast<uint8_t>(payload.size()), array));
  return array;
}

Bytes with_value(uint8_t slot, int16_t value) {
  Bytes payload = array_payload(0, 0);
  write_number(payload.data() + ARRAY_VALUES_AT + slot * ARRAY_VALUES_BYTES, ARRAY_VALUES_BYTES,
               static_cast<uint32_t>(static_cast<int32_t>(value)));
  return payload;
}

}  // namespace

TEST(numbers_are_read_as_they_are_written) {
  uint8_t bytes[4];
  for (const int32_t number : {0, 1, -1, 1000, -1745, 32767, -32768}) {
    for (uint8_t width = 2; width <= 4; width++) {
      write_number(bytes, width, static_cast<uint32_t>(number));
      CHECK(read_signed(bytes, width) == number);
    }
  }
}

TEST(the_crc_is_the_one_of_its_name) {
  CHECK(crc_of(reinterpret_cast<const uint8_t*>("123456789"), 9) == 0x29B1);
}

TEST(an_array_of_another_length_is_refused) {
  Array array = {};
  array.values[0] = 5;
  const Bytes payload = array_payload(1, 100);
  for (uint8_t length = 0; length < LONGEST_PAYLOAD; length++) {
    Bytes other = payload;
    other.resize(length);
    CHECK(Array::read(other.data(), length, array) == (length == ARRAY_BYTES));
    CHECK(array.values[0] == (length < ARRAY_BYTES ? 5 : 100));
  }
}

TEST(a_value_out_of_range_is_refused_in_every_slot) {
  for (uint8_t slot = 0; slot < SLOTS; slot++) {
    Array array = {};
    for (const int sign : {1, -1}) {
      const int16_t most = static_cast<int16_t>(sign * LIMITS[slot]);
      const int16_t beyond = static_cast<int16_t>(most + sign);
      CHECK(Array::read(with_value(slot, most).data(), ARRAY_BYTES, array));
      CHECK(array.values[slot] == most);
      CHECK(!Array::read(with_value(slot, beyond).data(), ARRAY_BYTES, array));
      CHECK(array.values[slot] == most);
    }
    CHECK(!Array::read(with_value(slot, INT16_MIN).data(), ARRAY_BYTES, array));
  }
}

TEST(an_echo_is_what_was_read) {
  const Bytes payload = array_payload(0xDEADBEEF, -321);
  Bytes echo(ARRAY_BYTES);
  read_of(payload).write(echo.data());
  CHECK(echo == payload);
}

TEST(stopping_leaves_what_is_held) {
  for (uint8_t slot = 0; slot < SLOTS; slot++) {
    const uint32_t mask = 1UL << slot | OWN_CONTROLLER;
    Array array = read_of(array_payload(mask << ARRAY_HOLD_SHIFT | 3, 100));
    CHECK(array.held() == mask);
    array.stop();
    for (uint8_t other = 0; other < SLOTS; other++) {
      CHECK(array.values[other] == (mask >> other & 1 ? 100 : 0));
    }
    CHECK(array.id == (mask << ARRAY_HOLD_SHIFT | 3));
  }
}

TEST(a_mask_without_slots_that_are_always_held_is_none_and_everything_that_may_be_is_held) {
  for (const uint32_t mask : {0UL, ~(0xFFFFFFFFUL << SLOTS) & ~OWN_CONTROLLER}) {
    Array array = read_of(array_payload(static_cast<uint32_t>(mask << ARRAY_HOLD_SHIFT | 3), 100));
    array.stop();
    for (uint8_t slot = 0; slot < SLOTS; slot++) {
      CHECK(array.values[slot] == (HELD_WITHOUT_MASK >> slot & 1 ? 100 : 0));
    }
    Bytes echo(ARRAY_BYTES);
    array.write(echo.data());
    CHECK(read_of(echo).hold == mask);  // it is echoed as received
  }
}

TEST(the_switch_trips_when_nobody_has_spoken_and_again) {
  Switch it;
  const Ticks stop = milliseconds(STOP_AFTER_MS);
  CHECK(!it.trips(10 * stop));  // before the first array there is nothing to stop
  it.hear(100);
  CHECK(!it.trips(100 + stop - 1));
  CHECK(it.trips(100 + stop));
  CHECK(!it.trips(100 + stop + 1));
  CHECK(it.trips(100 + 2 * stop));
}

TEST(the_switch_trips_in_time_where_the_clock_wraps) {
  Switch it;
  it.hear(UINT32_MAX - 5);
  CHECK(!it.trips(100));
  CHECK(it.trips(milliseconds(STOP_AFTER_MS)));
}

namespace {

// What is in memory after power-on: anything.
void fill(Kept& kept) { memset(static_cast<void*>(&kept), 0x5A, sizeof kept); }

void pass(Kept& kept, int ms) {
  while (ms-- > 0) kept.pass_millisecond();
}

}  // namespace

TEST(what_was_in_force_is_recalled_after_a_hang_only_and_once) {
  Kept kept;
  fill(kept);
  Array array = read_of(array_payload(7, 50)), found = {};
  CHECK(kept.recall(found, POWER_ON) == BY_HAND);
  CHECK(kept.recall(found, WATCHDOG) == UNKNOWN && found.id == 0);  // nothing is kept
  kept.keep(array);
  CHECK(kept.recall(found, EXTERNAL) == BY_HAND && found.id == 0);
  kept.keep(array);
  pass(kept, 200);
  CHECK(kept.recall(found, 0) == HUNG && found.id == 7 && found.values[0] == 50);
  kept.keep(array);
  CHECK(kept.recall(found, WATCHDOG) == HUNG);
  CHECK(kept.recall(found, WATCHDOG) == UNKNOWN);
}

TEST(where_flags_are_lost_a_restart_without_a_mark_is_unknown_and_what_was_held_is) {
  Kept kept;
  fill(kept);
  Array found = {};
  kept.keep(read_of(array_payload(7, 50)));
  CHECK(kept.recall(found, 0) == UNKNOWN && found.id == 7);
}

TEST(a_reset_by_the_port_or_power_on_is_by_hand_whatever_else_happened) {
  for (const uint8_t flags : {POWER_ON | WATCHDOG, EXTERNAL | WATCHDOG, POWER_ON | EXTERNAL | 4}) {
    Kept kept;
    fill(kept);
    Array found = {};
    kept.keep(read_of(array_payload(7, 50)));
    pass(kept, 200);
    CHECK(kept.recall(found, static_cast<uint8_t>(flags)) == BY_HAND && found.id == 0);
  }
}

TEST(a_loop_that_came_round_late_did_not_hang) {
  Kept kept;
  fill(kept);
  Array found = {};
  kept.recall(found, POWER_ON);
  kept.keep(read_of(array_payload(7, 50)));
  pass(kept, 200);
  kept.come_round();
  pass(kept, 50);
  CHECK(kept.recall(found, 0) == UNKNOWN);
}

TEST(memory_that_was_damaged_is_not_recalled) {
  for (size_t at = 0; at < sizeof(Array); at++) {
    Kept kept;
    fill(kept);
    kept.keep(read_of(array_payload(7, 50)));
    pass(kept, 200);
    reinterpret_cast<uint8_t*>(&kept)[at] ^= 0x10;
    Array found = {};
    CHECK(kept.recall(found, WATCHDOG) == UNKNOWN && found.id == 0);
  }
}
