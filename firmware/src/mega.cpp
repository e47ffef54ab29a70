// The firmware on an Arduino Mega (ATmega2560, 16 MHz): ports, clock, watchdog, and the main loop.
//
// It has a `main` of its own, so that nothing of Arduino's core is linked: what the tests run is what
// is flashed.
#ifdef __AVR_ATmega2560__

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

#include "../robot.h"
#include "bay.h"
#include "kept.h"
#include "ring.h"
#include "rs485.h"
#include "ticks.h"

namespace {

FromHost from_host;
ToHost to_host;
BusPort bus;
Rs485 boards(bus);  // a lab with another bus puts its own `Boards` here

Kept kept __attribute__((section(".noinit")));
uint8_t reset_flags __attribute__((section(".noinit")));

Bay bay(from_host, to_host, boards, kept);

// --- why it restarted ----------------------------------------------------------------------------

static_assert(POWER_ON == _BV(PORF) && EXTERNAL == _BV(EXTRF) && WATCHDOG == _BV(WDRF),
              "the controller has other flags");

// Runs before anything else. After a restart by the watchdog the watchdog still runs, at its
// shortest time [data sheet, 12.4].
extern "C" void find_out_why() __attribute__((naked, used, section(".init3")));
extern "C" void find_out_why() {
  reset_flags = MCUSR;
  MCUSR = 0;
  wdt_disable();
}

// --- clock and watchdog --------------------------------------------------------------------------

constexpr uint16_t TICKS_PER_MS = milliseconds(1);

volatile uint16_t overflows = 0;

void start_clock() {
  TCCR1A = 0;
  TCCR1B = _BV(CS11) | _BV(CS10);  // 16 MHz / 64
  OCR1A = TICKS_PER_MS;
  TIMSK1 = _BV(TOIE1) | _BV(OCIE1A);
}

Ticks ticks() {
  const uint8_t flags = SREG;
  cli();
  const uint16_t low = TCNT1;
  uint16_t high = overflows;
  if ((TIFR1 & _BV(TOV1)) && low < 0x8000) high++;  // it wrapped a moment ago
  SREG = flags;
  return static_cast<Ticks>(high) << 16 | low;
}

ISR(TIMER1_OVF_vect) { overflows++; }

// Wakes the loop every millisecond, and notices when it does not come round.
ISR(TIMER1_COMPA_vect) {
  OCR1A += TICKS_PER_MS;
  kept.pass_millisecond();
}

// --- ports ---------------------------------------------------------------------------------------

// Of a rate, with the port at double speed; rounded [data sheet, table 22-1].
constexpr uint16_t divisor(uint32_t baud) { return (F_CPU / 4 / baud - 1) / 2; }

// The bus's driver is switched by pin 2 of the Arduino (PE4): high, and it drives the bus.
void drive_bus() { PORTE |= _BV(PE4); }
void release_bus() { PORTE &= static_cast<uint8_t>(~_BV(PE4)); }

void start_ports() {
  UCSR0A = _BV(U2X0);
  UBRR0 = divisor(robot::BAUD);
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);

  release_bus();
  DDRE |= _BV(PE4);
  UCSR1A = _BV(U2X1);
  UBRR1 = divisor(BUS_BAUD);
  UCSR1C = _BV(UCSZ11) | _BV(UCSZ10);
  UCSR1B = _BV(RXEN1) | _BV(TXEN1) | _BV(RXCIE1);
}

// Begins to send what the loop has put into the rings.
void start_sending() {
  if (!to_host.empty()) UCSR0B |= _BV(UDRIE0);
  if (!bus.out.empty()) {
    drive_bus();
    UCSR1B |= _BV(UDRIE1) | _BV(TXCIE1);
  }
}

ISR(USART0_RX_vect) { from_host.put(UDR0); }

ISR(USART0_UDRE_vect) {
  if (to_host.empty()) {
    UCSR0B &= static_cast<uint8_t>(~_BV(UDRIE0));
  } else {
    UDR0 = to_host.get();
  }
}

ISR(USART1_RX_vect) {
  const uint8_t byte = UDR1;
  if (!bus.talking) bus.in.put(byte);  // a bus that hears itself
}

ISR(USART1_UDRE_vect) {
  if (bus.out.empty()) {
    UCSR1B &= static_cast<uint8_t>(~_BV(UDRIE1));
  } else {
    UCSR1A |= _BV(TXC1);  // this byte is not the last one any more
    UDR1 = bus.out.get();
  }
}

// The last bit has left, of the frame if nothing waits any more.
ISR(USART1_TX_vect) {
  if (!bus.out.empty()) return;
  UCSR1B &= static_cast<uint8_t>(~_BV(TXCIE1));
  release_bus();
  bus.talking = false;
}

}  // namespace

int main() {
  bay.start(reset_flags);
  start_clock();
  start_ports();
  set_sleep_mode(SLEEP_MODE_IDLE);
  wdt_enable(WDTO_250MS);
  sei();
  for (;;) {
    bay.step(ticks());
    start_sending();
    wdt_reset();
    kept.come_round();
    sleep_mode();
  }
}

#endif
