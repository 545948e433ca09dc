#include <utility>  // Before Asio 1.74, which forgets it.

#include "app/live/session_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "mien/live/page_messages.h"
#include "mien/live/page_server.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::session_client_test {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr SessionClient::Patience kShort{.silence = milliseconds(1'000), .answer = milliseconds(3'000)};

/// A page's server without a session behind it: it says what a test lets it say.
class ScriptedSession {
 public:
  /// Tells its state every 50 ms from the first command on, if it is to; answers `answers` after that.
  ScriptedSession(bool news, std::optional<milliseconds> answers) : news_(news), answers_(answers) {
    auto opened = live::PageServer::open(
        network_, {.port = 0, .token = {}, .assets = {}}, [] { return status(); },
        [this](std::uint64_t client, std::string_view text) { hear(client, text); });
    EXPECT_TRUE(opened) << opened.error().message();
    server_ = *std::move(opened);
    thread_ = std::thread([this] { network_.run(); });
  }
  ~ScriptedSession() {
    network_.stop();
    thread_.join();
  }
  [[nodiscard]] std::string address() const { return server_->address(); }
  /// So many events, at once.
  void tell(int events) {
    boost::asio::post(network_, [this, events] {
      for (int i = 0; i < events; ++i) server_->send(live::event_json("lost", std::to_string(i)));
    });
  }

 private:
  static std::string status() {
    live::Status now;
    now.report.shaping = "{}";
    now.report.links.resize(3);
    return live::status_json(now, virt::test::three_sensors());
  }
  void hear(std::uint64_t client, std::string_view text) {
    const std::int64_t id = nlohmann::json::parse(text)["id"];
    if (news_) say_news();
    if (!answers_) return;
    answer_.expires_after(*answers_);
    answer_.async_wait([this, client, id](boost::system::error_code code) {
      if (!code) server_->send(client, live::reply_json(id, ""));
    });
  }
  void say_news() {
    server_->send(status());
    next_.expires_after(milliseconds(50));
    next_.async_wait([this](boost::system::error_code code) {
      if (!code) say_news();
    });
  }

  bool news_;
  std::optional<milliseconds> answers_;
  boost::asio::io_context network_{1};
  boost::asio::steady_timer answer_{network_}, next_{network_};
  std::unique_ptr<live::PageServer> server_;
  std::thread thread_;
};

std::unique_ptr<SessionClient> client_of(const ScriptedSession& session) {
  static const std::atomic<bool> never = false;
  auto client = SessionClient::open(session.address(), {}, never, kShort);
  EXPECT_TRUE(client) << client.error().message();
  return client ? *std::move(client) : nullptr;
}

TEST(SessionClient, WaitsForALateAnswerWhileTheSessionTellsOtherThings) {
  const ScriptedSession session(true, milliseconds(1'500));
  const auto client = client_of(session);
  ASSERT_NE(client, nullptr);
  const Result<void> said = client->command({{"command", "recentre"}});
  EXPECT_TRUE(said) << said.error().message();
}

TEST(SessionClient, ASilentSessionIsGivenUp) {
  const ScriptedSession session(false, milliseconds(60'000));
  const auto client = client_of(session);
  ASSERT_NE(client, nullptr);
  const Result<void> said = client->command({{"command", "recentre"}});
  ASSERT_FALSE(said);
  EXPECT_THAT(said.error().message(), HasSubstr("the session does not answer"));
  EXPECT_EQ(client->next_status().error().message(), said.error().message()) << "the line is broken";
}

TEST(SessionClient, OneThatTellsMuchAndNeverAnswersIsGivenUpToo) {
  const ScriptedSession session(true, std::nullopt);
  const auto client = client_of(session);
  ASSERT_NE(client, nullptr);
  const Result<void> said = client->command({{"command", "recentre"}});
  ASSERT_FALSE(said);
  EXPECT_THAT(said.error().message(), HasSubstr("the session does not answer"));
}

TEST(SessionClient, ListeningItHearsWhatIsToldMeanwhile) {
  ScriptedSession session(false, milliseconds(0));
  const auto client = client_of(session);
  ASSERT_NE(client, nullptr);
  session.tell(40);
  std::size_t heard = 0;
  for (int i = 0; i < 500 && heard < 40; ++i) {
    ASSERT_TRUE(client->listen_until(std::chrono::steady_clock::now() + milliseconds(10)));
    heard += client->take_events().size();
  }
  EXPECT_EQ(heard, 40U);
  EXPECT_TRUE(client->command({{"command", "recentre"}}));
}

}  // namespace
}  // namespace mien::app::session_client_test
