#include "mien/model/denoiser.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "tests/model/random_network.h"

namespace mien::model::denoiser_test {
namespace {

using Matrix = std::vector<std::vector<double>>;

/// The network as the papers write it: double precision, plain loops, nothing shared with the run time.
class Reference {
 public:
  Reference(const Architecture& a, const std::vector<Tensor>& network) : a_(a) {
    for (const Tensor& t : network) tensors_[t.name] = &t;
  }

  Matrix predict(const Matrix& noisy, const Matrix& condition, std::size_t level) const {
    std::vector<double> sinusoid(64);
    for (std::size_t i = 0; i < 32; ++i) {
      const double angle = static_cast<double>(level) * std::pow(10000.0, -static_cast<double>(i) / 31);
      sinusoid[i] = std::sin(angle);
      sinusoid[32 + i] = std::cos(angle);
    }
    auto hidden = linear("noise.hidden", sinusoid);
    for (double& v : hidden) v = v * 0.5 * std::erfc(-v / std::numbers::sqrt2);
    Matrix tokens = {linear("noise.out", hidden)};
    for (std::size_t f = 0; f < noisy.size(); ++f) {
      std::vector<double> frame = noisy[f];
      frame.insert(frame.end(), condition[f].begin(), condition[f].end());
      tokens.push_back(linear("input", frame));
    }
    for (std::size_t t = 0; t < tokens.size(); ++t)
      for (std::size_t j = 0; j < a_.d_model; ++j) {
        const double angle =
            static_cast<double>(t + 1) /
            std::pow(10000.0, 2.0 * std::floor(static_cast<double>(j) / 2) / static_cast<double>(a_.d_model));
        tokens[t][j] += j % 2 == 0 ? std::sin(angle) : std::cos(angle);
      }
    for (std::size_t i = 0; i < a_.layers; ++i) layer("layers." + std::to_string(i) + ".", tokens);
    Matrix out;
    for (std::size_t t = 1; t < tokens.size(); ++t) out.push_back(linear("output", tokens[t]));
    return out;
  }

 private:
  std::vector<double> linear(const std::string& name, const std::vector<double>& x) const {
    const Tensor& w = *tensors_.at(name + ".weight");
    const Tensor& b = *tensors_.at(name + ".bias");
    std::vector<double> y(b.values.begin(), b.values.end());
    for (std::size_t o = 0; o < y.size(); ++o)
      for (std::size_t i = 0; i < x.size(); ++i) y[o] += double{w.values[o * x.size() + i]} * x[i];
    return y;
  }
  void add_and_normalise(const std::string& name, const std::vector<double>& change,
                         std::vector<double>& x) const {
    double mean = 0, variance = 0;
    for (std::size_t j = 0; j < x.size(); ++j) mean += (x[j] += change[j]) / static_cast<double>(x.size());
    for (const double v : x) variance += (v - mean) * (v - mean) / static_cast<double>(x.size());
    for (std::size_t j = 0; j < x.size(); ++j)
      x[j] = (x[j] - mean) / std::sqrt(variance + 1e-5) * double{tensors_.at(name + ".weight")->values[j]} +
             double{tensors_.at(name + ".bias")->values[j]};
  }
  void layer(const std::string& name, Matrix& tokens) const {
    Matrix q, k, v, attended;
    for (const auto& x : tokens) {
      q.push_back(linear(name + "query", x));
      k.push_back(linear(name + "key", x));
      v.push_back(linear(name + "value", x));
    }
    for (std::size_t t = 0; t < tokens.size(); ++t) {
      std::vector<double> mixed(a_.d_attention(), 0.0);
      for (std::size_t head = 0; head < a_.heads; ++head) {
        std::vector<double> share;
        double sum = 0;
        for (std::size_t s = 0; s < tokens.size(); ++s) {
          double dot = 0;
          for (std::size_t i = 0; i < a_.d_head; ++i)
            dot += q[t][head * a_.d_head + i] * k[s][head * a_.d_head + i];
          share.push_back(std::exp(dot / std::sqrt(static_cast<double>(a_.d_head))));
          sum += share.back();
        }
        for (std::size_t s = 0; s < tokens.size(); ++s)
          for (std::size_t i = 0; i < a_.d_head; ++i)
            mixed[head * a_.d_head + i] += share[s] / sum * v[s][head * a_.d_head + i];
      }
      attended.push_back(linear(name + "attended", mixed));
    }
    for (std::size_t t = 0; t < tokens.size(); ++t) {
      add_and_normalise(name + "attention_norm", attended[t], tokens[t]);
      auto hidden = linear(name + "ffn.hidden", tokens[t]);
      for (double& h : hidden) h = std::max(h, 0.0);
      add_and_normalise(name + "ffn_norm", linear(name + "ffn.out", hidden), tokens[t]);
    }
  }
  Architecture a_;
  std::map<std::string, const Tensor*> tensors_;
};

std::vector<float> numbers(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(random.normal());
  return values;
}

Matrix rows_of(const std::vector<float>& values, std::size_t width) {
  Matrix rows;
  for (std::size_t at = 0; at < values.size(); at += width)
    rows.emplace_back(values.begin() + static_cast<std::ptrdiff_t>(at),
                      values.begin() + static_cast<std::ptrdiff_t>(at + width));
  return rows;
}

double largest_difference(const Architecture& a, std::size_t frames, std::size_t level) {
  const auto network = random_network(a, 3);
  const auto denoiser = Denoiser::create(a, network);
  if (!denoiser) return 1e9;
  const auto condition = numbers(frames * a.condition, 1), noisy = numbers(frames * a.outputs, 2);
  Denoiser::Workspace workspace(*denoiser);
  std::vector<float> clean(noisy.size());
  denoiser->set_condition(condition, workspace);
  denoiser->predict(noisy, level, clean, workspace);
  const Matrix expected =
      Reference(a, network).predict(rows_of(noisy, a.outputs), rows_of(condition, a.condition), level);
  double difference = 0;
  for (std::size_t i = 0; i < clean.size(); ++i)
    difference = std::max(difference, std::abs(double{clean[i]} - expected[i / a.outputs][i % a.outputs]));
  return difference;
}

const Architecture kSmall{.name = {},
                          .layers = 2,
                          .d_model = 64,
                          .heads = 2,
                          .d_head = 32,
                          .ffn = 96,
                          .window = 40,
                          .condition = 18,
                          .outputs = 53};

TEST(Denoiser, AgreesWithThePapersInDoublePrecision) {
  for (const std::size_t level : {0U, 1U, 499U, 999U})
    EXPECT_LT(largest_difference(kSmall, 40, level), 2e-5) << level;
}

TEST(Denoiser, ShortWindowsAgreeToo) {
  for (const std::size_t frames : {1U, 2U, 31U, 32U, 39U})
    EXPECT_LT(largest_difference(kSmall, frames, 300), 2e-5) << frames;
}

TEST(Denoiser, TheLightNetworkAgrees) {
  EXPECT_LT(largest_difference(*named_architecture("light", 99), 120, 700), 5e-5);
}

TEST(Denoiser, OneWorkspaceServesWindowsOfAnyLength) {
  const auto network = random_network(kSmall, 3);
  const auto denoiser = Denoiser::create(kSmall, network);
  ASSERT_TRUE(denoiser);
  const auto condition = numbers(40 * 18, 1), noisy = numbers(40 * 53, 2);
  const auto short_window = [&](Denoiser::Workspace& workspace) {
    std::vector<float> clean(7 * 53);
    denoiser->set_condition(std::span(condition).first(7 * 18), workspace);
    denoiser->predict(std::span(noisy).first(7 * 53), 500, clean, workspace);
    return clean;
  };
  Denoiser::Workspace used(*denoiser), fresh(*denoiser);
  std::vector<float> clean(40 * 53);
  denoiser->set_condition(condition, used);
  denoiser->predict(noisy, 900, clean, used);
  EXPECT_EQ(short_window(used), short_window(fresh));
}

TEST(Denoiser, LowerPrecisionStaysNear) {
  const auto network = random_network(kSmall, 3);
  const auto condition = numbers(40 * 18, 1), noisy = numbers(40 * 53, 2);
  const auto answer = [&](Precision precision) {
    const auto denoiser = Denoiser::create(kSmall, network, precision);
    Denoiser::Workspace workspace(*denoiser);
    std::vector<float> clean(noisy.size());
    denoiser->set_condition(condition, workspace);
    denoiser->predict(noisy, 300, clean, workspace);
    return clean;
  };
  const auto exact = answer(Precision::fp32);
  double size = 0;
  for (const float v : exact) size += double{v} * double{v};
  for (const auto& [precision, limit] : {std::pair{Precision::bf16, 0.02}, {Precision::int8, 0.05}}) {
    const auto near = answer(precision);
    double error = 0;
    for (std::size_t i = 0; i < near.size(); ++i) error += std::pow(double{near[i]} - double{exact[i]}, 2);
    EXPECT_LT(std::sqrt(error / size), limit) << precision_name(precision);
  }
}

TEST(Denoiser, RefusesNetworksOfAnotherSize) {
  auto network = random_network(kSmall, 3);
  Architecture other = kSmall;
  other.ffn = 128;
  EXPECT_FALSE(Denoiser::create(other, network));
  network[0].values.pop_back();
  EXPECT_FALSE(Denoiser::create(kSmall, network));
}

}  // namespace
}  // namespace mien::model::denoiser_test
