#include "lab/imu/ablation/takes_stand_in.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/error.h"
#include "mien/dataset/recorded_take.h"
#include "mien/face/motion.h"
#include "mien/model/features.h"
#include "mien/sensor/rig.h"
#include "mien/solve/phone_truth.h"
#include "mien/solve/trace_features.h"
#include "mien/synthetic/shifted_person.h"
#include "mien/virtual/performance.h"
#include "mien/virtual/performers.h"
#include "mien/virtual/phone/phone_faults.h"
#include "mien/virtual/phone/worn_phone.h"
#include "mien/virtual/reception.h"
#include "mien/virtual/session.h"
#include "mien/virtual/stage.h"
#include "mien/virtual/virtual_clock.h"

namespace mien::lab {
namespace {

/// Who wears IMUs, and what looks on.
struct WearerRequest {
  face::Motion motion;
  std::string face = "builtin";    ///< As builtin_face::load_face takes it.
  std::filesystem::path rig;       ///< Its file.
  std::string devices = "device";  ///< As virt::StageRequest has it, and so are these two.
  double unlike = 0;
  std::uint64_t seed = 1;
  std::optional<virt::PhoneFaults> phone;  ///< None: no phone looks on.
};

/// A performance, with a phone beside it or without, as a session received it.
struct FilmedWearer {
  sensor::Rig rig;
  virt::VirtualSession session;
  std::vector<model::FeatureFrame> features;  ///< One a tick of the session.
  virt::VirtualClock reference, phone;
  double phone_lag_s = 0;  ///< How much older the face is that the phone tells than its frame says.
};

/// The same request gives the same bits. Errors: those of the stage and the devices.
Result<FilmedWearer> film_wearer(const WearerRequest& request) {
  virt::StageRequest asked;
  asked.motion = request.motion;
  asked.script_name = request.motion.name;
  asked.face = request.face;
  asked.rig = request.rig;
  asked.devices = request.devices;
  asked.unlike = request.unlike;
  asked.seed = request.seed;
  asked.phone = request.phone.has_value();
  asked.phone_faults = request.phone;
  MIEN_TRY_ASSIGN(virt::Stage stage, virt::set_stage(asked));
  FilmedWearer filmed;
  MIEN_TRY_ASSIGN(virt::Sent sent, stage.worn->send(stage, no_progress));
  filmed.reference = sent.reference;
  if (request.phone) {
    const virt::PhoneSimulator shown = virt::phone_before(stage, *request.phone);
    filmed.phone = shown.clock();
    filmed.phone_lag_s = shown.lag_s();
  }
  MIEN_TRY_ASSIGN(filmed.session, virt::receive_all(std::move(sent), stage.motion, stage.rig));
  filmed.rig = std::move(stage.rig);
  const virt::VirtualSession& session = filmed.session;
  MIEN_TRY_ASSIGN(filmed.features,
                  solve::trace_features(filmed.rig, session.events, session.entries, session.ticks));
  return filmed;
}

/// What the phone told, aligned by what the sensors felt: the true times are not asked. Errors: phone_track's
/// and phone_truth's.
Result<solve::PhoneTruth> truth_of(const FilmedWearer& filmed) {
  MIEN_TRY_ASSIGN(const solve::PhoneTrack track,
                  solve::phone_track(filmed.rig, filmed.session.samples, filmed.features.front().time));
  return solve::phone_truth(filmed.session.events, filmed.features, track);
}

/// Of the built-in family; far from those that other studies draw.
constexpr std::uint64_t kFirstFace = 70'000;

struct StandInPerson {
  std::vector<dataset::Sequence> sequences;
  std::optional<std::string> left_out;
};

std::vector<dataset::Sequence> labelled(const FilmedWearer& filmed, const solve::PhoneTruth& truth,
                                        std::uint32_t performer) {
  std::vector<dataset::Sequence> out;
  dataset::Sequence stretch;
  const auto end_stretch = [&] {
    if (stretch.frames >= dataset::kShortestStretchFrames) out.push_back(std::move(stretch));
    stretch = {};
    stretch.performer = performer;
    stretch.from_take = true;
  };
  end_stretch();
  for (std::size_t f = 0; f < filmed.features.size(); ++f) {
    if (truth.frames[f].evaluated && truth.frames[f].has_face)
      dataset::append_frame(filmed.features[f].sensors, truth.frames[f].weights, stretch);
    else
      end_stretch();
  }
  end_stretch();
  return out;
}

Result<StandInPerson> stand_in(const StandInRequest& request, std::size_t p) {
  const Random root = Random(request.seed).fork("stand-in", p);
  const std::uint64_t number = kFirstFace + request.seed * 1000 + p;
  WearerRequest wearer;
  wearer.face = fmt::format("builtin:{}", number);
  wearer.rig = request.rig;
  wearer.unlike = root.fork("unlike").uniform();
  wearer.seed = number;
  wearer.phone = virt::usual_phone();
  wearer.motion = p % 2 == 0 ? virt::draw_motion(request.seconds, virt::draw_person(root).style, root)
                             : synthetic::draw_shifted_person(p / 2, request.seconds, root).motion;
  MIEN_TRY_ASSIGN(const FilmedWearer filmed, film_wearer(wearer));
  StandInPerson out;
  const Result<solve::PhoneTruth> truth = truth_of(filmed);
  if (!truth) {
    if (!is_bad_input(truth.error().code)) return std::unexpected(truth.error());
    out.left_out = fmt::format("person {}: {}", p + 1, truth.error().what);
    return out;
  }
  out.sequences = labelled(filmed, *truth, static_cast<std::uint32_t>(p));
  return out;
}

}  // namespace

Result<StandIn> stand_in_takes(const StandInRequest& request, const Progress& progress) {
  std::vector<StandInPerson> people(request.people);
  MIEN_TRY_ASSIGN(const sensor::Rig rig, sensor::read_rig(request.rig));
  MIEN_TRY(virt::for_each_performer(people.size(), 0, progress, [&](std::size_t p) -> Result<void> {
    MIEN_TRY_ASSIGN(people[p], stand_in(request, p));
    return {};
  }));
  StandIn out;
  out.data.train.sensors = out.data.validation.sensors = rig.face_sensor_names();
  for (std::size_t p = 0; p < people.size(); ++p) {
    if (people[p].left_out) out.left_out.push_back(*people[p].left_out);
    constexpr std::size_t kEvery = 5;
    dataset::Dataset& set = p % kEvery == kEvery - 1 ? out.data.validation : out.data.train;
    for (dataset::Sequence& sequence : people[p].sequences) set.sequences.push_back(std::move(sequence));
  }
  std::vector<dataset::Sequence>&train = out.data.train.sequences,
  &validation = out.data.validation.sequences;
  if (validation.empty() && !train.empty()) {
    // Whoever is the last of those who are labelled.
    const std::uint32_t last = train.back().performer;
    const auto from = std::ranges::find(train, last, &dataset::Sequence::performer);
    std::move(from, train.end(), std::back_inserter(validation));
    train.erase(from, train.end());
  }
  if (train.empty() || validation.empty())
    return fail(ErrorCode::not_found,
                "the phones' time was found of fewer than two, so that nobody is left to learn from or to "
                "validate on",
                "takes", "let more of them perform, or for longer");
  return out;
}

}  // namespace mien::lab
