#include "lab/imu/placement/placement_study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/imu/placement/sensor_candidates.h"
#include "lab/imu/short_training.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/measure/metrics.h"
#include "mien/solve/part_of_work.h"

namespace mien::lab {
namespace {

constexpr double kPlacementTestsShare = 0.12;  // Of the work: who is tested on performs first.
constexpr double kPlacementTrainedShare = 0.92;

/// People of one set's rig whom nobody trained on.
struct PlacementTests {
  std::vector<std::string> sensors;
  std::vector<synthetic::ImuPerson> device, lab;
};

Result<PlacementTests> perform_tests(const PlacementTrainingRequest& request, const sensor::Rig& rig,
                                     const Progress& progress) {
  synthetic::DataRecipe recipe = request.data;
  recipe.seed = Random(request.seed).fork("placement tests").bits() >> 1U;  // As recipe_seed().
  recipe.performers = 0;
  recipe.validation_performers = static_cast<int>(request.test_people);
  recipe.seconds = recipe.device_seconds = request.test_seconds;
  recipe.device_long_share = 0;
  MIEN_TRY_ASSIGN(const dataset::TrainingData data,
                  synthetic::make_dataset(recipe, "builtin", rig, progress, request.threads));
  return PlacementTests{.sensors = data.validation.sensors,
                        .device = synthetic::watched(data.validation),
                        .lab = watched_in_lab(data.validation, request.seed)};
}

Result<void> try_people(const model::ModelFile& model, const PlacementTests& tests,
                        const std::vector<synthetic::ImuPerson>& people, const measure::Meter& meter,
                        unsigned threads, SeedErrors& errors) {
  MIEN_TRY_ASSIGN(
      const std::vector<PersonErrors> of_people,
      errors_of_people(model, tests.sensors, people, meter, synthetic::WindowJoin::overlap, threads));
  errors.add_seed(of_people);
  return {};
}

std::string percent_of(const measure::Interval& change) {
  return fmt::format("{:+.1f} % ({:+.1f} to {:+.1f})", 100 * change.mean, 100 * change.low,
                     100 * change.high);
}

using Eigen::Index;
using Eigen::MatrixXd;

// Where parts of the work end, as shares of it.
constexpr double kBoundDone = 0.05, kPaperSitesDone = 0.08, kPicturesDone = 0.12, kRigsDone = 0.16;

std::vector<SensorCandidate> picked(const std::vector<SensorCandidate>& all,
                                    const std::vector<std::size_t>& indices) {
  std::vector<SensorCandidate> out;
  for (const std::size_t i : indices) out.push_back(all[i]);
  return out;
}

std::array<double, kShapeGroups.size()> group_ratios(const PosteriorOverPrior& ratios) {
  std::array<double, kShapeGroups.size()> sum{}, count{};
  for (std::size_t k = 0; k < ratios.size(); ++k) {
    sum[shape_group(k)] += ratios[k] * ratios[k];
    ++count[shape_group(k)];
  }
  for (std::size_t g = 0; g < sum.size(); ++g) sum[g] = std::sqrt(sum[g] / count[g]);
  return sum;
}

/// Sets by the linear bound on one face.
struct PlacementEvaluator {
  const PlacementRequest& request;
  const face::Face& face;
  measure::Meter meter;
  MatrixXd vertex_gram, gram;

  PlacementEvaluator(const PlacementRequest& asked, const face::Face& on)
      : request(asked),
        face(on),
        meter(on),
        vertex_gram(placement_gram(on, PlacementObjective::vertex)),
        gram(placement_gram(on, asked.objective)) {}

  [[nodiscard]] Result<MatrixXd> slopes(const std::vector<SensorCandidate>& candidates) const {
    MIEN_TRY_ASSIGN(const std::vector<virt::SkinSite> sites, virt::skin_sites(face, sites_rig(candidates)));
    return virt::rotation_slopes(sites, kBoundStep);
  }

  [[nodiscard]] PlacementRow row(std::string title, const std::vector<SensorCandidate>& set,
                                 const MatrixXd& covariance) const {
    PlacementRow row{.title = std::move(title),
                     .sensors = {},
                     .rms_vertex_mm = std::sqrt(expected_squared_error(vertex_gram, covariance)),
                     .bound = bound_of(meter, covariance, request.settings.prior, Random(request.seed)),
                     .group_ratios = {}};
    for (const SensorCandidate& candidate : set) row.sensors.push_back(candidate.name);
    row.group_ratios = group_ratios(row.bound.left);
    return row;
  }

  [[nodiscard]] Result<PlacementRow> row_of(std::string title,
                                            const std::vector<SensorCandidate>& set) const {
    MIEN_TRY_ASSIGN(const MatrixXd rows, slopes(set));
    return row(std::move(title), set,
               posterior_covariance(rows, request.settings.prior, request.settings.noise_rad));
  }
};

Result<std::vector<SensorCandidate>> paper_five(const std::vector<SensorCandidate>& paper,
                                                const std::string& rig_name) {
  std::vector<SensorCandidate> out;
  for (const std::string_view name : kPaperFive) {
    const auto found = std::ranges::find(paper, name, &SensorCandidate::name);
    if (found == paper.end())
      return fail(ErrorCode::not_found, fmt::format("there is no sensor {}", name), rig_name,
                  "use rigs/default.toml");
    out.push_back(*found);
  }
  return out;
}

/// Mean difference of the two sides.
double left_right_difference(const std::vector<SensorCandidate>& candidates,
                             const std::vector<double>& reductions) {
  const std::vector<std::size_t> mirror = mirror_candidates(candidates);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (mirror[i] >= candidates.size() || mirror[i] == i) continue;
    sum += std::abs(reductions[i] - reductions[mirror[i]]);
    ++count;
  }
  const double most = *std::ranges::max_element(reductions);
  return count > 0 && most > 0 ? sum / count / most : 0;
}

std::vector<std::string> names_without_mirror(const std::vector<SensorCandidate>& candidates) {
  const std::vector<std::size_t> mirror = mirror_candidates(candidates);
  std::vector<std::string> out;
  for (std::size_t i = 0; i < mirror.size(); ++i)
    if (mirror[i] >= mirror.size() || mirror[mirror[i]] != i) out.push_back(candidates[i].name);
  return out;
}

/// The sizes of the sets that are trained, each once: the paper's whole set's and its five's.
std::vector<std::size_t> trained_sizes(const PlacementRigs& rigs) {
  std::vector<std::size_t> sizes = {rigs.paper.face_sensors().size()};
  if (sizes.front() != kPaperFive.size()) sizes.push_back(kPaperFive.size());
  return sizes;
}

/// In names of rigs, models and files: the published sizes as words.
std::string size_word(std::size_t size) {
  if (size == 5) return "five";
  return size == 11 ? "eleven" : fmt::format("{}", size);
}

/// PlacementStudy::not_trained, once somebody trains.
std::string not_trained_words(const PlacementBound& bound, const PlacementRigs& rigs) {
  const std::vector<std::size_t> sizes = trained_sizes(rigs);
  std::string missing;
  std::size_t count = 0;
  for (const std::size_t size : sizes) {
    if (bound.of_size(size) != nullptr) continue;
    missing += (count++ > 0 ? " or " : "") + size_word(size);
  }
  if (count == 0) return {};
  if (count < sizes.size())
    return fmt::format("No set of {} sensors was trained: the candidates give none.", missing);
  return fmt::format(
      "No set was trained: only sets of {} sensors are compared, as large as the paper's, and the candidates "
      "give none.",
      missing);
}

/// The sets that are trained, ours and the paper's in turn.
Result<std::vector<PlacementRig>> trained_rigs(const PlacementRequest& request, const PlacementRigs& rigs,
                                               const PlacementStudy& study,
                                               const std::vector<SensorCandidate>& five,
                                               const Progress& progress) {
  const std::size_t whole = rigs.paper.face_sensors().size();
  std::vector<PlacementRig> out;
  for (const std::size_t size : trained_sizes(rigs)) {
    const PlacementSet* ours = study.bound.of_size(size);
    if (ours == nullptr) continue;
    const std::string name = size_word(size);
    const std::string title = fmt::format("greedy {}", name);
    const auto part = [&] {
      const double from = static_cast<double>(out.size()) / 4;
      return solve::part_of_work(progress, from, from + 0.25);
    };
    MIEN_TRY_ASSIGN(sensor::Rig greedy, worn_rig_of(picked(study.candidates, ours->chosen), rigs.paper, title,
                                                    request.skin, part()));
    out.push_back({fmt::format("greedy-{}", name), title, std::move(greedy)});
    sensor::Rig paper = rigs.paper;  // As it stands, but for a part of it.
    if (size != whole) {
      MIEN_TRY_ASSIGN(paper,
                      worn_rig_of(five, rigs.paper, fmt::format("paper's {}", name), request.skin, part()));
    }
    out.push_back({fmt::format("paper-{}", name), fmt::format("the paper's {}", name), std::move(paper)});
  }
  return out;
}

/// What is chosen from, and where else the picture looks.
Result<void> gather_candidates(const PlacementRequest& request, const PlacementRigs& rigs,
                               PlacementStudy& study) {
  MIEN_TRY_ASSIGN(study.candidates, candidates_of(rigs.own ? *rigs.own : rigs.paper_candidates));
  study.grid_begin = study.candidates.size();
  for (SensorCandidate& candidate : dense_candidates(request.spacing_m))
    study.candidates.push_back(std::move(candidate));
  study.choices = rigs.own ? study.grid_begin : study.candidates.size();
  if (study.grid_begin == study.candidates.size())
    return fail(ErrorCode::internal, "no skin was found to look for sites on");
  return {};
}

}  // namespace

Result<std::vector<TrainedPlacement>> train_placements(const PlacementTrainingRequest& request,
                                                       std::span<const PlacementRig> rigs,
                                                       const TrainShort& train, const Progress& progress) {
  const auto count = static_cast<double>(rigs.size());
  std::vector<PlacementTests> tests;
  for (std::size_t r = 0; r < rigs.size(); ++r) {
    const double from = kPlacementTestsShare * static_cast<double>(r) / count;
    MIEN_TRY_ASSIGN(tests.emplace_back(),
                    perform_tests(request, rigs[r].rig,
                                  solve::part_of_work(progress, from, from + kPlacementTestsShare / count)));
  }
  std::vector<ShortTraining> trainings;
  for (const PlacementRig& worn : rigs) {
    const std::string rig_text = sensor::write_rig(worn.rig);
    for (std::size_t s = 0; s < request.seeds; ++s)
      trainings.push_back(
          {.name = fmt::format("{}-{}", worn.name, s + 1),
           .recipe =
               short_recipe({.seed = training_seed(request.seed, s), .steps = request.steps}, request.data),
           .rig = rig_text,
           .data_key =
               fmt::format("placement\n{}long {} moving {}\n{}", data_table(request.data),
                           request.data.device_long_share, request.data.device_moving_share, rig_text),
           .data = [&request, &worn](const Progress& part) {
             return synthetic::make_dataset(request.data, "builtin", worn.rig, part, request.threads);
           }});
  }
  MIEN_TRY_ASSIGN(
      const std::vector<model::ModelFile> trained,
      train(trainings, solve::part_of_work(progress, kPlacementTestsShare, kPlacementTrainedShare)));

  const measure::Meter meter(builtin_face::default_builtin());
  std::vector<TrainedPlacement> out;
  for (std::size_t r = 0; r < rigs.size(); ++r) {
    TrainedPlacement& row = out.emplace_back();
    row.name = rigs[r].name;
    row.title = rigs[r].title;
    row.sensors = rigs[r].rig.face_sensors().size();
    for (std::size_t s = 0; s < request.seeds; ++s) {
      const double done = static_cast<double>(r * request.seeds + s) / static_cast<double>(trained.size());
      if (!progress(kPlacementTrainedShare + (1 - kPlacementTrainedShare) * done, row.title))
        return fail(ErrorCode::cancelled, "stopped", "study placement");
      const model::ModelFile& model = trained[r * request.seeds + s];
      MIEN_TRY(try_people(model, tests[r], tests[r].device, meter, request.threads, row.device));
      MIEN_TRY(try_people(model, tests[r], tests[r].lab, meter, request.threads, row.lab));
    }
  }
  return out;
}

std::string PlacementContest::verdict() const {
  const std::string figures =
      fmt::format("vertex error {} in device, {} in lab; squared error {} and {}", percent_of(device),
                  percent_of(lab), percent_of(device_mse), percent_of(lab_mse));
  if (device.high < 0) return fmt::format("By vertex error {} beats {}: {}.", ours, paper, figures);
  if (device.low > 0)
    return fmt::format("By vertex error {} beats {}, from which {} differs by: {}.", paper, ours, ours,
                       figures);
  return fmt::format("By vertex error neither {} nor {} is better with 95 % confidence: {}.", ours, paper,
                     figures);
}

PlacementContest contest(const TrainedPlacement& ours, const TrainedPlacement& paper) {
  return {.ours = ours.title,
          .paper = paper.title,
          .device = measure::change_interval(ours.device.pve_mm, paper.device.pve_mm),
          .lab = measure::change_interval(ours.lab.pve_mm, paper.lab.pve_mm),
          .device_mse = measure::change_interval(ours.device.mse, paper.device.mse),
          .lab_mse = measure::change_interval(ours.lab.mse, paper.lab.mse)};
}

std::vector<SensorCandidate> PlacementStudy::chosen_candidates() const {
  return picked(candidates, chosen);
}

Result<PlacementStudy> study_placement(const PlacementRequest& request, const face::Face& face,
                                       const PlacementRigs& rigs, const TrainShort* train,
                                       const Progress& progress) {
  const auto stopped = [&](double share, std::string_view what) { return !progress(share, what); };
  const auto cancelled = [] { return fail(ErrorCode::cancelled, "stopped", "study placement"); };
  if (stopped(0, "candidates")) return cancelled();
  PlacementStudy study;
  MIEN_TRY(gather_candidates(request, rigs, study));
  MIEN_TRY_ASSIGN(const std::vector<SensorCandidate> paper, candidates_of(rigs.paper));
  MIEN_TRY_ASSIGN(const std::vector<SensorCandidate> five, paper_five(paper, rigs.paper.name));
  const PlacementEvaluator evaluator(request, face);
  MIEN_TRY_ASSIGN(const MatrixXd slopes, evaluator.slopes(study.candidates));
  if (stopped(kBoundDone / 3, "bound")) return cancelled();

  const std::vector<SensorCandidate> choices(
      study.candidates.begin(), study.candidates.begin() + static_cast<std::ptrdiff_t>(study.choices));
  PlacementSettings settings = request.settings;
  settings.most = std::max(settings.most, request.sensors);
  MIEN_TRY_ASSIGN(study.bound, bound_placement(choices, slopes.topRows(3 * static_cast<Index>(study.choices)),
                                               evaluator.gram, settings));
  const PlacementSet* chosen = study.bound.of_size(request.sensors);
  if (chosen == nullptr) {
    std::vector<std::size_t> sizes;
    for (const PlacementSet& set : study.bound.sets) sizes.push_back(set.chosen.size());
    return fail(ErrorCode::bad_usage,
                fmt::format("these candidates give no set of {} sensors, but of {}", request.sensors,
                            fmt::join(sizes, ", ")),
                rigs.own ? rigs.own->name : "the grid",
                "say so by --sensors, give more candidates, or let each side be for itself (--one-sided)");
  }
  if (!settings.one_sided) study.without_mirror = names_without_mirror(choices);
  study.chosen = chosen->chosen;
  const MatrixXd prior = prior_covariance(settings.prior);
  study.alone = error_reductions(evaluator.gram, prior, slopes, settings.noise_rad);
  for (std::size_t i = 0; i < study.candidates.size(); ++i)
    study.alone_posterior.push_back(posterior_over_prior(
        posterior_with(prior, slopes.middleRows(3 * static_cast<Index>(i), 3), settings.noise_rad),
        settings.prior));
  study.left_right = left_right_difference(study.candidates, study.alone);
  for (const PlacementSet& set : study.bound.sets) {
    const double done = static_cast<double>(study.sets.size()) / static_cast<double>(study.bound.sets.size());
    if (stopped(kBoundDone * (1 + 2 * done) / 3, "bound")) return cancelled();
    study.sets.push_back(evaluator.row(fmt::format("greedy {}", set.chosen.size()),
                                       picked(study.candidates, set.chosen), set.covariance));
  }
  MIEN_TRY_ASSIGN(study.paper, evaluator.row_of(fmt::format("the paper's {}", paper.size()), paper));
  MIEN_TRY_ASSIGN(study.paper_five, evaluator.row_of("the paper's 5", five));
  MIEN_TRY_ASSIGN(study.paper_sites,
                  study_paper_sites(request.paper_sites, rigs.paper_candidates,
                                    solve::part_of_work(progress, kBoundDone, kPaperSitesDone)));
  if (stopped(kPaperSitesDone, "picture")) return cancelled();
  std::vector<Vec3> grid_m, chosen_m;
  for (std::size_t i = study.grid_begin; i < study.candidates.size(); ++i)
    grid_m.push_back(study.candidates[i].position_m);
  for (const std::size_t i : study.chosen) chosen_m.push_back(study.candidates[i].position_m);
  MIEN_TRY_ASSIGN(study.picture, placement_picture(grid_m, std::span(study.alone).subspan(study.grid_begin),
                                                   chosen_m, request.spacing_m, request.picture_px));
  if (train == nullptr) {
    progress(1, "done");
    return study;
  }
  study.not_trained = not_trained_words(study.bound, rigs);
  MIEN_TRY_ASSIGN(
      const std::vector<PlacementRig> worn,
      trained_rigs(request, rigs, study, five, solve::part_of_work(progress, kPicturesDone, kRigsDone)));
  if (!worn.empty()) {
    MIEN_TRY_ASSIGN(study.trained, train_placements(request.training, worn, *train,
                                                    solve::part_of_work(progress, kRigsDone, 1)));
  }
  for (std::size_t i = 0; i + 1 < study.trained.size(); i += 2)
    study.contests.push_back(contest(study.trained[i], study.trained[i + 1]));
  return study;
}

std::string top_shapes(const PosteriorOverPrior& posterior, std::size_t most) {
  std::vector<std::pair<double, std::size_t>> reductions;
  for (std::size_t k = 0; k < posterior.size(); ++k)
    reductions.emplace_back(1 - posterior[k] * posterior[k], k);
  std::ranges::sort(reductions, [](const auto& a, const auto& b) {
    return std::pair(-a.first, a.second) < std::pair(-b.first, b.second);
  });
  std::string out;
  for (std::size_t i = 0; i < std::min(most, reductions.size()) && reductions[i].first >= 0.1; ++i)
    out += fmt::format("{}{} {:.0f} %", i > 0 ? ", " : "", face::kShapeNames[reductions[i].second],
                       100 * reductions[i].first);
  return out.empty() ? "little of anything" : out;
}

}  // namespace mien::lab
