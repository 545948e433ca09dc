#include "lab/imu/ablation/ablation_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>
#include <utility>

#include "lab/imu/paper_five.h"
#include "mien/core/nearest_word.h"

namespace mien::lab {
namespace {

/// A region of muscles, as the paper divides the face, and the sites that lie there.
struct MuscleRegion {
  const char* name;
  const char* title;
  std::array<const char*, 2> sites;
};
constexpr std::array kMuscleRegions = {
    MuscleRegion{"no_frontalis", "without the forehead (frontalis)", {"frontalis", "frontalis"}},
    MuscleRegion{"no_orbicularis", "without the eyes (orbicularis oculi)", {"orbicularis", "orbicularis"}},
    MuscleRegion{
        "no_zygomaticus", "without the cheeks (zygomaticus)", {"zygomaticus_upper", "zygomaticus_lower"}},
    MuscleRegion{
        "no_buccinator", "without mouth and chin (buccinator, mentalis)", {"buccinator", "mentalis"}}};

using IsKept = std::function<bool(const sensor::Mount&)>;

std::vector<std::string> kept(const sensor::Rig& rig, const IsKept& is_kept) {
  std::vector<std::string> names;
  for (const std::uint16_t s : rig.face_sensors())
    if (is_kept(rig.sensors[s])) names.push_back(rig.sensors[s].name);
  return names;
}

using FiveNames = std::array<std::string_view, 5>;

class RowTable {
 public:
  explicit RowTable(const sensor::Rig& rig) : rig_(rig), all_(rig.face_sensor_names()) {}

  /// A row of five sensors; none where the rig lacks one of them.
  void add_five(std::string name, std::string title, const FiveNames& five) {
    const auto has = [&](std::string_view sensor) { return std::ranges::find(all_, sensor) != all_.end(); };
    if (!std::ranges::all_of(five, has)) return;
    add_sensors(std::move(name), std::move(title), [&](const sensor::Mount& mount) {
      return std::ranges::find(five, mount.name) != five.end();
    });
  }

  /// A row of fewer sensors; none where that leaves all of them, or none.
  void add_sensors(std::string name, std::string title, const IsKept& is_kept) {
    std::vector<std::string> names = kept(rig_, is_kept);
    if (names.empty() || names.size() == all_.size()) return;
    title = fmt::format("{} ({})", title, names.size());
    rows_.push_back({.name = std::move(name),
                     .group = "sensors",
                     .title = std::move(title),
                     .sensors = std::move(names)});
  }
  void add(AblationRow row) {
    row.sensors = all_;
    rows_.push_back(std::move(row));
  }
  [[nodiscard]] std::vector<AblationRow> rows() && { return std::move(rows_); }
  [[nodiscard]] std::size_t sensors() const { return all_.size(); }

 private:
  const sensor::Rig& rig_;
  std::vector<std::string> all_;
  std::vector<AblationRow> rows_;
};

}  // namespace

std::vector<AblationRow> ablation_rows(const sensor::Rig& rig, bool stand_ins) {
  RowTable table(rig);
  table.add({.name = std::string(kAblationBase),
             .group = "sensors",
             .title = fmt::format("all {} sensors, all data, recurrent", table.sensors())});
  table.add_five("five_sensors", "the paper's five, at the lower cheeks", kPaperFive);
  table.add_five("five_upper", "the paper's five, at the upper cheeks", kPaperFiveUpper);
  for (const MuscleRegion& region : kMuscleRegions)
    table.add_sensors(region.name, region.title, [&](const sensor::Mount& mount) {
      return std::ranges::find(region.sites, mount.site) == region.sites.end();
    });
  table.add_sensors("one_side", "the left half",
                    [](const sensor::Mount& mount) { return mount.side != 'R'; });

  table.add({.name = "third_of_people", .group = "data", .title = "a third of the people", .one_in = 3});
  table.add({.name = "tenth_of_people", .group = "data", .title = "a tenth of the people", .one_in = 10});
  table.add({.name = "takes_alone",
             .group = "data",
             .title = stand_ins ? "stand-ins for takes alone" : "people's takes alone",
             .learns_from = LearnsFrom::takes});
  table.add({.name = "takes_too",
             .group = "data",
             .title = stand_ins ? "performers and stand-ins for takes" : "performers and people's takes",
             .learns_from = LearnsFrom::both});

  table.add({.name = "no_difference",
             .group = "networks",
             .title = "recurrent, changes not in its loss",
             .difference_weight = 0});
  table.add({.name = "transformer",
             .group = "networks",
             .title = "transformer, sees 2 s at once",
             .network = ShortNetwork::transformer});
  table.add({.name = "diffusion",
             .group = "networks",
             .title = "diffusion, sees 2 s, overlapping",
             .network = ShortNetwork::diffusion});
  table.add({.name = "no_overlap",
             .group = "networks",
             .title = "diffusion, sees 2 s, side by side",
             .network = ShortNetwork::diffusion,
             .join = synthetic::WindowJoin::side_by_side});

  for (const std::size_t window : {30, 60, 240})
    table.add({.name = fmt::format("window_{}", window),
               .group = "windows",
               .title = fmt::format("trained on {:.3g} s at a time instead of 2 s",
                                    static_cast<double>(window) / 60),
               .window = window});
  return std::move(table).rows();
}

Result<std::vector<AblationRow>> chosen_rows(const sensor::Rig& rig, bool stand_ins,
                                             std::span<const std::string> names) {
  std::vector<AblationRow> all = ablation_rows(rig, stand_ins);
  if (names.empty()) return all;
  std::vector<std::string> known;
  for (const AblationRow& row : all) known.push_back(row.name);
  for (const std::string& name : names)
    if (std::ranges::find(known, name) == known.end())
      return fail(ErrorCode::not_found, fmt::format("there is no row {}{}", name, did_you_mean(name, known)),
                  "--rows", fmt::format("the rows are {}", fmt::join(known, ", ")));
  std::erase_if(all, [&](const AblationRow& row) {
    return row.name != kAblationBase && std::ranges::find(names, row.name) == names.end();
  });
  return all;
}

}  // namespace mien::lab
