#include "bay.h"

#include "../robot.h"

namespace {

const char* const GREETING = "firmware 1 of ";  // the version, which `pirate doctor` reads

// Boards have this long to say that they have what is in force; then it is echoed nevertheless.
constexpr Ticks ECHO_WITHIN = milliseconds(robot::ECHO_WITHIN_MS);

constexpr uint32_t ALL_SLOTS = 0xFFFFFFFFUL >> (32 - robot::SLOTS);

// A number below 256 as text.
class Text {
 public:
  explicit Text(uint8_t number) {
    do {
      *--begin_ = static_cast<char>('0' + number % 10);
      number /= 10;
    } while (number > 0);
  }
  const char* c_str() const { return begin_; }

 private:
  char letters_[4] = {};
  char* begin_ = letters_ + 3;
};

}  // namespace

void Bay::start(bool restarted_by_watchdog) {
  restored_ = kept_.recall(in_force_, restarted_by_watchdog);
  if (restored_) {
    in_force_.stop();
    kept_.keep(in_force_);
  }
  cycle_.put_in_force(in_force_, restored_ ? ALL_SLOTS : ALL_SLOTS & ~robot::OWN_CONTROLLER);
}

void Bay::step(Ticks now) {
  while (node_.hears(now)) take_array(now);
  if (switch_.trips(now)) {
    in_force_.stop();
    put_in_force(now);
  }
  cycle_.step(now);
  node_.speak(now);
  say(now);
}

void Bay::take_array(Ticks now) {
  if (to_echo_) node_.send_echo(in_force_);  // it was in force, if only until now
  if (!Array::read(node_.payload(), node_.length(), in_force_)) {
    refused_ = true;
    return;
  }
  switch_.hear(now);
  put_in_force(now);
}

void Bay::put_in_force(Ticks now) {
  kept_.keep(in_force_);
  cycle_.put_in_force(in_force_, ALL_SLOTS);
  to_echo_ = true;
  since_ = now;
}

// --- what the host is told -----------------------------------------------------------------------

void Bay::say(Ticks now) {
  if (!node_.listened_to()) to_echo_ = false;
  if (to_echo_ && (cycle_.settled() || now - since_ >= ECHO_WITHIN)) {
    to_echo_ = !node_.send_echo(in_force_);
  }
  if (!node_.ready()) {
    greeted_ = 0;
    cycle_.told_nothing();
    return;
  }
  greet();
  if (refused_) refused_ = !node_.log(LOG_ERROR, "an array was refused: wrong length or range");
  Cycle::News news;
  if (cycle_.has_news(news) &&
      node_.log(LOG_WARNING, news.answers ? "answers again: board " : "no answer from board ",
                Text(robot::BOARDS[news.board].id).c_str())) {
    cycle_.told(news);
  }
}

void Bay::greet() {
  if (greeted_ == 0 && node_.log(LOG_INFO, GREETING, robot::NAME_AND_TABLES)) greeted_ = 1;
  if (greeted_ == 1 &&
      (!restored_ || node_.log(LOG_WARNING, "the main loop hung, and the watchdog restarted it: "
                                            "held slots are as they were, others at zero"))) {
    greeted_ = 2;
  }
}
