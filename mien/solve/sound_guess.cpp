#include "mien/solve/sound_guess.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "mien/sensor/clock_model.h"
#include "mien/solve/whole_line.h"
#include "mien/speech/sound_block.h"

namespace mien::solve {
namespace {

/// An hour is enough: a quarter of a gigabyte.
constexpr std::uint64_t kMostBlocksInOne = 3600 * 50;
/// Gaps are kept as silence while at least a quarter of the time was heard, but for the first minute.
constexpr std::uint64_t kFirstBlocks = 60 * 50, kBlocksAHeard = 4;

/// A film's first picture is its time code's frame, to one.
constexpr double kTimecodeFrames = 1;
/// How far the beginnings of film and file may be apart, s: two pictures at 60 Hz. Assumed: nobody tells it.
constexpr double kBeginTogether_s = 2.0 / 60;
constexpr double kFilmRate_hz = 60;
/// Beyond that a film's time code is another clock's.
constexpr double kMostStartsApart_s = 10;
/// A phone shows faces 20 to 100 ms late, and a microphone's way into a program takes as long: motion looks
/// within this of what was heard, s.
constexpr double kSoundWindow_s = 0.5;
/// A phone counts samples and pictures by two clocks, of one crystal as far as is known, ppm.
constexpr double kTwoClocks_ppm = 10;

/// One block as it arrived.
struct HeardBlock {
  speech::BlockHeader header;
  HostTime arrival;
  std::int64_t entry = 0;
};

DeviceTime end_of(const HeardBlock& block) {
  return block.header.time() + speech::kBlockDuration;
}

Result<std::vector<HeardBlock>> logged_blocks(std::span<const take::LogEntry> entries,
                                              take::PayloadReader& payloads) {
  std::map<std::uint64_t, std::vector<HeardBlock>> by_device;
  for (const take::LogEntry& entry : entries) {
    if (!speech::is_block(entry.bytes) && !speech::is_packet(entry.bytes)) continue;
    MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry.id));
    if (const auto logged = speech::logged_block(entry.bytes, payload.bytes))
      by_device[logged->header.device].push_back({logged->header, entry.arrival, entry.id});
  }
  std::vector<HeardBlock> most;
  for (auto& [device, blocks] : by_device)
    if (blocks.size() > most.size()) most = std::move(blocks);
  return most;
}

/// The longest stretch in which the microphone's clock did not jump, in its order.
std::vector<HeardBlock> longest_run(std::vector<HeardBlock> all) {
  std::vector<HeardBlock> longest, now;
  sensor::ClockModel clock;
  const auto close = [&] {
    if (now.size() > longest.size()) std::swap(longest, now);
    now.clear();
  };
  for (const HeardBlock& block : all) {
    if (clock.add(end_of(block), block.arrival)) close();
    now.push_back(block);
  }
  close();
  const auto count = [](const HeardBlock& block) { return block.header.block; };
  std::ranges::stable_sort(longest, {}, count);
  const auto same = std::ranges::unique(longest, {}, count);
  longest.erase(same.begin(), same.end());
  std::uint64_t heard = 0;
  const auto too_far = std::ranges::find_if(longest, [&](const HeardBlock& block) {
    const std::uint64_t span = block.header.block - longest.front().header.block;
    return span >= kMostBlocksInOne || span >= kFirstBlocks + kBlocksAHeard * heard++;
  });
  longest.erase(too_far, longest.end());
  return longest;
}

/// Where a microphone's clock stands on the sensors': of its first sample and of its last.
std::pair<double, double> on_sensors_time(const take::Take& take, std::span<const take::StoredSample> samples,
                                          std::span<const HeardBlock> blocks, DeviceTime begin) {
  const Duration span =
      std::max<Duration>(blocks.back().arrival - blocks.front().arrival,
                         samples.empty() ? Duration{} : samples.back().arrival - samples.front().arrival);
  WholeLine microphone(span), sensors(span);
  // A block is sent when it is whole.
  for (const HeardBlock& block : blocks) microphone.add(end_of(block), block.arrival);
  if (const auto reference = take.rig().find(take.rig().reference))
    for (const take::StoredSample& stored : samples)
      if (stored.sample.sensor == *reference) sensors.add(stored.sample.time, stored.arrival);
  const auto on_line = [&](DeviceTime time) {
    const HostTime arrival = microphone.clock().to_host(time);
    // Without a reference the sensors' time is the host's.
    const DeviceTime line =
        sensors.clock().ready() ? sensors.clock().to_device(arrival) : DeviceTime(arrival.time_since_epoch());
    return to_seconds(line - begin);
  };
  return {on_line(blocks.front().header.time()), on_line(end_of(blocks.back()))};
}

}  // namespace

Result<TakeSound> take_sound(const take::Take& take, DeviceTime begin) {
  MIEN_TRY_ASSIGN(std::optional<take::Audio> audio, take.audio());
  if (audio && !audio->samples.empty())
    return TakeSound{.sound = {.rate_hz = static_cast<std::uint32_t>(audio->rate_hz),
                               .samples = std::move(audio->samples)},
                     .begin_s = to_seconds(audio->start - begin)};
  MIEN_TRY_ASSIGN(const std::vector<take::LogEntry> entries, take.entries());
  MIEN_TRY_ASSIGN(take::PayloadReader counted, take.payloads());
  MIEN_TRY_ASSIGN(std::vector<HeardBlock> all, logged_blocks(entries, counted));
  const std::vector<HeardBlock> blocks = longest_run(std::move(all));
  if (blocks.size() < 2)
    return fail(ErrorCode::not_found, "the take has no sound", take.path().string(),
                "record it with --audio");
  TakeSound out;
  out.sound.rate_hz = speech::kRateHz;
  const std::uint64_t first = blocks.front().header.block;
  out.sound.samples.resize((blocks.back().header.block - first + 1) * speech::kBlockSamples);
  // Payloads are read in the order of their entries.
  std::map<std::int64_t, std::uint64_t> place_of;
  for (const HeardBlock& block : blocks) place_of.emplace(block.entry, block.header.block - first);
  MIEN_TRY_ASSIGN(take::PayloadReader payloads, take.payloads());
  for (const take::LogEntry& entry : entries) {
    const auto place = place_of.find(entry.id);
    if (place == place_of.end()) continue;
    MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry.id));
    const auto logged = speech::logged_block(entry.bytes, payload.bytes);
    if (!logged) continue;
    const auto into =
        out.sound.samples.begin() + static_cast<std::ptrdiff_t>(place->second * speech::kBlockSamples);
    std::ranges::transform(logged->block, into, [](std::int16_t sample) {
      return static_cast<float>(sample) / speech::kFullScale;
    });
  }
  MIEN_TRY_ASSIGN(const std::vector<take::StoredSample> samples, take.samples());
  const auto [from_s, to_s] = on_sensors_time(take, samples, blocks, begin);
  out.begin_s = from_s;
  out.drift_ppm = 1e6 * ((to_s - from_s) / out.sound.duration_s() - 1);
  return out;
}

phone::AlignmentPrior SoundGuess::prior() const {
  return {.offset_s = at.offset_s,
          .offset_window_s = kSoundWindow_s,
          .drift_ppm = at.drift_ppm,
          .drift_sigma_ppm = std::hypot(kTwoClocks_ppm, at.drift_sigma_ppm)};
}

Result<SoundGuess> guess_by_sound(const TakeSound& heard, const FilmSound& film,
                                  std::optional<double> track_start_s) {
  MIEN_TRY_ASSIGN(const phone::SoundOffset between, phone::sound_offset(heard.sound, film.sound));
  SoundGuess out;
  out.begin_sigma_s = kBeginTogether_s;
  double film_later_s = 0;  // Than the track.
  if (film.start_s && track_start_s) {
    constexpr double kDay_s = 86'400;
    const double apart_s = std::remainder(*film.start_s - *track_start_s, kDay_s);
    out.by_timecode = std::abs(apart_s) <= kMostStartsApart_s;
    if (out.by_timecode) film_later_s = apart_s, out.begin_sigma_s = kTimecodeFrames / kFilmRate_hz;
  }
  out.at = between;
  out.at.middle_s = heard.begin_s + between.middle_s * (1 + 1e-6 * heard.drift_ppm);
  out.at.offset_s = out.at.middle_s - (between.middle_s - between.offset_s + film_later_s);
  out.at.drift_ppm = 1e6 * ((1 + 1e-6 * between.drift_ppm) * (1 + 1e-6 * heard.drift_ppm) - 1);
  return out;
}

}  // namespace mien::solve
