#include "app/film_option.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "app/child_program.h"
#include "app/media_helper.h"
#include "mien/core/excerpt.h"
#include "mien/solve/sound_guess.h"

namespace mien::app {
namespace {

/// Of what is compared: more tells no more (phone::sound_offset).
constexpr int kComparedRate_hz = 8'000;

/// Why there is no guess by sound; what else there is goes on without it.
void tell_without(const std::string& film, const Error& why) {
  const std::string said = why.where == film || why.where.empty() ? why.what : why.where + ": " + why.what;
  fmt::print(stderr, "mien: {}: {}; its sound is not used\n", without_controls(film), without_controls(said));
}

}  // namespace

void add_film_options(const Command& command, FilmOption& option) {
  const Option film =
      command.add_option("--film", option.film,
                         "A film or sound that the phone recorded with its file, which the take's own sound "
                         "is compared with for a first guess (default: NAME.mov beside NAME.csv)");
  command.add_flag("--no-sound", option.no_sound, "Compare no sound, even where a film lies beside the file")
      .excludes(film);
}

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

Result<void> add_sound_guess(const take::Take& take, std::span<const model::FeatureFrame> features,
                             const std::string& csv, const FilmOption& option, solve::PhoneTrack& track) {
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

}  // namespace mien::app
