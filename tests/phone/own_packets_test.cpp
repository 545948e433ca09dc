// What our own sinks send as a phone comes back as it went out.
#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"
#include "mien/core/units.h"
#include "mien/face/ifacialmocap_request.h"
#include "mien/phone/ifacialmocap.h"
#include "mien/phone/live_link.h"
#include "mien/sink/ifacialmocap.h"
#include "mien/sink/live_link.h"

namespace mien::phone::test::own_packets_test {
namespace {

sink::ArkitFrame some_frame(Random& random) {
  sink::ArkitFrame frame;
  for (float& weight : frame.weights.values) weight = static_cast<float>(random.uniform());
  frame.head =
      exp_rotation(Vec3(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)));
  frame.head_position_known = true;
  frame.head_position_m = Vec3f(0.1F, -0.2F, 0.35F);
  return frame;
}

Quat rotation(const ToldHead& head) {
  return {static_cast<double>(head.rotation[0]), static_cast<double>(head.rotation[1]),
          static_cast<double>(head.rotation[2]), static_cast<double>(head.rotation[3])};
}

TEST(OwnPackets, OfLiveLinkComeBack) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const sink::ArkitFrame frame = some_frame(random);
    sink::Datagrams out;
    encode_live_link(frame, sink::live_link_source("mien"), 1000 + i, out);
    const auto packet = parse_live_link(out[0]).value();
    EXPECT_EQ(packet.subject, "mien");
    EXPECT_EQ(packet.frame, 1000U + static_cast<unsigned>(i));
    const ToldFace face = told_face(packet.values.value());
    for (std::size_t k = 0; k < 52; ++k) EXPECT_EQ(face.weights[k], frame.weights.values[k]);
    EXPECT_LT(rotation(*face.head).angularDistance(frame.head), 1e-5);
  }
}

TEST(OwnPackets, OfIFacialMocapComeBackToTheirDigits) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const sink::ArkitFrame frame = some_frame(random);
    for (const auto version : {sink::IFacialMocapVersion::v1, sink::IFacialMocapVersion::v2}) {
      sink::Datagrams out;
      encode_ifacialmocap(frame, version, out);
      ASSERT_TRUE(is_ifacialmocap(out[0]));
      const auto back = parse_ifacialmocap(out[0]);
      ASSERT_TRUE(back) << back.error().message();
      EXPECT_EQ(back->face.told(), 52U);
      for (std::size_t k = 0; k < 52; ++k)
        EXPECT_NEAR(back->face.weights[k], frame.weights.values[k], 0.0051F)
            << shape_name(ShapeSet::arkit52, k);
      ASSERT_TRUE(back->face.head);
      EXPECT_LT(rotation(*back->face.head).angularDistance(frame.head), 1e-4);
      EXPECT_LT((back->face.head->position_m - frame.head_position_m).norm(), 1e-4F);
    }
  }
}

TEST(OwnPackets, WhatWeAskIsWhatWeUnderstand) {
  const std::string request = face::ifacialmocap_request();
  EXPECT_EQ(sink::parse_ifacialmocap_request(std::as_bytes(std::span(request))),
            sink::IFacialMocapRequest::v2);
}

}  // namespace
}  // namespace mien::phone::test::own_packets_test
