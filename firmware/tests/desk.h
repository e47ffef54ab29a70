// A bay on a desk: the firmware between a host and boards that the tests play.
#pragma once

#include <stdint.h>

#include <vector>

#include "../robot.h"
#include "../src/bay.h"
#include "../src/rs485.h"

typedef std::vector<uint8_t> Bytes;

// A frame of rosserial, made and taken apart here independently of the firmware.
struct Frame {
  uint16_t topic;
  Bytes payload;
  Bytes bytes() const;
};

// An array whose values are all the same, except where the robot's limits are smaller.
Bytes array_payload(uint32_t id, int16_t value);

// One board on the bus.
struct PlayedBoard {
  int16_t values[robot::MOST_SLOTS];
  int32_t channels[robot::MOST_CHANNELS];
  bool answers;
  bool obeys;
  unsigned written;
};

class Desk {
 public:
  explicit Desk(uint8_t reset_flags = POWER_ON, Kept* kept = nullptr);

  void send(const Bytes& bytes);
  void send(const Frame& frame) { send(frame.bytes()); }
  void ask_for_topics() { send(Frame{0, {}}); }

  // Lets time pass, in steps of a quarter of a millisecond.
  void run(uint32_t ms);

  // What the host has received, and forgets.
  std::vector<Frame> heard();

  Kept& kept;
  PlayedBoard boards[robot::BOARD_COUNT];
  Ticks now = 0;
  Bytes bus;  // everything that the bay has sent to the boards

 private:
  void play_boards();
  void play_line();

  Kept own_kept_;
  FromHost from_host_;
  ToHost to_host_;
  BusPort port_;
  Rs485 rs485_;
  Bay bay_;
  Bytes received_;
  uint32_t line_free_ = 0;
};
