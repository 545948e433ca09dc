#include "mien/modalities/modalities.h"

#include <gtest/gtest.h>

#include <utility>

#include "mien/core/bytes.h"
#include "mien/eyewear/packet.h"
#include "mien/headset/headset_model.h"
#include "mien/imu/packets/node_message.h"
#include "mien/model/linear.h"
#include "mien/speech/sound_block.h"
#include "mien/tracker/causal_tracker.h"
#include "tests/project_path.h"

namespace mien::modalities::modalities_test {
namespace {

TEST(Registry, ARigOfSeveralKindsTakesAFolderOfModels) {
  const sensor::Rig imus = sensor::read_rig(project_path("rigs/default.toml")).value();
  const sensor::Rig both = sensor::read_rig(project_path("rigs/imu_eyewear.toml")).value();
  EXPECT_TRUE(has_window_models(imus));
  EXPECT_FALSE(has_window_models(both));
  const auto file = live_model(imus, "");
  const auto folder = live_model(both, "");
  ASSERT_TRUE(file && folder);
  EXPECT_EQ(file->filename(), "live.safetensors");
  EXPECT_EQ(*folder, file->parent_path());
  EXPECT_EQ(live_model(both, "mine").value(), "mine");
  // The first that is missing is named.
  const auto missing = make_session(both, "no/such/folder");
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message().find("no/such/folder: a rig with sensors of several kinds"),
            std::string::npos)
      << missing.error().message();
}

TEST(Registry, NamesWhatEachKindMultipliesWith) {
  const auto kernels = [](const char* rig) {
    return live_kernels(sensor::read_rig(project_path(std::string("rigs/") + rig)).value());
  };
  const std::string imus = model::kernel_name(tracker::kLivePrecision),
                    cameras = model::kernel_name(headset::kHeadsetPrecision);
  EXPECT_EQ(kernels("default.toml"), imus);
  EXPECT_EQ(kernels("headset.toml"), cameras);
  const std::string both = kernels("imu_headset.toml");
  EXPECT_NE(both.find(imus), std::string::npos) << both;
  EXPECT_NE(both.find(cameras), std::string::npos) << both;
}

TEST(Registry, GazeNeedsNoModel) {
  sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  rig.sensors.push_back({.name = "eyes", .kind = "gaze", .role = "face", .device = "02:4D:49:47:5A:00"});
  const auto model = live_model(rig, "");
  ASSERT_TRUE(model);
  EXPECT_EQ(model->filename(), "live.safetensors");
  const auto both = make_session(rig, *model);
  ASSERT_TRUE(both) << both.error().message();
  EXPECT_EQ((*both)->modality(), "imu+gaze");
  EXPECT_FALSE(has_window_models(rig));

  rig.reference = "eyes";
  std::erase_if(rig.sensors, [](const sensor::Mount& mount) { return mount.kind != "gaze"; });
  EXPECT_EQ(live_model(rig, "").value(), "");
  const auto alone = make_session(rig, "");
  ASSERT_TRUE(alone) << alone.error().message();
  EXPECT_EQ((*alone)->modality(), "gaze");
  EXPECT_EQ(live_kernels(rig), "none");
  EXPECT_TRUE(make_session(rig, ""));
}

TEST(Registry, WeightsNeedNoModelAndArePutTogetherWithGaze) {
  sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  rig.sensors.push_back({.name = "eyes", .kind = "gaze", .role = "face", .device = "02:4D:49:47:5A:00"});
  rig.sensors.push_back({.name = "phone", .kind = "weights", .role = "face", .device = "02:4D:49:45:4E:70"});
  const auto model = live_model(rig, "");
  ASSERT_TRUE(model);
  EXPECT_EQ(model->filename(), "live.safetensors");
  const auto all = make_session(rig, *model);
  ASSERT_TRUE(all) << all.error().message();
  EXPECT_EQ((*all)->modality(), "imu+gaze+weights");

  rig.reference = "phone";
  std::erase_if(rig.sensors, [](const sensor::Mount& mount) { return mount.kind != "weights"; });
  EXPECT_EQ(live_model(rig, "").value(), "");
  EXPECT_TRUE(make_session(rig, ""));
}

TEST(Registry, RefusesSensorsOfAKindThatItDoesNotKnow) {
  sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  rig.sensors[3].kind = "thermometer";
  EXPECT_EQ(live_model(rig, "").error().code, ErrorCode::unsupported);
  EXPECT_EQ(make_session(rig, "models").error().code, ErrorCode::unsupported);
  EXPECT_FALSE(has_window_models(rig));
}

/// A paired device, which has asked a session of these protocols for its token.
class Paired {
 public:
  Paired(sensor::Protocol& session, const sensor::SealKey& key, std::uint64_t device)
      : session_(session), key_(key), device_(device) {
    ByteWriter hello;
    EXPECT_TRUE(encode_node_message(imu::Hello{.device = device, .sites = {""}}, hello));
    EXPECT_EQ(send(hello.bytes()), sensor::Verdict::taken);
    std::vector<std::byte> welcome;
    const auto header = sensor::open_sealed({&key_, 1}, inbox.reply, welcome);
    EXPECT_TRUE(header) << header.error().message();
    if (header) token_ = header->session;
  }
  sensor::Verdict send(std::span<const std::byte> inner) {
    ByteWriter sealed;
    EXPECT_TRUE(sensor::seal_packet(
        key_, {.key_id = key_.id, .device = device_, .counter = ++counter_, .session = token_}, inner,
        sealed));
    inbox.clear();
    return session_.receive(HostTime(), 1, sealed.bytes(), inbox);
  }
  sensor::Inbox inbox;

 private:
  sensor::Protocol& session_;
  sensor::SealKey key_;
  std::uint64_t device_;
  std::uint64_t counter_ = 0;
  std::uint64_t token_ = 0;
};

std::vector<std::byte> scan(std::uint64_t device) {
  eyewear::Packet packet;
  packet.device = device;
  packet.channels = 3;
  packet.light[1] = {.on = 700, .off = 30};
  return eyewear::encode_packet(packet).value();
}

TEST(Registry, AKeyAdmitsSealedNodesAndGlassesInOneSessionAndNothingPlain) {
  constexpr std::uint64_t kGlasses = 0x024D'4945'4E40, kNode = 0x024D'4945'4E07;
  const sensor::SealKey key{.id = 4, .secret = {std::byte{9}}};
  const Protocols protocols = make_protocols({key}).value();
  // Beside it only what devices inside this program speak, by payloads that no datagram has.
  ASSERT_EQ(protocols.size(), 3U);
  EXPECT_EQ(protocols.front()->name(), "sound");
  sensor::Protocol& session = *protocols.back();
  Paired node(session, key, kNode), glasses(session, key, kGlasses);
  EXPECT_EQ(glasses.send(scan(kGlasses)), sensor::Verdict::taken);
  ASSERT_EQ(glasses.inbox.readings.size(), 3U);
  EXPECT_EQ(glasses.inbox.readings[1].from, (sensor::DeviceKey{kGlasses, 1}));
  EXPECT_EQ(glasses.inbox.opened, scan(kGlasses));
  ByteWriter pulse;
  ASSERT_TRUE(encode_node_message(imu::Pulse{.device = kNode, .index = 3}, pulse));
  EXPECT_EQ(node.send(pulse.bytes()), sensor::Verdict::taken);
  EXPECT_EQ(node.inbox.pulses.size(), 1U);
  // One does not speak for the other, nor anybody without the key.
  EXPECT_EQ(node.send(scan(kGlasses)), sensor::Verdict::refused);
  sensor::Inbox inbox;
  EXPECT_EQ(session.receive(HostTime(), 1, scan(kGlasses), inbox), sensor::Verdict::refused);
  EXPECT_EQ(session.receive(HostTime(), 1, pulse.bytes(), inbox), sensor::Verdict::refused);
  const std::vector<std::byte> block = speech::encode_header({.device = kNode, .block = 1}).value();
  EXPECT_EQ(protocols.front()->receive(HostTime(), 1, block, inbox), sensor::Verdict::malformed);
  const auto text = std::as_bytes(std::span<const char>("512,498,1003,17", 15));
  EXPECT_FALSE(session.recognises(text));
  // What a log keeps of it replays without keys.
  bool recognised = false;
  const Protocols without_keys = make_protocols().value();
  for (const auto& plain : without_keys) {
    if (!plain->recognises(scan(kGlasses))) continue;
    recognised = true;
    EXPECT_EQ(plain->receive(HostTime(), 1, scan(kGlasses), inbox), sensor::Verdict::taken);
    break;
  }
  EXPECT_TRUE(recognised);
}

}  // namespace
}  // namespace mien::modalities::modalities_test
