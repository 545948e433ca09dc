#include "mien/virtual/worn_together.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace mien::virt {
namespace {

class TogetherOnNetwork final : public NodeDevices {
 public:
  TogetherOnNetwork(std::unique_ptr<NodeDevices> one, std::unique_ptr<NodeDevices> other)
      : one_(std::move(one)), other_(std::move(other)) {}
  [[nodiscard]] std::vector<Node*> nodes() override {
    std::vector<Node*> all = one_->nodes();
    std::ranges::copy(other_->nodes(), std::back_inserter(all));
    return all;
  }
  /// The one that is behind, so that neither runs far ahead.
  [[nodiscard]] Result<void> simulate() override {
    const bool first = other_->done() || (!one_->done() && one_->simulated_s() <= other_->simulated_s());
    return (first ? *one_ : *other_).simulate();
  }
  [[nodiscard]] double simulated_s() const override {
    if (one_->done()) return other_->simulated_s();
    if (other_->done()) return one_->simulated_s();
    return std::min(one_->simulated_s(), other_->simulated_s());
  }
  [[nodiscard]] bool done() const override { return one_->done() && other_->done(); }

 private:
  std::unique_ptr<NodeDevices> one_, other_;
};

}  // namespace

performer::PrologueNeeds WornTogether::prologue(const Stage& stage) const {
  return feeling_.worn->prologue(stage);
}

Result<Sent> WornTogether::send(const Stage& stage, const Progress& progress) const {
  MIEN_TRY_ASSIGN(Sent all, feeling_.worn->send(stage, progress));
  MIEN_TRY_ASSIGN(Sent heard, hearing_->send(stage, progress));
  std::ranges::move(heard.datagrams, std::back_inserter(all.datagrams));
  return all;
}

std::vector<take::CalibrationVersion> WornTogether::calibrations(const Stage& stage,
                                                                 const VirtualSession& session) const {
  VirtualSession felt;
  felt.ticks = session.ticks;
  felt.events = session.events;
  for (const take::StoredSample& stored : session.samples) {
    const auto found = std::ranges::find(feeling_.sensors, stored.sample.sensor);
    if (found == feeling_.sensors.end()) continue;
    felt.samples.push_back(stored);
    felt.samples.back().sample.sensor = static_cast<std::uint16_t>(found - feeling_.sensors.begin());
  }
  return feeling_.worn->calibrations(stage, felt);
}

Result<std::unique_ptr<NodeDevices>> WornTogether::on_network(const Stage& stage, const PlayedMotion& motion,
                                                              NodeLanguage language) const {
  MIEN_TRY_ASSIGN(auto feeling, feeling_.worn->on_network(stage, motion, language));
  MIEN_TRY_ASSIGN(auto hearing, hearing_->on_network(stage, motion, language));
  return std::make_unique<TogetherOnNetwork>(std::move(feeling), std::move(hearing));
}

}  // namespace mien::virt
