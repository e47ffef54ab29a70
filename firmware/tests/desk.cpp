#include "desk.h"

#include <string.h>

#include "check.h"

namespace {

constexpr uint32_t LINE_BYTES_PER_S = robot::BAUD / 10;

uint8_t sum(const Bytes& bytes, size_t from) {
  unsigned total = 0;
  for (size_t at = from; at < bytes.size(); at++) total += bytes[at];
  return static_cast<uint8_t>(total);
}

uint16_t crc(const Bytes& bytes) {
  uint16_t found = 0xFFFF;
  for (const uint8_t byte : bytes) {
    for (int bit = 7; bit >= 0; bit--) {
      const bool out = found >> 15;
      found = static_cast<uint16_t>(found << 1);
      if (out != (byte >> bit & 1)) found ^= 0x1021;
    }
  }
  return found;
}

}  // namespace

Bytes Frame::bytes() const {
  const uint8_t low = payload.size() & 0xFF, high = static_cast<uint8_t>(payload.size() >> 8);
  Bytes made = {0xFF, 0xFE, low, high, static_cast<uint8_t>(255 - static_cast<uint8_t>(low + high))};
  made.push_back(topic & 0xFF);
  made.push_back(static_cast<uint8_t>(topic >> 8));
  made.insert(made.end(), payload.begin(), payload.end());
  made.push_back(static_cast<uint8_t>(255 - sum(made, 5)));
  return made;
}

Bytes array_payload(uint32_t id, int16_t value) {
  Array array = {};
  array.id = id;
  for (uint8_t slot = 0; slot < robot::SLOTS; slot++) {
    array.values[slot] = value < robot::LIMITS[slot] ? value : robot::LIMITS[slot];
  }
  Bytes payload(robot::ARRAY_BYTES);
  array.write(payload.data());
  return payload;
}

Desk::Desk(uint8_t reset_flags, Kept* kept)
    : kept(kept != nullptr ? *kept : own_kept_),
      rs485_(port_),
      bay_(from_host_, to_host_, rs485_, this->kept) {
  if (kept == nullptr) memset(static_cast<void*>(&own_kept_), 0xA5, sizeof own_kept_);
  for (PlayedBoard& board : boards) {
    board = {};
    board.answers = board.obeys = true;
    for (int16_t& value : board.values) value = 77;  // what they were left with
  }
  bay_.start(reset_flags);
}

void Desk::send(const Bytes& bytes) {
  for (const uint8_t byte : bytes) from_host_.put(byte);
}

void Desk::run(uint32_t ms) {
  for (uint32_t step = 0; step < 4 * ms; step++) {
    now += milliseconds(1) / 4;
    bay_.step(now);
    play_boards();
    play_line();
  }
}

// The line takes the bytes at its rate.
void Desk::play_line() {
  for (line_free_ += LINE_BYTES_PER_S; line_free_ >= 4000; line_free_ -= 4000) {
    if (!to_host_.empty()) received_.push_back(to_host_.get());
  }
}

// Boards answer what they have been asked at once.
void Desk::play_boards() {
  if (!port_.talking) return;
  Bytes asked;
  while (!port_.out.empty()) asked.push_back(port_.out.get());
  bus.insert(bus.end(), asked.begin(), asked.end());
  port_.talking = false;
  CHECK(asked.size() >= 6u && asked[0] == 0xB5 && asked[3] == asked.size() - 6);
  CHECK(crc(asked) == 0 || crc(Bytes(asked.begin(), asked.end() - 2)) ==
                               (asked[asked.size() - 2] | asked[asked.size() - 1] << 8));
  for (uint8_t index = 0; index < robot::BOARD_COUNT; index++) {
    const robot::Board& at = robot::BOARDS[index];
    PlayedBoard& board = boards[index];
    if (at.id != asked[1] || !board.answers) continue;
    const bool writes = asked[2] == 'W';
    board.written += writes;
    for (uint8_t slot = 0; writes && board.obeys && slot < at.slots; slot++) {
      if (asked[4] >> slot & 1) {
        board.values[slot] = static_cast<int16_t>(asked[5 + 2 * slot] | asked[6 + 2 * slot] << 8);
      }
    }
    Bytes answer = {0xB5, at.id, static_cast<uint8_t>(asked[2] + 32), 0};
    for (uint8_t slot = 0; slot < at.slots; slot++) {
      answer.push_back(static_cast<uint8_t>(board.values[slot]));
      answer.push_back(static_cast<uint8_t>(board.values[slot] >> 8));
    }
    for (uint8_t channel = 0; !writes && channel < at.channels; channel++) {
      for (uint8_t byte = 0; byte < 4; byte++) {
        answer.push_back(static_cast<uint8_t>(board.channels[channel] >> (8 * byte)));
      }
    }
    answer[3] = static_cast<uint8_t>(answer.size() - 4);
    const uint16_t check = crc(answer);
    answer.push_back(check & 0xFF);
    answer.push_back(static_cast<uint8_t>(check >> 8));
    for (const uint8_t byte : answer) port_.in.put(byte);
  }
}

std::vector<Frame> Desk::heard() {
  std::vector<Frame> found;
  size_t at = 0;
  while (at + 8 <= received_.size()) {
    const size_t length = received_[at + 2] | received_[at + 3] << 8;
    if (at + 8 + length > received_.size()) break;
    const Frame frame = {static_cast<uint16_t>(received_[at + 5] | received_[at + 6] << 8),
                         Bytes(received_.begin() + at + 7, received_.begin() + at + 7 + length)};
    CHECK(frame.bytes() == Bytes(received_.begin() + at, received_.begin() + at + 8 + length));
    found.push_back(frame);
    at += 8 + length;
  }
  received_.erase(received_.begin(), received_.begin() + at);
  return found;
}
