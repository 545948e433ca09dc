#include "mien/shaping/merge.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "mien/shaping/bounds.h"
#include "mien/shaping/fading.h"

namespace mien::shaping {
namespace {

using face::OutputFrame;
using face::Provenance;

/// The place whose order decides over a part of the frame; the tongue goes with the jaw.
constexpr std::array<std::size_t, kPartCount> kPlaces = [] {
  std::array<std::size_t, kPartCount> places{};
  for (std::size_t i = 0; i < face::kShapeCount; ++i)
    places[i] = static_cast<std::size_t>(face::kShapeRegions[i]);
  places[kTonguePart] = static_cast<std::size_t>(MergePlace::jaw);
  places[kHeadPart] = static_cast<std::size_t>(MergePlace::head);
  places[kPositionPart] = static_cast<std::size_t>(MergePlace::head);
  places[kEyesPart] = static_cast<std::size_t>(MergePlace::gaze);
  return places;
}();
/// The tongue has no confidence of its own.
constexpr std::size_t kTongueGoesWith = face::shape("jawOpen");

/// Whether the frame's tracker tells this part; the tongue is told with the jaw, a position with its head.
bool tells(const OutputFrame& frame, std::size_t part) {
  const Provenance provenance = part < face::kShapeCount ? frame.provenance[part]
                                : part == kTonguePart    ? frame.provenance[kTongueGoesWith]
                                : part == kEyesPart      ? frame.eyes_provenance
                                                         : frame.head_provenance;
  return provenance != Provenance::neutral;
}

bool has_estimate(const OutputFrame& frame) {
  const auto estimated = [](Provenance p) { return p != Provenance::neutral; };
  return std::ranges::any_of(frame.provenance, estimated) || estimated(frame.head_provenance) ||
         estimated(frame.eyes_provenance);
}

}  // namespace

std::array<MergeSettings::Order, kMergePlaceCount> MergeSettings::default_order() {
  return {{
      {"camera", "weights", "eyewear", "imu", "speech"},          // brows
      {"camera", "gaze", "weights", "eyewear", "imu", "speech"},  // eyes
      {"imu", "eyewear", "camera", "weights", "speech"},          // cheeks
      {"camera", "weights", "imu", "eyewear", "speech"},          // mouth
      {"camera", "weights", "imu", "eyewear", "speech"},          // jaw
      {"weights", "imu", "camera", "eyewear", "speech"},          // head
      {"camera", "gaze", "weights", "eyewear", "imu", "speech"},  // gaze
  }};
}

Merge::Merge(std::vector<std::string> modalities, const MergeSettings& settings,
             const FallbackSettings& times)
    : modalities_(std::move(modalities)), history_(modalities_.size()) {
  assert(modalities_.size() <= kMostSources);
  for (const std::string& modality : modalities_) listens_.push_back(modality == kListening ? 1 : 0);
  set(settings, times);
  reset();
}

void Merge::set(const MergeSettings& settings, const FallbackSettings& times, bool on) {
  on_ = on;
  if (!on) reset();
  settings_ = settings;
  settings_.sure = settings.sure > 0 ? std::min(settings.sure, 1.0F) : 0.0F;  // NaN becomes 0.
  settings_.unsure = settings.unsure > 0 ? std::min(settings.unsure, settings_.sure) : 0.0F;
  times_ = times.within_range();
  for (std::size_t place = 0; place < kMergePlaceCount; ++place) {
    std::vector<std::uint8_t>& order = order_[place];
    order.clear();
    const auto append = [&](std::size_t source) {
      const auto number = static_cast<std::uint8_t>(source);
      if (std::ranges::find(order, number) == order.end()) order.push_back(number);
    };
    for (const std::string& name : settings_.order[place])
      for (std::size_t s = 0; s < modalities_.size(); ++s)
        if (modalities_[s] == name) append(s);
    for (std::size_t s = 0; s < modalities_.size(); ++s) append(s);
  }
}

void Merge::reset() {
  const OutputFrame neutral = face::neutral_frame({});
  std::ranges::fill(history_, History{.last = neutral, .before = neutral, .earlier = neutral});
  answers_.fill(kNobody);
  leads_.fill(kNobody);
  unsensed_since_.fill(std::nullopt);
  heard_.fill(false);
  turning_since_.fill(std::nullopt);
  gap_.fill(false);
  sensed_.fill(false);
  ease_out_.stop();
  from_ = face::neutral_frame({});
  begun_ = known_ = false;
}

Merge::Vote Merge::vote_of(std::span<const Source> sources, std::size_t which, std::size_t part) const {
  Vote out;
  const Source& source = sources[which];
  const OutputFrame& frame = *source.frame;
  const bool shape = part < face::kShapeCount;
  const Provenance provenance = shape               ? frame.provenance[part]
                                : part == kHeadPart ? frame.head_provenance
                                                    : frame.eyes_provenance;
  out.heard = listens_[which] != 0;
  out.known = source.sensors_present > 0 && !history_[which].warms_up && provenance != Provenance::neutral &&
              (settings_.audio || !out.heard);
  if (shape) {
    const float region = frame.region_confidence[static_cast<std::size_t>(face::kShapeRegions[part])];
    const float said = region > 0 ? region : frame.confidence[part];
    out.share = source.explained != nullptr ? (*source.explained)[part] : said;
    out.measured = source.explained != nullptr || said > 0;
  } else {
    out.share = part == kHeadPart ? frame.head_confidence : frame.eyes_confidence;
  }
  return out;
}

std::uint8_t Merge::choose(std::span<const Source> sources, std::size_t part) const {
  const std::vector<std::uint8_t>& order = order_[kPlaces[part]];
  const std::uint8_t present = answers_[part];
  const auto region = part < face::kShapeCount ? static_cast<std::size_t>(face::kShapeRegions[part])
                                               : face::kShapeRegionCount;
  if (region < face::kShapeRegionCount && heard_[region])
    for (const std::uint8_t s : order)
      if (const Vote vote = vote_of(sources, s, part); vote.known && vote.heard) return s;
  if (region < face::kShapeRegionCount && gap_[region]) return kNobody;
  if (sources.size() == 1) return 0;
  for (const std::uint8_t s : order) {
    const Vote vote = vote_of(sources, s, part);
    if (vote.known && !vote.heard && vote.share >= (s == present ? settings_.unsure : settings_.sure))
      return s;
  }
  const float hysteresis = settings_.sure - settings_.unsure;
  std::uint8_t best = kNobody;
  float most = 0;
  for (const std::uint8_t s : order) {
    // Half a picture of a mouth is worse than sensors that guess the other half: the region goes as a whole.
    if (region < face::kShapeRegionCount && seen_[region] && history_[s].sight[region] == Sight::lost)
      continue;
    const Vote vote = vote_of(sources, s, part);
    // Who explains nothing has no hold on the part: else whoever came first would keep it for good.
    const float score = vote.share + (s == present && vote.share > 0 ? hysteresis : 0);
    if (!vote.known || vote.heard || (best != kNobody && score <= most)) continue;
    best = s;
    most = score;
  }
  return best;
}

void Merge::look_for_sight(std::span<const Source> sources) {
  seen_.fill(false);
  for (std::size_t s = 0; s < sources.size(); ++s) {
    std::array<std::optional<float>, face::kShapeRegionCount> most;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const Vote vote = vote_of(sources, s, k);
      if (!vote.known || vote.heard) continue;
      std::optional<float>& region = most[static_cast<std::size_t>(face::kShapeRegions[k])];
      region = std::max(region.value_or(0), vote.share);
    }
    for (std::size_t r = 0; r < most.size(); ++r) {
      if (!most[r]) continue;
      Sight& sight = history_[s].sight[r];
      if (*most[r] >= settings_.sure)
        sight = Sight::sees;
      else if (sight == Sight::sees && *most[r] < settings_.unsure)
        sight = Sight::lost;
      seen_[r] = seen_[r] || sight == Sight::sees;
    }
  }
}

void Merge::look_for_gaps(std::span<const Source> sources, DeviceTime time) {
  for (const face::ShapeRegion region : {face::ShapeRegion::mouth, face::ShapeRegion::jaw}) {
    const auto r = static_cast<std::size_t>(region);
    float most = 0;
    bool known = false, measured = true;
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      if (face::kShapeRegions[k] != region) continue;
      for (std::size_t i = 0; i < sources.size(); ++i) {
        const Vote vote = vote_of(sources, i, k);
        if (!vote.known || vote.heard) continue;
        known = true;
        measured = measured && vote.measured;
        most = std::max(most, vote.share);
      }
    }
    sensed_[r] = sensed_[r] || (known && most >= settings_.unsure);
    const bool gap = sensed_[r] && known && measured && most < settings_.unsure;
    if (gap == gap_[r])
      turning_since_[r].reset();
    else if (!turning_since_[r])
      turning_since_[r] = time;
    const bool sure = most > 0 && most >= settings_.sure;
    if (turning_since_[r] && (sure || time - *turning_since_[r] >= kUnheard)) {
      gap_[r] = gap;
      turning_since_[r].reset();
    }
    if (most > 0 && most >= (heard_[r] ? settings_.sure : settings_.unsure)) {
      unsensed_since_[r].reset();
      heard_[r] = false;
    } else if (!unsensed_since_[r]) {
      unsensed_since_[r] = time;
    }
    heard_[r] = heard_[r] || (unsensed_since_[r] && time - *unsensed_since_[r] >= kUnheard);
  }
}

std::uint8_t Merge::lead_of(std::size_t region) const {
  // The last place counts the shapes that are faded.
  std::array<std::size_t, kMostSources + 1> shapes{};
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (static_cast<std::size_t>(face::kShapeRegions[k]) == region)
      ++shapes[std::min<std::size_t>(answers_[k], kMostSources)];
  const auto most = std::ranges::max_element(shapes) - shapes.begin();
  return most == kMostSources ? kNobody : static_cast<std::uint8_t>(most);
}

void Merge::copy_regions(std::span<const Source> sources, OutputFrame& out) {
  for (std::size_t r = 0; r < face::kShapeRegionCount; ++r) {
    const std::uint8_t before = std::exchange(leads_[r], lead_of(r));
    if (leads_[r] != kNobody) {
      out.region_confidence[r] = sources[leads_[r]].frame->region_confidence[r];
      continue;
    }
    if (before != kNobody) {
      from_.region_confidence[r] = shown_.region_confidence[r];
      region_since_[r] = shown_.time;
    }
    const Fading fading(to_seconds(out.time - region_since_[r]), times_);
    out.region_confidence[r] = fading.fade(from_.region_confidence[r]);
  }
}

std::size_t Merge::follow(const Source& source, History& history) {
  mend(*source.frame, history.last);
  history.frames = history.told ? history.frames + 1 : 0;
  history.told = source.sensors_present > 0 && has_estimate(*source.frame);
  history.earlier = history.before;
  history.before = history.last;
  history.last = *source.frame;
  if (source.sensors_present == 0) {
    history.warms_up = history.seen;
    history.back_since.reset();
    return 0;
  }
  history.seen = true;
  if (!history.back_since) history.back_since = source.frame->time;
  if (source.frame->time - *history.back_since >= kWarmUp) history.warms_up = false;
  return history.warms_up ? 0 : source.sensors_present;
}

void Merge::change_hands(std::size_t part, const History& next, const OutputFrame& out) {
  const double step_s = to_seconds(shown_.time - shown_before_.time);
  if (next.frames < 2 || step_s <= 0 || !tells(next.before, part) || !tells(next.earlier, part))
    return ease_out_.begin(part, shown_, out);
  ease_out_.begin_moving(part, {shown_before_, shown_}, {next.earlier, next.before}, step_s);
}

std::size_t Merge::apply(std::span<const Source> sources, OutputFrame& out) {
  assert(!sources.empty() && sources.size() == modalities_.size());
  if (!on_) {
    out = *sources.front().frame;
    return sources.front().sensors_present;
  }
  const DeviceTime time = sources.front().frame->time;
  if (begun_ && time <= shown_.time) reset();
  std::size_t there = 0, behind = 0;
  for (std::size_t s = 0; s < sources.size(); ++s) {
    const std::size_t present = follow(sources[s], history_[s]);
    if (listens_[s] != 0 && !settings_.audio) continue;
    there += present;
    if (has_estimate(*sources[s].frame)) behind += present;
  }
  known_ = known_ || behind > 0;
  look_for_sight(sources);
  look_for_gaps(sources, time);

  out.time = time;
  for (std::size_t part = 0; part < kPartCount; ++part) {
    const std::uint8_t before = answers_[part];
    const std::uint8_t now = part == kTonguePart     ? answers_[kTongueGoesWith]
                             : part == kPositionPart ? answers_[kHeadPart]
                                                     : choose(sources, part);
    answers_[part] = now;
    if (now != kNobody) {
      copy_part(*sources[now].frame, part, out);
      if (begun_ && now != before) change_hands(part, history_[now], out);
      continue;
    }
    if (before != kNobody) {
      copy_part(shown_, part, from_);
      since_[part] = shown_.time;
      ease_out_.stop(part);
    }
    Fading(to_seconds(time - since_[part]), times_).apply(part, from_, out);
  }
  copy_regions(sources, out);
  if (begun_) ease_out_.apply(out, to_seconds(time - shown_.time), times_.return_s);
  shown_before_ = begun_ ? shown_ : out;
  shown_ = out;
  begun_ = true;
  return known_ && sources.size() > 1 ? behind : there;
}

}  // namespace mien::shaping
