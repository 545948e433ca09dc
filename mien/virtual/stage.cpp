#include "mien/virtual/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ranges>
#include <string_view>
#include <utility>

#include "mien/builtin_face/load_face.h"
#include "mien/core/files.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/performer.h"
#include "mien/performer/style.h"
#include "mien/sensor/rig_part.h"
#include "mien/virtual/eyewear/worn_eyewear.h"
#include "mien/virtual/imu/worn_imus.h"

namespace mien::virt {
namespace {

face::Motion motion_of(const StageRequest& request, const Random& root) {
  if (request.motion) return *request.motion;
  Random style_random = root.fork("style");
  const performer::Style style = performer::draw_style(style_random);
  performer::Script script = request.script;
  script.moves_head = request.devices != "lab";
  return performer::perform(script, style, root.fork("motion"));
}

/// A kind of sensors, and how a performer puts them on.
struct Modality {
  std::string_view kind;  ///< As rigs name it.
  Result<std::shared_ptr<const WornDevices>> (*wear)(const StageRequest&, face::Face, const Random& root,
                                                     const Stage&);
};
constexpr std::array kModalities = {
    Modality{"imu", wear_imus},
    Modality{"eyewear", wear_eyewear},
};

}  // namespace

Result<FaultsText> read_faults(const StageRequest& request, const sensor::Rig& rig) {
  std::error_code code;
  if (request.devices == "device") return FaultsText{rig.faults_toml, request.rig.string()};
  if (!std::filesystem::exists(request.devices, code))
    return fail(ErrorCode::not_found, "there are no such devices", request.devices,
                "name device, lab, or a TOML file of faults");
  MIEN_TRY_ASSIGN(std::string text, read_text(request.devices));
  return FaultsText{std::move(text), request.devices};
}

Result<Stage> set_stage(const StageRequest& request) {
  Stage stage;
  MIEN_TRY_ASSIGN(stage.rig_toml, read_text(request.rig));
  MIEN_TRY_ASSIGN(stage.rig, sensor::parse_rig(stage.rig_toml, request.rig.string()));
  const std::vector<std::string> kinds = sensor::kinds_of(stage.rig);
  if (kinds.size() != 1)
    return fail(ErrorCode::unsupported, "no virtual performer wears sensors of several kinds at once",
                request.rig.string(), "perform each kind with a rig of its own, to one session that has all");
  const auto modality = std::ranges::find(kModalities, kinds.front(), &Modality::kind);
  if (modality == kModalities.end())
    return fail(ErrorCode::unsupported, "there are no virtual sensors of the kind " + kinds.front(),
                request.rig.string(),
                fmt::format("use a rig of the kind {}",
                            fmt::join(kModalities | std::views::transform(&Modality::kind), " or ")));
  stage.lab = request.devices == "lab";
  MIEN_TRY_ASSIGN(face::Face face, builtin_face::load_face(request.face));
  const Random root(request.seed);
  MIEN_TRY_ASSIGN(stage.worn, modality->wear(request, std::move(face), root, stage));

  const double seconds = request.motion ? request.motion->duration_s() : request.script.duration_s();
  if (!(seconds <= kLongestPerformanceS))
    return fail(
        ErrorCode::out_of_range,
        fmt::format("the performance is {:.0f} s long, more than {:.0f}", seconds, kLongestPerformanceS),
        request.script_name, "perform it in parts; a time code may jump");
  face::Motion motion = motion_of(request, root);
  if (motion.frames.empty())
    return fail(ErrorCode::bad_usage, "the motion has no frames", request.script_name);
  if (!motion.has_head && !stage.lab) motion = performer::with_head_motion(motion, root.fork("head"));
  stage.motion =
      performer::with_prologue(motion, request.prologue, root.fork("prologue"), stage.worn->prologue(stage));
  stage.devices = root.fork("devices");
  return stage;
}

Result<VirtualSession> play(const Stage& stage, const Progress& progress) {
  return stage.worn->play(stage, progress);
}

}  // namespace mien::virt
