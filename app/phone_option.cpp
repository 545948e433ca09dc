#include "app/phone_option.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include "mien/core/excerpt.h"
#include "mien/solve/trace_features.h"

namespace mien::app {
namespace {

/// The calibrated file beside one that Live Link Face recorded; empty where there is none, or this is one of
/// the two that it names by how they were made.
std::filesystem::path calibrated_beside(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  if (stem.ends_with("_cal") || stem.ends_with("_raw")) return {};
  std::filesystem::path beside = file;
  beside.replace_filename(stem + "_cal" + file.extension().string());
  std::error_code code;
  return std::filesystem::is_regular_file(beside, code) ? beside : std::filesystem::path();
}

}  // namespace

Result<void> check_aligns(const take::Take& take) {
  if (!solve::traced_sensor_names(take.rig()).empty()) return {};
  return fail(ErrorCode::unsupported, "it has no sensors on the skin, whose turns tell a phone's time",
              take.path().string(), "use a take of IMUs");
}

Result<solve::PhoneTrack> open_phone_track(const take::Take& take,
                                           std::span<const model::FeatureFrame> features,
                                           const std::string& file, bool as_named) {
  if (file.empty()) {
    MIEN_TRY_ASSIGN(const std::vector<take::StoredSample> samples, take.samples());
    auto own = solve::phone_track(take.rig(), samples, features.front().time);
    if (!own) own.error().where = take.path().string();
    return own;
  }
  std::filesystem::path read = file;
  if (const auto calibrated = as_named ? std::filesystem::path() : calibrated_beside(file);
      !calibrated.empty()) {
    fmt::print(stderr, "mien: {}: the calibrated {} beside it is read; --raw reads the one that is named\n",
               without_controls(file), without_controls(calibrated.filename().string()));
    read = calibrated;
  }
  std::vector<std::string> warnings;
  MIEN_TRY_ASSIGN(solve::PhoneTrack track, solve::phone_track(read, &warnings));
  for (const std::string& warning : warnings)
    fmt::print(stderr, "mien: {}: {}\n", without_controls(read.string()), without_controls(warning));
  return track;
}

void PhoneOption::add_to(const Command& command, const std::string& does) {
  const Option truth = command.add_option("--truth", truth_,
                                          does +
                                              ": \"phone\" (the truth that was recorded in the take), or a "
                                              "Live Link Face CSV that a phone recorded meanwhile");
  command
      .add_flag("--raw", raw_,
                "Read the phone's file as named, even where a calibrated NAME_cal.csv lies beside it")
      .needs(truth);
  add_film_options(command, film_);
  (void)command.option("--film").needs(truth);
  (void)command.option("--no-sound").needs(truth);
}

std::string PhoneOption::file() const {
  return truth_ == "phone" ? std::string() : truth_;
}

Result<solve::PhoneTrack> PhoneOption::open(const take::Take& take,
                                            std::span<const model::FeatureFrame> features) const {
  MIEN_TRY_ASSIGN(solve::PhoneTrack track, open_phone_track(take, features, file(), raw_));
  MIEN_TRY(add_sound_guess(take, features, file(), film_, track));
  return track;
}

}  // namespace mien::app
