// A million damaged frames. The sanitizers watch; what is in force is always an array that was sent.
#include <stdint.h>

#include "../src/array.h"
#include "../src/frame.h"
#include "check.h"
#include "desk.h"

namespace {

// Marsaglia's xorshift: the same numbers on every machine.
uint32_t state = 0x2545F491;
uint32_t chance() {
  state ^= state << 13;
  state ^= state >> 17;
  state ^= state << 5;
  return state;
}

// A frame of any topic and length, or an array, at times damaged, cut off or run into the next.
Bytes any_frame() {
  const uint16_t topics[] = {0, 1, 6, 7, 10, 11, 100, 100, 100, 125, static_cast<uint16_t>(chance())};
  Frame frame = {topics[chance() % (sizeof topics / sizeof topics[0])], {}};
  if (frame.topic == 100 && chance() % 4 != 0) {
    frame.payload = array_payload(chance(), static_cast<int16_t>(chance() % 4000 - 2000));
  } else {
    frame.payload.resize(chance() % (chance() % 8 == 0 ? 700 : 60));
    for (uint8_t& byte : frame.payload) byte = static_cast<uint8_t>(chance());
  }
  Bytes bytes = frame.bytes();
  for (uint32_t hits = chance() % 4; hits > 0 && chance() % 2 == 0; hits--) {
    bytes[chance() % bytes.size()] = static_cast<uint8_t>(chance());
  }
  if (chance() % 10 == 0) bytes.resize(chance() % bytes.size());
  return bytes;
}

}  // namespace

TEST(a_million_frames_of_any_kind_bring_only_arrays_in_range_into_force) {
  Reader reader;
  unsigned whole = 0, taken = 0;
  for (uint32_t frame = 0; frame < 1000000; frame++) {
    const Ticks now = frame * milliseconds(5);
    for (const uint8_t byte : any_frame()) {
      if (!reader.take(byte, now)) continue;
      whole++;
      CHECK(reader.length() <= LONGEST_PAYLOAD);
      Array array = {};
      if (!Array::read(reader.payload(), reader.length(), array)) continue;
      taken++;
      for (uint8_t slot = 0; slot < robot::SLOTS; slot++) {
        CHECK(array.values[slot] >= -robot::LIMITS[slot] && array.values[slot] <= robot::LIMITS[slot]);
      }
    }
  }
  printf("  %u frames were whole, %u of them arrays in range\n", whole, taken);
  CHECK(whole > 100000 && taken > 10000);
}

TEST(the_whole_firmware_survives_frames_of_any_kind) {
  Desk desk;
  desk.ask_for_topics();
  for (int frame = 0; frame < 20000; frame++) {
    desk.send(any_frame());
    desk.run(1 + chance() % 8);
    desk.boards[chance() % robot::BOARD_COUNT].answers = chance() % 4 != 0;
    if (frame % 100 == 0) desk.heard();
    for (uint8_t board = 0; board < robot::BOARD_COUNT; board++) {
      for (uint8_t slot = 0; slot < robot::BOARDS[board].slots; slot++) {
        const int16_t limit = robot::LIMITS[robot::BOARDS[board].first_slot + slot];
        CHECK(desk.boards[board].values[slot] >= -limit && desk.boards[board].values[slot] <= limit);
      }
    }
  }
}
