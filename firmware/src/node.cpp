#include "node.h"

#include <string.h>

#include "../robot.h"
#include "numbers.h"

namespace {

// Reserved topics of rosserial.
constexpr uint16_t REQUEST_TOPICS = 0;
constexpr uint16_t PUBLISHER = 0;
constexpr uint16_t SUBSCRIBER = 1;
constexpr uint16_t LOG = 7;
constexpr uint16_t TIME = 10;
constexpr uint16_t TX_STOP = 11;

// Ours. The host learns them from the introductions.
constexpr uint16_t SETPOINTS = 100;
constexpr uint16_t STATE = 125;
constexpr uint16_t ECHO = 126;

constexpr Ticks ASK_TIME_EVERY = milliseconds(2500);  // [rosserial_arduino]
constexpr Ticks FORGET_AFTER = milliseconds(11000);   // [rosserial_arduino]

struct Topic {
  uint16_t frame;
  uint16_t number;
  const char* name;
  const char* type;
  const char* md5;
};

constexpr Topic INTRODUCED[] = {
    {PUBLISHER, STATE, robot::STATE_TOPIC, robot::STATE_TYPE, robot::STATE_MD5},
    {PUBLISHER, ECHO, robot::ECHO_TOPIC, robot::ECHO_TYPE, robot::ECHO_MD5},
    {SUBSCRIBER, SETPOINTS, robot::ARRAY_TOPIC, robot::ARRAY_TYPE, robot::ARRAY_MD5},
};

// The payload of an introduction: numbers, and three texts with their lengths.
template <size_t NAME, size_t TYPE, size_t MD5>
constexpr size_t bytes_of(const char (&)[NAME], const char (&)[TYPE], const char (&)[MD5]) {
  return 2 + (4 + NAME - 1) + (4 + TYPE - 1) + (4 + MD5 - 1) + 4;
}
constexpr size_t MOST_BYTES = ToHost::ROOM - FRAME_BYTES;

static_assert(bytes_of(robot::STATE_TOPIC, robot::STATE_TYPE, robot::STATE_MD5) <= MOST_BYTES &&
                  bytes_of(robot::ECHO_TOPIC, robot::ECHO_TYPE, robot::ECHO_MD5) <= MOST_BYTES &&
                  bytes_of(robot::ARRAY_TOPIC, robot::ARRAY_TYPE, robot::ARRAY_MD5) <= MOST_BYTES,
              "the name of a topic or of its type is too long");
static_assert(robot::ARRAY_BYTES <= LONGEST_PAYLOAD, "an array of setpoints is too long");
static_assert(robot::STATE_BYTES <= MOST_BYTES, "a state message is too long");

// A number of counts in the type that the state message has for it.
uint32_t bits_of_state(int32_t value) {
  if (robot::STATE_IS_FLOAT) {
    const float number = static_cast<float>(value);
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
  }
  if (value < robot::STATE_LEAST) value = robot::STATE_LEAST;
  if (value > robot::STATE_MOST) value = robot::STATE_MOST;
  return static_cast<uint32_t>(value);
}

}  // namespace

// --- hearing -------------------------------------------------------------------------------------

bool Node::hears(Ticks now) {
  while (!in_.empty()) {
    if (!reader_.take(in_.get(), now)) continue;
    if (reader_.topic() == SETPOINTS && met_) return true;
    obey(now);
  }
  return false;
}

void Node::obey(Ticks now) {
  switch (reader_.topic()) {
    case REQUEST_TOPICS:
      met_ = configured_ = asked_for_topics_ = true;
      introduced_ = 0;
      answered_ = now;
      break;
    case TIME:
      answered_ = now;
      break;
    case TX_STOP:
      configured_ = false;
      break;
    default:  // no subscriber
      break;
  }
}

// --- speaking ------------------------------------------------------------------------------------

void Node::speak(Ticks now) {
  if (now - answered_ > FORGET_AFTER) configured_ = false;
  if (!configured_) return;
  if (introduced_ == 0) asked_ = now - ASK_TIME_EVERY;
  if (now - asked_ >= ASK_TIME_EVERY && writer_.begin(TIME, 8)) {
    writer_.put_number(0, 4);
    writer_.put_number(0, 4);
    writer_.end();
    asked_ = now;
    if (introduced_ == 0) introduced_ = 1;
  }
  while (introduced_ > 0 && introduced_ < TOPICS && introduce(introduced_ - 1)) introduced_++;
}

bool Node::introduce(uint8_t which) {
  const Topic& topic = INTRODUCED[which];
  const uint8_t texts =
      bytes_of_text(topic.name) + bytes_of_text(topic.type) + bytes_of_text(topic.md5);
  if (!writer_.begin(topic.frame, 2 + texts + 4)) return false;
  writer_.put_number(topic.number, 2);
  writer_.put_text(topic.name);
  writer_.put_text(topic.type);
  writer_.put_text(topic.md5);
  writer_.put_number(LONGEST_PAYLOAD, 4);
  writer_.end();
  return true;
}

bool Node::send_echo(const Array& array) {
  if (!ready() || !writer_.begin(ECHO, robot::ARRAY_BYTES)) return false;
  uint8_t payload[robot::ARRAY_BYTES];
  array.write(payload);
  writer_.put_bytes(payload, robot::ARRAY_BYTES);
  writer_.end();
  return true;
}

bool Node::send_state(uint8_t board, uint8_t channel, const int32_t* values, uint8_t count) {
  using namespace robot;
  const uint8_t bytes =
      STATE_COUNTED ? STATE_VALUES_AT + count * STATE_VALUES_BYTES : STATE_BYTES;
  if (!ready() || !writer_.begin(STATE, bytes)) return false;
  uint8_t payload[STATE_BYTES] = {};
  write_number(payload + STATE_BOARD_AT, STATE_BOARD_BYTES, board);
  if (STATE_CHANNEL_BYTES > 0) {
    write_number(payload + STATE_CHANNEL_AT, STATE_CHANNEL_BYTES, channel);
  }
  if (STATE_COUNTED) write_number(payload + STATE_VALUES_AT - 4, 4, count);
  for (uint8_t index = 0; index < count; index++) {
    write_number(payload + STATE_VALUES_AT + index * STATE_VALUES_BYTES, STATE_VALUES_BYTES,
                 bits_of_state(values[index]));
  }
  writer_.put_bytes(payload, bytes);
  writer_.end();
  return true;
}

bool Node::log(uint8_t level, const char* text, const char* more) {
  const uint8_t letters = static_cast<uint8_t>(strlen(text) + strlen(more));
  if (!ready() || !writer_.begin(LOG, 1 + 4 + letters)) return false;
  writer_.put(level);
  writer_.put_number(letters, 4);
  writer_.put_bytes(reinterpret_cast<const uint8_t*>(text), strlen(text));
  writer_.put_bytes(reinterpret_cast<const uint8_t*>(more), strlen(more));
  writer_.end();
  return true;
}
