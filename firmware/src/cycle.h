// The cycle of the bus, four cases of equal length [thesis 4-2]: idle, write setpoints, read a
// board, publish what it said. An exchange begins in its case and may end in the next one. A case
// that comes late is not caught up.
//
// A board has a setpoint when it has said so: each answer tells what the board has in force, and
// is compared. A write that was not answered, or not with these values, is repeated in the next
// cycle, and so is one to a board that has forgotten its setpoints.
#pragma once

#include <stdint.h>

#include "array.h"
#include "boards.h"
#include "node.h"
#include "ticks.h"

class Cycle {
 public:
  Cycle(Boards& boards, Node& node) : boards_(boards), node_(node) {}

  // Puts those slots of the array in force whose bits are set; the others stay as they are.
  void put_in_force(const Array& array, uint32_t slots);

  void step(Ticks now);

  // Whether every board that answers at all has said that it has what is in force. One that answers
  // and has something else is waited for, however long that takes.
  bool settled() const;

  enum Health : uint8_t { WELL, SILENT, DISOBEYS };

  // What the host has not been told yet of a board.
  struct News {
    uint8_t board;
    Health was, is;
  };
  bool has_news(News& news) const;
  void told(const News& news) { states_[news.board].told = news.is; }

  // Another host listens, which has been told nothing.
  void told_nothing();

 private:
  enum Case : uint8_t { IDLE, WRITE, READ, PUBLISH, CASES };

  void take_outcome(Ticks now);
  void begin_write(Ticks now);
  void begin_read(Ticks now);
  void publish();
  void next_turn();
  uint8_t slots_of(uint8_t board) const;
  bool has_in_force(uint8_t board) const;

  struct State {
    bool to_write = false;   // whether it must be told what is in force
    uint8_t missed = 0;      // how many exchanges in a row have failed, at most 255
    uint8_t refused = 0;     // after how many writes in a row it had something else, at most 255
    Health told = WELL;
  };
  static Health health_of(const State& board);

  Boards& boards_;
  Node& node_;
  int16_t values_[robot::SLOTS] = {};
  uint32_t known_ = 0;  // the slots that are in force because of us, one bit each
  State states_[robot::BOARD_COUNT];
  Answer answer_ = {};

  Case case_ = IDLE;
  Ticks began_ = 0;
  uint8_t asked_ = 0;       // the board of the exchange that is under way
  bool writing_ = false;    // what that exchange is
  uint8_t next_write_ = 0;  // boards take turns, so that a dead one holds up no other
  uint8_t tries_ = 0;       // writes that may still begin in this case
  bool to_read_ = false;    // whether the board whose turn it is must still be asked in this case
  bool to_publish_ = false;
  uint8_t turn_ = 0;        // the board that is read, and, where a message has one value,
  uint8_t channel_ = 0;     // the channel that is published
};
