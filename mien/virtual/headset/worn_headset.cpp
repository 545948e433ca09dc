#include "mien/virtual/headset/worn_headset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "mien/builtin_face/person.h"
#include "mien/builtin_face/skin_marks.h"
#include "mien/core/bytes.h"
#include "mien/headset/picture_packet.h"
#include "mien/virtual/node.h"
#include "mien/virtual/reception.h"
#include "mien/virtual/worn_together.h"

namespace mien::virt {
namespace {

/// The failure as a take tells of it.
take::Event event_of(const TimedFailure& failure, const std::optional<std::array<bool, 2>>& seen,
                     const Stage& stage, double end_s, const VirtualClock& reference) {
  const double start_s = stage.motion.times.motion_start_s;
  const double from_s = failure.from_s ? start_s + *failure.from_s : 0.0;
  const double to_s = failure.to_s ? std::min(end_s, start_s + *failure.to_s) : end_s;
  const auto [upper, lower] = seen.value_or(std::array{true, true});
  return {"headset_failure", reference.device(from_s), reference.device(std::max(from_s, to_s)),
          fmt::format(R"({{"name": "{}", "sees_upper": {}, "sees_lower": {}}})",
                      failure_name(failure.failure), upper, lower)};
}

}  // namespace

performer::PrologueNeeds WornHeadset::prologue(const Stage&) const {
  return {.neutral_s = 3, .gestures = false};
}

Result<HeadsetBoards> WornHeadset::boards(const Stage& stage, int width, double rate_hz) const {
  return HeadsetBoards::put_on(
      wearer_, rig_, faults_, stage.devices,
      {.width = width, .rate_hz = rate_hz, .failure = failure_ ? failure_->failure : HeadsetFailure::none});
}

HeadsetMoment WornHeadset::moment_at(const Stage& stage, const PlayedMotion& motion, double true_s) const {
  const face::MotionFrame frame = motion.at(motion.encore ? std::max(0.0, true_s) : true_s);
  HeadsetMoment moment;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    moment.pose.weights[k] = std::clamp(frame.weights[k], 0.0F, 1.0F);
  moment.pose.tongue_out = std::clamp(frame.tongue_out, 0.0F, 1.0F);
  if (failure_) {
    // By the motion's own time, so that an encore has it again.
    const double motion_s = (motion.encore ? frame.time_s : true_s) - stage.motion.times.motion_start_s;
    moment.fails = (!failure_->from_s || motion_s >= *failure_->from_s) &&
                   (!failure_->to_s || motion_s < *failure_->to_s);
  }
  return moment;
}

Result<Sent> WornHeadset::send(const Stage& stage, const Progress& progress) const {
  const std::string& name = stage.motion.motion.name;
  MIEN_TRY_ASSIGN(const face::MotionCurve curve, curve_of(stage.motion));
  if (!(curve.duration_s() <= kLongestS))
    return fail(ErrorCode::out_of_range,
                fmt::format("pictures of {:.0f} s do not fit into memory", curve.duration_s()), name,
                fmt::format("film at most {:.0f} s at once, with the prologue", kLongestS));
  MIEN_TRY_ASSIGN(HeadsetBoards boards, this->boards(stage));
  const std::optional<performer::Encore> once;
  const auto at = [&](double true_s) { return moment_at(stage, {curve, once}, true_s); };
  const double end_s = curve.duration_s() + kDeviceMarginS;

  Sent sent;
  std::vector<BoardPicture> pictures;
  std::vector<bool> begun(boards.cameras());
  while (boards.shot_s() < end_s) {
    if (!progress(std::clamp(boards.shot_s() / end_s, 0.0, 1.0), "filming"))
      return fail(ErrorCode::cancelled, "stopped", name);
    pictures.clear();
    MIEN_TRY(boards.shoot(at, pictures));
    for (BoardPicture& picture : pictures) {
      ByteWriter packet;
      MIEN_TRY(headset::write_picture_packet({.from = boards.device(picture.camera),
                                              .sequence = picture.sequence,
                                              .time = boards.clock(picture.camera).device(picture.read_s),
                                              .first = !begun[picture.camera]},
                                             packet));
      begun[picture.camera] = true;
      sent.datagrams.push_back({.time = HostTime(from_seconds(picture.arrival_s)),
                                .source = static_cast<std::uint16_t>(picture.camera),
                                .bytes = {packet.bytes().begin(), packet.bytes().end()},
                                .payload = std::move(picture.jpeg)});
    }
  }
  const std::uint16_t reference = rig_.find(rig_.reference).value_or(0);
  for (std::size_t c = 0; c < boards.cameras(); ++c)
    if (rig_.find(wearer_.cameras[c].name) == reference) sent.reference = boards.clock(c);
  if (failure_)
    sent.events.push_back(
        event_of(*failure_, boards.seen_in_failure(), stage, curve.duration_s(), sent.reference));
  return sent;
}

Result<std::unique_ptr<NodeDevices>> WornHeadset::on_network(const Stage&, const PlayedMotion&,
                                                             NodeLanguage) const {
  return fail(ErrorCode::bad_usage, "cameras send nothing of themselves, they are asked", rig_.name,
              "offer their pictures, and nothing else: --to http://HOST:PORT");
}

Result<std::shared_ptr<const WornDevices>> wear_headset(const StageRequest& request, face::Face face,
                                                        const Random& root, const Stage& stage) {
  if (stage.lab)
    return fail(ErrorCode::bad_usage, "the profile lab is of sensors on the skin, and cameras look at it",
                stage.rig.name, "use --devices device");
  if (request.unlike > 0 && !stage.together)
    return fail(ErrorCode::bad_usage, "only sensors that are glued to it feel how skin turns", stage.rig.name,
                "leave out --unlike");
  MIEN_TRY_ASSIGN(const FaultsText text, read_faults(request, stage.rig, stage.together ? "headset" : ""));
  MIEN_TRY_ASSIGN(HeadsetFaults faults, parse_headset_faults(text.toml, text.where));
  MIEN_TRY(virtual_devices(stage.rig));
  face::SkinMarks marks;
  if (builtin_face::names_person(request.face)) {
    // As cameras see people in infrared light, and without the hair that a headset lies on.
    MIEN_TRY_ASSIGN(const builtin_face::Person person, builtin_face::find_person(request.face));
    const builtin_face::BuiltinParameters bare = builtin_face::without_hair(person.parameters);
    face = builtin_face::make_builtin(bare);
    builtin_face::paint_infrared(face, bare);
    marks = builtin_face::skin_marks(bare, face);
  }
  MIEN_TRY_ASSIGN(HeadsetWearer wearer,
                  seat_headset(std::move(face), stage.rig, faults, root.fork("wearer")));
  wearer.looks.marks = std::move(marks);
  return std::make_shared<const WornHeadset>(stage.rig, std::move(faults), std::move(wearer),
                                             request.headset_failure);
}

const WornHeadset* headset_of(const Stage& stage) {
  const auto headset_in = [](const std::shared_ptr<const WornDevices>& worn) {
    return dynamic_cast<const WornHeadset*>(worn.get());
  };
  if (const auto* const together = dynamic_cast<const WornTogether*>(stage.worn.get()))
    for (const WornTogether::Part& part : together->parts())
      if (const WornHeadset* const headset = headset_in(part.worn)) return headset;
  return headset_in(stage.worn);
}

}  // namespace mien::virt
