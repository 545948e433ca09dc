#include "lab/imu/filmed_wearer.h"

#include <utility>

#include "mien/solve/trace_features.h"
#include "mien/virtual/phone/worn_phone.h"
#include "mien/virtual/reception.h"
#include "mien/virtual/stage.h"

namespace mien::lab {

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

Result<solve::PhoneTruth> truth_of(const FilmedWearer& filmed) {
  MIEN_TRY_ASSIGN(const solve::PhoneTrack track,
                  solve::phone_track(filmed.rig, filmed.session.samples, filmed.features.front().time));
  return solve::phone_truth(filmed.session.events, filmed.features, track);
}

}  // namespace mien::lab
