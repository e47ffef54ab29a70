// The whole firmware: its conversation, its cycle, its boards.
#include <algorithm>
#include <string>

#include "check.h"
#include "desk.h"

using namespace robot;

namespace {

constexpr uint16_t SETPOINTS = 100, STATE = 125, ECHO = 126, LOG = 7, TIME = 10;

std::vector<Frame> on(uint16_t topic, const std::vector<Frame>& frames) {
  std::vector<Frame> found;
  std::copy_if(frames.begin(), frames.end(), std::back_inserter(found),
               [topic](const Frame& frame) { return frame.topic == topic; });
  return found;
}

std::string words(const std::vector<Frame>& frames) {
  std::string found;
  for (const Frame& line : on(LOG, frames)) {
    found.append(line.payload.begin() + 5, line.payload.end());
    found += "\n";
  }
  return found;
}

void introduce(Desk& desk) {
  desk.ask_for_topics();
  desk.run(300);
  desk.heard();
}

int count(const std::string& text, const std::string& what) {
  int found = 0;
  for (size_t at = 0; (at = text.find(what, at)) != std::string::npos; at++) found++;
  return found;
}

bool all(const Desk& desk, int16_t value) {
  for (uint8_t board = 0; board < BOARD_COUNT; board++) {
    for (uint8_t slot = 0; slot < BOARDS[board].slots; slot++) {
      const int16_t limit = LIMITS[BOARDS[board].first_slot + slot];
      if (desk.boards[board].values[slot] != std::min(value, limit)) return false;
    }
  }
  return true;
}

}  // namespace

TEST(it_is_silent_until_it_is_asked) {
  Desk desk;
  desk.run(5000);
  CHECK(desk.heard().empty());
}

TEST(it_introduces_time_publishers_and_the_subscriber_in_order_and_says_what_it_is) {
  Desk desk;
  desk.ask_for_topics();
  desk.run(300);
  const std::vector<Frame> frames = desk.heard();
  CHECK(frames.size() > 5);
  CHECK(frames[0].topic == TIME && frames[0].payload == Bytes(8, 0));
  CHECK(frames[1].topic == 0 && frames[1].payload[0] == STATE);
  CHECK(frames[2].topic == 0 && frames[2].payload[0] == ECHO);
  CHECK(frames[3].topic == 1 && frames[3].payload[0] == SETPOINTS);
  CHECK(words(frames).find(NAME_AND_TABLES) != std::string::npos);
  CHECK(words(frames).find("watchdog") == std::string::npos);
}

TEST(it_reads_one_board_in_each_cycle_and_publishes_it) {
  Desk desk;
  for (uint8_t board = 0; board < BOARD_COUNT; board++) desk.boards[board].channels[0] = 1000 + board;
  introduce(desk);
  desk.run(1000);
  const std::vector<Frame> states = on(STATE, desk.heard());
  CHECK(states.size() >= 1000000 / CYCLE_US - 1 && states.size() <= 1000000 / CYCLE_US + 1);
  for (const Frame& state : states) CHECK(state.payload.size() == STATE_BYTES);
}

TEST(motors_are_at_rest_from_the_start_and_boards_with_controllers_as_they_were) {
  Desk desk;
  desk.run(100);
  for (uint8_t board = 0; board < BOARD_COUNT; board++) {
    for (uint8_t slot = 0; slot < BOARDS[board].slots; slot++) {
      const bool own = OWN_CONTROLLER >> (BOARDS[board].first_slot + slot) & 1;
      CHECK(desk.boards[board].values[slot] == (own ? 77 : 0));
    }
  }
}

TEST(an_array_is_in_force_within_two_cycles_and_echoed_whole) {
  Desk desk;
  introduce(desk);
  const Bytes payload = array_payload(42, 300);
  desk.send(Frame{SETPOINTS, payload});
  desk.run(2 * CYCLE_US / 1000 + 1);
  CHECK(all(desk, 300));
  desk.run(50);
  const std::vector<Frame> echoes = on(ECHO, desk.heard());
  CHECK(echoes.size() == 1 && echoes[0].payload == payload);
}

TEST(no_array_is_obeyed_before_the_host_has_asked_because_it_may_not_know_of_the_restart) {
  Desk desk;
  desk.send(Frame{SETPOINTS, array_payload(1, 10)});
  desk.run(100);
  introduce(desk);
  CHECK(desk.boards[0].values[0] == 0);
  desk.send(Frame{SETPOINTS, array_payload(2, 20)});
  desk.run(100);
  CHECK(all(desk, 20));
}

TEST(an_array_is_obeyed_also_by_a_firmware_that_has_fallen_silent) {
  Desk desk;
  introduce(desk);
  desk.send(Frame{11, {}});
  desk.send(Frame{SETPOINTS, array_payload(1, 10)});
  desk.run(100);
  CHECK(all(desk, 10));
}

TEST(an_array_that_is_refused_changes_nothing_and_is_told) {
  Desk desk;
  introduce(desk);
  desk.send(Frame{SETPOINTS, array_payload(1, 10)});
  desk.run(100);
  desk.heard();
  Bytes bad = array_payload(2, 20);
  bad.pop_back();
  desk.send(Frame{SETPOINTS, bad});
  desk.run(100);
  CHECK(all(desk, 10));
  const std::vector<Frame> frames = desk.heard();
  CHECK(on(ECHO, frames).empty());
  CHECK(words(frames).find("refused") != std::string::npos);
}

TEST(silence_of_the_host_stops_what_is_not_held_and_says_so_again) {
  Desk desk;
  introduce(desk);
  const uint32_t hold = 1UL << BOARDS[0].first_slot | OWN_CONTROLLER;
  desk.send(Frame{SETPOINTS, array_payload(hold << ARRAY_HOLD_SHIFT | 9, 500)});
  desk.run(STOP_AFTER_MS - 20);
  desk.heard();
  CHECK(all(desk, 500));
  desk.run(20 + 2 * CYCLE_US / 1000 + 2);
  CHECK(desk.boards[0].values[0] == 500 && desk.boards[0].values[1] == 0);
  for (uint8_t board = 1; board < BOARD_COUNT; board++) {
    for (uint8_t slot = 0; slot < BOARDS[board].slots; slot++) {
      const bool own = OWN_CONTROLLER >> (BOARDS[board].first_slot + slot) & 1;
      CHECK(desk.boards[board].values[slot] == (own ? 500 : 0));
    }
  }
  desk.run(2 * STOP_AFTER_MS + 20);
  const std::vector<Frame> echoes = on(ECHO, desk.heard());
  CHECK(echoes.size() == 3);
  CHECK(echoes[0].payload[0] == 9 && echoes[0].payload == echoes[2].payload);
}

TEST(a_write_that_a_board_did_not_obey_is_repeated_until_it_does_and_not_echoed_before) {
  Desk desk;
  introduce(desk);
  desk.boards[1].obeys = false;
  desk.send(Frame{SETPOINTS, array_payload(1, 10)});
  desk.run(200);
  CHECK(!all(desk, 10));
  CHECK(desk.boards[1].written > 8);
  std::vector<Frame> frames = desk.heard();
  CHECK(on(ECHO, frames).empty());
  CHECK(count(words(frames), "not obeyed by board " + std::to_string(BOARDS[1].id)) == 1);
  desk.boards[1].obeys = true;
  desk.run(100);
  frames = desk.heard();
  CHECK(all(desk, 10));
  CHECK(on(ECHO, frames).size() == 1);
  CHECK(count(words(frames), "obeys again: board " + std::to_string(BOARDS[1].id)) == 1);
}

TEST(a_board_that_does_not_obey_leaves_a_stream_without_echoes_and_is_told_once) {
  Desk desk;
  introduce(desk);
  desk.boards[1].obeys = false;
  for (uint32_t id = 1; id < 60; id++) {
    desk.send(Frame{SETPOINTS, array_payload(id, static_cast<int16_t>(id))});
    desk.run(50);
    CHECK(desk.boards[0].values[0] == static_cast<int16_t>(id));
  }
  const std::vector<Frame> frames = desk.heard();
  CHECK(on(ECHO, frames).empty());
  CHECK(count(words(frames), "not obeyed") == 1);
}

TEST(a_wheel_that_does_not_stop_is_not_echoed_as_standing) {
  Desk desk;
  introduce(desk);
  desk.send(Frame{SETPOINTS, array_payload(OWN_CONTROLLER << ARRAY_HOLD_SHIFT | 9, 500)});
  desk.run(200);
  CHECK(on(ECHO, desk.heard()).size() == 1);
  desk.boards[0].obeys = false;
  desk.run(1500);
  const std::vector<Frame> frames = desk.heard();
  CHECK(on(ECHO, frames).empty());
  CHECK(count(words(frames), "not obeyed by board " + std::to_string(BOARDS[0].id)) == 1);
}

TEST(a_board_that_forgets_its_setpoints_is_told_again) {
  Desk desk;
  introduce(desk);
  for (int round = 0; round < 20; round++) {
    if (round % 2 == 0) desk.send(Frame{SETPOINTS, array_payload(1, 10)});
    desk.run(20);
  }
  desk.boards[2].values[1] = 555;
  const unsigned before = desk.boards[2].written;
  desk.run(STOP_AFTER_MS / 2);
  CHECK(all(desk, 10));
  CHECK(desk.boards[2].written == before + 1);
}

TEST(a_dead_board_holds_up_no_other_and_is_told_once) {
  Desk desk;
  desk.boards[0].answers = false;
  introduce(desk);
  desk.heard();
  for (int16_t value = 100; value < 130; value++) {
    desk.send(Frame{SETPOINTS, array_payload(static_cast<uint32_t>(value), value)});
    desk.run(3 * CYCLE_US / 1000);
    for (uint8_t board = 1; board < BOARD_COUNT; board++) CHECK(desk.boards[board].values[0] == value);
  }
  desk.run(200);
  const std::vector<Frame> frames = desk.heard();
  CHECK(on(ECHO, frames).size() == 30);
  desk.boards[0].answers = true;
  desk.run(200);
  const std::string said = words(desk.heard());
  CHECK(said.find("answers again: board " + std::to_string(BOARDS[0].id)) != std::string::npos);
  CHECK(desk.boards[0].values[0] == 129);
}

TEST(boards_that_were_dead_when_the_host_came_are_told_each_to_each_host) {
  Desk desk;
  for (PlayedBoard& board : desk.boards) board.answers = false;
  desk.run(3000);
  for (int host = 0; host < 3; host++) {
    desk.ask_for_topics();
    desk.run(1000);
    const std::string said = words(desk.heard());
    CHECK(count(said, NAME_AND_TABLES) == 1);
    CHECK(count(said, "no answer from board") == BOARD_COUNT);
  }
}

TEST(a_second_host_hears_the_version_however_soon_it_comes) {
  Desk desk;
  for (int host = 0; host < 3; host++) {
    desk.ask_for_topics();
    desk.run(300);
    CHECK(count(words(desk.heard()), NAME_AND_TABLES) == 1);
  }
}

TEST(nothing_is_published_for_a_board_that_does_not_answer) {
  Desk desk;
  for (PlayedBoard& board : desk.boards) board.answers = false;
  introduce(desk);
  desk.run(1000);
  CHECK(on(STATE, desk.heard()).empty());
}

TEST(it_falls_silent_when_the_host_says_so_and_when_nobody_answers_for_the_time) {
  Desk desk;
  introduce(desk);
  desk.send(Frame{11, {}});
  desk.run(100);
  desk.heard();
  desk.run(1000);
  CHECK(desk.heard().empty());

  introduce(desk);
  desk.run(10000);
  CHECK(on(TIME, desk.heard()).size() == 4);
  desk.run(1500);
  desk.heard();
  desk.run(1000);
  CHECK(desk.heard().empty());
}

TEST(answers_for_the_time_keep_it_going) {
  Desk desk;
  introduce(desk);
  for (int second = 0; second < 30; second++) {
    desk.send(Frame{TIME, Bytes(8, 1)});
    desk.run(1000);
  }
  CHECK(on(STATE, desk.heard()).size() > 1000);
}

TEST(other_topics_and_long_payloads_change_nothing) {
  Desk desk;
  introduce(desk);
  for (const uint16_t topic : {uint16_t(1), uint16_t(6), uint16_t(7), STATE, ECHO, uint16_t(65535)}) {
    desk.send(Frame{topic, array_payload(1, 10)});
    desk.run(20);
  }
  desk.run(100);
  CHECK(desk.boards[0].values[0] == 0);
  CHECK(on(ECHO, desk.heard()).empty());
}

TEST(after_a_hang_held_slots_are_as_they_were_and_others_at_zero) {
  Desk before;
  introduce(before);
  const uint32_t hold = 1UL << BOARDS[0].first_slot | OWN_CONTROLLER;
  before.send(Frame{SETPOINTS, array_payload(hold << ARRAY_HOLD_SHIFT | 9, 500)});
  before.run(100);
  for (int ms = 0; ms < 200; ms++) before.kept.pass_millisecond();

  Desk after(0, &before.kept);
  after.run(50);
  CHECK(after.boards[0].values[0] == 500 && after.boards[0].values[1] == 0);
  CHECK(after.boards[1].values[0] == 0 && after.boards[1].values[1] == 0);
  after.ask_for_topics();
  after.run(400);
  CHECK(words(after.heard()).find("watchdog") != std::string::npos);

  Desk again(EXTERNAL, &before.kept);
  again.run(50);
  CHECK(again.boards[0].values[0] == 0);
}

TEST(after_a_restart_of_which_it_is_not_known_why_held_slots_are_left_alone) {
  Desk before;
  introduce(before);
  const uint32_t hold = 1UL << BOARDS[0].first_slot | OWN_CONTROLLER;
  before.send(Frame{SETPOINTS, array_payload(hold << ARRAY_HOLD_SHIFT | 9, 500)});
  before.run(100);

  Desk after(0, &before.kept);  // its boards have 77, which nobody has put there
  after.ask_for_topics();
  after.run(300);
  for (uint8_t board = 0; board < BOARD_COUNT; board++) {
    for (uint8_t slot = 0; slot < BOARDS[board].slots; slot++) {
      const bool held = hold >> (BOARDS[board].first_slot + slot) & 1;
      CHECK(after.boards[board].values[slot] == (held ? 77 : 0));
    }
  }
  CHECK(count(words(after.heard()), "held slots were left alone") == 1);
  after.send(Frame{SETPOINTS, array_payload(1, 10)});
  after.run(100);
  CHECK(all(after, 10));
}

TEST(and_where_memory_has_nothing_all_that_may_be_held) {
  Desk after(0);
  after.run(100);
  for (uint8_t board = 0; board < BOARD_COUNT; board++) {
    for (uint8_t slot = 0; slot < BOARDS[board].slots; slot++) {
      const bool held = HELD_WITHOUT_MASK >> (BOARDS[board].first_slot + slot) & 1;
      CHECK(after.boards[board].values[slot] == (held ? 77 : 0));
    }
  }
}
