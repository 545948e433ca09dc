#include "mien/sink/ifacialmocap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>
#include <string>

#include "mien/core/random.h"

namespace mien::sink::ifacialmocap_test {
namespace {

using Request = IFacialMocapRequest;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::optional<Request> parse(std::string_view text) {
  return parse_ifacialmocap_request(std::as_bytes(std::span(text)));
}

TEST(IFacialMocap, KnowsWhatIsAskedOfPhones) {
  EXPECT_EQ(parse("iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719"), Request::v1);
  EXPECT_EQ(parse("iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719\r\n"), Request::v1);
  EXPECT_EQ(parse("iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719|sendDataVersion=v2"), Request::v2);
  EXPECT_EQ(parse("iFacialMocap_UDPTCP_sahuasouryya9218sauhuiayeta91555dy3719"), Request::tcp);
  EXPECT_EQ(parse("iFacialMocap_UDPTCPSTOP_sahuasouryya9218sauhuiayeta91555dy3719"), Request::tcp_stop);
}

TEST(IFacialMocap, RefusesAllElse) {
  for (const std::string& text :
       {std::string(), std::string("iFacialMocap_"), std::string("FACEMOTION3D_OtherStreaming"),
        std::string("iFacialMocap_sahuasouryya9218sauhuiayeta91555dy371"),
        std::string("iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719x"),
        std::string(" iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719"),
        std::string("iFacialMocap_sahuasouryya9218sauhuiayeta91555dy3719|sendDataVersion=v3"),
        std::string("iFacialMocap_UDPTCP_sahuasouryya9218sauhuiayeta91555dy3719|sendDataVersion=v2"),
        std::string("\n\n\n"), std::string(70000, '\n')})
    EXPECT_EQ(parse(text), std::nullopt) << text.substr(0, 80);
}

std::string encoded(const face::OutputFrame& frame, IFacialMocapVersion version) {
  Datagrams out;
  encode_ifacialmocap(arkit_frame(frame), version, out);
  EXPECT_EQ(out.size(), 1u);
  const auto bytes = out[0];
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// How receivers parse it: fields end with |, name and value are set apart by `separator`.
std::map<std::string, int> shapes_of(const std::string& text, char separator) {
  std::map<std::string, int> shapes;
  std::istringstream fields(text.substr(0, text.find("=head#")));
  for (std::string field; std::getline(fields, field, '|');) {
    const std::size_t at = field.rfind(separator);
    EXPECT_NE(at, std::string::npos) << field;
    shapes[field.substr(0, at)] = std::stoi(field.substr(at + 1));
  }
  return shapes;
}

TEST(IFacialMocap, WritesBothVersions) {
  face::OutputFrame frame;
  frame.weights[face::shape("mouthSmile_R")] = 0.124F;
  frame.weights[face::shape("eyeBlink_L")] = 0.126F;
  frame.weights[face::shape("jawLeft")] = 1;
  frame.tongue_out = 0.5F;
  const std::string v1 = encoded(frame, IFacialMocapVersion::v1);
  EXPECT_THAT(v1, HasSubstr("mouthSmile_R-12|"));
  EXPECT_THAT(
      v1, EndsWith("|=head#0.0000,0.0000,0.0000,0,0,0|rightEye#0.0000,0.0000,0|leftEye#0.0000,0.0000,0|"));
  EXPECT_LT(v1.size(), 1200u);
  const auto shapes = shapes_of(v1, '-');
  EXPECT_EQ(shapes.size(), 52u);
  EXPECT_EQ(shapes.at("eyeBlink_L"), 13);
  EXPECT_EQ(shapes.at("jawLeft"), 100);
  EXPECT_EQ(shapes.at("mouthRight"), 0);
  EXPECT_EQ(shapes.at("tongueOut"), 50);
  EXPECT_EQ(shapes.at("browInnerUp"), 0);

  const std::string v2 = encoded(frame, IFacialMocapVersion::v2);
  EXPECT_THAT(v2, StartsWith("trackingStatus&1|"));
  EXPECT_EQ(shapes_of(v2, '&').size(), 53u);
  EXPECT_EQ(shapes_of(v2, '&').at("mouthSmile_R"), 12);
  // Read back by the names that this house's own importers know.
  for (const auto& [name, value] : shapes) EXPECT_LT(face::arkit_index(name), 52u) << name;
}

/// The vendor's sample line has eyeLookDown 17 in both eyes with rx of +6.03, eyeLookIn_R 6 with a right ry
/// of +2.44 and eyeLookIn_L 4 with a left ry of -1.67: X is positive down, Y to the performer's left.
TEST(IFacialMocap, TurnsTheEyesAsTheVendorDoes) {
  face::OutputFrame frame;
  frame.eyes_rad = {Eigen::Vector2f(-0.0291F, -0.1053F), Eigen::Vector2f(0.0426F, -0.1052F)};
  const std::string text = encoded(frame, IFacialMocapVersion::v2);
  EXPECT_THAT(text, HasSubstr("|rightEye#6.0275,2.4408,0|"));
  EXPECT_THAT(text, HasSubstr("|leftEye#6.0332,-1.6673,0|"));
}

TEST(IFacialMocap, TurnsTheHeadAboutTheSameAxes) {
  face::OutputFrame frame;
  frame.head = Quat(Eigen::AngleAxisd(0.2, Vec3::UnitY()) * Eigen::AngleAxisd(0.1, Vec3::UnitX()) *
                    Eigen::AngleAxisd(-0.3, Vec3::UnitZ()));
  EXPECT_THAT(encoded(frame, IFacialMocapVersion::v2), HasSubstr("=head#5.7296,11.4592,-17.1887,0,0,0|"));
}

TEST(IFacialMocap, SendsAKnownPositionInMetres) {
  face::OutputFrame frame;
  frame.head_position_m = {0.25F, -0.0F, -1.5F};
  EXPECT_THAT(encoded(frame, IFacialMocapVersion::v2), HasSubstr("=head#0.0000,0.0000,0.0000,0,0,0|"));
  frame.head_position_known = true;
  EXPECT_THAT(encoded(frame, IFacialMocapVersion::v2),
              HasSubstr("=head#0.0000,0.0000,0.0000,0.2500,0.0000,-1.5000|rightEye#"));
  frame.head_position_m = {std::nanf(""), 1e30F, 0};
  EXPECT_THAT(encoded(frame, IFacialMocapVersion::v1), HasSubstr(",0.0000,100.0000,0.0000|rightEye#"));
}

}  // namespace
}  // namespace mien::sink::ifacialmocap_test
