#include "mien/virtual/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <ranges>
#include <sstream>
#include <string_view>
#include <utility>

#include "mien/builtin_face/load_face.h"
#include "mien/core/files.h"
#include "mien/core/toml.h"
#include "mien/performer/head_motion.h"
#include "mien/performer/performer.h"
#include "mien/performer/style.h"
#include "mien/phone/live_link.h"
#include "mien/phone/phone_mount.h"
#include "mien/sensor/bindings.h"
#include "mien/sensor/rig_part.h"
#include "mien/virtual/eyewear/worn_eyewear.h"
#include "mien/virtual/headset/worn_headset.h"
#include "mien/virtual/imu/worn_imus.h"
#include "mien/virtual/phone/worn_phone.h"
#include "mien/virtual/reception.h"
#include "mien/virtual/speech/worn_microphones.h"
#include "mien/virtual/worn_together.h"

namespace mien::virt {
namespace {

/// The virtual performer's motion, a script after another; no frames after the last.
std::function<face::Motion(std::size_t index)> pieces_of(const StageRequest& request, const Random& root) {
  Random style_random = root.fork("style");
  return [style = performer::draw_style(style_random), random = root.fork("motion"),
          moves_head = request.devices != "lab", first = request.script,
          later = request.later_scripts](std::size_t index) {
    if (index > later.size()) return face::Motion();
    performer::Script script = index == 0 ? first : later[index - 1];
    script.moves_head = moves_head;
    return performer::perform(script, style, index == 0 ? random : random.fork("piece", index));
  };
}

double seconds_of(const StageRequest& request) {
  if (request.motion) return request.motion_s.value_or(request.motion->duration_s());
  double seconds = request.script.duration_s();
  for (const performer::Script& script : request.later_scripts) seconds += script.duration_s();
  return seconds;
}

/// The recorded motion with a head, cut where it is longer than it is to last.
Result<face::Motion> recorded_motion(const StageRequest& request, bool lab, const Random& root) {
  face::Motion motion = *request.motion;
  if (motion.frames.empty())
    return fail(ErrorCode::bad_usage, "the motion has no frames", request.script_name);
  if (request.motion_s)
    std::erase_if(motion.frames, [end_s = motion.frames.front().time_s + *request.motion_s](
                                     const face::MotionFrame& frame) { return frame.time_s > end_s; });
  if (!motion.has_head && !lab) motion = performer::with_head_motion(motion, root.fork("head"));
  return motion;
}

/// A session that is played and received at once.
class WholeSession final : public SessionStream {
 public:
  explicit WholeSession(const Stage& stage) : stage_(stage) {}
  [[nodiscard]] Result<Stretch> next(const Progress& progress) override {
    done_ = true;
    Stretch all;
    MIEN_TRY_ASSIGN(all.session, play(stage_, progress));
    return all;
  }
  [[nodiscard]] bool done() const override { return done_; }

 private:
  const Stage& stage_;
  bool done_ = false;
};

/// A kind of sensors, and how a performer puts them on.
struct Modality {
  std::string_view kind;  ///< As rigs name it.
  Result<std::shared_ptr<const WornDevices>> (*wear)(const StageRequest&, face::Face, const Random& root,
                                                     const Stage&);
};
constexpr std::string_view kHearing = "speech";
constexpr std::string_view kSeeing = "camera";
constexpr std::string_view kTelling = "weights";
constexpr std::array kModalities = {
    Modality{"imu", wear_imus},           Modality{"eyewear", wear_eyewear}, Modality{kSeeing, wear_headset},
    Modality{kHearing, wear_microphones}, Modality{kTelling, wear_phone},
};
/// Devices whose faults stand in a table of their own, so that they can be worn beside others.
constexpr std::array<std::string_view, 3> kFaultTables = {"microphone", "headset", "phone"};
/// What cameras may be worn beside; a microphone may be beside both, or beside any one kind, and a phone
/// beside all of these, whether it is a truth or not.
constexpr std::string_view kFeeling = "imu";

/// A rig with nothing but the sensors of one kind, each bound as in the whole.
Result<sensor::Rig> only_of(const sensor::Rig& rig, std::string_view kind) {
  MIEN_TRY_ASSIGN(const auto bound, sensor::bindings(rig));
  sensor::Rig only = rig;
  for (const auto& [key, sensor] : bound) only.sensors[sensor].device = sensor::format_device(key);
  std::erase_if(only.sensors, [&](const sensor::Mount& mount) { return mount.kind != kind; });
  return only;
}

/// Their numbers in the whole, truths among them.
std::vector<std::uint16_t> numbers_of(const sensor::Rig& rig, std::string_view kind) {
  std::vector<std::uint16_t> numbers;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i)
    if (rig.sensors[i].kind == kind) numbers.push_back(static_cast<std::uint16_t>(i));
  return numbers;
}

Result<std::shared_ptr<const WornDevices>> wear(const StageRequest& request, std::string_view kind,
                                                face::Face face, const Random& root, const Stage& stage) {
  const auto modality = std::ranges::find(kModalities, kind, &Modality::kind);
  if (modality == kModalities.end())
    return fail(ErrorCode::unsupported, fmt::format("there are no virtual sensors of the kind {}", kind),
                request.rig.string(),
                fmt::format("use sensors of the kind {}",
                            fmt::join(kModalities | std::views::transform(&Modality::kind), " or ")));
  return modality->wear(request, std::move(face), root, stage);
}

/// All that the stage's rig has.
Result<std::shared_ptr<const WornDevices>> wear_all(const StageRequest& request, face::Face face,
                                                    const Random& root, const Stage& stage) {
  std::vector<std::string> kinds = sensor::kinds_of(stage.rig);
  if (request.headset_failure && std::ranges::find(kinds, kSeeing) == kinds.end())
    return fail(ErrorCode::bad_usage, "a headset's failure, and the rig has no cameras", request.rig.string(),
                "leave out --headset-failure, or use rigs/headset.toml");
  std::erase(kinds, kTelling);
  const bool told = !numbers_of(stage.rig, kTelling).empty();
  if (kinds.size() == 1 && !told) return wear(request, kinds.front(), std::move(face), root, stage);
  const bool hears = kinds.size() > 1 && std::erase(kinds, kHearing) > 0;
  std::ranges::sort(kinds, {}, [](const std::string& kind) { return kind != kFeeling; });
  if (kinds.size() > 1 && kinds != std::vector<std::string>{std::string(kFeeling), std::string(kSeeing)})
    return fail(ErrorCode::unsupported, "no virtual performer wears sensors of these kinds at once",
                request.rig.string(),
                "cameras may be beside IMUs, and a microphone and a phone beside these or beside one kind; "
                "perform each other one with a rig of its own, to one session that has all");
  if (const auto reference = stage.rig.find(stage.rig.reference);
      kinds.empty() || !reference || stage.rig.sensors[*reference].kind != kinds.front())
    return fail(ErrorCode::bad_usage,
                "the frames' clock is a microphone's or a phone's, or a camera's beside IMUs",
                request.rig.string(),
                fmt::format("name a sensor of the kind {} as the reference",
                            kinds.empty() ? kFeeling : kinds.front()));
  const bool together = kinds.size() > 1;
  if (hears) kinds.emplace_back(kHearing);
  if (told) kinds.emplace_back(kTelling);
  std::vector<WornTogether::Part> parts;
  for (const std::string& kind : kinds) {
    Stage part;
    part.lab = stage.lab;
    part.together = together;
    MIEN_TRY_ASSIGN(part.rig, only_of(stage.rig, kind));
    MIEN_TRY_ASSIGN(auto worn, wear(request, kind, face, root, part));
    parts.push_back({std::move(worn), numbers_of(stage.rig, kind)});
  }
  return std::make_shared<const WornTogether>(std::move(parts));
}

/// What belongs to one table of devices, or to none.
Result<FaultsText> part_of(FaultsText all, std::string_view table) {
  MIEN_TRY_ASSIGN(toml::table faults, parse_toml(all.toml, all.where + ", [faults]"));
  std::ostringstream out;
  if (!table.empty()) {
    toml::node* const own = faults.get(table);
    if (own == nullptr) return FaultsText{{}, std::move(all.where), false};
    if (!own->is_table())
      return fail(ErrorCode::malformed, fmt::format("faults.{} is no table", table), all.where);
    own->as_table()->is_inline(false);  // Else it would be written in braces.
    out << *own->as_table();
  } else {
    bool erased = false;
    for (const std::string_view name : kFaultTables) erased = faults.erase(name) > 0 || erased;
    if (!erased) return all;
    out << faults;
  }
  return FaultsText{out.str(), std::move(all.where)};
}

/// The stage's rig with the phone that the request adds.
Result<void> add_phone(Stage& stage) {
  constexpr std::array kPhones = {sensor::DeviceKey{phone::kLiveLinkDevice, 0}};
  MIEN_TRY_ASSIGN(const auto missing, phone::without_sensor(stage.rig, kPhones));
  if (missing.empty()) return {};
  MIEN_TRY_ASSIGN(stage.rig, phone::with_phones(std::move(stage.rig), missing, phone::PhoneUse::truth));
  stage.rig_toml = sensor::write_rig(stage.rig);
  return {};
}

}  // namespace

Result<FaultsText> read_faults(const StageRequest& request, const sensor::Rig& rig, std::string_view table) {
  std::error_code code;
  if (request.devices == "device") return part_of({rig.faults_toml, request.rig.string()}, table);
  if (!std::filesystem::exists(request.devices, code))
    return fail(ErrorCode::not_found, "there are no such devices", request.devices,
                "name device, lab, or a TOML file of faults");
  MIEN_TRY_ASSIGN(std::string text, read_text(request.devices));
  return part_of({std::move(text), request.devices}, table);
}

Result<std::unique_ptr<SessionStream>> WornDevices::stream(const Stage& stage) const {
  return fail(ErrorCode::unsupported, "these devices cannot be streamed", stage.rig.name);
}

Result<Stage> set_stage(const StageRequest& request, StageHolds holds) {
  Stage stage;
  MIEN_TRY_ASSIGN(stage.rig_toml, read_text(request.rig));
  MIEN_TRY_ASSIGN(stage.rig, sensor::parse_rig(stage.rig_toml, request.rig.string()));
  if (request.phone) MIEN_TRY(add_phone(stage));
  stage.lab = request.devices == "lab";
  MIEN_TRY_ASSIGN(face::Face face, builtin_face::load_face(request.face));
  const Random root(request.seed);
  MIEN_TRY_ASSIGN(stage.worn, wear_all(request, std::move(face), root, stage));

  const double seconds = seconds_of(request);
  const bool streamed = holds == StageHolds::piece && stage.worn->streams(stage.lab);
  if (const double most_s = streamed ? kLongestPerformanceS : kLongestWholeS;
      !(seconds < most_s + 1 / kFrameRateHz))
    return fail(ErrorCode::out_of_range,
                fmt::format("the performance is {:.0f} s long, more than {:.0f}", seconds, most_s),
                request.script_name,
                streamed ? "perform it in parts; a time code may jump"
                         : fmt::format("perform it in parts, or with IMUs alone into a take: up to {:.0f} s",
                                       kLongestPerformanceS));
  if (const double from_s = request.headset_failure ? request.headset_failure->from_s.value_or(0) : 0;
      from_s > 0 && from_s >= seconds)
    return fail(
        ErrorCode::out_of_range,
        fmt::format("a headset's failure from {} s on, and the motion is over after {:.1f}", from_s, seconds),
        request.script_name, "let it begin before that, or perform for longer");
  const auto begin_with = [&](const face::Motion& motion) {
    stage.motion = performer::with_prologue(motion, request.prologue, root.fork("prologue"),
                                            stage.worn->prologue(stage));
    stage.duration_s = stage.motion.motion.duration_s();
  };
  if (request.motion) {
    MIEN_TRY_ASSIGN(const face::Motion motion, recorded_motion(request, stage.lab, root));
    begin_with(motion);
    if (const double end_s = stage.motion.times.motion_start_s + request.motion_s.value_or(0);
        end_s > stage.duration_s + 1 / kFrameRateHz) {
      stage.encore = performer::add_encore(stage.motion);
      stage.duration_s = end_s;
    }
  } else {
    const auto pieces = pieces_of(request, root);
    begin_with(pieces(0));
    if (!request.later_scripts.empty()) {
      stage.duration_s = stage.motion.times.motion_start_s + seconds - 1 / kFrameRateHz;
      stage.later = performer::LaterPieces{.draw = pieces, .duration_s = stage.duration_s};
    }
  }
  if (!streamed) {
    if (stage.encore) performer::repeat(stage.motion, *std::exchange(stage.encore, {}), stage.duration_s);
    if (stage.later) stage.motion = performer::join(std::move(stage.motion), *std::exchange(stage.later, {}));
    stage.duration_s = stage.motion.motion.duration_s();
  }
  stage.devices = root.fork("devices");
  return stage;
}

performer::LongMotion long_motion(const Stage& stage) {
  if (stage.encore) return {stage.motion, *stage.encore, stage.duration_s};
  if (stage.later) return {stage.motion, *stage.later};
  return performer::LongMotion(stage.motion);
}

Result<VirtualSession> play(const Stage& stage, const Progress& progress) {
  MIEN_TRY_ASSIGN(Sent sent, stage.worn->send(stage, progress));
  return receive_all(std::move(sent), stage.motion, stage.rig);
}

Result<std::unique_ptr<SessionStream>> stream(const Stage& stage) {
  if (stage.worn->streams(stage.lab)) return stage.worn->stream(stage);
  return std::make_unique<WholeSession>(stage);
}

}  // namespace mien::virt
