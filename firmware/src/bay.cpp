#include "bay.h"

#include "../robot.h"

namespace {

const char* const GREETING = "firmware 1 of ";  // the version, which `pirate doctor` reads

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

const char* text_of(const Cycle::News& news) {
  if (news.is == Cycle::SILENT) return "no answer from board ";
  if (news.is == Cycle::DISOBEYS) return "setpoints are not obeyed by board ";
  return news.was == Cycle::SILENT ? "answers again: board " : "obeys again: board ";
}

const char* text_of(Restart restart) {
  return restart == HUNG ? "the main loop hung, and the watchdog restarted it: "
                           "held slots are as they were, others at zero"
                         : "started, and it is not known why: "
                           "held slots were left alone, others set to zero";
}

// Under a boot loader that clears the flags every start is one of which it is not known why.
uint8_t level_of(Restart restart) { return restart == HUNG ? LOG_WARNING : LOG_INFO; }

}  // namespace

void Bay::start(uint8_t reset_flags) {
  restart_ = kept_.recall(in_force_, reset_flags);
  uint32_t known = ALL_SLOTS;
  if (restart_ == BY_HAND) known &= ~robot::OWN_CONTROLLER;
  if (restart_ == UNKNOWN) known &= ~in_force_.held();
  in_force_.stop();
  if (restart_ == HUNG) kept_.keep(in_force_);
  cycle_.put_in_force(in_force_, known);
}

void Bay::step(Ticks now) {
  while (node_.hears(now)) take_array(now);
  if (switch_.trips(now)) {
    in_force_.stop();
    put_in_force();
  }
  cycle_.step(now);
  if (node_.was_asked()) {
    greeted_ = 0;
    cycle_.told_nothing();
  }
  node_.speak(now);
  say();
}

void Bay::take_array(Ticks now) {
  if (!Array::read(node_.payload(), node_.length(), in_force_)) {
    refused_ = true;
    return;
  }
  switch_.hear(now);
  put_in_force();
}

void Bay::put_in_force() {
  kept_.keep(in_force_);
  cycle_.put_in_force(in_force_, ALL_SLOTS);
  to_echo_ = true;
}

// --- what the host is told -----------------------------------------------------------------------

// An echo says what the boards have said: there is none while one of them has something else.
void Bay::say() {
  if (!node_.listened_to()) to_echo_ = false;
  if (to_echo_ && cycle_.settled()) to_echo_ = !node_.send_echo(in_force_);
  if (!node_.ready()) return;
  greet();
  if (refused_) refused_ = !node_.log(LOG_ERROR, "an array was refused: wrong length or range");
  Cycle::News news;
  if (cycle_.has_news(news) &&
      node_.log(LOG_WARNING, text_of(news), Text(robot::BOARDS[news.board].id).c_str())) {
    cycle_.told(news);
  }
}

void Bay::greet() {
  if (greeted_ == 0 && node_.log(LOG_INFO, GREETING, robot::NAME_AND_TABLES)) greeted_ = 1;
  if (greeted_ == 1 && (restart_ == BY_HAND || node_.log(level_of(restart_), text_of(restart_)))) {
    greeted_ = 2;
  }
}
