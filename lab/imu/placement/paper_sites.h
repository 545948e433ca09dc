#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "lab/imu/placement/sensor_candidates.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// A candidate of CAPUS's Table 2: "the variations times 10^-3" of the acceleration there while its area
/// moves, without a unit; whether its rig uses it (bold). Source: arXiv:2402.03944v4.
struct PaperSite {
  std::string_view area;  ///< A row of the table.
  int number = 0;         ///< Its column, from 1.
  double variation = 0;   ///< As printed.
  bool used = false;
  std::string_view name;  ///< In rigs/candidates.toml, without the side.
};

inline constexpr std::array<PaperSite, 13> kPaperSites = {{
    {"frontalis", 1, 0.71, true, "frontalis_1"},
    {"frontalis", 2, 0.57, false, "frontalis_2"},
    {"frontalis", 3, 0.52, false, "frontalis_3"},
    {"frontalis", 4, 0.58, false, "frontalis_4"},
    {"zygomaticus", 1, 0.64, true, "zygomaticus_1"},
    {"zygomaticus", 2, 1.20, true, "zygomaticus_2"},
    {"zygomaticus", 3, 0.57, false, "zygomaticus_3"},
    {"zygomaticus", 4, 0.32, false, "zygomaticus_4"},
    {"buccinator / mentalis", 1, 0.84, false, "buccinator_mentalis_1"},
    {"buccinator / mentalis", 2, 1.38, true, "buccinator_mentalis_2"},
    {"buccinator / mentalis", 3, 0.54, false, "buccinator_mentalis_3"},
    {"buccinator / mentalis", 4, 0.88, false, "buccinator_mentalis_4"},
    {"buccinator / mentalis", 5, 1.77, true, "buccinator_mentalis_5"},
}};
inline constexpr std::array<std::string_view, 3> kPaperAreas = {"frontalis", "zygomaticus",
                                                                "buccinator / mentalis"};

/// Who moves the areas: virtual people of the built-in family, whose skin is unlike the standard one by an
/// even share of virt::KinematicsSpread. A movement rises within `rise_s` by minimum jerk, is held for half
/// of that, and falls likewise.
struct PaperSitesRequest {
  std::size_t performers = 24;  ///< 1 or more.
  double rise_s = 0.4;          ///< Above 0.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// What a candidate of the table feels while its area moves, the mean over people, movements and sides.
struct PaperSiteFelt {
  PaperSite site;
  double acceleration = 0;   ///< Variance of the skin's acceleration, (m/s^2)^2.
  double accelerometer = 0;  ///< Of what an accelerometer reads, in its own axes: gravity as it tilts, too.
  double rotation_deg = 0;   ///< RMS of the skin's rotation.
};

/// Rank correlation with the table (Spearman): of each area, and of all candidates as shares of their area's
/// mean.
struct PaperAgreement {
  std::array<double, kPaperAreas.size()> areas{};
  double all = 0;
};

struct PaperSitesStudy {
  std::vector<PaperSiteFelt> sites;  ///< In the table's order; those that the rig lacks are left out.
  PaperAgreement acceleration, accelerometer, rotation;
};

/// `rig`: sensors of the table's names with "_L" and "_R", or without on the midline. Errors: bad_usage (none
/// of them is there); those of the sites; cancelled. The same for any number of threads.
[[nodiscard]] Result<PaperSitesStudy> study_paper_sites(const PaperSitesRequest& request,
                                                        const sensor::Rig& rig, const Progress& progress);

/// The table's site that a candidate is, by its name; nullptr for any other candidate.
[[nodiscard]] const PaperSite* paper_site_of(const SensorCandidate& candidate);

/// Spearman's rank correlation; ties have their mean rank. 0 where either does not vary. Of equal size.
[[nodiscard]] double rank_correlation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace mien::lab
