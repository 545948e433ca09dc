// What we send, read by npm's osc-js and ws: see other_readers.mjs.
#include <gtest/gtest.h>
#include <stdio.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "mien/sink/sink.h"
#include "mien/sink/unified.h"
#include "mien/sink/vmc.h"
#include "tests/project_path.h"
#include "tests/sink/loopback.h"

namespace mien::sink::other_readers_test {
namespace {

using Json = nlohmann::json;

/// A reader's process, whose lines are read.
class Reader {
 public:
  explicit Reader(const std::string& arguments)
      : pipe_(::popen(("node '" + project_path("tests/sink/other_readers.mjs") + "' " + arguments).c_str(),
                      "r")) {}
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() {
    if (pipe_ != nullptr) ::pclose(pipe_);
  }
  /// The next line, or null at the end.
  Json line() {
    std::string text;
    for (int c = 0; pipe_ != nullptr && (c = ::fgetc(pipe_)) != EOF && c != '\n';)
      text += static_cast<char>(c);
    return Json::parse(text, nullptr, false);
  }

 private:
  FILE* pipe_;
};

bool installed() {
  return std::filesystem::exists(project_path("script/npm/node_modules/osc-js")) &&
         std::filesystem::exists(project_path("script/npm/node_modules/ws")) &&
         ::system("node --version > /dev/null 2>&1") == 0;
}
#define MIEN_SKIP_WITHOUT_NPM() \
  if (!installed()) GTEST_SKIP() << "no node, or no npm packages: run script/bootstrap"

face::OutputFrame speaking() {
  face::OutputFrame frame;
  frame.time = DeviceTime(std::chrono::seconds(3));
  frame.weights[face::shape("jawOpen")] = 0.5F;
  frame.weights[face::shape("jawLeft")] = 0.25F;
  frame.head = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitY()));
  frame.provenance.fill(face::Provenance::measured);
  return frame;
}

TEST(OtherReaders, ReadVmc) {
  MIEN_SKIP_WITHOUT_NPM();
  // OK, T, three bones, 52 shapes, the presets, Apply; all of it twice.
  const std::size_t count = 2 * (1 + 1 + 3 + 52 + kVmcPresets.size() + 1);
  Reader reader(std::to_string(count).insert(0, "osc "));
  const Json port = reader.line();
  ASSERT_TRUE(port.is_number());
  boost::asio::io_context network;
  auto sink = open_sink(network, fmt::format("vmc://127.0.0.1:{}", port.get<int>()));
  ASSERT_TRUE(sink) << sink.error().message();
  (*sink)->send(speaking(), 0);
  (*sink)->send(speaking(), 1);
  std::map<std::string, double> shapes;
  for (std::size_t i = 0; i < count; ++i) {
    const Json message = reader.line();
    ASSERT_TRUE(message.is_object()) << i;
    EXPECT_LE(message.at("bytes"), 1500);
    const std::string address = message.at("address");
    const Json& args = message.at("args");
    if (address == "/VMC/Ext/Blend/Val") {
      EXPECT_EQ(message.at("types"), ",sf");
      shapes[args[0]] = args[1];
    } else if (address == "/VMC/Ext/Bone/Pos") {
      EXPECT_EQ(message.at("types"), ",sfffffff");
      EXPECT_NEAR(args[5].get<double>(), args[0] == "Head" ? -std::sin(0.15) : 0, 1e-6);
    } else if (address == "/VMC/Ext/T") {
      EXPECT_EQ(args, Json({3.0}));
    } else if (address == "/VMC/Ext/OK") {
      EXPECT_EQ(message.at("types"), ",i");
    } else {
      EXPECT_EQ(address, "/VMC/Ext/Blend/Apply");
      EXPECT_EQ(i % (count / 2), count / 2 - 1);
      EXPECT_EQ(message.at("types"), ",");
    }
  }
  EXPECT_EQ(shapes.size(), 52 + kVmcPresets.size());
  EXPECT_EQ(shapes.at("JawOpen"), 0.5);
  EXPECT_EQ(shapes.at("A"), 0.75);
}

TEST(OtherReaders, ReadVrchat) {
  MIEN_SKIP_WITHOUT_NPM();
  // A float, two bits and a sign for each parameter but gaze's six, which nothing measures here; three
  // states; the eyes are closed by so much.
  const std::size_t count = 4 * (unified_parameters().size() - 6) + 3 + 1;
  Reader reader(std::to_string(count).insert(0, "osc "));
  const Json port = reader.line();
  ASSERT_TRUE(port.is_number());
  boost::asio::io_context network;
  auto sink = open_sink(network, fmt::format("vrchat://127.0.0.1:{}?prefix=FT/&binary=2", port.get<int>()));
  ASSERT_TRUE(sink) << sink.error().message();
  (*sink)->send(speaking(), 0);
  std::map<std::string, Json> values;
  for (std::size_t i = 0; i < count; ++i) {
    const Json message = reader.line();
    ASSERT_TRUE(message.is_object()) << i;
    ASSERT_EQ(message.at("args").size(), 1u);
    EXPECT_EQ(message.at("types"),
              message.at("args")[0].is_boolean() ? (message.at("args")[0] ? ",T" : ",F") : ",f");
    values[message.at("address")] = message.at("args")[0];
  }
  EXPECT_EQ(values.size(), count);
  EXPECT_FALSE(values.contains("/avatar/parameters/FT/v2/EyeLeftX"));
  EXPECT_FALSE(values.contains("/tracking/eye/LeftRightPitchYaw"));
  const auto value = [&](const std::string& name) { return values.at("/avatar/parameters/FT/" + name); };
  EXPECT_EQ(value("v2/JawOpen"), 0.5);
  EXPECT_EQ(value("v2/JawOpen1"), false);
  EXPECT_EQ(value("v2/JawOpen2"), true);
  EXPECT_EQ(value("v2/JawX"), -0.25);
  EXPECT_EQ(value("v2/JawX1"), true);
  EXPECT_EQ(value("v2/JawXNegative"), true);
  EXPECT_EQ(value("LipTrackingActive"), true);
  EXPECT_EQ(value("EyeTrackingActive"), false);
  EXPECT_EQ(values.at("/tracking/eye/EyesClosedAmount"), 0);
}

TEST(OtherReaders, ReadTheWebSocket) {
  MIEN_SKIP_WITHOUT_NPM();
  boost::asio::io_context network;
  std::unique_ptr<Sink> sink;
  std::uint16_t port = 0;
  for (port = 20'000; port < 60'000 && !sink; port = static_cast<std::uint16_t>(port + 997))
    if (auto one = open_sink(network, fmt::format("ws://127.0.0.1:{}?role=listen", port))) {
      sink = *std::move(one);
      break;
    }
  ASSERT_TRUE(sink);
  std::vector<Json> messages;
  std::atomic<bool> done = false;
  std::thread reading([&] {
    Reader reader(fmt::format("ws ws://127.0.0.1:{}/ 5", port));
    for (int i = 0; i < 5; ++i) messages.push_back(reader.line());
    done = true;
  });
  // The reader ends itself after half a minute.
  for (std::int64_t index = 0; !done; ++index) {
    sink->send(speaking(), index);
    network.run_for(std::chrono::milliseconds(2));
  }
  reading.join();
  ASSERT_TRUE(messages[0].is_object());
  EXPECT_EQ(messages[0].at("type"), "hello");
  EXPECT_EQ(messages[0].at("shapes").size(), 53u);
  ASSERT_TRUE(messages[4].is_object());
  EXPECT_EQ(messages[4].at("weights")[26], 0.5);
  EXPECT_EQ(messages[4].at("provenance"), std::string(53, 'm'));
}

}  // namespace
}  // namespace mien::sink::other_readers_test
