// Frames of rosserial, protocol revision 1, least significant byte first:
//
//   FF FE | length | check | topic | payload | check
//
// The first check makes the sum of itself and the length's bytes 255 modulo 256; the second that
// of itself, the topic's bytes and the payload.
#pragma once

#include <stdint.h>

#include "ring.h"
#include "ticks.h"

constexpr uint8_t SYNC = 0xFF;
constexpr uint8_t REVISION = 0xFE;
constexpr uint8_t FRAME_BYTES = 8;  // around the payload

// The longest payload that is taken: more than any array of setpoints of a controller of this size.
constexpr uint8_t LONGEST_PAYLOAD = 128;

typedef Ring<128> FromHost;  // the host has at most 64 bytes under way: an Arduino's ring
typedef Ring<256> ToHost;    // takes the longest introduction of a topic

// Finds frames in a stream of bytes. Damage drops the frame, silently; so does a payload that
// is longer than there is room for, before any of it is stored.
class Reader {
 public:
  // Takes a byte; returns whether it completes a frame.
  bool take(uint8_t byte, Ticks now);

  // Of the frame just completed; valid until the next byte.
  uint16_t topic() const { return topic_; }
  const uint8_t* payload() const { return payload_; }
  uint8_t length() const { return static_cast<uint8_t>(length_); }

 private:
  enum Part : uint8_t {
    AT_SYNC,
    AT_REVISION,
    AT_LENGTH_LOW,
    AT_LENGTH_HIGH,
    AT_LENGTH_CHECK,
    AT_TOPIC_LOW,
    AT_TOPIC_HIGH,
    AT_PAYLOAD,
    AT_CHECK
  };

  Part after(uint8_t byte, Ticks now);

  Part part_ = AT_SYNC;
  Ticks began_ = 0;
  uint8_t sum_ = 0;
  uint16_t length_ = 0;
  uint16_t topic_ = 0;
  uint8_t filled_ = 0;
  uint8_t payload_[LONGEST_PAYLOAD] = {};
};

// Writes a frame piece by piece, so that it needs no memory besides the ring.
class Writer {
 public:
  explicit Writer(ToHost& out) : out_(out) {}

  // Begins a frame and returns true; does nothing and returns false where the whole frame does not
  // fit. Then put `length` bytes, and end.
  bool begin(uint16_t topic, uint8_t length);

  void put(uint8_t byte);
  void put_number(uint32_t number, uint8_t bytes);
  void put_bytes(const uint8_t* bytes, uint8_t count);
  void put_text(const char* text);  // its length in four bytes, then its bytes
  void end();

 private:
  ToHost& out_;
  uint8_t sum_ = 0;
};

// Bytes that `put_text` takes.
uint8_t bytes_of_text(const char* text);
