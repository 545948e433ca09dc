#include "lab/commands/studies.h"

#include <fmt/format.h>

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "app/json_output.h"
#include "app/performance.h"
#include "app/seed_option.h"
#include "lab/commands/output.h"
#include "lab/motion_statistics.h"

namespace mien::lab {
namespace {

struct StudyMotionOptions {
  std::vector<std::string> files;
  VirtualMotionRequest request = {.performers = 0};
  Output to;
};

Result<MotionStatistics> statistics_of(const std::string& file) {
  MIEN_TRY_ASSIGN(app::Performance performance, app::load_performance(file));
  std::string name = app::one_line(performance.motion.name);
  MotionStatistics out = motion_statistics(std::span(&performance.motion, 1), std::move(name));
  if (out.duration_s == 0)
    return fail(ErrorCode::out_of_range, "nothing moves: it has fewer than two frames with a face", file,
                "give a longer performance");
  return out;
}

app::Json motion_json(const MotionStatistics& motion, std::span<const MotionStatistics> compared) {
  app::Json out = {{"name", motion.name}};
  for (const MotionSummary& summary : kMotionSummaries)
    out[std::string(summary.name)] = motion.*summary.value;
  // Names need not differ: in the order of the files.
  out["agreement"] = app::Json::array();
  for (const MotionStatistics& other : compared)
    out["agreement"].push_back(correlation_agreement(motion, other));
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const ShapeStatistics& shape = motion.shapes[k];
    out["shapes"][std::string(face::kShapeNames[k])] = {{"mean", shape.mean},
                                                        {"deviation", shape.deviation},
                                                        {"rest", shape.rest},
                                                        {"p95", shape.p95},
                                                        {"speed_per_s", shape.speed_per_s}};
  }
  return out;
}

Result<void> run_study_motion(const StudyMotionOptions& options) {
  std::vector<MotionStatistics> columns;
  for (const std::string& file : options.files) {
    MIEN_TRY_ASSIGN(columns.emplace_back(), statistics_of(file));
  }
  const std::size_t files = columns.size();
  std::vector<MotionSpread> spreads;
  if (options.request.performers > 0) {
    MIEN_TRY_ASSIGN(const std::vector<VirtualKind> made,
                    virtual_motion(options.request, app::terminal_progress("motion")));
    spreads = motion_spreads(made.back().people, std::span(columns).first(files));
    for (const VirtualKind& kind : made) columns.push_back(mean_statistics(kind.people, kind.name));
  }
  measure::Report report("How performances move");
  for (const measure::Table& table : motion_tables(columns, files)) report.table(table);
  if (!spreads.empty()) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < files; ++i) names.push_back(columns[i].name);
    report.table(spread_table(spreads, names));
  }
  app::Json out = {{"files", options.files},
                   {"performers", options.request.performers},
                   {"seconds", options.request.seconds},
                   {"seed", options.request.seed},
                   {"motions", app::Json::array()}};
  for (const MotionStatistics& column : columns)
    out["motions"].push_back(motion_json(column, std::span(columns).first(files)));
  for (const MotionSpread& spread : spreads)
    out["spreads"].push_back({{"name", spread.name},
                              {"low", spread.low},
                              {"median", spread.median},
                              {"high", spread.high},
                              {"files", spread.compared}});
  return put_out(options.to, report, out);
}

}  // namespace

void add_study_motion(app::Commands& commands, app::Command study) {
  auto options = std::make_shared<StudyMotionOptions>();
  const app::Command command = commands.add_under(
      study, "motion", "How performances move beside each other: range, speed, rest, what moves together",
      "mien study motion real.csv take.mien --performers 20",
      [options] { return run_study_motion(*options); });
  command.add_option("files", options->files, "Live Link Face CSVs, or takes with truth; a column each")
      .required();
  const app::Option performers = command
                                     .add_option("--performers", options->request.performers,
                                                 "Virtual performers; a column for each kind of script")
                                     .in_range(1, 10000);
  command
      .add_option("--seconds", options->request.seconds,
                  "Length of each virtual performance, of each kind of script")
      .number_between(1.0, 3600.0)
      .needs(performers)
      .show_default();
  app::add_seed_option(command, options->request.seed, "Of the virtual performers").needs(performers);
  app::add_json_flag(command, options->to.json);
}

}  // namespace mien::lab
