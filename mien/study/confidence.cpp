#include "mien/study/confidence.h"

#include <algorithm>
#include <cmath>

#include "mien/study/confidence_fit.h"
#include "mien/study/performers.h"
#include "mien/tracker/provenance.h"

namespace mien::study {
namespace {

constexpr std::size_t kLosses = 6;
constexpr std::array<std::size_t, 4> kStudiedLosses = {0, 1, 3, 6};

Result<ConfidenceFit> fit_person(const WatchedPerson& person, Random random) {
  ConfidenceFit fit;
  for (std::size_t i = 0; i <= kLosses; ++i) {
    const std::size_t lost = i == 0 ? 0 : 1 + random.below(person.sensor_count());
    MIEN_TRY_ASSIGN(const Watched seen, person.watch(lost, random.fork("lost", i)));
    for (std::size_t f = 0; f < seen.answer.size(); ++f)
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        fit.add(k, seen.coverage[f][k], seen.answer[f][k], seen.truth[f][k]);
    fit.end_person();
  }
  return fit;
}

/// Measured frames of one person, shape by shape.
void follow(const std::array<Correlation, face::kShapeCount>& shapes, Followed& out) {
  for (const Correlation& shape : shapes) {
    if (!shape.speaks()) continue;
    ++out.pairs;
    out.good += shape.r() >= kMeasuredCorrelation ? 1 : 0;
  }
}

Result<ConfidenceRow> study_person(const tracker::ShapeConfidence& confidence, const WatchedPerson& person,
                                   std::size_t lost, const Random& random) {
  MIEN_TRY_ASSIGN(const Watched seen, person.watch(lost, random));
  ConfidenceRow row{.lost = lost, .people = 1, .frames = seen.answer.size()};
  std::array<Correlation, face::kShapeCount> now{}, before{};
  face::OutputFrame frame;
  for (std::size_t f = 0; f < seen.answer.size(); ++f) {
    frame.weights = seen.answer[f];
    confidence.write(seen.coverage[f], frame);
    const bool there = std::ranges::any_of(seen.coverage[f], [](float share) { return share > 0; });
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const float estimate = frame.weights[k], truth = seen.truth[f][k];
      const bool within = std::abs(estimate - truth) <= model::kConfidenceTolerance;
      row.all.add(frame.confidence[k], within);
      if (estimate > model::kConfidenceTolerance) row.moving.add(frame.confidence[k], within);
      row.all_before.add(seen.coverage[f][k], within);
      if (there && !tracker::is_gaze(k)) before[k].add(truth, estimate);
      if (frame.provenance[k] != face::Provenance::measured) continue;
      row.measured += 1;
      row.gaze_measured += tracker::is_gaze(k) ? 1 : 0;
      now[k].add(truth, estimate);
    }
  }
  follow(now, row.followed);
  follow(before, row.followed_before);
  row.single = {row.all.expected_error()};
  return row;
}

/// Adds what was counted of another person.
void add(const ConfidenceRow& one, ConfidenceRow& row) {
  row.people += one.people;
  row.frames += one.frames;
  row.measured += one.measured;
  row.gaze_measured += one.gaze_measured;
  row.followed.pairs += one.followed.pairs;
  row.followed.good += one.followed.good;
  row.followed_before.pairs += one.followed_before.pairs;
  row.followed_before.good += one.followed_before.good;
  row.all.add(one.all);
  row.moving.add(one.moving);
  row.all_before.add(one.all_before);
  row.single.insert(row.single.end(), one.single.begin(), one.single.end());
}

}  // namespace

Result<model::ConfidenceTable> measure_confidence(const WatchedGroup& group, std::uint64_t seed,
                                                  const Progress& progress, unsigned threads) {
  if (group.people.empty()) return fail(ErrorCode::not_found, "nobody is there to measure confidence on");
  std::vector<ConfidenceFit> fits(group.people.size());
  MIEN_TRY(for_each_performer(fits.size(), threads, progress, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(fits[p], fit_person(*group.people[p], Random(seed).fork("confidence", p)));
    return {};
  }));
  for (std::size_t p = 1; p < fits.size(); ++p) fits.front().add(fits[p]);
  model::ConfidenceTable table = fits.front().table();
  table.people = group.people.size();
  table.seed = seed;
  return table;
}

void Reliability::add(float confidence, bool within) {
  const auto bin = static_cast<std::size_t>(confidence * kBins);
  Bin& into = bins_[std::min(bin, kBins - 1)];
  into.frames += 1;
  into.confidence += confidence;
  into.within += within ? 1 : 0;
}

void Reliability::add(const Reliability& other) {
  for (std::size_t b = 0; b < kBins; ++b) {
    bins_[b].frames += other.bins_[b].frames;
    bins_[b].confidence += other.bins_[b].confidence;
    bins_[b].within += other.bins_[b].within;
  }
}

double Reliability::expected_error() const {
  double frames = 0, error = 0;
  for (const Bin& bin : bins_) {
    frames += bin.frames;
    error += std::abs(bin.confidence - bin.within);
  }
  return frames > 0 ? error / frames : 0;
}

Result<std::vector<ConfidenceRow>> study_confidence(const model::ConfidenceTable& table,
                                                    const std::vector<WatchedGroup>& groups,
                                                    std::uint64_t seed, const Progress& progress,
                                                    unsigned threads) {
  const tracker::ShapeConfidence confidence(table);
  std::vector<ConfidenceRow> rows;
  for (const WatchedGroup& group : groups) {
    const std::size_t people = group.people.size();
    std::vector<ConfidenceRow> each(people * kStudiedLosses.size());
    MIEN_TRY(for_each_performer(each.size(), threads, progress, [&](std::size_t i) -> Result<void> {
      const WatchedPerson& person = *group.people[i % people];
      const std::size_t lost = std::min(kStudiedLosses[i / people], person.sensor_count());
      const Random random = Random(seed).fork("lost", lost).fork("person", i % people);
      MIEN_TRY_ASSIGN(each[i], study_person(confidence, person, lost, random));
      return {};
    }));
    for (std::size_t l = 0; people > 0 && l < kStudiedLosses.size(); ++l) {
      ConfidenceRow& row = rows.emplace_back();
      row.who = group.who;
      row.lost = each[l * people].lost;
      for (std::size_t p = 0; p < people; ++p) add(each[l * people + p], row);
      std::ranges::sort(row.single);
      row.measured /= std::max(1.0, static_cast<double>(row.frames * face::kShapeCount));
    }
  }
  if (rows.empty()) return fail(ErrorCode::not_found, "nobody is there to study confidence on");
  return rows;
}

bool kept(const ConfidenceRow& row) {
  return row.all.expected_error() <= kErrorAllowed && row.followed.share() >= kMeasuredShare &&
         row.gaze_measured == 0;
}

}  // namespace mien::study
