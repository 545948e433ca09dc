#include "mien/virtual/worn_together.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string_view>
#include <utility>

namespace mien::virt {
namespace {

class TogetherOnNetwork final : public NodeDevices {
 public:
  explicit TogetherOnNetwork(std::vector<std::unique_ptr<NodeDevices>> parts) : parts_(std::move(parts)) {}
  [[nodiscard]] std::vector<Node*> nodes() override {
    std::vector<Node*> all;
    for (const auto& part : parts_) std::ranges::copy(part->nodes(), std::back_inserter(all));
    return all;
  }
  /// The one that is behind, so that none runs far ahead.
  [[nodiscard]] Result<void> simulate() override { return behind().simulate(); }
  [[nodiscard]] double simulated_s() const override { return behind().simulated_s(); }
  [[nodiscard]] bool done() const override { return std::ranges::all_of(parts_, &NodeDevices::done); }

 private:
  /// Of those that are not done the one that is simulated least; of done ones the one that ended first.
  [[nodiscard]] NodeDevices& behind() const {
    return **std::ranges::min_element(parts_, {}, [](const std::unique_ptr<NodeDevices>& part) {
      return std::pair(part->done(), part->simulated_s());
    });
  }
  std::vector<std::unique_ptr<NodeDevices>> parts_;
};

}  // namespace

performer::PrologueNeeds WornTogether::prologue(const Stage& stage) const {
  performer::PrologueNeeds all{.neutral_s = 0, .gestures = false};
  for (const Part& part : parts_) {
    const performer::PrologueNeeds one = part.worn->prologue(stage);
    all.neutral_s = std::max(all.neutral_s, one.neutral_s);
    all.gestures = all.gestures || one.gestures;
  }
  return all;
}

Result<Sent> WornTogether::send(const Stage& stage, const Progress& progress) const {
  Sent all;
  const auto count = static_cast<double>(parts_.size());
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    MIEN_TRY_ASSIGN(Sent sent, parts_[p].worn->send(stage, [&](double share, std::string_view what) {
      return progress((static_cast<double>(p) + share) / count, what);
    }));
    if (p == 0) {
      all = std::move(sent);
      continue;
    }
    std::ranges::move(sent.datagrams, std::back_inserter(all.datagrams));
    // What befell them is told on their own clock.
    for (take::Event& event : sent.events) {
      event.begin = all.reference.device(sent.reference.true_s(event.begin));
      event.end = all.reference.device(sent.reference.true_s(event.end));
      all.events.push_back(std::move(event));
    }
  }
  return all;
}

Result<std::unique_ptr<NodeDevices>> WornTogether::on_network(const Stage& stage, const PlayedMotion& motion,
                                                              NodeLanguage language) const {
  std::vector<std::unique_ptr<NodeDevices>> all;
  for (const Part& part : parts_) {
    if (part.worn->are_asked()) continue;
    MIEN_TRY_ASSIGN(all.emplace_back(), part.worn->on_network(stage, motion, language));
  }
  return std::make_unique<TogetherOnNetwork>(std::move(all));
}

}  // namespace mien::virt
