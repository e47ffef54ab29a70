// Tables of a robot, written by `pirate firmware pirate_ii -o robot.h`: do not edit them.
#pragma once

#include <stdint.h>

namespace robot {

constexpr char TABLES[] = "375106fc";  // CRC-32 of what follows, without comments
constexpr char NAME_AND_TABLES[] = "robot pirate_ii, tables 375106fc";

// The line, and times
constexpr uint32_t BAUD = 57600;
constexpr uint16_t STOP_AFTER_MS = 500;
constexpr uint32_t CYCLE_US = 16000;

// Topics and their definitions
constexpr char ARRAY_TOPIC[] = "setpoint_array";
constexpr char ARRAY_TYPE[] = "pirate_msgs/Setpoint_Array";
constexpr char ARRAY_MD5[] = "91cb216cb01faeb36bf37f6896af1aea";
constexpr char ECHO_TOPIC[] = "setpoint_echo";
constexpr char ECHO_TYPE[] = "pirate_msgs/Setpoint_Echo";
constexpr char ECHO_MD5[] = "91cb216cb01faeb36bf37f6896af1aea";
constexpr char STATE_TOPIC[] = "state";
constexpr char STATE_TYPE[] = "pirate_msgs/State";
constexpr char STATE_MD5[] = "05333c9697234305dce168019c710409";

// The array of setpoints, and its echo, which has the same fields
constexpr uint8_t SLOTS = 18;
constexpr uint8_t ARRAY_BYTES = 40;
constexpr uint8_t ARRAY_ID_AT = 0;
constexpr uint8_t ARRAY_ID_BYTES = 4;
constexpr uint8_t ARRAY_VALUES_AT = 4;
constexpr uint8_t ARRAY_VALUES_BYTES = 2;
constexpr bool ARRAY_COUNTED = false;
constexpr uint8_t ARRAY_HOLD_AT = 0;
constexpr uint8_t ARRAY_HOLD_BYTES = 4;
constexpr uint8_t ARRAY_HOLD_SHIFT = 14;
constexpr uint32_t HELD_WITHOUT_MASK = 0x3555f;
constexpr uint32_t OWN_CONTROLLER = 0x400;
constexpr int16_t LIMITS[] = {1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000, 1745, 1000, 1000, 1000, 1000, 1000, 1000, 1000};

// The state message
constexpr bool STATE_ONE_VALUE = false;
constexpr uint8_t STATE_BYTES = 37;
constexpr uint8_t STATE_BOARD_AT = 0;
constexpr uint8_t STATE_BOARD_BYTES = 1;
constexpr uint8_t STATE_CHANNEL_AT = 0;
constexpr uint8_t STATE_CHANNEL_BYTES = 0;
constexpr uint8_t STATE_VALUES_AT = 1;
constexpr uint8_t STATE_VALUES_BYTES = 4;
constexpr bool STATE_COUNTED = false;
constexpr bool STATE_IS_FLOAT = true;
constexpr int32_t STATE_LEAST = 0;
constexpr int32_t STATE_MOST = 0;

// The boards on the bus, in the order in which they are read
struct Board {
  uint8_t id, first_slot, slots, channels;
};
constexpr uint8_t BOARD_COUNT = 7;
constexpr uint8_t MOST_SLOTS = 2;
constexpr uint8_t MOST_CHANNELS = 9;
constexpr Board BOARDS[] = {
    {22, 4, 2, 6},
    {23, 6, 2, 6},
    {24, 8, 2, 9},
    {25, 10, 2, 5},
    {26, 12, 2, 6},
    {27, 14, 2, 6},
    {28, 16, 2, 0},
};

}  // namespace robot
