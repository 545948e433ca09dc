#include "mien/modalities/osc_commands.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/modalities/modalities.h"
#include "tests/gaze/osc_bytes.h"

namespace mien::modalities::osc_commands_test {
namespace {

using gaze::test::bundle;
using gaze::test::message;
using sensor::Verdict;

constexpr std::string_view kAddress = "/mien/recentre", kAvatar = "/avatar/parameters/mien/recentre";

/// A message with type tags alone.
std::vector<std::byte> tagged(std::string_view address, const std::string& types) {
  ByteWriter out;
  gaze::test::write_text(address, out);
  gaze::test::write_text("," + types, out);
  return out.release();
}

struct Heard {
  bool recognised = false;
  Verdict verdict = Verdict::malformed;
  bool recentre = false;
};
Heard hear(const std::vector<std::byte>& datagram) {
  OscCommands commands;
  Heard heard{.recognised = commands.recognises(datagram)};
  sensor::Inbox inbox;
  if (heard.recognised) heard.verdict = commands.receive({}, 0, datagram, inbox);
  heard.recentre = inbox.recentre;
  EXPECT_TRUE(inbox.readings.empty());
  return heard;
}

TEST(OscCommands, AButtonThatIsPressedAsksToRecentre) {
  for (const std::string_view address : {kAddress, kAvatar})
    for (const auto& datagram :
         {message(address, {}), message(address, {1}), message(address, {0.5F}), tagged(address, "T"),
          tagged(address, "I"), bundle({message(address, {1})}), bundle({bundle({tagged(address, "T")})})}) {
      const Heard heard = hear(datagram);
      EXPECT_TRUE(heard.recognised);
      EXPECT_EQ(heard.verdict, Verdict::taken);
      EXPECT_TRUE(heard.recentre);
    }
}

TEST(OscCommands, AButtonThatIsReleasedDoesNot) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& datagram :
       {message(kAddress, {0}), tagged(kAddress, "F"), tagged(kAvatar, "N"), message(kAddress, {nan})}) {
    const Heard heard = hear(datagram);
    EXPECT_EQ(heard.verdict, Verdict::ignored);
    EXPECT_FALSE(heard.recentre);
  }
}

TEST(OscCommands, OtherArgumentsAreMalformed) {
  for (const auto& datagram : {message(kAddress, {1, 1}), tagged(kAddress, "TT"), tagged(kAddress, "[]")}) {
    const Heard heard = hear(datagram);
    EXPECT_EQ(heard.verdict, Verdict::malformed);
    EXPECT_FALSE(heard.recentre);
  }
  // In a bundle one that is malformed spoils all.
  const Heard heard = hear(bundle({message(kAddress, {1}), message(kAddress, {1, 1})}));
  EXPECT_EQ(heard.verdict, Verdict::malformed);
  EXPECT_FALSE(heard.recentre);
}

TEST(OscCommands, OtherAddressesAreSomebodyElses) {
  for (const auto& datagram :
       {message("/mien/recentre/x", {1}), message("/mien", {1}), message("/avatar/parameters/recentre", {1}),
        message("/LeftEyeX", {0.1F}), bundle({message("/LeftEyeX", {0.1F}), message(kAddress, {1})}),
        std::vector<std::byte>()})
    EXPECT_FALSE(hear(datagram).recognised);
  std::vector<std::byte> cut = message(kAddress, {1});
  cut.pop_back();
  EXPECT_FALSE(hear(cut).recognised && hear(cut).recentre);
}

TEST(OscCommands, ASessionHearsThemUnlessItHasKeys) {
  const std::vector<std::byte> datagram = message(kAddress, {1});
  const auto heard_by = [&](const Protocols& protocols) -> std::string {
    for (const auto& protocol : protocols)
      if (protocol->recognises(datagram)) return std::string(protocol->name());
    return "nobody";
  };
  EXPECT_EQ(heard_by(make_protocols().value()), "OSC commands");
  EXPECT_EQ(heard_by(make_protocols({sensor::SealKey{}}).value()), "nobody");
  // Eyes are not kept from their protocol.
  const std::vector<std::byte> eyes = message("/LeftEyeX", {0.1F});
  const Protocols protocols = make_protocols().value();
  for (const auto& protocol : protocols)
    if (protocol->recognises(eyes)) {
      EXPECT_EQ(protocol->name(), "gaze");
      break;
    }
}

}  // namespace
}  // namespace mien::modalities::osc_commands_test
