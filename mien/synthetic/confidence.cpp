#include "mien/synthetic/confidence.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mien/synthetic/confidence_fit.h"
#include "mien/synthetic/logistic_fit.h"
#include "mien/tracker/shape_confidence.h"
#include "mien/virtual/performers.h"

namespace mien::synthetic {
namespace {

constexpr std::size_t kLosses = 6;
constexpr std::array<std::size_t, 4> kStudiedLosses = {0, 1, 3, 6};

/// A person with all sensors, then without some: `random` is drawn from in that order.
Result<Watched> watch_loss(const WatchedPerson& person, std::size_t number, Random& random) {
  const std::size_t lost = number == 0 ? 0 : 1 + random.below(person.sensor_count());
  return person.watch(lost, random.fork("lost", number));
}

Result<ConfidenceFit> fit_person(const WatchedPerson& person, Random random) {
  ConfidenceFit fit;
  for (std::size_t i = 0; i <= kLosses; ++i) {
    MIEN_TRY_ASSIGN(const Watched seen, watch_loss(person, i, random));
    for (std::size_t f = 0; f < seen.answer.size(); ++f)
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        fit.add(k, seen.coverage[f][k], seen.answer[f][k], seen.truth[f][k]);
    fit.end_person();
  }
  return fit;
}

using RegionFits = std::array<LogisticFit, face::kShapeRegionCount>;

void add(const tracker::ShapeConfidence& confidence, const Watched& seen, RegionFits& fits) {
  for (std::size_t f = 0; f < seen.answer.size(); ++f) {
    const tracker::RegionScores scores = confidence.region_scores(seen.coverage[f], seen.answer[f]);
    const auto within = solve::regions_within(seen.answer[f], seen.truth[f]);
    for (std::size_t r = 0; r < fits.size(); ++r) fits[r].add(scores[r], within[r]);
  }
}

/// Measured frames of one person, shape by shape.
void follow(const std::array<Correlation, face::kShapeCount>& shapes, Followed& out) {
  for (const Correlation& shape : shapes) {
    if (!shape.speaks()) continue;
    ++out.pairs;
    out.good += shape.r() >= kMeasuredCorrelation ? 1 : 0;
  }
}

ConfidenceRow study_person(const tracker::ShapeConfidence& confidence, const Watched& seen) {
  ConfidenceRow row;
  row.people = 1;
  row.frames = seen.answer.size();
  std::array<Correlation, face::kShapeCount> now{}, before{};
  face::OutputFrame frame;
  for (std::size_t f = 0; f < seen.answer.size(); ++f) {
    frame.weights = seen.answer[f];
    confidence.write(seen.coverage[f], frame);
    row.regions.add(frame, seen.truth[f]);
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
  row.regions_single = {row.regions.all.expected_error()};
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
  row.regions.add(one.regions);
  row.regions_single.insert(row.regions_single.end(), one.regions_single.begin(), one.regions_single.end());
}

/// From the sums over people to what the row says.
void finish(ConfidenceRow& row) {
  std::ranges::sort(row.single);
  std::ranges::sort(row.regions_single);
  row.measured /= std::max(1.0, static_cast<double>(row.frames * face::kShapeCount));
}

}  // namespace

Result<model::ConfidenceTable> measure_confidence(const WatchedGroup& group, std::uint64_t seed,
                                                  const Progress& progress, unsigned threads) {
  if (group.people.empty()) return fail(ErrorCode::not_found, "nobody is there to measure confidence on");
  std::vector<ConfidenceFit> fits(group.people.size());
  MIEN_TRY(virt::for_each_performer(fits.size(), threads, progress, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(fits[p], fit_person(*group.people[p], Random(seed).fork("confidence", p)));
    return {};
  }));
  for (std::size_t p = 1; p < fits.size(); ++p) fits.front().add(fits[p]);
  model::ConfidenceTable table = fits.front().table();
  table.people = group.people.size();
  table.seed = seed;
  return table;
}

Result<model::RegionMaps> fit_regions(const model::ConfidenceTable& table, const WatchedGroup& group,
                                      const std::vector<FaultyGroup>& faulty, std::uint64_t seed,
                                      const Progress& progress, unsigned threads) {
  std::vector<std::shared_ptr<const FaultyPerson>> troubled;
  for (const FaultyGroup& one : faulty) troubled.insert(troubled.end(), one.people.begin(), one.people.end());
  const std::size_t sound = group.people.size();
  if (sound + troubled.size() == 0)
    return fail(ErrorCode::not_found, "nobody is there to measure confidence on");
  const tracker::ShapeConfidence confidence(table);
  std::vector<RegionFits> fits(sound + troubled.size());
  MIEN_TRY(virt::for_each_performer(fits.size(), threads, progress, [&](std::size_t p) -> Result<void> {
    const auto see = [&](const Watched& seen) { add(confidence, seen, fits[p]); };
    if (p >= sound)
      return troubled[p - sound]->watch_each([&](std::size_t, const Watched& seen) { see(seen); });
    const WatchedPerson& person = *group.people[p];
    Random random = Random(seed).fork("confidence", p);
    for (std::size_t i = 0; i <= kLosses; ++i) {
      MIEN_TRY_ASSIGN(const Watched seen, watch_loss(person, i, random));
      see(seen);
    }
    return {};
  }));
  model::RegionMaps maps;
  for (std::size_t r = 0; r < maps.size(); ++r) {
    for (std::size_t p = 1; p < fits.size(); ++p) fits.front()[r].add(fits[p][r]);
    maps[r] = fits.front()[r].solve();
  }
  return maps;
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
    MIEN_TRY(virt::for_each_performer(each.size(), threads, progress, [&](std::size_t i) -> Result<void> {
      const WatchedPerson& person = *group.people[i % people];
      const std::size_t lost = std::min(kStudiedLosses[i / people], person.sensor_count());
      const Random random = Random(seed).fork("lost", lost).fork("person", i % people);
      MIEN_TRY_ASSIGN(const Watched seen, person.watch(lost, random));
      each[i] = study_person(confidence, seen);
      each[i].lost = lost;
      return {};
    }));
    for (std::size_t l = 0; people > 0 && l < kStudiedLosses.size(); ++l) {
      ConfidenceRow& row = rows.emplace_back();
      row.who = group.who;
      row.lost = each[l * people].lost;
      for (std::size_t p = 0; p < people; ++p) add(each[l * people + p], row);
      finish(row);
    }
  }
  if (rows.empty()) return fail(ErrorCode::not_found, "nobody is there to study confidence on");
  return rows;
}

Result<std::vector<ConfidenceRow>> study_faults(const model::ConfidenceTable& table,
                                                const std::vector<FaultyGroup>& groups,
                                                const Progress& progress, unsigned threads) {
  const tracker::ShapeConfidence confidence(table);
  std::vector<ConfidenceRow> rows;
  for (const FaultyGroup& group : groups) {
    const std::size_t people = group.people.size(), faults = group.faults.size();
    std::vector<ConfidenceRow> each(people * faults);
    MIEN_TRY(virt::for_each_performer(people, threads, progress, [&](std::size_t p) {
      return group.people[p]->watch_each([&](std::size_t fault, const Watched& seen) {
        each[p * faults + fault] = study_person(confidence, seen);
      });
    }));
    for (std::size_t f = 0; people > 0 && f < faults; ++f) {
      ConfidenceRow& row = rows.emplace_back();
      row.who = group.who;
      row.fault = group.faults[f];
      for (std::size_t p = 0; p < people; ++p) add(each[p * faults + f], row);
      finish(row);
    }
  }
  return rows;
}

bool kept(const ConfidenceRow& row) {
  return row.all.expected_error() <= kErrorAllowed && row.followed.share() >= kMeasuredShare &&
         row.gaze_measured == 0;
}

bool regions_kept(const ConfidenceRow& row) {
  return row.regions.all.expected_error() <= kErrorAllowed;
}

}  // namespace mien::synthetic
