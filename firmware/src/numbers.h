// Numbers as bytes, the lowest first, in one to four bytes.
#pragma once

#include <stdint.h>

inline uint32_t read_number(const uint8_t* at, uint8_t bytes) {
  uint32_t found = 0;
  while (bytes-- > 0) found = found << 8 | at[bytes];
  return found;
}

inline void write_number(uint8_t* at, uint8_t bytes, uint32_t number) {
  for (uint8_t byte = 0; byte < bytes; byte++) {
    at[byte] = static_cast<uint8_t>(number);
    number >>= 8;
  }
}

// Two's complement of so many bytes.
inline int32_t read_signed(const uint8_t* at, uint8_t bytes) {
  const uint32_t found = read_number(at, bytes);
  if (bytes == 4) return static_cast<int32_t>(found);
  const uint32_t sign = 1UL << (8 * bytes - 1);
  return static_cast<int32_t>(found ^ sign) - static_cast<int32_t>(sign);
}

// CRC-16 with polynomial 0x1021, the highest bit first, from 0xFFFF ("CCITT-FALSE").
constexpr uint16_t CRC_START = 0xFFFF;

inline uint16_t crc_of(uint8_t byte, uint16_t crc) {
  crc ^= static_cast<uint16_t>(byte) << 8;
  for (uint8_t bit = 0; bit < 8; bit++) {
    crc = static_cast<uint16_t>(crc & 0x8000 ? crc << 1 ^ 0x1021 : crc << 1);
  }
  return crc;
}

inline uint16_t crc_of(const uint8_t* bytes, uint8_t count) {
  uint16_t crc = CRC_START;
  while (count-- > 0) crc = crc_of(*bytes++, crc);
  return crc;
}
