#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "app/dataset_text.h"
#include "app/json_output.h"
#include "app/seed_option.h"
#include "mien/core/files.h"
#include "mien/dataset/export_windows.h"
#include "mien/dataset/recorded_dataset.h"
#include "mien/dataset/splits.h"

namespace mien::app {
namespace {

Result<dataset::RecordedDataset> read_folder(const std::string& folder) {
  const Progress progress = terminal_progress("dataset");
  MIEN_TRY_ASSIGN(const dataset::FoundTakes found, dataset::find_takes(folder, {}, progress));
  auto dataset = dataset::read_dataset(found, progress);
  clear_progress();
  return dataset;
}

Result<void> list_dataset(const std::string& folder, bool json) {
  if (folder.empty())
    return fail(ErrorCode::bad_usage, "it was not said which folder", "dataset",
                "write mien dataset FOLDER; see mien dataset --help");
  MIEN_TRY_ASSIGN(const dataset::RecordedDataset dataset, read_folder(folder));
  if (json)
    print_json(json_of(dataset));
  else
    print_dataset(dataset);
  return {};
}

struct SplitOptions {
  std::string folder, out;
  dataset::SplitShares shares;
  std::uint64_t seed = 1;
  bool force = false;
  bool json = false;
};

/// What few people cannot be split into; empty: nothing is missing.
std::string few_people(const dataset::Splits& splits, const dataset::SplitShares& shares) {
  const bool validates = !splits.of(dataset::Split::validation).empty() || shares.validation == 0;
  const bool tests = !splits.of(dataset::Split::test).empty() || shares.test == 0;
  if (validates && tests) return {};
  const std::size_t people =
      splits.of(dataset::Split::train).size() + splits.of(dataset::Split::validation).size();
  return people == 1 ? "one person alone trains; nobody validates, and nobody is kept for the test"
                     : "two people are too few for a test: nobody is kept for it";
}

Result<void> split_dataset(const SplitOptions& options) {
  MIEN_TRY(check_output(options.out, {".toml"}));
  MIEN_TRY(dataset::check_shares(options.shares));
  if (!options.force && std::filesystem::exists(options.out))
    return fail(ErrorCode::bad_usage, "it exists already", options.out, "use --force to replace it");
  MIEN_TRY_ASSIGN(const dataset::RecordedDataset dataset, read_folder(options.folder));
  if (dataset.people.empty())
    return fail(ErrorCode::not_found, "no take in it counts", options.folder, "mien dataset says why");
  std::vector<std::string> people;
  for (const dataset::RecordedPerson& person : dataset.people) people.push_back(person.name);
  MIEN_TRY_ASSIGN(const dataset::Splits splits,
                  dataset::draw_splits(std::move(people), options.shares, options.seed));
  MIEN_TRY(write_file(
      options.out,
      dataset::write_splits(splits, fmt::format("Who trains, validates and tests: a person with all of their "
                                                "takes. Drawn with --seed {}.",
                                                options.seed))));
  const std::string missing = few_people(splits, options.shares);
  if (!missing.empty()) fmt::print(stderr, "mien: {}: {}\n", options.folder, missing);
  if (options.json) {
    Json json{{"folder", options.folder}, {"out", options.out}, {"seed", options.seed}};
    json["split"] = json_of(splits);
    print_json(json);
  } else {
    fmt::print("people: train {}, validation {}, test {}\n", splits.of(dataset::Split::train).size(),
               splits.of(dataset::Split::validation).size(), splits.of(dataset::Split::test).size());
    fmt::print("wrote {}\n", options.out);
  }
  return {};
}

struct ExportDatasetOptions {
  dataset::ExportRequest request;
  std::string folder, splits, out;
  bool json = false;
};

Result<void> export_dataset(ExportDatasetOptions options) {
  dataset::ExportRequest& request = options.request;
  request.folder = options.folder;
  request.splits = options.splits;
  request.out = options.out;
  request.software = "mien " MIEN_VERSION;
  request.command = fmt::format("mien dataset export {} --splits {} --out {} --window {} --stride {}",
                                options.folder, options.splits, options.out, request.window, request.stride);
  MIEN_TRY_ASSIGN(const dataset::Export exported,
                  dataset::export_windows(request, terminal_progress("dataset export")));
  clear_progress();
  if (options.json) {
    Json json = json_of(exported);
    json["out"] = options.out;
    print_json(json);
  } else {
    print_export(exported);
    fmt::print("wrote {}\n", (request.out / "datasheet.md").string());
  }
  return {};
}

void add_split_command(Commands& commands, Command parent) {
  const auto options = std::make_shared<SplitOptions>();
  const Command command = commands.add_under(
      parent, "split", "Draws who trains, validates and tests, by person and never by window, into a file",
      "mien dataset split takes/ --out splits.toml --seed 3", [options] { return split_dataset(*options); });
  command.add_option("folder", options->folder, "The folder with the takes").required();
  command.add_option("--out", options->out, "The file to write: .toml").required();
  add_seed_option(command, options->seed, "What is drawn comes from it");
  command.add_option("--validation", options->shares.validation, "Share of the people who validate")
      .number_between(0.0, 1.0)
      .show_default();
  command.add_option("--test", options->shares.test, "Share of the people who are kept for the test")
      .number_between(0.0, 1.0)
      .show_default();
  command.add_flag("--force", options->force, "Replace an existing file");
  add_json_flag(command, options->json);
}

void add_windows_command(Commands& commands, Command parent) {
  const auto options = std::make_shared<ExportDatasetOptions>();
  const Command command = commands.add_under(
      parent, "export", "Writes what counts as windows: safetensors for each set, and a datasheet",
      "mien dataset export takes/ --splits splits.toml --out windows/",
      [options] { return export_dataset(*options); });
  command.add_option("folder", options->folder, "The folder with the takes").required();
  command.add_option("--splits", options->splits, "Who is in which set: a file of mien dataset split")
      .required();
  command.add_option("--out", options->out, "The folder to write; it is made where there is none").required();
  command.add_option("--window", options->request.window, "Frames of a window, 60 a second")
      .in_range(std::size_t{2}, dataset::kLongestWindow)
      .show_default();
  command.add_option("--stride", options->request.stride, "Frames from one window to the next")
      .in_range(std::size_t{1}, dataset::kLongestWindow)
      .show_default();
  command.add_flag("--force", options->request.force, "Replace an export that is there");
  add_json_flag(command, options->json);
}

}  // namespace

void add_dataset_command(Commands& commands) {
  struct Options {
    std::string folder;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  const Command parent = commands.add(
      "dataset", "What a folder of takes holds to train on, and what is left out",
      "mien dataset takes/\n  mien dataset split takes/ --out splits.toml\n  mien dataset export takes/ "
      "--splits "
      "splits.toml --out windows/",
      [options] { return list_dataset(options->folder, options->json); });
  parent.require_commands(0, 1);
  parent.add_option("folder", options->folder, "The folder with the takes");
  add_json_flag(parent, options->json);
  add_split_command(commands, parent);
  add_windows_command(commands, parent);
}

}  // namespace mien::app
