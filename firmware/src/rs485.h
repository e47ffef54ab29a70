// The boards on an RS-485 bus, half duplex. A frame of either direction:
//
//   B5 | board | kind | bytes | data | CRC
//
// `bytes` counts those of the data. The CRC-16 (numbers.h) is of everything before it. Numbers are
// least significant byte first.
//
//   kind  from     data
//   'W'   the bay  a byte with one bit per slot that is to be set, then an int16 for each slot
//   'w'   a board  an int16 for each slot, as they are in force now
//   'R'   the bay  nothing
//   'r'   a board  as in 'w', then an int32 for each channel
//
// A board answers within 1 ms of the last byte, with its own number, and to nothing that is damaged
// or for another board.
#pragma once

#include <stdint.h>

#include "boards.h"
#include "ring.h"

constexpr uint32_t BUS_BAUD = 500000;  // [assumed] exact at 16 MHz; a frame of 10 bytes takes 0.2 ms

// The port of the bus. Whoever writes sets `talking`; the interrupt that sees the last bit leave
// clears it, and turns the direction round. What comes in before is not kept.
struct BusPort {
  Ring<64> out;
  Ring<128> in;
  volatile bool talking = false;
};

class Rs485 : public Boards {
 public:
  explicit Rs485(BusPort& port) : port_(port) {}

  void write(uint8_t board, uint8_t slots, const int16_t* values, Ticks now) override;
  void read(uint8_t board, Ticks now) override;
  Outcome outcome(Ticks now, Answer& answer) override;

 private:
  static constexpr uint8_t HEAD_BYTES = 4;
  static constexpr uint8_t CRC_BYTES = 2;
  static constexpr uint8_t MOST_BYTES =
      HEAD_BYTES + 2 * robot::MOST_SLOTS + 4 * robot::MOST_CHANNELS + CRC_BYTES;

  void begin(uint8_t board, uint8_t kind, uint8_t bytes);
  void put(uint8_t byte);
  void end(uint8_t kind, uint8_t bytes, Ticks now);
  bool unpack(Answer& answer) const;

  BusPort& port_;
  uint16_t crc_ = 0;
  uint8_t board_ = 0;    // index in the table of boards
  uint8_t wanted_ = 0;   // the kind of the answer; 0: no exchange is under way
  uint8_t bytes_ = 0;    // of the answer's data
  uint8_t filled_ = 0;
  Ticks began_ = 0;
  Ticks within_ = 0;
  uint8_t answer_[MOST_BYTES] = {};
};
