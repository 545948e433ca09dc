#include "mien/virtual/phone/worn_phone.h"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/phone/live_link.h"
#include "mien/virtual/node.h"
#include "mien/virtual/reception.h"
#include "mien/virtual/speaking_node.h"

namespace mien::virt {
namespace {

constexpr std::string_view kPhone = "phone";

/// When it ends, true time: with the motion, while sensors go on for kDeviceMarginS. So a usual one's last
/// packet comes before theirs, and a take is as long with it as without.
double film_ends_s(const face::MotionCurve& curve) {
  return curve.duration_s();
}

class PhoneOnNetwork final : public SpeakingDevices {
 public:
  PhoneOnNetwork(PhoneSimulator phone, const PlayedMotion& motion)
      : SpeakingDevices(motion, film_ends_s(motion.curve)), phone_(std::move(phone)) {
    nodes_.emplace_back(phone::kLiveLinkDevice);
  }
  [[nodiscard]] Result<void> simulate() override {
    simulated_s_ += 1 / kFrameRateHz;
    sent_.clear();
    while (phone_.filmed_s() < simulated_s_)
      phone_.film([this](double true_s) { return motion_.at(true_s); }, sent_);
    for (Datagram& packet : sent_) nodes_.front().hand_over(std::move(packet));
    return {};
  }

 private:
  PhoneSimulator phone_;
  std::vector<Datagram> sent_;
};

/// The phone of these faults on that stage: what it sends, and its clock, are the same whenever it is asked
/// for.
PhoneSimulator phone_before(const Stage& stage, const PhoneFaults& faults) {
  return {faults, stage.motion.times.motion_start_s, stage.devices.fork(kPhone)};
}

}  // namespace

performer::PrologueNeeds WornPhone::prologue(const Stage&) const {
  return {.neutral_s = 0, .gestures = false};
}

Result<Sent> WornPhone::send(const Stage& stage, const Progress&) const {
  MIEN_TRY_ASSIGN(const face::MotionCurve curve, curve_of(stage.motion));
  const auto performed = [&](double true_s) { return curve.at(true_s); };
  PhoneSimulator phone = phone_before(stage, faults_);
  Sent sent;
  sent.reference = phone.clock();
  while (phone.filmed_s() < film_ends_s(curve)) phone.film(performed, sent.datagrams);
  return sent;
}

Result<std::unique_ptr<NodeDevices>> WornPhone::on_network(const Stage& stage, const PlayedMotion& motion,
                                                           NodeLanguage) const {
  return std::make_unique<PhoneOnNetwork>(phone_before(stage, faults_), motion);
}

Result<std::shared_ptr<const WornDevices>> wear_phone(const StageRequest& request, face::Face, const Random&,
                                                      const Stage& stage) {
  const std::string where = "rig " + stage.rig.name;
  if (stage.rig.sensors.size() > 1)
    return fail(
        ErrorCode::unsupported,
        fmt::format("a virtual performer has one phone, and the rig has {} sensors of the kind weights",
                    stage.rig.sensors.size()),
        where, "leave one of them");
  MIEN_TRY_ASSIGN(const std::vector<sensor::DeviceKey> devices, virtual_devices(stage.rig));
  constexpr sensor::DeviceKey kFirstHeard{phone::kLiveLinkDevice, 0};
  if (devices.front() != kFirstHeard)
    return fail(ErrorCode::bad_usage,
                fmt::format("'{}' is bound to {}, which no virtual phone is", stage.rig.sensors.front().name,
                            sensor::format_device(devices.front())),
                where, fmt::format("write device = \"{}\" at it", sensor::format_device(kFirstHeard)));
  PhoneFaults faults;
  if (request.phone_faults) {
    faults = *request.phone_faults;
  } else if (!stage.lab) {
    MIEN_TRY_ASSIGN(const FaultsText text, read_faults(request, stage.rig, kPhone));
    faults = usual_phone();
    if (text.stated) {
      MIEN_TRY_ASSIGN(faults, parse_phone_faults(text.toml, text.where));
    }
  }
  return std::make_shared<const WornPhone>(faults);
}

}  // namespace mien::virt
