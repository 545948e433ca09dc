#include "mien/session/event_list.h"

#include <gmock/gmock.h>

#include "mien/session/prompt.h"

namespace mien::session::event_list_test {
namespace {

using testing::HasSubstr;

TEST(EventList, GivesEachPromptUntilTheNext) {
  const auto events = parse_event_list("time_s,name\n0,neutral\n1.5,smile, wide\n\n10,jawOpen\n", "e.csv");
  ASSERT_TRUE(events) << events.error().message();
  EXPECT_EQ(*events, (std::vector<ListedEvent>{
                         {0, 1.5, "neutral"}, {1.5, kListed_s, "smile, wide"}, {10, kListed_s, "jawOpen"}}));
}

TEST(EventList, TakesLineEndsOfAnySystem) {
  const auto events = parse_event_list("\xEF\xBB\xBFtime_s,name\r\n2,blink\r\n3,up", "e.csv");
  ASSERT_TRUE(events) << events.error().message();
  EXPECT_EQ(*events, (std::vector<ListedEvent>{{2, 1, "blink"}, {3, kListed_s, "up"}}));
  EXPECT_TRUE(parse_event_list("time_s,name\n", "e.csv")->empty());
}

TEST(EventList, RefusesEachWrongLine) {
  const auto refused = [](const std::string& rows, ErrorCode code, const char* place) {
    const auto events = parse_event_list(rows, "e.csv");
    ASSERT_FALSE(events) << rows;
    EXPECT_EQ(events.error().code, code) << rows;
    EXPECT_THAT(events.error().message(), HasSubstr(place));
  };
  refused("", ErrorCode::malformed, "e.csv");
  refused("0,neutral\n", ErrorCode::malformed, "line 1");
  const std::string head = "time_s,name\n";
  refused(head + "neutral\n", ErrorCode::malformed, "line 2");
  refused(head + "1\n", ErrorCode::malformed, "line 2");
  refused(head + ",x\n", ErrorCode::malformed, "line 2");
  refused(head + "1s,x\n", ErrorCode::malformed, "line 2");
  refused(head + "nan,x\n", ErrorCode::out_of_range, "line 2");
  refused(head + "-1,x\n", ErrorCode::out_of_range, "line 2");
  refused(head + "1e7,x\n", ErrorCode::out_of_range, "line 2");
  refused(head + "1,\n", ErrorCode::out_of_range, "line 2");
  refused(head + "1,\x01\n", ErrorCode::out_of_range, "line 2");
  refused(head + "1," + std::string(61, 'x'), ErrorCode::out_of_range, "line 2");
  refused(head + "2,x\n2,y\n", ErrorCode::out_of_range, "line 3");
  std::string many = head;
  for (std::size_t i = 0; i <= kMaxPrompts; ++i) many += std::to_string(i) + ",x\n";
  refused(many, ErrorCode::out_of_range, "over");
}

}  // namespace
}  // namespace mien::session::event_list_test
