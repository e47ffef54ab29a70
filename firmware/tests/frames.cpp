// Frames, held to those that were captured from rosserial's own client and host.
#include "../src/frame.h"

#include <string.h>

#include "check.h"
#include "desk.h"

namespace {

Bytes from_hex(const char* hex) {
  Bytes found;
  for (; *hex != '\0'; hex += 2) {
    unsigned byte;
    sscanf(hex, "%2x", &byte);
    found.push_back(static_cast<uint8_t>(byte));
  }
  return found;
}

// How many frames a reader finds; it is left with the last one.
int count(Reader& reader, const Bytes& bytes, Ticks now = 0) {
  int found = 0;
  for (const uint8_t byte : bytes) found += reader.take(byte, now);
  return found;
}

const char* const ARRAY =
    "fffe2800d76400020000000100ffff000000000000000000000000000000000000000000000000000000000000e903ae";

Bytes written(uint16_t topic, const Bytes& payload) {
  ToHost ring;
  Writer writer(ring);
  CHECK(writer.begin(topic, static_cast<uint8_t>(payload.size())));
  writer.put_bytes(payload.data(), static_cast<uint8_t>(payload.size()));
  writer.end();
  Bytes found;
  while (!ring.empty()) found.push_back(ring.get());
  return found;
}

}  // namespace

TEST(a_captured_request_for_topics_is_a_frame) {
  Reader reader;
  CHECK(count(reader, from_hex("fffe0000ff0000ff")) == 1);
  CHECK(reader.topic() == 0 && reader.length() == 0);
}

TEST(a_captured_answer_for_the_time_is_a_frame) {
  Reader reader;
  CHECK(count(reader, from_hex("fffe0800f70a008cdd006b33718a22d1")) == 1);
  CHECK(reader.topic() == 10 && reader.length() == 8);
}

TEST(a_captured_array_is_a_frame) {
  Reader reader;
  CHECK(count(reader, from_hex(ARRAY)) == 1);
  CHECK(reader.topic() == 100 && reader.length() == 40);
  CHECK(reader.payload()[0] == 2 && reader.payload()[39] == 3);
}

TEST(what_is_written_is_what_a_host_reads) {
  CHECK(written(10, Bytes(8, 0)) == from_hex("fffe0800f70a000000000000000000f5"));
  CHECK(written(125, from_hex("04030080c943")) == from_hex("fffe0600f97d0004030080c943ef"));
}

TEST(a_frame_with_any_byte_changed_is_dropped) {
  const Bytes whole = from_hex(ARRAY);
  for (size_t at = 0; at < whole.size(); at++) {
    for (unsigned change = 1; change < 256; change++) {
      Bytes damaged = whole;
      damaged[at] = static_cast<uint8_t>(damaged[at] ^ change);
      Reader reader;
      CHECK(count(reader, damaged) == 0);
    }
  }
}

TEST(a_frame_follows_another_that_was_cut_off_if_20_ms_have_passed) {
  Reader reader;
  const Bytes whole = from_hex(ARRAY);
  CHECK(count(reader, Bytes(whole.begin(), whole.begin() + 20), 0) == 0);
  CHECK(count(reader, whole, milliseconds(21)) == 1);
}

TEST(a_frame_that_takes_longer_than_20_ms_is_dropped) {
  Reader reader;
  const Bytes whole = from_hex(ARRAY);
  CHECK(count(reader, Bytes(whole.begin(), whole.begin() + 20), 0) == 0);
  CHECK(count(reader, Bytes(whole.begin() + 20, whole.end()), milliseconds(21)) == 0);
  CHECK(count(reader, Bytes(whole.begin(), whole.begin() + 20), milliseconds(100)) == 0);
  CHECK(count(reader, Bytes(whole.begin() + 20, whole.end()), milliseconds(120)) == 1);
}

TEST(time_may_wrap_within_a_frame) {
  Reader reader;
  const Bytes whole = from_hex(ARRAY);
  CHECK(count(reader, Bytes(whole.begin(), whole.begin() + 20), UINT32_MAX - 10) == 0);
  CHECK(count(reader, Bytes(whole.begin() + 20, whole.end()), 10) == 1);
}

TEST(a_payload_for_which_there_is_no_room_is_dropped_before_it_is_stored) {
  for (const size_t length : {size_t(LONGEST_PAYLOAD) + 1, size_t(255), size_t(256), size_t(65535)}) {
    Reader reader;
    CHECK(count(reader, Frame{100, Bytes(length, 7)}.bytes()) == 0);
  }
  Reader reader;
  CHECK(count(reader, Frame{100, Bytes(LONGEST_PAYLOAD, 7)}.bytes()) == 1);
}

TEST(a_frame_is_written_whole_or_not_at_all) {
  ToHost ring;
  Writer writer(ring);
  const uint8_t payload[100] = {};
  int frames = 0;
  for (; writer.begin(1, sizeof payload); frames++) {
    writer.put_bytes(payload, sizeof payload);
    writer.end();
  }
  CHECK(frames == 2 && ring.waiting() == 2 * (sizeof payload + FRAME_BYTES));
}
