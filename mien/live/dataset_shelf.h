#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/take_listing.h"
#include "mien/session/consent.h"
#include "mien/session/prompt_script.h"

namespace mien::live {

/// A recording script that a page may choose.
struct RecordingScript {
  std::string name;  ///< Of its file, without the ending: "dataset_en".
  session::PromptScript script;
};

/// What a page asks for that begins a dataset's recording.
struct DatasetWish {
  std::string dataset;  ///< Name of its folder.
  std::string script;   ///< RecordingScript::name.
  session::Consent consent;
  bool by_voice = false;  ///< Texts are over when they were spoken.
};

/// What is recorded then.
struct DatasetPlan {
  DatasetWish wish;
  std::filesystem::path take;            ///< New; its folder may not be there yet.
  std::vector<session::Prompt> prompts;  ///< Of the script's lines those that are not recorded well yet.
  std::size_t done = 0;                  ///< Lines that are.
};

/// The datasets of a folder: each a folder of takes, in which it stands who has recorded what. Takes are
/// opened on a thread of its own, once for as long as their size and time stay the same; answers come on that
/// thread. list() and plan() from one thread, always the same.
class DatasetShelf {
 public:
  /// More datasets, and more takes in one, are not looked at: the first by name are.
  static constexpr std::size_t kMaxDatasets = 100, kMaxTakes = 2000;
  /// Asked for whenever scripts are wanted; on the shelf's thread.
  using Scripts = std::function<Result<std::vector<RecordingScript>>()>;

  DatasetShelf(std::filesystem::path folder, Scripts scripts);
  ~DatasetShelf();  ///< Waits for the take that is being read; what is asked for is left unanswered.
  DatasetShelf(const DatasetShelf&) = delete;
  DatasetShelf& operator=(const DatasetShelf&) = delete;

  /// A performer in a dataset.
  struct Performer {
    std::size_t takes = 0;
    std::size_t lines = 0;  ///< That are recorded well.
  };
  struct Dataset {
    std::string name;
    std::map<std::string, Performer> performers;
  };
  struct Contents {
    std::vector<Dataset> datasets;
    std::vector<RecordingScript> scripts;
  };
  /// `growing`: a take that is being recorded, which is left alone; may be empty. Errors, in the answer: the
  /// scripts'. Takes that cannot be read are passed over: `mien dataset` says why.
  void list(std::filesystem::path growing, std::function<void(Result<Contents>)> answer);
  /// Errors, in the answer: check_consent's, the scripts'; bad_usage (no name for a dataset, everything of
  /// the script is recorded); not_found (no such script).
  void plan(DatasetWish wish, std::filesystem::path growing, std::function<void(Result<DatasetPlan>)> answer);

 private:
  /// What a line is known by in any take: name and text.
  using LineKey = std::pair<std::string, std::string>;
  struct Recorded {
    FileVersion of;
    std::string performer;    ///< Empty: nobody consented, or it cannot be read.
    std::set<LineKey> lines;  ///< Recorded well.
  };
  void run(const std::stop_token& stop);
  void post(std::function<void()> job);
  [[nodiscard]] const Recorded* recorded_in(const std::filesystem::path& take);
  /// Takes of a dataset's folder by name, without the one that grows.
  [[nodiscard]] static std::vector<std::filesystem::path> takes_of(const std::filesystem::path& folder,
                                                                   const std::filesystem::path& growing);
  [[nodiscard]] Result<Contents> contents(const std::filesystem::path& growing);
  [[nodiscard]] Result<DatasetPlan> planned(DatasetWish wish, const std::filesystem::path& growing);

  std::filesystem::path folder_;
  Scripts scripts_;
  std::map<std::filesystem::path, Recorded> known_;  // The thread's alone, ...
  std::stop_token stop_;                             // ... as this.
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<std::function<void()>> jobs_;
  std::jthread thread_;  // Last: it ends before what it uses.
};

}  // namespace mien::live
