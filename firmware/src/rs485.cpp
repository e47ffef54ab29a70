#include "rs485.h"

#include "numbers.h"

using robot::BOARDS;

namespace {

constexpr uint8_t MARK = 0xB5;
constexpr uint8_t ANSWERS = 'a' - 'A';  // what an answer's kind has more than that of its request

constexpr Ticks ANSWER_WITHIN = milliseconds(1);
constexpr Ticks LOOKED_AT_EVERY = milliseconds(1);  // the loop wakes up at least this often
constexpr Ticks TICKS_PER_BYTE = microseconds(10 * 1000000 / BUS_BAUD);

static_assert(2 * robot::MOST_SLOTS + 1 + 6 <= Ring<64>::ROOM, "a request is too long");
static_assert(2 * robot::MOST_SLOTS + 4 * robot::MOST_CHANNELS + 6 <= Ring<128>::ROOM,
              "an answer is too long");

}  // namespace

void Rs485::write(uint8_t board, uint8_t slots, const int16_t* values, Ticks now) {
  const uint8_t bytes = 2 * BOARDS[board].slots;
  begin(board, 'W', 1 + bytes);
  put(slots);
  for (uint8_t slot = 0; slot < BOARDS[board].slots; slot++) {
    const uint16_t value = static_cast<uint16_t>(values[slot]);
    put(static_cast<uint8_t>(value));
    put(static_cast<uint8_t>(value >> 8));
  }
  end('W', bytes, now);
}

void Rs485::read(uint8_t board, Ticks now) {
  begin(board, 'R', 0);
  end('R', 2 * BOARDS[board].slots + 4 * BOARDS[board].channels, now);
}

void Rs485::begin(uint8_t board, uint8_t kind, uint8_t bytes) {
  port_.in.clear();  // of an answer that came too late
  board_ = board;
  crc_ = CRC_START;
  put(MARK);
  put(BOARDS[board].id);
  put(kind);
  put(bytes);
}

void Rs485::put(uint8_t byte) {
  crc_ = crc_of(byte, crc_);
  port_.out.put(byte);
}

void Rs485::end(uint8_t kind, uint8_t bytes, Ticks now) {
  const uint16_t crc = crc_;
  put(static_cast<uint8_t>(crc));
  put(static_cast<uint8_t>(crc >> 8));
  wanted_ = kind + ANSWERS;
  bytes_ = bytes;
  filled_ = 0;
  began_ = now;
  within_ = ANSWER_WITHIN + LOOKED_AT_EVERY +
            TICKS_PER_BYTE * (port_.out.waiting() + HEAD_BYTES + bytes + CRC_BYTES);
  port_.talking = true;
}

Boards::Outcome Rs485::outcome(Ticks now, Answer& answer) {
  if (wanted_ == 0) return NONE;
  const uint8_t whole = HEAD_BYTES + bytes_ + CRC_BYTES;
  while (!port_.talking && !port_.in.empty() && filled_ < whole) {
    const uint8_t byte = port_.in.get();
    if (filled_ > 0 || byte == MARK) answer_[filled_++] = byte;  // noise on an idle bus
  }
  if (filled_ == whole) {
    const bool right = unpack(answer);
    wanted_ = 0;
    return right ? ANSWERED : FAILED;
  }
  if (now - began_ <= within_) return BUSY;
  wanted_ = 0;
  return FAILED;
}

bool Rs485::unpack(Answer& answer) const {
  const uint8_t end = HEAD_BYTES + bytes_;
  if (answer_[1] != BOARDS[board_].id || answer_[2] != wanted_ || answer_[3] != bytes_) return false;
  if (crc_of(answer_, end) != read_number(answer_ + end, CRC_BYTES)) return false;
  const uint8_t* at = answer_ + HEAD_BYTES;
  for (uint8_t slot = 0; slot < BOARDS[board_].slots; slot++, at += 2) {
    answer.in_force[slot] = static_cast<int16_t>(read_number(at, 2));
  }
  for (uint8_t channel = 0; at < answer_ + end; channel++, at += 4) {
    answer.channels[channel] = read_signed(at, 4);
  }
  return true;
}
