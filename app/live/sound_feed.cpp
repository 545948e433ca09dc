#include "app/live/sound_feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "app/live/microphone.h"
#include "app/live/page_microphone.h"
#include "mien/core/files.h"
#include "mien/core/wav.h"
#include "mien/sensor/bindings.h"
#include "mien/speech/block_maker.h"
#include "mien/speech/sound_block.h"

namespace mien::app {
namespace {

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
void play(const std::vector<speech::Block>& blocks, live::FeedPort& port) {
  const auto begun = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < blocks.size() && !port.stopped(); ++i) {
    std::this_thread::sleep_until(begun + speech::kBlockDuration * static_cast<std::int64_t>(i + 1));
    if (!port.wanted()) continue;
    if (const auto header = speech::encode_header({.device = speech::kThisMachine, .block = i}))
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

Result<live::Feed> sound_feed(const std::string& what) {
  if (what == "page") return page_feed(speech::kThisMachine);
  std::error_code ignored;
  if (what != "default" &&
      (what.ends_with(".wav") || what.ends_with(".WAV") || std::filesystem::is_regular_file(what, ignored)))
    return file_feed(what);
  return microphone_feed(what, speech::kThisMachine);
}

Result<live::Feed> file_feed(const std::string& file) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, read_file(file));
  MIEN_TRY_ASSIGN(const Sound sound, parse_wav(bytes, file));
  if (sound.samples.empty()) return fail(ErrorCode::truncated, "there is no sound in it", file);
  if (sound.duration_s() > kLongest_s)
    return fail(ErrorCode::out_of_range, fmt::format("{:.1f} h of sound", sound.duration_s() / 3600), file,
                "cut it into pieces of at most two hours");
  if (sound.missing > 0)
    fmt::print(stderr,
               "mien: {}: the file is cut short: {:.1f} of {:.1f} s are there, and these are played\n", file,
               sound.duration_s(), sound.duration_s() + static_cast<double>(sound.missing) / sound.rate_hz);
  auto made = blocks_of(sound);
  if (!made) {
    made.error().where = file;
    return std::unexpected(std::move(made).error());
  }
  const auto blocks = std::make_shared<const std::vector<speech::Block>>(*std::move(made));
  return live::Feed{source_name(file), [blocks](live::FeedPort& port) { play(*blocks, port); }};
}

bool hears_network(const sensor::Rig& rig) {
  const auto hears = std::ranges::find(rig.sensors, kKind, &sensor::Mount::kind);
  if (hears == rig.sensors.end() || hears->device.empty()) return false;
  const auto key = sensor::parse_device(hears->device);
  return key && key->device != speech::kThisMachine;
}

Result<sensor::Rig> with_microphone(sensor::Rig rig, const std::string& hears_by, bool from_network) {
  MIEN_TRY_ASSIGN(rig, sensor::with_bindings(std::move(rig)));
  MIEN_TRY_ASSIGN(const auto bound, sensor::bindings(rig));
  auto hears = std::ranges::find(rig.sensors, kKind, &sensor::Mount::kind);
  if (hears != rig.sensors.end()) {
    const auto number = static_cast<std::uint16_t>(hears - rig.sensors.begin());
    const auto its = std::ranges::find(bound, number, &std::pair<sensor::DeviceKey, std::uint16_t>::second);
    const bool bad = its == bound.end() || its->first.channel != 0;
    if (bad || (from_network && its->first.device == speech::kThisMachine))
      return fail(
          ErrorCode::bad_usage,
          bad ? fmt::format("the microphone '{}' has no device, or not the first channel of one", hears->name)
              : fmt::format("the microphone '{}' is this machine's own, not one on the network", hears->name),
          "rig " + rig.name,
          fmt::format(
              "write device = \"{}\" at it",
              sensor::format_device({from_network ? speech::kAnyMicrophone : speech::kThisMachine, 0})));
    if (!hears_by.empty()) hears->hears_by = hears_by;
  } else {
    sensor::Mount microphone;
    microphone.name = "microphone";
    while (rig.find(microphone.name)) microphone.name += "_";
    microphone.kind = kKind;
    microphone.role = "face";
    microphone.hears_by = hears_by.empty() ? "network" : hears_by;
    microphone.device = sensor::format_device({speech::kAnyMicrophone, 0});
    hears = rig.sensors.insert(rig.sensors.end(), std::move(microphone));
  }
  if (!from_network) hears->device = sensor::format_device({speech::kThisMachine, 0});
  // As a take's reader sees it.
  return sensor::parse_rig(sensor::write_rig(rig), "rig " + rig.name);
}

}  // namespace mien::app
