// `mien live --listen http://` from outside: two cameras of a headset in, a take and a hash out, with their
// pictures and without.
#include <utility>  // Before Asio 1.74, which forgets it.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "mien/core/bytes.h"
#include "mien/headset/feature_record.h"
#include "mien/take/take.h"
#include "tests/app/program.h"
#include "tests/headset/small_jpeg.h"
#include "tests/headset/small_model.h"
#include "tests/live/camera_server.h"
#include "tests/live/pseudo_terminal.h"

namespace mien::app::test::headset_live_test {
namespace {

using live::test::CameraServer;
using testing::HasSubstr;

/// A camera of 60 pictures a second, as boards send them.
class Board {
 public:
  Board(boost::asio::io_context& network, int first)
      : first_(first), timer_(network), server_(network, 0, [this](CameraServer::Visitor& visitor) {
          visitor.send("HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=b\r\n\r\n");
          visitor_ = &visitor;
        }) {
    next_ = std::chrono::steady_clock::now();
    send_on();
  }
  [[nodiscard]] std::string address() const { return fmt::format("http://127.0.0.1:{}/", server_.port()); }

 private:
  void send_on() {
    next_ += std::chrono::microseconds(16'667);
    timer_.expires_at(next_);
    timer_.async_wait([this](boost::system::error_code code) {
      if (code) return;
      ++number_;
      if (visitor_ != nullptr && visitor_->socket.is_open()) {
        const headset::test::Bytes jpeg = headset::test::grey_jpeg(64, 64, (first_ + number_) % 40);
        const std::int64_t us = 16'667LL * number_;
        visitor_->send(
            fmt::format(
                "--b\r\nContent-Type: image/jpeg\r\nContent-Length: {}\r\nX-Timestamp: {}.{:06}\r\n\r\n",
                jpeg.size(), us / 1'000'000, us % 1'000'000) +
            std::string(as_text(jpeg)) + "\r\n");
      }
      send_on();
    });
  }
  int first_;
  int number_ = 0;
  CameraServer::Visitor* visitor_ = nullptr;
  std::chrono::steady_clock::time_point next_;
  boost::asio::steady_timer timer_;
  CameraServer server_;
};

class HeadsetProgram : public testing::Test {
 protected:
  HeadsetProgram() {
    write(folder / "rig.toml", headset::test::headset_rig_text());
    EXPECT_TRUE(headset::write_views_file(folder / "model.safetensors", headset::test::small_views_file()));
    thread_ = std::thread([this] { network_.run(); });
  }
  ~HeadsetProgram() override {
    network_.stop();
    thread_.join();
  }
  [[nodiscard]] Outcome live(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {
        "live", "--rig", folder / "rig.toml", "--model", folder / "model.safetensors", "--page",
        "off",  "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  Folder folder;
  boost::asio::io_context network_;
  Board left{network_, 0}, right{network_, 7};

 private:
  std::thread thread_;
};

TEST_F(HeadsetProgram, CamerasBecomeATakeThatReplaysToTheSameBits) {
  for (const bool images : {false, true}) {
    const std::string take = folder / (images ? "images.mien" : "features.mien");
    std::vector<std::string> more = {"--listen", left.address(), "--listen", right.address(),
                                     "--record", take,           "--for",    "2.5"};
    if (images) more.emplace_back("--images");
    const Outcome outcome = live(more);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("Asking " + left.address() + " for its pictures, eye_L's"));
    EXPECT_THAT(outcome.err, HasSubstr("No --listen is left for mouth_L, mouth_R: missing cameras"));
    EXPECT_THAT(outcome.err, HasSubstr(right.address() + ": pictures come"));
    const std::string kept = "Pictures of the face are kept as they come: 1.9 to 3.9 GB an hour";
    EXPECT_EQ(outcome.err.find(kept) != std::string::npos, images) << outcome.err;
    const auto summary = nlohmann::json::parse(outcome.out);
    EXPECT_GT(summary["frames"], 60);
    EXPECT_EQ(summary["malformed"], 0);
    ASSERT_EQ(summary["cameras"].size(), 2U);
    EXPECT_EQ(summary["cameras"][0]["address"], left.address());
    EXPECT_EQ(summary["cameras"][1]["sensor"], "eye_R");
    for (const auto& camera : summary["cameras"]) {
      EXPECT_GT(camera["pictures"], 60);
      EXPECT_EQ(camera["open"], true);
      EXPECT_EQ(camera["broken"], 0);
      EXPECT_TRUE(camera["refused"].empty());
    }
    const Outcome again = run({"live", "--replay", take, "--model", folder / "model.safetensors", "--json"});
    ASSERT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(nlohmann::json::parse(again.out)["hash"], summary["hash"]);

    const auto opened = take::Take::open(take).value();
    auto payloads = opened.payloads().value();
    std::size_t pictures = 0;
    const std::vector<take::LogEntry> entries = opened.entries().value();
    for (const take::LogEntry& entry : entries) {
      const sensor::Payload payload = payloads.of(entry.id).value();
      if (payload.bytes.empty()) continue;
      ++pictures;
      EXPECT_EQ(headset::is_feature_record(payload.bytes), !images);
      EXPECT_EQ(payload.reducer.empty(), images);
    }
    EXPECT_GT(pictures, 120U);
  }
}

TEST_F(HeadsetProgram, ACameraOnACableIsOneOfTheRigs) {
  live::test::Cable cable(folder / "mouth");
  std::jthread board([&](const std::stop_token& asked) {
    auto next = std::chrono::steady_clock::now();
    for (int n = 0; !asked.stop_requested(); ++n) {
      const headset::test::Bytes jpeg = headset::test::grey_jpeg(64, 64, n % 40);
      headset::test::Bytes frame = {std::byte{0xFF},
                                    std::byte{0xA0},
                                    std::byte{0xFF},
                                    std::byte{0xA1},
                                    static_cast<std::byte>(jpeg.size()),
                                    static_cast<std::byte>(jpeg.size() >> 8U)};
      frame.insert(frame.end(), jpeg.begin(), jpeg.end());
      cable.write(frame);
      next += std::chrono::microseconds(16'667);
      std::this_thread::sleep_until(next);
    }
  });
  const std::string take = folder / "cable.mien";
  const Outcome outcome = live({"--listen", left.address(), "--listen", cable.address() + "?baud=3000000",
                                "--record", take, "--for", "2.5"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("Pictures on " + cable.address() + " are eye_R's"));
  EXPECT_THAT(outcome.err, HasSubstr(cable.address() + ": pictures come"));
  const auto summary = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(summary["cameras"].size(), 2U);
  EXPECT_EQ(summary["cameras"][1]["address"], cable.address());
  EXPECT_EQ(summary["cameras"][1]["sensor"], "eye_R");
  EXPECT_GT(summary["cameras"][1]["pictures"], 60);
  const auto opened = take::Take::open(take).value();
  std::size_t pictures = 0;
  const std::vector<take::LogEntry> entries = opened.entries().value();
  for (const take::LogEntry& entry : entries) pictures += entry.source == cable.address() ? 1 : 0;
  EXPECT_GT(pictures, 60U);
  const Outcome again = run({"live", "--replay", take, "--model", folder / "model.safetensors", "--json"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["hash"], summary["hash"]);
}

TEST_F(HeadsetProgram, WithAKeyItSaysThatPicturesAreHeardAllTheSame) {
  write(folder / "key", "1 " + std::string(64, 'a') + "\n");
  std::filesystem::permissions(folder / "key", std::filesystem::perms::owner_read);
  const Outcome outcome = live({"--listen", left.address(), "--key", folder / "key", "--for", "1.5"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err,
              HasSubstr("Only devices with the key are received, and pictures, which no key seals"));
  const auto summary = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(summary["unsealed"], nlohmann::json({left.address()}));
  EXPECT_GT(summary["cameras"][0]["pictures"], 20);
  EXPECT_GT(summary["frames"], 20);
}

TEST_F(HeadsetProgram, SaysWhatIsWrong) {
  std::vector<std::string> five;
  for (int i = 1; i <= 5; ++i) {
    five.emplace_back("--listen");
    five.push_back(fmt::format("http://127.0.0.1:{}/", i));
  }
  const Outcome many = live(five);
  EXPECT_EQ(many.status, 2);
  EXPECT_THAT(many.err, HasSubstr("rig test has 4 cameras, and this is one more"));
  const Outcome secure = live({"--listen", "https://127.0.0.1/"});
  EXPECT_EQ(secure.status, 2);
  EXPECT_THAT(secure.err, HasSubstr("https://127.0.0.1/"));
  const Outcome twice = live({"--listen", left.address(), "--listen", left.address()});
  EXPECT_EQ(twice.status, 2);
  EXPECT_THAT(twice.err, HasSubstr("given twice"));
  const Outcome blind = run({"live", "--images", "--page", "off", "--listen", "udp://127.0.0.1:0"});
  EXPECT_EQ(blind.status, 2);
  EXPECT_THAT(blind.err, HasSubstr("this rig has no camera whose pictures could be kept"));
  const Outcome untrained = run({"live", "--rig", folder / "rig.toml", "--model", folder / "none.safetensors",
                                 "--page", "off", "--listen", left.address()});
  EXPECT_EQ(untrained.status, 2);
  EXPECT_THAT(untrained.err, HasSubstr("train it: mien train models/recipes/headset.toml"));
}

TEST_F(HeadsetProgram, ACameraThatIsNotThereIsSaid) {
  const Outcome outcome = live({"--listen", "http://127.0.0.1:1/", "--for", "0.5"});
  EXPECT_EQ(outcome.status, 1) << "no frame came";
  EXPECT_THAT(outcome.err, HasSubstr("http://127.0.0.1:1/: not there"));
}

}  // namespace
}  // namespace mien::app::test::headset_live_test
