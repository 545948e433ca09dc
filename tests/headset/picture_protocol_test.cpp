#include "mien/headset/picture_protocol.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/core/random.h"
#include "mien/headset/feature_record.h"
#include "mien/headset/picture_statistics.h"
#include "tests/allocation_count.h"
#include "tests/headset/small_jpeg.h"

namespace mien::headset::picture_protocol_test {
namespace {

using namespace test;
using sensor::Verdict;

constexpr std::uint64_t kCamera = 0x024D'4948'5300ULL;

class Pictures : public ::testing::Test {
 protected:
  struct Sent {
    std::uint64_t camera = 0;
    std::uint32_t number = 0;
    std::optional<DeviceTime> time;
    bool first = false;
    HostTime arrival;
  };
  Verdict send(const Sent& sent, const Bytes& payload) {
    packet_.clear();
    EXPECT_TRUE(write_picture_packet(
        {.from = {kCamera + sent.camera, 0}, .sequence = sent.number, .time = sent.time, .first = sent.first},
        packet_));
    inbox.clear();
    return protocol.receive_with_payload(sent.arrival, 0, packet_.bytes(), payload, inbox);
  }
  PictureProtocol protocol;
  sensor::Inbox inbox;

 private:
  ByteWriter packet_;
};

HostTime after_s(double seconds) {
  return HostTime(from_seconds(seconds));
}
DeviceTime time_s(double seconds) {
  return DeviceTime(from_seconds(seconds));
}

TEST_F(Pictures, BecomeSamplesWithTheirPayload) {
  const Bytes jpeg = grey_jpeg(240, 240, 1);
  ASSERT_EQ(send({.camera = 1, .number = 5, .time = time_s(2)}, jpeg), Verdict::taken);
  ASSERT_EQ(inbox.readings.size(), 1U);
  const sensor::Reading& reading = inbox.readings[0];
  EXPECT_EQ(reading.from, (sensor::DeviceKey{kCamera + 1, 0}));
  EXPECT_EQ(reading.payload.data(), jpeg.data()) << "by reference";
  EXPECT_EQ(reading.payload.size(), jpeg.size());
  EXPECT_EQ(reading.sample.kind, sensor::SampleKind::picture);
  EXPECT_EQ(reading.sample.sequence, 5U);
  EXPECT_EQ(reading.sample.time, time_s(2));
  EXPECT_FALSE(reading.sample.time_estimated);
  ASSERT_EQ(reading.sample.count, kPictureValues);
  auto decoder = PictureDecoder::create().value();
  const PictureStatistics wanted = statistics_of(*decoder.decode(jpeg, kMeasuredSide, kMeasuredSide));
  const sensor::Sample from_picture = reading.sample;
  EXPECT_EQ(from_picture.values[static_cast<std::size_t>(PictureValue::mean)], wanted.mean);
  EXPECT_EQ(from_picture.values[static_cast<std::size_t>(PictureValue::p98)], wanted.p98);
  EXPECT_FLOAT_EQ(from_picture.values[static_cast<std::size_t>(PictureValue::kbytes)],
                  static_cast<float>(jpeg.size()) / 1000);

  // What was kept of it gives the same numbers.
  Bytes record(200);
  record.resize(
      write_feature_record(
          {.statistics = wanted, .jpeg_bytes = static_cast<std::uint32_t>(jpeg.size()), .sensor = 1},
          std::vector<float>{1, 2}, record)
          .value());
  ASSERT_EQ(send({.camera = 1, .number = 6, .time = time_s(2.1)}, record), Verdict::taken);
  EXPECT_EQ(inbox.readings[0].sample.values, from_picture.values);
  EXPECT_EQ(inbox.readings[0].payload.data(), record.data());
}

TEST_F(Pictures, ThatAreNoneAreMalformed) {
  const Bytes jpeg = grey_jpeg(64, 64, 1);
  EXPECT_EQ(send({.number = 1}, text_bytes("no picture")), Verdict::malformed);
  EXPECT_EQ(send({.number = 1}, {jpeg.begin(), jpeg.end() - 40}), Verdict::malformed);
  EXPECT_EQ(send({.number = 1}, text_bytes("MNFR and more that is no record of a picture's features")),
            Verdict::malformed);
  EXPECT_TRUE(inbox.readings.empty());
  ByteWriter packet;
  ASSERT_TRUE(write_picture_packet({.from = {kCamera, 0}}, packet));
  EXPECT_TRUE(protocol.recognises(packet.bytes()));
  EXPECT_EQ(protocol.receive({}, 0, packet.bytes(), inbox), Verdict::malformed) << "no picture beside it";
  Bytes broken(packet.bytes().begin(), packet.bytes().end());
  broken[12] ^= std::byte{1};
  EXPECT_EQ(protocol.receive_with_payload({}, 0, broken, jpeg, inbox), Verdict::malformed);
}

TEST_F(Pictures, WithoutTimesGetEstimatesOnAnEvenGrid) {
  const Bytes jpeg = grey_jpeg(64, 64, 1);
  Random random(3);
  double worst_s = 0;
  DeviceTime last;
  for (std::uint32_t n = 0; n < 600; ++n) {
    const double late_s = random.uniform(0.002, 0.012);
    ASSERT_EQ(send({.number = n, .first = n == 0, .arrival = after_s(n / 30.0 + late_s)}, jpeg),
              Verdict::taken);
    const sensor::Sample& sample = inbox.readings[0].sample;
    EXPECT_TRUE(sample.time_estimated);
    if (n > 0) {
      EXPECT_GT(sample.time, last);
    }
    // After ten seconds they stand on a grid, for less than half of what their arrivals vary.
    if (n > 300) worst_s = std::max(worst_s, std::abs(to_seconds(sample.time - last) - 1 / 30.0));
    last = sample.time;
  }
  EXPECT_LT(worst_s, 0.005);
}

TEST_F(Pictures, OfOneConnectionHaveTimesOfOneClock) {
  const Bytes jpeg = grey_jpeg(64, 64, 1);
  EXPECT_EQ(send({.number = 0, .time = time_s(5), .first = true}, jpeg), Verdict::taken);
  EXPECT_EQ(send({.number = 1, .arrival = after_s(0.1)}, jpeg), Verdict::ignored) << "one without";
  EXPECT_TRUE(inbox.readings.empty());
  EXPECT_EQ(send({.number = 2, .time = time_s(5.2), .arrival = after_s(0.2)}, jpeg), Verdict::taken);
  // The next connection decides anew.
  EXPECT_EQ(send({.number = 3, .first = true, .arrival = after_s(0.3)}, jpeg), Verdict::taken);
  EXPECT_TRUE(inbox.readings[0].sample.time_estimated);
  EXPECT_EQ(send({.number = 4, .time = time_s(900), .arrival = after_s(0.4)}, jpeg), Verdict::taken);
  EXPECT_TRUE(inbox.readings[0].sample.time_estimated);
  EXPECT_LT(inbox.readings[0].sample.time, time_s(1));
}

TEST_F(Pictures, WhoseTimesAreMissingAllAtOnceGetEstimates) {
  const Bytes jpeg = grey_jpeg(32, 32, 1);
  const auto verdict = [&](std::uint32_t number, std::optional<DeviceTime> time) {
    return send({.number = number, .time = time, .first = number == 0, .arrival = after_s(number / 60.0)},
                jpeg);
  };
  std::uint32_t number = 0;
  for (; number < 5; ++number) EXPECT_EQ(verdict(number, time_s(100 + number / 60.0)), Verdict::taken);
  for (int i = 1; i < PictureProtocol::kStandsStill; ++i)
    EXPECT_EQ(verdict(number++, std::nullopt), Verdict::ignored);
  EXPECT_EQ(verdict(number++, std::nullopt), Verdict::taken);
  EXPECT_TRUE(inbox.readings.at(0).sample.time_estimated);
  EXPECT_EQ(verdict(number++, time_s(101)), Verdict::taken);
  EXPECT_TRUE(inbox.readings.at(0).sample.time_estimated) << "until its next connection";
}

TEST_F(Pictures, WhoseTimesRunBackGetEstimates) {
  const Bytes jpeg = grey_jpeg(32, 32, 1);
  for (std::uint32_t number = 0; number < 40; ++number) {
    EXPECT_EQ(send({.number = number,
                    .time = time_s(100 - number / 60.0),
                    .first = number == 0,
                    .arrival = after_s(number / 60.0)},
                   jpeg),
              Verdict::taken);
    EXPECT_EQ(inbox.readings.at(0).sample.time_estimated, number >= PictureProtocol::kStandsStill);
  }
}

TEST_F(Pictures, WhoseTimesStandStillGetEstimates) {
  const Bytes jpeg = grey_jpeg(32, 32, 1);
  const auto estimated = [&](std::uint32_t number, double told_s) {
    EXPECT_EQ(send({.number = number, .time = time_s(told_s), .arrival = after_s(number / 60.0)}, jpeg),
              Verdict::taken);
    return inbox.readings.at(0).sample.time_estimated;
  };
  std::uint32_t number = 0;
  for (; number < 5; ++number) EXPECT_FALSE(estimated(number, 100 + number / 60.0));
  EXPECT_FALSE(estimated(number++, 3)) << "it began anew";
  for (int i = 1; i < PictureProtocol::kStandsStill - 1; ++i) EXPECT_FALSE(estimated(number++, 3));
  EXPECT_FALSE(estimated(number++, 3.1)) << "it runs on";
  for (int i = 1; i < PictureProtocol::kStandsStill; ++i) EXPECT_FALSE(estimated(number++, 3.1));
  EXPECT_TRUE(estimated(number++, 3.1));
  EXPECT_TRUE(estimated(number++, 3.2)) << "until its next connection";
}

TEST_F(Pictures, OfMoreCamerasThanThereAreWaitForAPlace) {
  const Bytes jpeg = grey_jpeg(32, 32, 1);
  for (std::uint64_t c = 0; c < PictureProtocol::kMostCameras; ++c)
    EXPECT_EQ(send({.camera = c, .arrival = after_s(0.01 * static_cast<double>(c))}, jpeg), Verdict::taken);
  EXPECT_EQ(send({.camera = 99, .arrival = after_s(1)}, jpeg), Verdict::ignored);
  EXPECT_EQ(send({.camera = 99, .arrival = after_s(2.5)}, jpeg), Verdict::taken) << "in the silent one's";
  EXPECT_EQ(send({.camera = 99, .number = 1, .arrival = after_s(2.6)}, jpeg), Verdict::taken);
}

TEST_F(Pictures, AreReceivedWithoutAnAllocation) {
  const Bytes jpeg = grey_jpeg(240, 240, 1);
  std::size_t allocated = 0;
  for (std::uint32_t n = 0; n < 40; ++n) {
    const std::size_t before = mien::test::allocation_count();
    ASSERT_EQ(send({.camera = n % 4, .number = n, .arrival = after_s(n / 60.0)}, jpeg), Verdict::taken);
    if (n >= 8) allocated += mien::test::allocation_count() - before;
  }
  EXPECT_EQ(allocated, 0U);
}

}  // namespace
}  // namespace mien::headset::picture_protocol_test
