#include "mien/model/causal_network.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>

#include "mien/model/network_correction.h"
#include "tests/model/random_network.h"

namespace mien::model::causal_network_test {
namespace {

using Vector = std::vector<double>;

/// The network as its description has it: double precision, plain loops, nothing shared with the run time.
class Reference {
 public:
  Reference(const Architecture& a, const std::vector<Tensor>& network) : a_(a) {
    for (const Tensor& t : network) tensors_[t.name] = &t;
    states_.assign(a.layers, Vector(a.d_model, 0.0));
  }

  Vector step(const Vector& condition) {
    Vector x = linear("input", condition);
    for (double& v : x) v = std::max(v, 0.0);
    for (std::size_t i = 0; i < a_.layers; ++i) {
      Vector& state = states_[i];
      const Vector from_input = linear("layers." + std::to_string(i) + ".input", x);
      const Vector from_state = linear("layers." + std::to_string(i) + ".state", state);
      for (std::size_t j = 0; j < a_.d_model; ++j) {
        const auto part = [&](const Vector& parts, std::size_t n) { return parts[n * a_.d_model + j]; };
        const double r = sigmoid(part(from_input, 0) + part(from_state, 0));
        const double z = sigmoid(part(from_input, 1) + part(from_state, 1));
        const double n = std::tanh(part(from_input, 2) + r * part(from_state, 2));
        state[j] = (1 - z) * n + z * state[j];
        x[j] += state[j];
      }
    }
    return linear("output", x);
  }

 private:
  static double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }
  Vector linear(const std::string& name, const Vector& x) const {
    const Tensor& w = *tensors_.at(name + ".weight");
    const Tensor& b = *tensors_.at(name + ".bias");
    Vector y(b.values.begin(), b.values.end());
    for (std::size_t o = 0; o < y.size(); ++o)
      for (std::size_t i = 0; i < x.size(); ++i) y[o] += double{w.values[o * x.size() + i]} * x[i];
    return y;
  }
  Architecture a_;
  std::map<std::string, const Tensor*> tensors_;
  std::vector<Vector> states_;
};

Architecture small() {
  Architecture a = *named_architecture("causal", 21);
  a.layers = 3;
  a.d_model = 64;
  return a;
}

/// Frames of noise, louder than any that training sees.
std::vector<std::vector<float>> frames(std::size_t count, std::size_t width) {
  Random random(4);
  std::vector<std::vector<float>> out(count, std::vector<float>(width));
  for (auto& frame : out)
    for (float& v : frame) v = static_cast<float>(random.normal(0, 2));
  return out;
}

std::vector<float> run(const CausalNetwork& network, const std::vector<std::vector<float>>& conditions,
                       CausalNetwork::State& state) {
  std::vector<float> all, one(network.architecture().outputs);
  for (const auto& condition : conditions) {
    network.step(condition, state, one);
    all.insert(all.end(), one.begin(), one.end());
  }
  return all;
}

TEST(CausalNetwork, IsWhatItsDescriptionSays) {
  const Architecture a = small();
  const auto tensors = random_network(a, 3);
  const CausalNetwork network = CausalNetwork::create(a, tensors).value();
  CausalNetwork::State state(network);
  Reference reference(a, tensors);
  const auto conditions = frames(300, a.condition);
  const auto answer = run(network, conditions, state);
  for (std::size_t f = 0; f < conditions.size(); ++f) {
    const Vector expected = reference.step({conditions[f].begin(), conditions[f].end()});
    for (std::size_t j = 0; j < a.outputs; ++j)
      ASSERT_NEAR(answer[f * a.outputs + j], expected[j], 2e-5) << f << " " << j;
  }
}

TEST(CausalNetwork, ACorrectionIsPartOfItsOutputLayer) {
  const Architecture a = small();
  const auto tensors = random_network(a, 3);
  Random random(5);
  Correction correction{.network = correction_key(tensors),
                        .weights = std::vector<float>(a.outputs * a.d_model),
                        .bias = std::vector<float>(a.outputs)};
  for (float& weight : correction.weights) weight = static_cast<float>(random.normal(0, 0.05));
  for (float& bias : correction.bias) bias = static_cast<float>(random.normal(0, 0.2));
  const auto corrected_tensors = corrected_network(tensors, correction);
  EXPECT_NE(correction_key(corrected_tensors), correction.network);
  CausalNetwork network = CausalNetwork::create(a, tensors).value();
  network.correct(&correction);
  CausalNetwork::State state(network);
  Reference reference(a, corrected_tensors);
  const auto conditions = frames(100, a.condition);
  const auto answer = run(network, conditions, state);
  for (std::size_t f = 0; f < conditions.size(); ++f) {
    const Vector expected = reference.step({conditions[f].begin(), conditions[f].end()});
    for (std::size_t j = 0; j < a.outputs; ++j)
      ASSERT_NEAR(answer[f * a.outputs + j], expected[j], 2e-5) << f << " " << j;
  }
  // What the output layer reads is told: from it the answer follows.
  CausalNetwork::Workspace workspace(network);
  CausalNetwork::State* const one = &state;
  std::vector<float> out(a.outputs);
  network.step(conditions[0], std::span(&one, 1), workspace, out);
  const std::span<const float> hidden = workspace.hidden(0);
  ASSERT_EQ(hidden.size(), a.d_model);
  const Tensor &weight = corrected_tensors[corrected_tensors.size() - 2], &bias = corrected_tensors.back();
  for (std::size_t j = 0; j < a.outputs; ++j) {
    double sum = double{bias.values[j]};
    for (std::size_t i = 0; i < a.d_model; ++i)
      sum += double{weight.values[j * a.d_model + i]} * double{hidden[i]};
    EXPECT_NEAR(out[j], sum, 2e-5) << j;
  }
  // Taken back, it is the network that it was.
  network.correct(nullptr);
  CausalNetwork::State fresh(network);
  const CausalNetwork plain = CausalNetwork::create(a, tensors).value();
  CausalNetwork::State others(plain);
  EXPECT_EQ(run(network, conditions, fresh), run(plain, conditions, others));
}

TEST(CausalNetwork, TheSameAgainAfterAResetAndNotWithoutOne) {
  const Architecture a = small();
  const CausalNetwork network = CausalNetwork::create(a, random_network(a, 3)).value();
  CausalNetwork::State state(network), other(network);
  const auto conditions = frames(20, a.condition);
  const auto once = run(network, conditions, state);
  EXPECT_NE(run(network, conditions, state), once) << "it remembers";
  state.reset();
  EXPECT_EQ(run(network, conditions, state), once);
  EXPECT_EQ(run(network, conditions, other), once) << "states know nothing of each other";
}

TEST(CausalNetwork, SeveralPerformersGetTheBitsThatEachGetsAlone) {
  const Architecture a = small();
  const auto tensors = random_network(a, 3);
  for (const Precision precision : {Precision::fp32, Precision::bf16, Precision::int8}) {
    const CausalNetwork network = CausalNetwork::create(a, tensors, precision).value();
    EXPECT_EQ(network.precision(), precision);
    constexpr std::size_t kPerformers = 7, kFrames = 12;
    const auto conditions = frames(kPerformers * kFrames, a.condition);
    std::vector<CausalNetwork::State> states, lonely;
    std::vector<CausalNetwork::State*> crowd;
    for (std::size_t p = 0; p < kPerformers; ++p) lonely.emplace_back(network), states.emplace_back(network);
    CausalNetwork::Workspace workspace(network, kPerformers);
    for (std::size_t f = 0; f < kFrames; ++f) {
      // Not everybody's frame is due each time.
      crowd.clear();
      std::vector<float> rows, expected, one(a.outputs);
      for (std::size_t p = f % 3; p < kPerformers; ++p) {
        const auto& condition = conditions[f * kPerformers + p];
        crowd.push_back(&states[p]);
        rows.insert(rows.end(), condition.begin(), condition.end());
        network.step(condition, lonely[p], one);
        expected.insert(expected.end(), one.begin(), one.end());
      }
      std::vector<float> answer(expected.size());
      network.step(rows, crowd, workspace, answer);
      ASSERT_EQ(answer, expected) << precision_name(precision) << " " << f;
    }
  }
}

TEST(CausalNetwork, LowerPrecisionStaysNear) {
  const Architecture a = small();
  const auto tensors = random_network(a, 3);
  const auto conditions = frames(100, a.condition);
  const auto answer = [&](Precision precision) {
    const CausalNetwork network = CausalNetwork::create(a, tensors, precision).value();
    CausalNetwork::State state(network);
    return run(network, conditions, state);
  };
  const auto exact = answer(Precision::fp32);
  double size = 0;
  for (const float v : exact) size += double{v} * v;
  for (const auto& [precision, limit] : {std::pair{Precision::bf16, 0.02}, {Precision::int8, 0.05}}) {
    const auto near = answer(precision);
    double error = 0;
    for (std::size_t i = 0; i < near.size(); ++i) error += std::pow(double{near[i]} - double{exact[i]}, 2);
    EXPECT_LT(std::sqrt(error / size), limit) << precision_name(precision);
    EXPECT_GT(error, 0);
  }
}

TEST(CausalNetwork, WhatComesLaterChangesNothing) {
  const Architecture a = small();
  const CausalNetwork network = CausalNetwork::create(a, random_network(a, 3)).value();
  auto conditions = frames(20, a.condition);
  CausalNetwork::State state(network), other(network);
  const auto once = run(network, conditions, state);
  for (float& v : conditions[12]) v += 1;
  const auto changed = run(network, conditions, other);
  const auto outputs = static_cast<std::ptrdiff_t>(a.outputs);
  EXPECT_TRUE(std::equal(once.begin(), once.begin() + 12 * outputs, changed.begin()));
  EXPECT_NE(once, changed);
}

TEST(CausalNetwork, RefusesWhatDoesNotBelong) {
  const Architecture a = small();
  auto tensors = random_network(a, 3);
  const Architecture window = *named_architecture("light", 21);
  const auto other_kind = CausalNetwork::create(window, random_network(window, 1));
  ASSERT_FALSE(other_kind);
  EXPECT_EQ(other_kind.error().code, ErrorCode::mismatch);
  EXPECT_THAT(other_kind.error().message(), ::testing::HasSubstr("window network"));

  Architecture wrong = a;
  wrong.d_model = 33;
  EXPECT_EQ(CausalNetwork::create(wrong, tensors).error().code, ErrorCode::out_of_range);
  wrong = a;
  wrong.heads = 4;
  EXPECT_EQ(CausalNetwork::create(wrong, tensors).error().code, ErrorCode::out_of_range);
  wrong = a;
  wrong.condition = 22;
  EXPECT_EQ(CausalNetwork::create(wrong, tensors).error().code, ErrorCode::mismatch);
  std::swap(tensors[0], tensors[1]);
  EXPECT_EQ(CausalNetwork::create(a, tensors).error().code, ErrorCode::mismatch);
  tensors.pop_back();
  EXPECT_EQ(CausalNetwork::create(a, tensors).error().code, ErrorCode::mismatch);
}

TEST(CausalNetwork, IsSmall) {
  const Architecture a = *named_architecture("causal", 99);
  EXPECT_EQ(parameter_count(a), 828'725U);
  EXPECT_NEAR(flop_count(a), 1.65e6, 0.01e6);
}

}  // namespace
}  // namespace mien::model::causal_network_test
