#include "mien/dataset/recorded_take.h"

#include <algorithm>
#include <span>
#include <string_view>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/model/features.h"
#include "mien/solve/phone_truth.h"
#include "mien/solve/solve.h"
#include "mien/solve/trace_features.h"
#include "mien/speech/sound_block.h"

namespace mien::dataset {
namespace {

/// Letters of a label, and of what a header says, that an overview keeps.
constexpr std::size_t kOverviewLetters = 60;

/// Whether a take's header names a virtual performer, as `mien perform` writes it: "virtual:SEED".
bool is_virtual_performer(std::string_view name) {
  constexpr std::string_view kVirtual = "virtual:";
  constexpr std::size_t kMostDigits = 20;  // Of 64 bits.
  if (!name.starts_with(kVirtual)) return false;
  name.remove_prefix(kVirtual.size());
  return !name.empty() && name.size() <= kMostDigits &&
         name.find_first_not_of("0123456789") == std::string_view::npos;
}

/// Adds to what there is of a line's labels.
void add_labelled(const session::RecordedLine& line, std::size_t lines, double seconds, TakeOverview& to) {
  const auto add = [&](const std::string& label, LabelAmounts& amounts) {
    if (label.empty()) return;
    LabelAmount& amount = amounts[excerpt(label, kOverviewLetters)];
    amount.lines += lines;
    amount.seconds += seconds;
  };
  add(line.block, to.blocks);
  add(line.emotion, to.emotions);
  add(line.language, to.languages);
}

double frames_as_s(std::size_t frames) {
  return static_cast<double>(frames) / kFrameRateHz;
}

/// What is known of the face at each frame of features, and from which phone.
struct TruthBeside {
  std::vector<take::TruthFrame> frames;
  std::optional<TakeSync> sync;
};

/// The take's own, at the features' times; where it says nothing there is no face.
std::vector<take::TruthFrame> at_features(const std::vector<take::TruthFrame>& truth,
                                          std::span<const model::FeatureFrame> features) {
  std::vector<take::TruthFrame> out;
  out.reserve(features.size());
  auto next = truth.begin();
  for (const model::FeatureFrame& feature : features) {
    while (next != truth.end() && next->time < feature.time) ++next;
    take::TruthFrame& frame = out.emplace_back();
    if (next != truth.end() && next->time == feature.time)
      frame = *next;
    else
      frame = {.time = feature.time, .weights = {}, .has_face = false, .evaluated = false};
  }
  return out;
}

Result<TruthBeside> truth_beside(const take::Take& take, std::span<const take::Event> events,
                                 std::span<const take::StoredSample> samples,
                                 std::span<const model::FeatureFrame> features, bool consented) {
  MIEN_TRY_ASSIGN(const std::vector<take::TruthFrame> own, take.truth());
  if (!own.empty()) return TruthBeside{at_features(own, features), std::nullopt};
  if (!consented)
    return fail(ErrorCode::not_found, "a virtual performer's, without its truth", take.path().string(),
                "perform it with mien perform --take");
  MIEN_TRY_ASSIGN(const solve::PhoneTrack track,
                  solve::phone_track(take.rig(), samples, features.front().time));
  MIEN_TRY_ASSIGN(solve::PhoneTruth truth, solve::phone_truth(events, features, track));
  return TruthBeside{std::move(truth.frames), TakeSync{std::move(truth.alignment), track.left_out_s}};
}

/// Goes through a take's lines frame by frame: which one is shown, and whether it was poor.
class LineSweep {
 public:
  explicit LineSweep(std::span<const session::RecordedLine> lines) {
    for (const session::RecordedLine& line : lines) lines_.push_back(&line);
    // Of those that began together the later one is shown.
    std::ranges::sort(lines_, {},
                      [](const session::RecordedLine* line) { return std::pair(line->begin, line); });
  }
  /// Times ascend.
  void go_to(DeviceTime time) {
    for (; next_ < lines_.size() && lines_[next_]->begin <= time; ++next_) {
      shown_ = lines_[next_];
      if (!shown_->poor.empty()) poor_until_ = std::max(poor_until_.value_or(shown_->end), shown_->end);
    }
    if (shown_ != nullptr && time >= shown_->end) shown_ = nullptr;
    poor_ = poor_until_ && time < *poor_until_;
  }
  [[nodiscard]] bool poor() const { return poor_; }
  /// Null: none.
  [[nodiscard]] const session::RecordedLine* shown() const { return shown_; }

 private:
  std::vector<const session::RecordedLine*> lines_;  // By their beginning.
  std::size_t next_ = 0;
  const session::RecordedLine* shown_ = nullptr;
  std::optional<DeviceTime> poor_until_;
  bool poor_ = false;
};

/// Seconds of sound from `begin` on: what was recorded beside the take, or the blocks of the microphone that
/// was heard most.
Result<double> sound_from(const take::Take& take, std::span<const take::StoredSample> samples,
                          DeviceTime begin) {
  MIEN_TRY_ASSIGN(const std::optional<take::Audio> audio, take.audio());
  if (audio) {
    const double length_s = static_cast<double>(audio->samples.size()) / audio->rate_hz;
    return std::max(0.0, std::min(length_s, length_s - to_seconds(begin - audio->start)));
  }
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  const auto first = std::ranges::lower_bound(ticks, begin, {}, &take::Tick::frame);
  if (first == ticks.end()) return 0.0;
  std::map<std::uint16_t, std::size_t> blocks;
  for (const take::StoredSample& stored : samples)
    if (stored.sample.kind == sensor::SampleKind::sound && stored.entry > first->after_entry)
      ++blocks[stored.sample.sensor];
  std::size_t most = 0;
  for (const auto& [sensor, count] : blocks) most = std::max(most, count);
  return static_cast<double>(most) * to_seconds(speech::kBlockDuration);
}

/// Counts the lines, and gives those that count their places.
std::map<std::string_view, std::int32_t> place_lines(const session::RecordedPart& part, RecordedTake& out) {
  for (const session::RecordedLine* line : session::lines_that_count(part)) out.lines.push_back(*line);
  std::map<std::string_view, std::int32_t> places;
  for (std::size_t i = 0; i < out.lines.size(); ++i) {
    const session::RecordedLine& line = out.lines[i];
    places.emplace(line.name, static_cast<std::int32_t>(i));
    ++(line.poor.empty() ? out.overview.good_lines : out.overview.poor_lines);
    if (line.poor.empty()) add_labelled(line, 1, 0, out.overview);
  }
  return places;
}

/// What the labels of a stretch's frames amount to, and its weights.
void count_stretch(const CountedStretch& stretch, RecordedTake& out) {
  std::map<std::int32_t, std::size_t> frames;
  for (const std::int32_t line : stretch.line)
    if (line >= 0) ++frames[line];
  for (const auto& [place, count] : frames) {
    add_labelled(out.lines[static_cast<std::size_t>(place)], 0, frames_as_s(count), out.overview);
  }
  face::BlendshapeWeights weights;
  for (std::size_t f = 0; f < stretch.sequence.frames; ++f) {
    std::copy_n(stretch.sequence.weights.begin() + static_cast<std::ptrdiff_t>(f * face::kShapeCount),
                face::kShapeCount, weights.values.begin());
    out.weights.add(weights);
  }
}

/// Fills stretches and seconds.
void gather_stretches(std::span<const model::FeatureFrame> features, std::span<const take::TruthFrame> truth,
                      const std::optional<session::RecordedPart>& part, RecordedTake& out) {
  std::map<std::string_view, std::int32_t> places;
  if (part) places = place_lines(*part, out);
  LineSweep lines(part ? std::span<const session::RecordedLine>(part->lines)
                       : std::span<const session::RecordedLine>());
  const Duration longest_step = frame_offset(1) + frame_offset(1) / 2;
  TakeSeconds& seconds = out.overview.seconds;
  constexpr double kFrame_s = 1 / kFrameRateHz;
  CountedStretch stretch;
  const auto close = [&] {
    if (stretch.sequence.frames < kShortestStretchFrames) {
      seconds.brief += frames_as_s(stretch.sequence.frames);
    } else {
      seconds.counted += frames_as_s(stretch.sequence.frames);
      count_stretch(stretch, out);
      out.stretches.push_back(std::move(stretch));
    }
    stretch = {};
  };
  for (std::size_t f = 0; f < features.size(); ++f) {
    const model::FeatureFrame& feature = features[f];
    if (part && (feature.time < part->begin || (part->end && feature.time >= *part->end))) continue;
    lines.go_to(feature.time);
    double* spent = nullptr;  // Where its time belongs if it does not count.
    if (!truth[f].has_face)
      spent = &seconds.without_face;
    else if (!truth[f].evaluated)
      spent = &seconds.before_calibration;
    else if (lines.poor())
      spent = &seconds.poor;
    else if (std::ranges::none_of(feature.sensors, &model::SensorFeature::has_rotation))
      spent = &seconds.unfelt;
    if (spent != nullptr) {
      *spent += kFrame_s;
      close();
      continue;
    }
    if (f > 0 && feature.time - features[f - 1].time > longest_step) close();
    if (stretch.sequence.frames == 0) {
      stretch.begin = feature.time;
      stretch.sequence.from_take = true;
    }
    append_frame(feature.sensors, truth[f].weights, stretch.sequence);
    const auto place = lines.shown() == nullptr ? places.end() : places.find(lines.shown()->name);
    stretch.line.push_back(place == places.end() ? -1 : place->second);
  }
  close();
}

}  // namespace

TakeSeconds& TakeSeconds::operator+=(const TakeSeconds& other) {
  without_face += other.without_face;
  before_calibration += other.before_calibration;
  poor += other.poor;
  unfelt += other.unfelt;
  brief += other.brief;
  counted += other.counted;
  return *this;
}

void TakeTotals::add(const TakeOverview& take) {
  seconds += take.seconds;
  sound_s += take.sound_s;
  good_lines += take.good_lines;
  poor_lines += take.poor_lines;
  const auto add_labels = [](const LabelAmounts& amounts, LabelAmounts& to) {
    for (const auto& [label, amount] : amounts) {
      to[label].lines += amount.lines;
      to[label].seconds += amount.seconds;
    }
  };
  add_labels(take.blocks, blocks);
  add_labels(take.emotions, emotions);
  add_labels(take.languages, languages);
}

Result<TakeIdentity> identify_take(const take::Take& take) {
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  TakeIdentity identity;
  identity.part = session::recorded_part(events);
  if (identity.part)
    identity.performer = identity.part->consent.performer;
  else if (is_virtual_performer(take.header().performer))
    identity.performer = take.header().performer;
  else
    return fail(ErrorCode::not_found, "nobody consented to being in a dataset", take.path().string(),
                "record it as a dataset's, from the page");
  identity.sensors = solve::traced_sensor_names(take.rig());
  if (identity.sensors.empty())
    return fail(ErrorCode::unsupported, "it has no sensors on the skin", take.path().string(),
                "use a take of IMUs");
  return identity;
}

Result<RecordedTake> read_recorded_take(const take::Take& take) {
  MIEN_TRY_ASSIGN(TakeIdentity identity, identify_take(take));
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> features, solve::take_features(take));
  RecordedTake out;
  {
    MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
    MIEN_TRY_ASSIGN(const std::vector<take::StoredSample> samples, take.samples());
    MIEN_TRY_ASSIGN(const TruthBeside truth,
                    truth_beside(take, events, samples, features, identity.part.has_value()));
    out.overview.sync = truth.sync;
    gather_stretches(features, truth.frames, identity.part, out);
    MIEN_TRY_ASSIGN(out.overview.sound_s,
                    sound_from(take, samples, identity.part ? identity.part->begin : features.front().time));
  }
  if (out.stretches.empty())
    return fail(ErrorCode::not_found,
                "nothing in it counts: no two seconds with a face and a sensor, after the calibration and "
                "outside of poor lines",
                take.path().string(), "record it again");
  const take::Header& header = take.header();
  out.overview.path = take.path();
  out.overview.videos = videos_beside(take.path());
  out.overview.performer = std::move(identity.performer);
  if (identity.part) out.overview.consent = std::move(identity.part->consent);
  out.overview.software = excerpt(header.software, kOverviewLetters);
  out.overview.created_utc = excerpt(header.created_utc, kOverviewLetters);
  out.overview.devices = excerpt(header.devices, kOverviewLetters);
  out.overview.rig = excerpt(take.rig().name, kOverviewLetters);
  out.overview.finished = take.finished();
  out.overview.ranges = out.weights.ranges();
  out.first_frame = features.front().time;
  return out;
}

Sequence cut_sequence(const Sequence& sequence, std::size_t sensors, std::size_t first, std::size_t count) {
  Sequence part;
  part.performer = sequence.performer;
  part.lab = sequence.lab;
  part.from_take = sequence.from_take;
  part.slopes = sequence.slopes;
  part.frames = count;
  const auto cut = [&](const auto& from, auto& to, std::size_t width) {
    const auto begin = from.begin() + static_cast<std::ptrdiff_t>(first * width);
    to.assign(begin, begin + static_cast<std::ptrdiff_t>(count * width));
  };
  cut(sequence.values, part.values, 7 * sensors);
  cut(sequence.present, part.present, 2 * sensors);
  cut(sequence.weights, part.weights, face::kShapeCount);
  return part;
}

}  // namespace mien::dataset
