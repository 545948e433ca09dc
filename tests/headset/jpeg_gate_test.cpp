#include "mien/headset/jpeg_gate.h"

#include <gtest/gtest.h>

#include <set>

#include "mien/sensor/payload.h"
#include "tests/headset/small_jpeg.h"

namespace mien::headset::jpeg_gate_test {
namespace {

using namespace test;
using Fault = PictureFault;

/// What the gate says; for tests of what it refuses.
std::optional<Fault> fault_of(const Bytes& jpeg) {
  const auto header = check_jpeg(jpeg);
  return header ? std::nullopt : std::optional(header.error());
}

/// With one byte of a segment changed, counted from its FF.
Bytes changed(Bytes jpeg, unsigned code, std::size_t at, unsigned value) {
  jpeg[place_of(jpeg, code) + at] = static_cast<std::byte>(value);
  return jpeg;
}

/// Without the segment of this code.
Bytes without(Bytes jpeg, unsigned code) {
  const std::size_t at = place_of(jpeg, code);
  const auto length =
      2 + (std::to_integer<std::size_t>(jpeg[at + 2]) << 8U | std::to_integer<std::size_t>(jpeg[at + 3]));
  const auto first = jpeg.begin() + static_cast<std::ptrdiff_t>(at);
  jpeg.erase(first, first + static_cast<std::ptrdiff_t>(length));
  return jpeg;
}

class JpegGate : public ::testing::Test {
 protected:
  const Bytes grey = grey_jpeg(64, 48, 1);
  const Bytes colour = colour_jpeg(64, 48, 1);
};

TEST_F(JpegGate, LetsThroughWhatCamerasSend) {
  EXPECT_EQ(check_jpeg(grey), (JpegHeader{.width = 64, .height = 48, .components = 1, .bytes = grey.size()}));
  EXPECT_EQ(check_jpeg(colour),
            (JpegHeader{.width = 64, .height = 48, .components = 3, .bytes = colour.size()}));
  EXPECT_TRUE(check_jpeg(grey_jpeg(1280, 960, 1)));
  EXPECT_TRUE(check_jpeg(grey_jpeg(1, 1, 1)));
  EXPECT_FALSE(fault_of(changed(grey, 0xC0, 1, 0xC1))) << "extended sequential is sequential";
  EXPECT_FALSE(fault_of(with_segment(grey, 0xE1, grey))) << "a thumbnail";
}

TEST_F(JpegGate, LeavesOutWhatStandsBehindIt) {
  Bytes padded = grey;
  padded.resize(grey.size() + 100);
  EXPECT_EQ(check_jpeg(padded)->bytes, grey.size());
}

TEST_F(JpegGate, RefusesEveryTruncation) {
  for (const Bytes& jpeg : {grey, colour})
    for (std::size_t size = 0; size < jpeg.size(); ++size)
      EXPECT_EQ(fault_of({jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(size)}), Fault::truncated)
          << size;
}

TEST_F(JpegGate, RefusesOtherKindsOfFrames) {
  for (unsigned code = 0xC0; code <= 0xCF; ++code) {
    if (code == 0xC0 || code == 0xC1 || code == 0xC4) continue;
    const auto fault = fault_of(changed(grey, 0xC0, 1, code));
    ASSERT_TRUE(fault) << code;
    if (code == 0xC2) {
      EXPECT_EQ(*fault, Fault::progressive);
    } else if (code == 0xC3) {
      EXPECT_EQ(*fault, Fault::lossless);
    } else if (code == 0xC8) {
      EXPECT_EQ(*fault, Fault::not_a_jpeg);
    } else {
      EXPECT_EQ(*fault, code < 0xC8 ? Fault::hierarchical : Fault::arithmetic) << code;
    }
  }
  EXPECT_EQ(fault_of(with_segment(grey, 0xDE, Bytes(6))), Fault::hierarchical);
  EXPECT_EQ(fault_of(with_segment(grey, 0xCC, Bytes(2))), Fault::arithmetic);
}

TEST_F(JpegGate, RefusesOtherSizes) {
  EXPECT_EQ(fault_of(grey_jpeg(1281, 8, 1)), Fault::too_large);
  EXPECT_EQ(fault_of(grey_jpeg(8, 961, 1)), Fault::too_large);
  Bytes huge = grey;
  for (std::size_t i = 5; i < 9; ++i) huge = changed(huge, 0xC0, i, 0xFF);
  EXPECT_EQ(fault_of(huge), Fault::too_large) << "65,535 x 65,535";
  EXPECT_EQ(fault_of(changed(grey, 0xC0, 6, 0)), Fault::no_size);
  EXPECT_EQ(fault_of(changed(grey, 0xC0, 8, 0)), Fault::no_size);
  EXPECT_EQ(fault_of(without(grey, 0xC0)), Fault::no_size);
  EXPECT_EQ(fault_of(overlong_jpeg(grey)), Fault::overlong);
  const std::size_t frame = place_of(grey, 0xC0);
  const Bytes content(grey.begin() + static_cast<std::ptrdiff_t>(frame) + 4,
                      grey.begin() + static_cast<std::ptrdiff_t>(frame) + 13);
  EXPECT_EQ(fault_of(with_segment(grey, 0xC0, content)), Fault::repeated_size);
}

TEST_F(JpegGate, RefusesOtherPixels) {
  EXPECT_EQ(fault_of(changed(grey, 0xC0, 4, 12)), Fault::bits);
  EXPECT_EQ(fault_of(changed(colour, 0xC0, 9, 4)), Fault::components) << "CMYK";
  EXPECT_EQ(fault_of(changed(colour, 0xC0, 9, 2)), Fault::components);
  EXPECT_EQ(fault_of(changed(colour, 0xC0, 9, 1)), Fault::not_a_jpeg) << "more than it says";
  EXPECT_EQ(fault_of(changed(grey, 0xC0, 11, 0x01)), Fault::sampling);
  EXPECT_EQ(fault_of(changed(grey, 0xC0, 11, 0x15)), Fault::sampling);
  EXPECT_EQ(
      fault_of(changed(colour, 0xC0, 13, std::to_integer<unsigned>(colour[place_of(colour, 0xC0) + 10]))),
      Fault::components)
      << "two of one name";
}

TEST_F(JpegGate, RefusesPicturesThatNeedAnothersTables) {
  EXPECT_EQ(fault_of(without(grey, 0xDB)), Fault::tables);
  EXPECT_EQ(fault_of(without(grey, 0xC4)), Fault::tables);
  EXPECT_EQ(fault_of(changed(grey, 0xC0, 12, 1)), Fault::tables);
  EXPECT_EQ(fault_of(changed(grey, 0xC0, 12, 4)), Fault::tables);
  EXPECT_EQ(fault_of(changed(grey, 0xDA, 6, 0x11)), Fault::tables);
}

TEST_F(JpegGate, RefusesMoreThanOneScan) {
  const std::size_t scan = place_of(grey, 0xDA);
  Bytes many(grey.begin(), grey.end() - 2);
  for (int i = 0; i < 10'000; ++i) many += std::span(grey).subspan(scan, 10);
  many += text_bytes("\xFF\xD9");
  EXPECT_EQ(fault_of(many), Fault::scans);
  EXPECT_EQ(fault_of(changed(colour, 0xDA, 4, 1)), Fault::scans);
  EXPECT_EQ(fault_of(changed(grey, 0xDA, 8, 10)), Fault::not_a_jpeg);
}

TEST_F(JpegGate, RefusesBrokenSegments) {
  EXPECT_EQ(fault_of(text_bytes("GIF89a")), Fault::not_a_jpeg);
  EXPECT_EQ(fault_of(Bytes()), Fault::truncated);
  EXPECT_EQ(fault_of(changed(grey, 0xDB, 2, 0xFF)), Fault::truncated);
  EXPECT_EQ(fault_of(changed(grey, 0xDB, 3, 1)), Fault::not_a_jpeg);
  EXPECT_EQ(fault_of(changed(grey, 0xDB, 4, 0x20)), Fault::not_a_jpeg);
  EXPECT_EQ(fault_of(changed(grey, 0xC4, 4, 0x30)), Fault::not_a_jpeg);
  EXPECT_EQ(fault_of(changed(grey, 0xC4, 5, 0xFF)), Fault::not_a_jpeg);
  EXPECT_EQ(fault_of(changed(grey, 0xDA, 1, 0x02)), Fault::not_a_jpeg) << "a reserved marker";
}

TEST(PictureFault, EachHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kPictureFaults; ++i) names.insert(name_of(static_cast<Fault>(i)));
  EXPECT_EQ(names.size(), kPictureFaults);
  EXPECT_EQ(names.count(""), 0u);
  EXPECT_EQ(name_of(Fault::damaged), "damaged");
}

}  // namespace
}  // namespace mien::headset::jpeg_gate_test
