#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/json_output.h"
#include "mien/core/files.h"
#include "mien/core/wav.h"
#include "mien/speech/sound_block.h"
#include "mien/take/summary.h"

namespace mien::app {
namespace {

/// Seconds from the take's begin: devices count from their power-on, which says nothing to anybody.
double since_begin_s(const take::Summary& summary, DeviceTime time) {
  return to_seconds(time - summary.begin);
}

/// The sensor that an event is about; empty when it is about none.
std::string sensor_of(const take::Event& event) {
  const auto details = nlohmann::json::parse(event.json, nullptr, false);
  const auto sensor = details.is_object() ? details.find("sensor") : details.end();
  return sensor != details.end() && sensor->is_string() ? sensor->get<std::string>() : std::string();
}

void print_event(const take::Summary& summary, const take::EventGroup& group) {
  const double begin_s = since_begin_s(summary, group.first.begin);
  const double end_s = since_begin_s(summary, group.end);
  const std::string sensor = sensor_of(group.first);
  const std::string what = sensor.empty() ? group.first.kind : group.first.kind + " " + sensor;
  fmt::print("  event      {:<32} {:8.2f}{} s{}\n", one_line(what, 60), begin_s,
             end_s > begin_s ? fmt::format(" to {:.2f}", end_s) : "",
             group.count > 1 ? fmt::format(", {} times", group.count) : "");
}

const char* state_of(const take::Take& take) {
  return take.finished() ? "finished" : "cut off, or still recording";
}

Result<void> print_info_json(const take::Take& take, const take::Summary& summary) {
  const take::Header& header = take.header();
  Json json;
  json["file"] = take.path().string();
  json["finished"] = take.finished();
  json["software"] = header.software;
  json["created_utc"] = header.created_utc;
  json["performer"] = header.performer;
  json["script"] = header.script;
  json["devices"] = header.devices;
  json["face"] = header.face;
  json["prologue"] = header.prologue;
  json["seed"] = header.seed;
  json["duration_s"] = summary.duration_s;
  json["begin_device_s"] = to_seconds(summary.begin.time_since_epoch());
  json["log"] = {{"entries", summary.entries},
                 {"bytes", summary.entry_bytes},
                 {"payloads", summary.payloads},
                 {"payload_bytes", summary.payload_bytes}};
  json["ticks"] = summary.ticks;
  json["samples"] = summary.samples;
  json["rig"] = take.rig().name;
  json["reference"] = take.rig().reference;
  json["sensors"] = Json::array();
  for (const take::SensorSummary& sensor : summary.sensors)
    json["sensors"].push_back({{"name", sensor.name},
                               {"role", sensor.role},
                               {"samples", sensor.samples},
                               {"rate_hz", sensor.rate_hz},
                               {"loss", sensor.loss},
                               {"lost", sensor.lost},
                               {"doubled", sensor.doubled},
                               {"gaps", sensor.gaps},
                               {"longest_gap_s", sensor.longest_gap_s},
                               {"begin_s", sensor.begin_s},
                               {"end_s", sensor.end_s},
                               {"leaps", sensor.leaps},
                               {"time_estimated", sensor.time_estimated}});
  json["truth"] = {{"frames", summary.truth_frames},
                   {"without_face", summary.truth_lost},
                   {"evaluated", summary.truth_evaluated}};
  json["audio"] = {{"seconds", summary.audio_s}, {"rate_hz", summary.audio_rate_hz}};
  json["events"] = Json::array();
  MIEN_TRY_ASSIGN(const auto events, take.events());
  for (const take::Event& event : events)
    json["events"].push_back({{"kind", event.kind},
                              {"sensor", sensor_of(event)},
                              {"begin_s", since_begin_s(summary, event.begin)},
                              {"end_s", since_begin_s(summary, event.end)}});
  json["calibrations"] = Json::array();
  MIEN_TRY_ASSIGN(const auto calibrations, take.calibrations());
  for (const take::CalibrationVersion& calibration : calibrations)
    json["calibrations"].push_back({{"id", calibration.id},
                                    {"modality", calibration.modality},
                                    {"made_s", since_begin_s(summary, calibration.made)}});
  json["notes"] = Json::object();
  MIEN_TRY_ASSIGN(const auto notes, take.notes());
  for (const take::Note& note : notes) json["notes"][note.key] = note.value;
  print_json(json);
  return {};
}

/// What there is to say of a sensor beside its figures.
std::string remarks_on(const take::SensorSummary& sensor) {
  std::string out;
  if (sensor.role == "truth") out += "  truth";
  if (sensor.time_estimated) out += "  times estimated";
  if (sensor.leaps > 0)
    out += fmt::format("  its clock leapt {} time{}", sensor.leaps, sensor.leaps == 1 ? "" : "s");
  return out;
}

Result<void> print_info_text(const take::Take& take, const take::Summary& summary) {
  const take::Header& header = take.header();
  fmt::print("{}: {:.1f} s, {}\n", take.path().string(), summary.duration_s, state_of(take));
  fmt::print("  performer  {}\n", one_line(header.performer));
  fmt::print("  performs   {}\n", one_line(header.script));
  fmt::print("  face       {}\n", one_line(header.face));
  fmt::print("  devices    {}, seed {}, prologue {}\n", one_line(header.devices), header.seed,
             one_line(header.prologue));
  fmt::print("  made by    {}, {}\n", one_line(header.software), one_line(header.created_utc));
  fmt::print("  log        {} entries, {:.1f} MB, {} ticks\n", summary.entries,
             static_cast<double>(summary.entry_bytes) * 1e-6, summary.ticks);
  if (summary.payloads > 0)
    fmt::print("  payloads   {}, {:.1f} MB\n", summary.payloads,
               static_cast<double>(summary.payload_bytes) * 1e-6);
  if (summary.truth_frames > 0)
    fmt::print("  truth      {} frames, {} evaluated, {} without a face\n", summary.truth_frames,
               summary.truth_evaluated, summary.truth_lost);
  if (summary.audio_rate_hz > 0)
    fmt::print("  sound      {:.1f} s at {} Hz\n", summary.audio_s, summary.audio_rate_hz);
  MIEN_TRY_ASSIGN(const auto calibrations, take.calibrations());
  for (const take::CalibrationVersion& calibration : calibrations)
    fmt::print("  calibrated {} (version {}) at {:.2f} s\n", one_line(calibration.modality), calibration.id,
               since_begin_s(summary, calibration.made));
  MIEN_TRY_ASSIGN(const auto events, take.events());
  const std::vector<take::EventGroup> groups = take::group_events(events);
  constexpr std::size_t kGroupsShown = 40;
  for (std::size_t i = 0; i < std::min(groups.size(), kGroupsShown); ++i) print_event(summary, groups[i]);
  if (groups.size() > kGroupsShown) fmt::print("  event      and {} more\n", groups.size() - kGroupsShown);
  MIEN_TRY_ASSIGN(const auto notes, take.notes());
  for (const take::Note& note : notes)
    fmt::print("  note       {}: {}\n", one_line(note.key), one_line(note.value));
  fmt::print("\n  {:<24} {:>9} {:>9} {:>8} {:>6} {:>12}\n", "sensor (rig " + one_line(take.rig().name) + ")",
             "samples", "rate, Hz", "loss, %", "gaps", "longest, ms");
  for (const take::SensorSummary& sensor : summary.sensors)
    fmt::print("  {:<24} {:>9} {:>9.2f} {:>8.2f} {:>6} {:>12.1f}{}\n", one_line(sensor.name), sensor.samples,
               sensor.rate_hz, 100 * sensor.loss, sensor.gaps, 1e3 * sensor.longest_gap_s,
               remarks_on(sensor));
  return {};
}

Result<void> info(const std::string& file, bool json) {
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(file));
  MIEN_TRY_ASSIGN(const take::Summary summary, take::summarise(take));
  return json ? print_info_json(take, summary) : print_info_text(take, summary);
}

Result<void> check(const std::string& file, bool json) {
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(file));
  MIEN_TRY(take.check());
  if (json)
    print_json({{"file", file}, {"sound", true}, {"finished", take.finished()}});
  else
    fmt::print("{}: sound, {}\n", file, state_of(take));
  return {};
}

/// Blocks of a gap that is kept as silence: a minute.
constexpr std::uint64_t kLongestGap = 60 * speech::kRateHz / speech::kBlockSamples;

/// Blocks of a device that was started anew are counted from below this: a second.
constexpr std::uint64_t kRestart = speech::kRateHz / speech::kBlockSamples;

/// Appends block after block of one device.
class Gathered {
 public:
  void add(const speech::BlockHeader& header, const speech::Block& block) {
    if (device_ && *device_ != header.device) return;
    device_ = header.device;
    // Doubled, late, or of another who sends as this device; a device that restarts counts from 0.
    if (next_ && header.block < *next_ && header.block > kRestart) return;
    if (next_ && header.block > *next_ && header.block - *next_ <= kLongestGap)
      sound_.samples.resize(sound_.samples.size() + (header.block - *next_) * speech::kBlockSamples);
    for (const std::int16_t sample : block)
      sound_.samples.push_back(static_cast<float>(sample) / speech::kFullScale);
    next_ = header.block + 1;
  }
  [[nodiscard]] bool any() const { return device_.has_value(); }
  [[nodiscard]] Sound take() { return std::move(sound_); }

 private:
  Sound sound_{.rate_hz = speech::kRateHz, .samples = {}};
  std::optional<std::uint64_t> device_;
  std::optional<std::uint64_t> next_;
};

/// What is heard in a take: the blocks that its session logged, of the device that was heard first, or else
/// the sound that was recorded beside it. Blocks that were lost are silence; where a device restarts, or is
/// not heard for a minute, its next block follows at once. Errors: not_found (no sound), the take's.
Result<Sound> sound_of(const take::Take& take) {
  MIEN_TRY_ASSIGN(const std::vector<take::LogEntry> entries, take.entries());
  MIEN_TRY_ASSIGN(take::PayloadReader payloads, take.payloads());
  Gathered gathered;
  for (const take::LogEntry& entry : entries) {
    if (!speech::is_block(entry.bytes) && !speech::is_packet(entry.bytes)) continue;
    MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry.id));
    if (const auto logged = speech::logged_block(entry.bytes, payload.bytes))
      gathered.add(logged->header, logged->block);
  }
  if (gathered.any()) return gathered.take();
  MIEN_TRY_ASSIGN(std::optional<take::Audio> audio, take.audio());
  if (!audio)
    return fail(ErrorCode::not_found, "the take has no sound", take.path().string(),
                "record one with --audio, or perform one with a voice");
  return Sound{.rate_hz = static_cast<std::uint32_t>(audio->rate_hz), .samples = std::move(audio->samples)};
}

Result<void> write_sound(const std::string& file, const std::string& out) {
  MIEN_TRY(check_output(out, {".wav"}));
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(file));
  MIEN_TRY_ASSIGN(const Sound sound, sound_of(take));
  MIEN_TRY(write_file(out, format_wav(sound)));
  fmt::print("{}: {:.1f} s of sound, {} Hz\n", out, sound.duration_s(), sound.rate_hz);
  return {};
}

}  // namespace

void add_take_command(Commands& commands) {
  const Command parent = commands.add("take", "Looks into takes", "mien take info a.mien", {});
  parent.require_commands(0, 1);
  struct Options {
    std::string file;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();

  const Command info_command = commands.add_under(
      parent, "info", "Shows who performed what, for how long, and how much of each sensor arrived",
      "mien take info a.mien --json", [options] { return info(options->file, options->json); });
  const Command check_command =
      commands.add_under(parent, "check", "Reads all of a take and says whether it is sound",
                         "mien take check a.mien", [options] { return check(options->file, options->json); });
  struct SoundOptions {
    std::string file, out;
  };
  const auto sound_options = std::make_shared<SoundOptions>();
  const Command sound_command =
      commands.add_under(parent, "sound",
                         "Writes what is heard in a take as a WAV file: its microphone's blocks, else the "
                         "sound of the performance",
                         "mien take sound a.mien --out a.wav",
                         [sound_options] { return write_sound(sound_options->file, sound_options->out); });
  sound_command.add_option("take", sound_options->file, "The take").required();
  sound_command.add_option("--out", sound_options->out, "The WAV file").required();

  for (Command command : {info_command, check_command}) {
    command.add_option("take", options->file, "The take").required();
    add_json_flag(command, options->json);
  }
}

}  // namespace mien::app
