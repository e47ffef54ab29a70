#include "cycle.h"

using robot::BOARD_COUNT;
using robot::BOARDS;

namespace {

constexpr Ticks CASE = microseconds(robot::CYCLE_US) / 4;

// A board that has not answered so often in a row is not waited for [assumed], and one that has not
// answered or not obeyed so often is reported: at one reading in 0.1 s after a second.
constexpr uint8_t MOST_TRIES = 3;
constexpr uint8_t TOLD_AFTER = 8;

}  // namespace

void Cycle::put_in_force(const Array& array, uint32_t slots) {
  known_ |= slots;
  for (uint8_t slot = 0; slot < robot::SLOTS; slot++) {
    if (slots >> slot & 1) values_[slot] = array.values[slot];
  }
  for (uint8_t board = 0; board < BOARD_COUNT; board++) {
    states_[board].to_write = slots_of(board) != 0;
  }
}

void Cycle::step(Ticks now) {
  take_outcome(now);
  if (now - began_ >= CASE) {
    began_ = now - began_ < 2 * CASE ? began_ + CASE : now;
    case_ = static_cast<Case>((case_ + 1) % CASES);
    tries_ = case_ == WRITE ? BOARD_COUNT : 0;
    to_read_ = case_ == READ;
    if (case_ == WRITE) to_publish_ = false;  // too late
  }
  if (tries_ > 0) begin_write(now);
  if (to_read_) begin_read(now);
  if (case_ == PUBLISH && to_publish_) publish();
}

bool Cycle::settled() const {
  for (const State& board : states_) {
    if (board.to_write && board.missed < MOST_TRIES) return false;
  }
  return true;
}

// --- exchanges -----------------------------------------------------------------------------------

void Cycle::take_outcome(Ticks now) {
  const Boards::Outcome outcome = boards_.outcome(now, answer_);
  State& board = states_[asked_];
  if (outcome == Boards::ANSWERED) {
    board.missed = 0;
    board.to_write = !has_in_force(asked_);
    if (!board.to_write) {
      board.refused = 0;
    } else if (writing_ && board.refused < 255) {
      board.refused++;
    }
    to_publish_ = !writing_;
  } else if (outcome == Boards::FAILED && board.missed < 255) {
    board.missed++;
  }
}

void Cycle::begin_write(Ticks now) {
  if (boards_.outcome(now, answer_) != Boards::NONE) return;
  for (; tries_ > 0; tries_--) {
    const uint8_t board = next_write_;
    next_write_ = (next_write_ + 1) % BOARD_COUNT;
    if (!states_[board].to_write) continue;
    tries_--;
    asked_ = board;
    writing_ = true;
    boards_.write(board, slots_of(board), values_ + BOARDS[board].first_slot, now);
    return;
  }
}

void Cycle::begin_read(Ticks now) {
  if (boards_.outcome(now, answer_) != Boards::NONE) return;
  to_read_ = false;
  next_turn();
  if (BOARDS[turn_].channels == 0) return;  // no board of this robot reports
  asked_ = turn_;
  writing_ = false;
  boards_.read(turn_, now);
}

void Cycle::publish() {
  to_publish_ = false;
  const uint8_t id = BOARDS[turn_].id;
  if (robot::STATE_ONE_VALUE) {
    node_.send_state(id, channel_, answer_.channels + channel_, 1);
  } else {
    node_.send_state(id, 0, answer_.channels, BOARDS[turn_].channels);
  }
}

// Boards take turns, and so do the channels of a board where a message has one value.
void Cycle::next_turn() {
  if (robot::STATE_ONE_VALUE && ++channel_ < BOARDS[turn_].channels) return;
  channel_ = 0;
  for (uint8_t board = 0; board < BOARD_COUNT; board++) {
    turn_ = (turn_ + 1) % BOARD_COUNT;
    if (BOARDS[turn_].channels > 0) return;
  }
}

// --- what boards have ----------------------------------------------------------------------------

// The slots of the board that are known, one bit each.
uint8_t Cycle::slots_of(uint8_t board) const {
  const uint8_t all = static_cast<uint8_t>((1 << BOARDS[board].slots) - 1);
  return known_ >> BOARDS[board].first_slot & all;
}

bool Cycle::has_in_force(uint8_t board) const {
  const uint8_t slots = slots_of(board);
  for (uint8_t slot = 0; slot < BOARDS[board].slots; slot++) {
    if ((slots >> slot & 1) && answer_.in_force[slot] != values_[BOARDS[board].first_slot + slot]) {
      return false;
    }
  }
  return true;
}

// --- what the host is told of them ---------------------------------------------------------------

// Between well and ill a board is what it was.
Cycle::Health Cycle::health_of(const State& board) {
  if (board.missed >= TOLD_AFTER) return SILENT;
  if (board.refused >= TOLD_AFTER) return DISOBEYS;
  return board.missed == 0 && board.refused == 0 ? WELL : board.told;
}

bool Cycle::has_news(News& news) const {
  for (uint8_t board = 0; board < BOARD_COUNT; board++) {
    const State& state = states_[board];
    news = {board, state.told, health_of(state)};
    if (news.is != news.was) return true;
  }
  return false;
}

void Cycle::told_nothing() {
  for (State& state : states_) state.told = WELL;
}
