// The device's side of the conversation with the host: topics, time, log.
//
// It is silent until the host asks for its topics, and again when the host says so, or has not
// answered a request for the time for 11 s. Nothing waits: what does not fit into the ring to the
// host is sent when it does.
#pragma once

#include <stdint.h>

#include "array.h"
#include "frame.h"
#include "ring.h"
#include "ticks.h"

class Node {
 public:
  Node(FromHost& in, ToHost& out) : in_(in), writer_(out) {}

  // Takes the bytes that have come, up to the next payload for the topic of setpoints; returns
  // whether there is one, `payload()` of `length()` bytes, valid until the next call. There is none
  // before a host has asked for the topics: it may not know of the restart, and repeats an array.
  bool hears(Ticks now);
  const uint8_t* payload() const { return reader_.payload(); }
  uint8_t length() const { return reader_.length(); }

  // Whether a host has asked for the topics since the last call. It has been told nothing yet.
  bool was_asked() {
    const bool was = asked_for_topics_;
    asked_for_topics_ = false;
    return was;
  }

  // Sends what is due: introductions, requests for the time.
  void speak(Ticks now);

  // Each sends a message if the host listens and it fits; returns whether it was sent.
  bool send_echo(const Array& array);
  bool send_state(uint8_t board, uint8_t channel, const int32_t* values, uint8_t count);
  bool log(uint8_t level, const char* text, const char* more = "");

  // Whether the host listens; whether it has been told all topics, too.
  bool listened_to() const { return configured_; }
  bool ready() const { return configured_ && introduced_ == TOPICS; }

 private:
  static constexpr uint8_t TOPICS = 4;  // a request for the time, states, echoes, setpoints

  void obey(Ticks now);
  bool introduce(uint8_t which);

  FromHost& in_;
  Writer writer_;
  Reader reader_;
  bool met_ = false;  // whether a host has asked for the topics since the restart
  bool configured_ = false;
  bool asked_for_topics_ = false;
  uint8_t introduced_ = 0;
  Ticks asked_ = 0;
  Ticks answered_ = 0;
};

// Levels of the log, as in ROS.
constexpr uint8_t LOG_INFO = 1;
constexpr uint8_t LOG_WARNING = 2;
constexpr uint8_t LOG_ERROR = 3;
