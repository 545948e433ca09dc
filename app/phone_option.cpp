#include "app/phone_option.h"

#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "app/child_program.h"
#include "app/media_helper.h"
#include "mien/solve/sound_guess.h"
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

/// The film that Live Link Face left beside a file: NAME.mov beside NAME.csv, NAME_cal.csv and NAME_raw.csv;
/// empty where there is none.
std::string film_beside(const std::string& csv) {
  const std::filesystem::path file = csv;
  std::string stem = file.stem().string();
  for (const char* made : {"_cal", "_raw"})
    if (stem.ends_with(made)) {
      stem.erase(stem.size() - 4);
      break;
    }
  for (const char* ending : {".mov", ".MOV", ".mp4"}) {
    std::filesystem::path film = file;
    film.replace_filename(stem + ending);
    std::error_code code;
    if (std::filesystem::is_regular_file(film, code)) return film.string();
  }
  return {};
}

/// Of what is compared: more tells no more (phone::sound_offset).
constexpr int kComparedRate_hz = 8'000;

/// Why there is no guess by sound; what else there is goes on without it.
void tell_without(const std::string& film, const Error& why) {
  const std::string said = why.where == film || why.where.empty() ? why.what : why.where + ": " + why.what;
  fmt::print(stderr, "mien: {}: {}; its sound is not used\n", without_controls(film), without_controls(said));
}

/// Compares the sound of a file's film with the take's; `csv` is empty for the take's own truth, without
/// film.
Result<void> add_sound_guess(const take::Take& take, std::span<const model::FeatureFrame> features,
                             const std::string& csv, const PhoneReading& option, solve::PhoneTrack& track) {
  if (csv.empty() && !option.film.empty())
    return fail(ErrorCode::bad_usage, "a film belongs to a phone's file, and none is named", "--film",
                "name the CSV that was recorded with it");
  if (csv.empty() || option.no_sound) return {};
  const std::string film = option.film.empty() ? film_beside(csv) : option.film;
  if (film.empty()) return {};
  if (const auto helper = find_helper("mien-media"); !helper) {
    tell_without(film, helper.error());
    return {};
  }
  const auto heard = solve::take_sound(take, features.front().time);
  if (!heard && heard.error().code != ErrorCode::not_found) return std::unexpected(heard.error());
  if (!heard) {
    tell_without(film, heard.error());
    return {};
  }
  const auto told = read_film_sound(film, kComparedRate_hz);
  if (!told && !option.film.empty()) return std::unexpected(told.error());
  if (!told) {
    tell_without(film, told.error());
    return {};
  }
  auto guess = solve::guess_by_sound(*heard, *told, track.start_s);
  if (!guess)
    tell_without(film, guess.error());
  else
    track.sound = *std::move(guess);
  return {};
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

}  // namespace

Result<void> check_aligns(const take::Take& take) {
  if (!solve::traced_sensor_names(take.rig()).empty()) return {};
  return fail(ErrorCode::unsupported, "it has no sensors on the skin, whose turns tell a phone's time",
              take.path().string(), "use a take of IMUs");
}

void PhoneReading::add_to(const Command& command) {
  command.add_flag("--raw", raw,
                   "Read the phone's file as named, even where a calibrated NAME_cal.csv lies beside it");
  const Option named =
      command.add_option("--film", film,
                         "A film or sound that the phone recorded with its file, which the take's own sound "
                         "is compared with for a first guess (default: NAME.mov beside NAME.csv)");
  command.add_flag("--no-sound", no_sound, "Compare no sound, even where a film lies beside the file")
      .excludes(named);
}

Result<solve::PhoneTrack> PhoneReading::open(const take::Take& take,
                                             std::span<const model::FeatureFrame> features,
                                             const std::string& file) const {
  MIEN_TRY_ASSIGN(solve::PhoneTrack track, open_phone_track(take, features, file, raw));
  MIEN_TRY(add_sound_guess(take, features, file, *this, track));
  return track;
}

void PhoneOption::add_to(const Command& command, const std::string& does) {
  const Option truth = command.add_option(
      "--truth", truth_,
      does +
          ": \"phone\" (the truth that was recorded in the take), or a Live Link Face CSV that a phone "
          "recorded meanwhile");
  reading_.add_to(command);
  for (const char* name : {"--raw", "--film", "--no-sound"}) (void)command.option(name).needs(truth);
}

}  // namespace mien::app
