// Frames of any kind, until so many of them were damaged or cut off as the command line says.
//
// The sanitizers watch. Whatever comes, only arrays in range come into force, and the echo shows what
// was taken. It need not be what was sent: the sum of a frame has 8 bits, so some damage passes, and
// is found by the host, which compares.
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

struct Sent {
  Bytes payload, bytes;
  bool damaged;
};

// A frame of any topic and length, or an array, at times damaged, cut off or run into the next.
Sent any_frame() {
  const uint16_t topics[] = {0, 1, 6, 7, 10, 11, 100, 100, 100, 125, static_cast<uint16_t>(chance())};
  Frame frame = {topics[chance() % (sizeof topics / sizeof topics[0])], {}};
  if (frame.topic == 100 && chance() % 4 != 0) {
    frame.payload = array_payload(chance(), static_cast<int16_t>(chance() % 4000 - 2000));
  } else {
    frame.payload.resize(chance() % (chance() % 8 == 0 ? 700 : 60));
    for (uint8_t& byte : frame.payload) byte = static_cast<uint8_t>(chance());
  }
  const Bytes whole = frame.bytes();
  Bytes bytes = whole;
  for (uint32_t hits = chance() % 4; hits > 0; hits--) {
    bytes[chance() % bytes.size()] = static_cast<uint8_t>(chance());
  }
  if (chance() % 10 == 0) bytes.resize(chance() % bytes.size());
  return {frame.payload, bytes, bytes != whole};
}

}  // namespace

TEST(frames_of_any_kind_bring_only_arrays_in_range_into_force_and_echoes_show_them) {
  Reader reader;
  uint32_t frames = 0, damaged = 0, taken = 0, others = 0;
  for (; damaged < Test::damaged_frames; frames++) {
    const Ticks now = frames * milliseconds(5);
    const Sent sent = any_frame();
    damaged += sent.damaged;
    for (const uint8_t byte : sent.bytes) {
      if (!reader.take(byte, now)) continue;
      CHECK(reader.length() <= LONGEST_PAYLOAD);
      Array array = {};
      if (!Array::read(reader.payload(), reader.length(), array)) continue;
      taken++;
      for (uint8_t slot = 0; slot < robot::SLOTS; slot++) {
        CHECK(array.values[slot] >= -robot::LIMITS[slot] && array.values[slot] <= robot::LIMITS[slot]);
      }
      Bytes payload(reader.payload(), reader.payload() + reader.length()), echo(robot::ARRAY_BYTES);
      array.write(echo.data());
      CHECK(echo == payload);
      others += payload != sent.payload;
    }
  }
  printf("  %u frames, %u of them damaged; %u arrays were taken, %u of them not as sent\n", frames,
         damaged, taken, others);
  CHECK(taken > damaged / 100 && others < damaged / 255);
}

TEST(the_whole_firmware_survives_frames_of_any_kind) {
  Desk desk;
  desk.ask_for_topics();
  for (uint32_t frame = 0; frame < Test::damaged_frames / 50; frame++) {
    desk.send(any_frame().bytes);
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
