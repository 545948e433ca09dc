#include "app/live/sound_feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "app/live/microphone.h"
#include "mien/core/files.h"
#include "mien/core/wav.h"
#include "mien/sensor/bindings.h"
#include "mien/speech/block_maker.h"
#include "mien/speech/sound_block.h"

namespace mien::app {
namespace {

/// "02:4D:49:53:4E:00": what is heard on this machine.
constexpr std::uint64_t kMicrophone = 0x024D'4953'4E00ULL;
constexpr std::string_view kKind = "speech";
constexpr double kLongest_s = 2 * 3600;

Result<std::vector<speech::Block>> blocks_of(const Sound& sound) {
  MIEN_TRY_ASSIGN(speech::BlockMaker maker, speech::BlockMaker::create(static_cast<int>(sound.rate_hz)));
  std::vector<speech::Block> blocks;
  const auto take = [&blocks](const speech::Block& block) { blocks.push_back(block); };
  maker.push(sound.samples, take);
  maker.finish(take);
  return blocks;
}

/// Each block is handed over when its last sample would have been heard.
void play(const std::vector<speech::Block>& blocks, std::uint64_t device, live::FeedPort& port) {
  const auto begun = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < blocks.size() && !port.stopped(); ++i) {
    std::this_thread::sleep_until(begun + speech::kBlockDuration * static_cast<std::int64_t>(i + 1));
    if (!port.wanted()) continue;
    if (const auto header = speech::encode_header({.device = device, .block = i}))
      port.hand_over(*header, speech::payload_of(blocks[i]));
  }
}

/// Sources of the log have plain names, files need not.
std::string source_name(const std::string& file) {
  constexpr std::size_t kLongest = 60;
  std::string name = "sound:" + std::filesystem::path(file).filename().string();
  std::ranges::replace_if(
      name, [](char c) { return c <= ' ' || c >= 0x7F; }, '_');
  return name.substr(0, kLongest);
}

}  // namespace

Result<live::Feed> sound_feed(const std::string& what, std::uint64_t device) {
  std::error_code ignored;
  if (what != "default" &&
      (what.ends_with(".wav") || what.ends_with(".WAV") || std::filesystem::is_regular_file(what, ignored)))
    return file_feed(what, device);
  return microphone_feed(what, device);
}

Result<live::Feed> file_feed(const std::string& file, std::uint64_t device) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, read_file(file));
  MIEN_TRY_ASSIGN(const Sound sound, parse_wav(bytes, file));
  if (sound.samples.empty()) return fail(ErrorCode::truncated, "there is no sound in it", file);
  if (sound.duration_s() > kLongest_s)
    return fail(ErrorCode::out_of_range, fmt::format("{:.1f} h of sound", sound.duration_s() / 3600), file,
                "cut it into pieces of at most two hours");
  auto made = blocks_of(sound);
  if (!made) {
    made.error().where = file;
    return std::unexpected(std::move(made).error());
  }
  const auto blocks = std::make_shared<const std::vector<speech::Block>>(*std::move(made));
  return live::Feed{source_name(file),
                    [blocks, device](live::FeedPort& port) { play(*blocks, device, port); }};
}

Result<HearingRig> with_microphone(sensor::Rig rig, const std::string& hears_by) {
  MIEN_TRY_ASSIGN(const auto bound, sensor::bindings(rig));
  const auto hears = std::ranges::find(rig.sensors, kKind, &sensor::Mount::kind);
  if (hears != rig.sensors.end()) {
    const auto number = static_cast<std::uint16_t>(hears - rig.sensors.begin());
    const auto its = std::ranges::find(bound, number, &std::pair<sensor::DeviceKey, std::uint16_t>::second);
    if (its == bound.end() || its->first.channel != 0)
      return fail(
          ErrorCode::bad_usage,
          fmt::format("the microphone '{}' has no device, or not the first channel of one", hears->name),
          "rig " + rig.name, "write device = \"02:4D:49:53:4E:00\" at it");
    if (!hears_by.empty()) rig.sensors[number].hears_by = hears_by;
    return HearingRig{std::move(rig), its->first.device};
  }
  // A rig that binds nothing means virtual nodes, and with a microphone bound it would no longer.
  for (const auto& [key, number] : bound) rig.sensors[number].device = sensor::format_device(key);
  sensor::Mount microphone;
  microphone.name = "microphone";
  while (rig.find(microphone.name)) microphone.name += "_";
  microphone.kind = kKind;
  microphone.role = "face";
  microphone.hears_by = hears_by.empty() ? "network" : hears_by;
  microphone.device = sensor::format_device({kMicrophone, 0});
  rig.sensors.push_back(std::move(microphone));
  // As a take's reader sees it.
  MIEN_TRY_ASSIGN(sensor::Rig whole, sensor::parse_rig(sensor::write_rig(rig), "rig " + rig.name));
  return HearingRig{std::move(whole), kMicrophone};
}

}  // namespace mien::app
