// Allocations are counted, by taking the place of operator new.
#include "mien/headset/feature_reducer.h"

#include <gtest/gtest.h>

#include "mien/headset/feature_record.h"
#include "mien/headset/picture_packet.h"
#include "tests/allocation_count.h"
#include "tests/headset/small_jpeg.h"
#include "tests/headset/small_model.h"

namespace mien::headset::feature_reducer_test {
namespace {

using namespace test;

FeatureReducer reducer_of(const sensor::Rig& rig = headset_rig(), std::uint64_t seed = 1) {
  return FeatureReducer::create(rig, small_model(seed)).value();
}

Bytes packet_of(std::uint64_t device) {
  ByteWriter out;
  EXPECT_TRUE(write_picture_packet({.from = {device, 0}, .sequence = 7}, out));
  return out.release();
}

/// The record of a picture; empty where there is none.
Bytes reduced(FeatureReducer& reducer, std::uint64_t device, const Bytes& jpeg) {
  Bytes out(sensor::kMaxPayload);
  const auto size = reducer.reduce(packet_of(device), jpeg, out);
  out.resize(size.value_or(0));
  return out;
}

TEST(FeatureReducer, FindsWhatTheNetworkFindsBesideOtherViews) {
  FeatureReducer reducer = reducer_of();
  const auto model = small_model();
  const model::ViewsNetwork& network = model->network();
  model::ViewsNetwork::Workspace workspace(network);
  const std::size_t pixels = 16 * 16, count = network.architecture().features;
  std::vector<float> views(model::kViews * pixels), features(model::kViews * count);
  for (std::size_t c = 0; c < model::kViews; ++c) {
    auto decoder = PictureDecoder::create().value();
    auto view = NetworkView::create(
                    {.side = 16, .left = 0.1, .top = 0.1, .right = 0.9, .bottom = 0.9, .mirror = c % 2 == 1})
                    .value();
    const auto picture = decoder.decode(grey_jpeg(240, 240, static_cast<int>(c)), 96, 96);
    ASSERT_TRUE(picture);
    view.make(*picture, std::span(views).subspan(c * pixels, pixels));
  }
  network.find(views, {true, true, true, true}, workspace, features);
  for (std::size_t c = 0; c < model::kViews; ++c) {
    const Bytes bytes = reduced(reducer, kHeadset + c, grey_jpeg(240, 240, static_cast<int>(c)));
    const auto record = parse_feature_record(bytes);
    ASSERT_TRUE(record) << record.error().message();
    EXPECT_EQ(record->sensor, c);
    ASSERT_EQ(record->count(), count);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(record->feature(i), features[c * count + i]);
  }
  // Where a view is missing its token stands.
  network.find(views, {true, false, true, true}, workspace, features);
  EXPECT_TRUE(std::ranges::equal(network.missing(1), std::span(features).subspan(count, count)));
}

TEST(FeatureReducer, MeasuresThePictureWhicheverPartTheNetworkSees) {
  sensor::Rig narrow = headset_rig();
  narrow.sensors[0].camera->crop = {0.4, 0.4, 0.1, 0.1};
  FeatureReducer wide = reducer_of(), close = reducer_of(narrow);
  const Bytes jpeg = grey_jpeg(240, 240, 2);
  const Bytes a = reduced(wide, kHeadset, jpeg), b = reduced(close, kHeadset, jpeg);
  EXPECT_NE(a, b);
  const auto record = parse_feature_record(a);
  ASSERT_TRUE(record);
  EXPECT_EQ(record->statistics, parse_feature_record(b)->statistics);
  auto decoder = PictureDecoder::create().value();
  EXPECT_EQ(record->statistics, statistics_of(*decoder.decode(jpeg, kMeasuredSide, kMeasuredSide)));
  EXPECT_EQ(record->jpeg_bytes, jpeg.size());
}

TEST(FeatureReducer, OfACameraThatTheRigDoesNotKnowOnlyMeasures) {
  FeatureReducer reducer = reducer_of();
  const Bytes bytes = reduced(reducer, kHeadset + 9, grey_jpeg(240, 240, 1));
  const auto record = parse_feature_record(bytes);
  ASSERT_TRUE(record);
  EXPECT_FALSE(record->sensor);
  EXPECT_EQ(record->count(), 0U);
}

TEST(FeatureReducer, TakesNoPictureThatDoesNotDecodeAndNoOtherPacket) {
  FeatureReducer reducer = reducer_of();
  const Bytes jpeg = grey_jpeg(64, 64, 1);
  for (std::size_t size = 0; size < jpeg.size(); size += 37)
    EXPECT_TRUE(
        reduced(reducer, kHeadset, {jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(size)}).empty())
        << size;
  Bytes out(sensor::kMaxPayload);
  EXPECT_FALSE(reducer.reduce(text_bytes("no packet"), jpeg, out));
  EXPECT_FALSE(reducer.reduce(packet_of(kHeadset), reduced(reducer, kHeadset, jpeg), out))
      << "what is reduced already";
  EXPECT_FALSE(reducer.reduce(packet_of(kHeadset), jpeg, std::span(out).first(20)));
}

TEST(FeatureReducer, ItsHashIsOfAllThatTheResultDependsOn) {
  const std::string hash(reducer_of().hash());
  EXPECT_TRUE(sensor::is_reducer_hash(hash));
  EXPECT_EQ(reducer_of().hash(), hash);
  EXPECT_NE(reducer_of(headset_rig(), 2).hash(), hash) << "another network";
  const auto with = [](const auto& edit) {
    sensor::Rig rig = headset_rig();
    edit(rig);
    return std::string(reducer_of(rig).hash());
  };
  EXPECT_EQ(with([](sensor::Rig& rig) { rig.name = "other"; }), hash);
  EXPECT_NE(with([](sensor::Rig& rig) { rig.sensors[1].camera->crop[0] = 0.05; }), hash);
  EXPECT_NE(with([](sensor::Rig& rig) { rig.sensors[1].camera->turn_deg = 90; }), hash);
  EXPECT_NE(with([](sensor::Rig& rig) { rig.sensors[2].camera->mirror = true; }), hash);
  EXPECT_NE(with([](sensor::Rig& rig) { rig.sensors[2].device = "02:4D:49:48:53:77"; }), hash);
}

TEST(FeatureReducer, FollowsViewsAndPlacesAsIfItWereMadeForSuchARig) {
  FeatureReducer reducer = reducer_of();
  const std::string before(reducer.hash());
  const sensor::PictureView view{.crop = {0.2, 0.3, 0.4, 0.5}, .turn_deg = 90, .mirror = true};
  reducer.change_view(2, view);
  sensor::Rig rig = headset_rig();
  sensor::set_view(*rig.sensors[2].camera, view);
  EXPECT_NE(reducer.hash(), before);
  EXPECT_EQ(reducer.hash(), reducer_of(rig).hash());
  FeatureReducer made = reducer_of(rig);
  const Bytes jpeg = grey_jpeg(240, 240, 3);
  EXPECT_EQ(reduced(reducer, kHeadset + 2, jpeg), reduced(made, kHeadset + 2, jpeg));
  EXPECT_EQ(reduced(reducer, kHeadset, jpeg), reduced(made, kHeadset, jpeg));
  // Another camera at that place; the one that was there is at none.
  reducer.bind(2, {0x77, 0});
  rig.sensors[2].device = "00:00:00:00:00:77";
  EXPECT_EQ(reducer.hash(), reducer_of(rig).hash());
  EXPECT_EQ(reduced(reducer, 0x77, jpeg), reduced(made, kHeadset + 2, jpeg));
  EXPECT_FALSE(parse_feature_record(reduced(reducer, kHeadset + 2, jpeg)).value().sensor);
  // And at the other's place there is none any more.
  reducer.bind(1, {0x77, 0});
  EXPECT_EQ(parse_feature_record(reduced(reducer, 0x77, jpeg)).value().sensor, 1);
  EXPECT_FALSE(parse_feature_record(reduced(reducer, kHeadset + 1, jpeg)).value().sensor);
  // What is no camera has no view and no pictures.
  const std::string hash(reducer.hash());
  reducer.change_view(9, view);
  EXPECT_EQ(reducer.hash(), hash);
}

TEST(FeatureReducer, RefusesRigsThatItsNetworkHasNoPlaceFor) {
  const auto error = [](const auto& edit) {
    sensor::Rig rig = headset_rig();
    edit(rig);
    const auto made = FeatureReducer::create(rig, small_model());
    return made ? std::string() : made.error().message();
  };
  EXPECT_NE(
      error([](sensor::Rig& rig) { rig.sensors[1].side = 'L'; }).find("eye_L and eye_R look at the same"),
      std::string::npos);
  EXPECT_NE(
      error([](sensor::Rig& rig) { rig.sensors[3].camera.reset(); }).find("mouth_R has no [sensor.camera]"),
      std::string::npos);
  EXPECT_NE(error([](sensor::Rig& rig) {
              for (sensor::Mount& mount : rig.sensors) mount.kind = "imu";
            }).find("no sensor of this rig is of the kind camera"),
            std::string::npos);
}

TEST(FeatureReducer, AllocatesNothingAfterItsFirstPictures) {
  FeatureReducer reducer = reducer_of();
  const Bytes jpeg = grey_jpeg(240, 240, 1), packet = packet_of(kHeadset);
  Bytes out(sensor::kMaxPayload);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(reducer.reduce(packet, jpeg, out));
  const std::size_t before = mien::test::allocation_count();
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(reducer.reduce(packet, jpeg, out));
  EXPECT_EQ(mien::test::allocation_count(), before);
}

}  // namespace
}  // namespace mien::headset::feature_reducer_test
