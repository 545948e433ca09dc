#include "lab/commands/short_trainings.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <list>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/private_folder.h"
#include "app/trainer_helper.h"
#include "mien/core/files.h"
#include "mien/core/sha256.h"
#include "mien/synthetic/imu/dataset_file.h"

namespace mien::lab {
namespace {

namespace fs = std::filesystem;

/// How often the helpers are looked at.
constexpr std::chrono::milliseconds kLook(200);
/// So long they may take to write their checkpoints when they are asked to stop.
constexpr std::chrono::seconds kTrainerPatience(60);
constexpr const char* kGoOn = "run the study again: it goes on where it was";

std::string key_of(std::string_view text) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(text)));
  return hash.hex().substr(0, 12);
}

/// One training, and its files.
struct TrainingRow {
  const ShortTraining* training;
  fs::path model, recipe, rig, data;
};

TrainingRow row_of(const ShortTraining& training, const fs::path& folder) {
  const std::string key =
      key_of(fmt::format("{}\n\n{}\n\n{}", training.recipe, training.rig, training.data_key));
  const fs::path stem = folder / fmt::format("{}-{}", training.name, key);
  const auto with = [&](const char* ending) { return fs::path(stem.string() + ending); };
  return {.training = &training,
          .model = with(".safetensors"),
          .recipe = with(".toml"),
          .rig = with(".rig.toml"),
          .data = folder / fmt::format("data-{}.safetensors", key_of(training.data_key))};
}

bool is_there(const fs::path& path) {
  std::error_code code;
  return fs::exists(path, code);
}

void remove_quietly(const fs::path& path) {
  std::error_code code;
  fs::remove(path, code);
}

/// What is left of a folder's trainings, worked off side by side.
class ShortTrainings {
 public:
  ShortTrainings(std::vector<TrainingRow> rows, const Progress& progress)
      : progress_(progress), all_(rows.size()) {
    for (TrainingRow& row : rows) {
      if (is_there(row.model)) continue;
      ++wanted_[row.data];
      waiting_.push_back(std::move(row));
    }
    std::ranges::reverse(waiting_);  // Taken from the back.
  }

  /// Removes what studies that were killed left behind: data that nobody waits for, and halves of files.
  void tidy(const fs::path& folder) const {
    std::error_code code;
    std::vector<fs::path> left;
    for (const auto& entry : fs::directory_iterator(folder, code)) {
      const std::string name = entry.path().filename().string();
      const bool data = name.starts_with("data-") && !wanted_.contains(entry.path());
      if (data || name.ends_with(".part")) left.push_back(entry.path());
    }
    for (const fs::path& path : left) remove_quietly(path);
  }

  Result<void> run() {
    Result<void> worked = work();
    end_helpers();
    if (worked || worked.error().code != ErrorCode::cancelled) return worked;
    // One wording, whatever was at work.
    return fail(ErrorCode::cancelled, fmt::format("stopped after {} of {} trainings", ended(), all_), "",
                kGoOn);
  }

 private:
  struct Running {
    TrainingRow row;
    app::Child child;
  };

  Result<void> work() {
    const std::size_t workers = std::max(1U, std::thread::hardware_concurrency());
    while (!waiting_.empty() || !running_.empty()) {
      while (running_.size() < workers && !waiting_.empty()) {
        MIEN_TRY(start_next());
      }
      std::this_thread::sleep_for(kLook);
      // Asked first: Ctrl-C ends the helpers too, which is no error of theirs.
      if (!progress_(share(), status())) return fail(ErrorCode::cancelled, "stopped");
      MIEN_TRY(collect());
    }
    return {};
  }

  /// It waits, and is no share of the work, until its helper has begun.
  Result<void> start_next() {
    const TrainingRow& row = waiting_.back();
    if (!is_there(row.data)) {
      MIEN_TRY_ASSIGN(
          const dataset::TrainingData data, row.training->data([&](double part, std::string_view what) {
            return progress_(share(),
                             fmt::format("data of {}: {:.0f} %, {}", row.training->name, 100 * part, what));
          }));
      MIEN_TRY(synthetic::write_training_data(row.data, data));
    }
    MIEN_TRY(write_file(row.recipe, row.training->recipe));
    MIEN_TRY(write_file(row.rig, row.training->rig));
    MIEN_TRY_ASSIGN(app::Child child,
                    app::start_trainer({"train", row.recipe.string(), "--out", row.model.string(), "--rig",
                                        row.rig.string(), "--data", row.data.string(), "--threads", "1",
                                        "--resume", "--parent", std::to_string(::getpid())}));
    running_.push_back({std::move(waiting_.back()), std::move(child)});
    waiting_.pop_back();
    return {};
  }

  Result<void> collect() {
    for (auto one = running_.begin(); one != running_.end();) {
      if (!one->child.has_ended()) {
        ++one;
        continue;
      }
      const TrainingRow row = one->row;
      MIEN_TRY_ASSIGN(const app::ChildOutput output, one->child.wait());
      one = running_.erase(one);
      if (!output.succeeded()) return complain(row, output);
      if (--wanted_[row.data] == 0) remove_quietly(row.data);
    }
    return {};
  }

  /// The helper's last line is its error; those before it are progress.
  static Result<void> complain(const TrainingRow& row, const app::ChildOutput& output) {
    std::string line = output.complaints;
    while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.pop_back();
    line = line.substr(line.find_last_of("\n\r") + 1);
    return fail(ErrorCode::io, line.empty() ? "the trainer stopped without a word" : line, row.training->name,
                kGoOn);
  }

  /// Asks all before it waits for one, so that they write their checkpoints side by side. What they say of it
  /// changes nothing.
  void end_helpers() {
    using Clock = std::chrono::steady_clock;
    for (Running& one : running_) one.child.ask_to_stop();
    const Clock::time_point until = Clock::now() + kTrainerPatience;
    for (Running& one : running_)
      (void)one.child.stop(std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()));
  }

  [[nodiscard]] std::size_t ended() const { return all_ - waiting_.size() - running_.size(); }
  [[nodiscard]] double share() const { return static_cast<double>(ended()) / static_cast<double>(all_); }
  [[nodiscard]] std::string status() const {
    std::string names;
    for (const Running& one : running_) names += (names.empty() ? "" : ", ") + one.row.training->name;
    return fmt::format("training {} of {}: {}", all_ - waiting_.size(), all_, names);
  }

  const Progress& progress_;
  std::size_t all_;
  std::vector<TrainingRow> waiting_;
  std::list<Running> running_;              ///< Children cannot be assigned.
  std::map<fs::path, std::size_t> wanted_;  ///< Of each file of data, who still learns from it.
};

/// Holds a folder as long as it lives, so that no other study works in it.
class FolderLock {
 public:
  static Result<FolderLock> take(const fs::path& folder) {
    const fs::path path = folder / "lock";
    const int file = ::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600);
    if (file < 0) return fail(ErrorCode::io, std::strerror(errno), path.string());
    if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
      ::close(file);
      return fail(ErrorCode::io, "another study is at work in this folder", folder.string(),
                  "wait for it, or name another --out");
    }
    return FolderLock(file);
  }
  FolderLock(FolderLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock() {
    if (file_ >= 0) ::close(file_);
  }

 private:
  explicit FolderLock(int file) : file_(file) {}
  int file_;
};

/// Whether a folder has models, checkpoints or data.
bool is_begun(const fs::path& folder) {
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    const fs::path ending = entry.path().extension();
    if (ending == ".safetensors" || ending == ".checkpoint") return true;
  }
  return false;
}

/// Another build of the trainer, whose simulation and training may differ, leaves models that cannot stand
/// beside this one's; nor can those of which nothing says whose they are.
Result<void> check_same_trainer(const fs::path& folder) {
  MIEN_TRY_ASSIGN(const fs::path helper, app::find_helper("mien-train"));
  MIEN_TRY_ASSIGN(const std::vector<std::byte> program, read_file(helper));
  Sha256 hash;
  hash.add(program);
  const std::string own = hash.hex() + "\n";
  const fs::path path = folder / "trainer.sha256";
  const bool known = is_there(path);
  if (known) {
    MIEN_TRY_ASSIGN(const std::string standing, read_text(path));
    if (standing == own) return {};
  } else if (!is_begun(folder)) {
    return write_file(path, own);
  }
  return fail(
      ErrorCode::mismatch,
      fmt::format("what is trained here is of {} build of the trainer", known ? "another" : "an unknown"),
      folder.string(), "remove this folder to train anew, or name another --out");
}

}  // namespace

Result<TrainShort> train_by_helper(const fs::path& folder) {
  MIEN_TRY(app::make_private_folders(folder));
  MIEN_TRY_ASSIGN(FolderLock taken, FolderLock::take(folder));
  MIEN_TRY(check_same_trainer(folder));
  return [folder, lock = std::make_shared<const FolderLock>(std::move(taken))](
             std::span<const ShortTraining> trainings,
             const Progress& progress) -> Result<std::vector<model::ModelFile>> {
    std::vector<TrainingRow> rows;
    for (const ShortTraining& training : trainings) rows.push_back(row_of(training, folder));
    ShortTrainings work(rows, progress);
    work.tidy(folder);
    MIEN_TRY(work.run());
    std::vector<model::ModelFile> trained;
    for (const TrainingRow& row : rows) {
      MIEN_TRY_ASSIGN(trained.emplace_back(), model::read_model(row.model));
    }
    return trained;
  };
}

void add_short_training_options(app::Command command, const ShortTrainingAmounts& amounts) {
  command
      .add_option("--seeds", amounts.seeds,
                  "Trainings of each row: more narrow the intervals, and take as much longer")
      .in_range(1, 100)
      .show_default();
  command.add_option("--steps", amounts.steps, "Steps of each training, the same for all rows")
      .in_range(1, 1000000)
      .show_default();
  command.add_option("--performers", amounts.data.performers, "Virtual people who are trained on")
      .in_range(10, 1000000)
      .show_default();
  command.add_option("--people", amounts.test_people, "Virtual people of each kind whom rows are tried on")
      .in_range(amounts.fewest_people, 10000)
      .show_default();
}

}  // namespace mien::lab
