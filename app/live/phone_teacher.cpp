#include "app/live/phone_teacher.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>
#include <vector>

#include "mien/builtin_face/load_face.h"
#include "mien/core/files.h"
#include "mien/imu/calibration.h"
#include "mien/model/correction_json.h"
#include "mien/solve/part_of_work.h"
#include "mien/solve/phone_truth.h"
#include "mien/solve/solve.h"
#include "mien/solve/trace_features.h"
#include "mien/take/take.h"

namespace mien::app {
namespace {

/// The wearer's skin of the newest calibration, which is in force; empty: the model's own.
std::vector<float> skin_in(const std::vector<take::CalibrationVersion>& versions) {
  if (versions.empty()) return {};
  nlohmann::json made = nlohmann::json::parse(versions.back().json, nullptr, false);
  // Of several trackers each has its own.
  if (made.is_object() && made.contains("imu")) made = nlohmann::json(made["imu"]);
  const auto calibration = imu::parse_calibration(made.dump(), "calibration");
  return calibration ? calibration->wearer : std::vector<float>();
}

/// A lesson with its pauses; of a session that runs for long what was before is left out.
constexpr double kNewestS = 300;

Result<live::TaughtByPhone> learn(const std::filesystem::path& path, const std::filesystem::path& model,
                                  const std::string& face_name, const Progress& progress) {
  // Reading the take is a second or two of a dozen.
  constexpr double kRead = 0.15;
  MIEN_TRY_ASSIGN(const take::Take take, take::Take::open(path));
  if (solve::traced_sensor_names(take.rig()).empty())
    return fail(ErrorCode::unsupported, "there are no sensors on the skin, whose answers could be corrected",
                path.filename().string());
  MIEN_TRY_ASSIGN(const std::vector<model::FeatureFrame> all, solve::take_features(take));
  if (!progress(kRead, "learning")) return fail(ErrorCode::cancelled, "stopped", path.filename().string());
  constexpr auto kNewest = static_cast<std::size_t>(kNewestS * kFrameRateHz);
  const std::span features = std::span(all).last(std::min(all.size(), kNewest));
  MIEN_TRY_ASSIGN(std::vector<take::StoredSample> samples, take.samples());
  if (!samples.empty())
    std::erase_if(samples, [oldest = samples.back().arrival - from_seconds(kNewestS)](const auto& stored) {
      return stored.arrival < oldest;
    });
  MIEN_TRY_ASSIGN(const solve::PhoneTrack track,
                  solve::phone_track(take.rig(), samples, features.front().time));
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(model, ignored);
  MIEN_TRY_ASSIGN(model::ModelFile file, model::read_model(folder ? model / "live.safetensors" : model));
  MIEN_TRY_ASSIGN(const std::vector<take::CalibrationVersion> versions, take.calibrations());
  if (std::vector<float> skin = skin_in(versions); file.skin && skin.size() == file.skin->standard.size())
    file.skin->wearer = std::move(skin);
  MIEN_TRY_ASSIGN(const face::Face face, builtin_face::load_face(face_name));
  MIEN_TRY_ASSIGN(
      const solve::LearntFromPhone lesson,
      solve::learn_from_phone(take, features, track, face, file, solve::part_of_work(progress, kRead, 1)));
  if (!lesson.learnt.taken)
    return fail(
        ErrorCode::not_found,
        fmt::format(
            "what was learnt is no better where it was held out ({:.2f} mm, without it {:.2f}), so it "
            "is not used",
            lesson.learnt.skin_after_mm, lesson.learnt.skin_before_mm),
        path.filename().string(), "speak and make faces before the phone, and learn again");
  return live::TaughtByPhone{
      .correction = model::rounded_as_written(*file.correction),
      .sentence = fmt::format(
          "learnt from {:.0f} s of the phone: {} shapes are corrected, and where it was held out the "
          "face is {:.2f} mm off, {:.2f} before",
          static_cast<double>(lesson.learnt.frames) / kFrameRateHz, lesson.learnt.shapes,
          lesson.learnt.skin_after_mm, lesson.learnt.skin_before_mm)};
}

Result<session::PromptScript> lesson_script() {
  MIEN_TRY_ASSIGN(const std::filesystem::path file, find_resource("prompts/learn_phone.toml"));
  return session::read_prompts(file);
}

}  // namespace

live::PhoneLesson::Settings phone_teacher(const std::filesystem::path& model, const std::string& face) {
  return {.script = lesson_script,
          .learn = [model, face](const std::filesystem::path& take, const Progress& progress) {
            return learn(take, model, face, progress);
          }};
}

}  // namespace mien::app
