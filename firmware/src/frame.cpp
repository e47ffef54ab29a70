#include "frame.h"

#include <string.h>

namespace {

// A frame that is not complete this long after its first byte is dropped [rosserial_arduino].
constexpr Ticks PATIENCE = milliseconds(20);

constexpr uint8_t WHOLE = 255;  // what a group sums to

}  // namespace

// --- reading -------------------------------------------------------------------------------------

bool Reader::take(uint8_t byte, Ticks now) {
  if (part_ != AT_SYNC && now - began_ > PATIENCE) part_ = AT_SYNC;
  const bool at_end = part_ == AT_CHECK;
  part_ = after(byte, now);
  return at_end && sum_ == WHOLE;
}

Reader::Part Reader::after(uint8_t byte, Ticks now) {
  sum_ += byte;
  switch (part_) {
    case AT_SYNC:
      began_ = now;
      return byte == SYNC ? AT_REVISION : AT_SYNC;
    case AT_REVISION:
      sum_ = 0;
      return byte == REVISION ? AT_LENGTH_LOW : AT_SYNC;
    case AT_LENGTH_LOW:
      length_ = byte;
      return AT_LENGTH_HIGH;
    case AT_LENGTH_HIGH:
      length_ |= static_cast<uint16_t>(byte) << 8;
      return AT_LENGTH_CHECK;
    case AT_LENGTH_CHECK: {
      const bool usable = sum_ == WHOLE && length_ <= LONGEST_PAYLOAD;
      sum_ = 0;
      return usable ? AT_TOPIC_LOW : AT_SYNC;
    }
    case AT_TOPIC_LOW:
      topic_ = byte;
      return AT_TOPIC_HIGH;
    case AT_TOPIC_HIGH:
      topic_ |= static_cast<uint16_t>(byte) << 8;
      filled_ = 0;
      return length_ > 0 ? AT_PAYLOAD : AT_CHECK;
    case AT_PAYLOAD:
      payload_[filled_++] = byte;
      return filled_ < length_ ? AT_PAYLOAD : AT_CHECK;
    case AT_CHECK:
      break;
  }
  return AT_SYNC;
}

// --- writing -------------------------------------------------------------------------------------

bool Writer::begin(uint16_t topic, uint8_t length) {
  if (length > ToHost::ROOM - FRAME_BYTES || out_.room() < length + FRAME_BYTES) return false;
  out_.put(SYNC);
  out_.put(REVISION);
  out_.put(length);
  out_.put(0);  // no payload of a controller has 256 bytes
  out_.put(WHOLE - length);
  sum_ = 0;
  put_number(topic, 2);
  return true;
}

void Writer::put(uint8_t byte) {
  sum_ += byte;
  out_.put(byte);
}

void Writer::put_number(uint32_t number, uint8_t bytes) {
  for (; bytes > 0; bytes--, number >>= 8) put(static_cast<uint8_t>(number));
}

void Writer::put_bytes(const uint8_t* bytes, uint8_t count) {
  while (count-- > 0) put(*bytes++);
}

void Writer::put_text(const char* text) {
  put_number(strlen(text), 4);
  while (*text != '\0') put(static_cast<uint8_t>(*text++));
}

void Writer::end() { out_.put(WHOLE - sum_); }

uint8_t bytes_of_text(const char* text) { return static_cast<uint8_t>(4 + strlen(text)); }
