#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "mien/core/error.h"

namespace mien::app {

/// What `mien demo --record-dataset` is asked for.
struct DatasetDemo {
  std::filesystem::path out = "out/demo";  ///< The session's folder of takes.
  std::uint64_t seed = 2026;               ///< Who performs.
  std::string script = "dataset_try";      ///< A recording script: a shipped one's name or a file.
  std::string page = "127.0.0.1:8740";     ///< Where the page is served.
  std::string model;                       ///< The live model or models; empty: those of models/.
};

/// What was recorded.
struct RecordedDemo {
  std::filesystem::path dataset;  ///< Its folder.
  std::filesystem::path take;
  std::size_t lines = 0;          ///< That were recorded.
  std::vector<std::string> poor;  ///< Of these the poor ones, each with what was poor in it.
};

/// Records a dataset as a person does from the page, by its own protocol: a virtual performer wears sensors
/// and a microphone through real sockets, a virtual phone looks on, consent is given, lines are read and
/// poses made, and what was recorded is a take with truth, sound, labels and sync. In real time. Errors: the
/// session's and the performance's; not_found (mien-media); what the session refuses; cancelled.
[[nodiscard]] Result<RecordedDemo> record_demo_dataset(const DatasetDemo& demo);

}  // namespace mien::app
