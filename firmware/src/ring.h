// A queue of bytes between the program and an interrupt: one of them writes, the other reads.
#pragma once

#include <stdint.h>

#include "barrier.h"

// SIZE is a power of two, at most 256, so that an index is one byte, which nothing can interrupt.
template <uint16_t SIZE>
class Ring {
  static_assert(SIZE <= 256 && (SIZE & (SIZE - 1)) == 0, "an index is one byte");

 public:
  // One place stays empty, or a full ring would look like an empty one.
  static constexpr uint8_t ROOM = SIZE - 1;

  uint8_t waiting() const { return (head_ - tail_) & (SIZE - 1); }
  uint8_t room() const { return ROOM - waiting(); }
  bool empty() const { return head_ == tail_; }

  // A byte for which there is no room is lost.
  void put(uint8_t byte) {
    if (room() == 0) return;
    bytes_[head_] = byte;
    barrier();  // the byte is there before the index says so
    head_ = (head_ + 1) & (SIZE - 1);
  }

  // Call it only where the ring is not empty.
  uint8_t get() {
    const uint8_t byte = bytes_[tail_];
    barrier();  // the byte is read before its place is free
    tail_ = (tail_ + 1) & (SIZE - 1);
    return byte;
  }

  // For the side that reads.
  void clear() { tail_ = head_; }

 private:
  uint8_t bytes_[SIZE] = {};
  volatile uint8_t head_ = 0;
  volatile uint8_t tail_ = 0;
};
