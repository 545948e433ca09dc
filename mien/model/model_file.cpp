#include "mien/model/model_file.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "mien/core/files.h"
#include "mien/model/confidence_file.h"
#include "mien/model/network_correction.h"
#include "mien/model/network_parts.h"

namespace mien::model {
namespace {

using Json = nlohmann::json;
constexpr std::string_view kVersion = "1";
constexpr std::string_view kRidgePrefix = "ridge.";
constexpr const char* kStandardSkin = "skin.standard";
constexpr const char* kWearerSkin = "skin.wearer";
constexpr const char* kWeightCovariance = "skin.weight_covariance";
constexpr const char* kCorrection = "correction.weights";
constexpr const char* kCorrectionBias = "correction.bias";
/// Two whole turns per unit weight, rad.
constexpr float kMostSlope = 12.6F;

bool unique(const std::vector<std::string>& names) {
  return std::set<std::string>(names.begin(), names.end()).size() == names.size();
}

/// What only a denoiser has.
Result<void> check_sampling(const ModelFile& m, const std::string& where) {
  if (m.schedule.levels < 1 || m.schedule.levels > 100'000 ||
      !(m.schedule.offset >= 0 && m.schedule.offset <= 1))
    return fail(ErrorCode::out_of_range, "the noise schedule is outside its range", where);
  if (m.sampler.steps < 1 || m.sampler.steps > m.schedule.levels)
    return fail(ErrorCode::out_of_range, "the number of sampler steps is outside its range", where);
  if (!(m.sampler.first_noise >= 0 && m.sampler.first_noise <= 1))
    return fail(ErrorCode::out_of_range, "the sampler's first noise is outside its range", where);
  return {};
}

/// Whether the covariance is one: symmetric, and nowhere less than nothing.
bool is_covariance(const std::vector<float>& values, std::size_t shapes) {
  using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto size = static_cast<Eigen::Index>(shapes);
  const Eigen::MatrixXd c = Eigen::Map<const Matrix>(values.data(), size, size).cast<double>();
  // Sums in single precision: to a thousandth of the largest variance.
  const double rounding = 1e-3 * c.diagonal().maxCoeff() + 1e-9;
  if ((c - c.transpose()).cwiseAbs().maxCoeff() > rounding) return false;
  return (c + rounding * Eigen::MatrixXd::Identity(size, size)).llt().info() == Eigen::Success;
}

/// Slopes of every sensor, and a covariance that is one.
Result<void> check_skin(const ModelFile& m, const std::string& where) {
  const std::size_t shapes = m.shapes.size(), slopes = 3 * m.features.sensors.size() * shapes;
  const Skin& skin = *m.skin;
  if (skin.standard.size() != slopes || (!skin.wearer.empty() && skin.wearer.size() != slopes) ||
      skin.covariance.size() != shapes * shapes)
    return fail(ErrorCode::mismatch, "the skin has another size than sensors and shapes", where);
  for (const std::vector<float>* values : {&skin.standard, &skin.wearer, &skin.covariance})
    for (const float value : *values)
      if (!(std::abs(value) <= kMostSlope))
        return fail(ErrorCode::out_of_range, "the skin turns by what no skin does", where);
  if (!is_covariance(skin.covariance, shapes))
    return fail(ErrorCode::out_of_range, "the skin's covariance of the weights is none", where);
  return {};
}

Result<void> check_model(const ModelFile& m, const std::string& where) {
  if (const auto ok = check(m.architecture); !ok) return fail(ok.error().code, ok.error().what, where);
  const auto differ = [&](std::string what) { return fail(ErrorCode::mismatch, std::move(what), where); };
  const Architecture& a = m.architecture;
  if (m.features.sensors.empty() || m.features.width() != a.condition)
    return differ(
        fmt::format("{} sensors do not give {} numbers a frame", m.features.sensors.size(), a.condition));
  if (!unique(m.features.sensors)) return differ("two sensors have one name");
  if (m.shapes.size() != a.outputs || !unique(m.shapes))
    return differ(fmt::format("{} shape names do not name {} outputs", m.shapes.size(), a.outputs));
  if (m.mean_pose.size() != a.outputs) return differ("the mean pose has another number of shapes");
  if (m.normalisation.mean.size() != m.features.value_count() ||
      m.normalisation.scale.size() != m.features.value_count())
    return differ("the normalisation has another number of values than the sensors");
  for (const float scale : m.normalisation.scale)
    if (!(scale > 0)) return fail(ErrorCode::out_of_range, "a normalisation scale is not positive", where);
  if (a.kind == NetworkKind::window) MIEN_TRY(check_sampling(m, where));
  std::set<std::string> profiles;
  for (const RidgeBaseline& ridge : m.ridge) {
    if (!profiles.insert(ridge.profile).second) return differ("two ridges are for one profile");
    if (ridge.condition != a.condition || ridge.outputs != a.outputs ||
        ridge.matrix.size() != a.outputs * (a.condition + 1))
      return differ(fmt::format("the ridge for {} has another size", ridge.profile));
  }
  if (m.skin) MIEN_TRY(check_skin(m, where));
  if (m.confidence) MIEN_TRY(check(*m.confidence, m.shapes.size(), where));
  if (const auto ok = check_tensors(a, m.network); !ok) return differ(ok.error().what);
  if (m.correction) MIEN_TRY(check_correction(*m.correction, a, m.network, where));
  return {};
}

/// A metadata entry as JSON. Throws Json::exception on wrong content, as all reading of it below does.
Json entry(const TensorFile& file, const std::string& name) {
  const auto it = file.metadata.find(name);
  return it == file.metadata.end() ? Json() : Json::parse(it->second);
}

void read_sampling(const TensorFile& file, ModelFile& m) {
  const Json schedule = entry(file, "schedule");
  m.schedule.levels =
      schedule.at("levels").is_number_unsigned() ? schedule.at("levels").get<std::size_t>() : 0;
  m.schedule.offset = schedule.at("offset").get<double>();
  const Json sampler = entry(file, "sampler");
  m.sampler.kind = sampler.at("kind").get<std::string>() == "ddpm" ? SamplerKind::ddpm : SamplerKind::ddim;
  m.sampler.hold =
      sampler.at("hold").get<std::string>() == "clean" ? OverlapHold::clean : OverlapHold::noised;
  m.sampler.steps = sampler.at("steps").is_number_unsigned() ? sampler.at("steps").get<std::size_t>() : 0;
  m.sampler.seed = sampler.at("seed").get<std::uint64_t>();
  m.sampler.first_noise = sampler.value("first_noise", 1.0);
}

void read_metadata(const TensorFile& file, ModelFile& m) {
  const Json features = entry(file, "features");
  m.features.sensors = features.at("sensors").get<std::vector<std::string>>();
  m.features.presence_flags = features.at("presence_flags").get<bool>();
  m.shapes = entry(file, "shapes").get<std::vector<std::string>>();
  if (m.architecture.kind == NetworkKind::window) read_sampling(file, m);
  const auto text = [&](const char* name) {
    const auto it = file.metadata.find(name);
    return it == file.metadata.end() ? std::string() : it->second;
  };
  m.rig = text("rig");
  m.recipe = text("recipe");
  m.results = text("results");
}

/// Whose it is, where there is a correction; its numbers are tensors.
void read_correction(const TensorFile& file, ModelFile& m) {
  if (file.metadata.contains("correction"))
    m.correction = {
        .network = entry(file, "correction").at("network").get<std::string>(), .weights = {}, .bias = {}};
}

void read_ridges(const TensorFile& file, ModelFile& m) {
  for (const Json& r : entry(file, "ridge")) {
    RidgeBaseline& ridge = m.ridge.emplace_back();
    ridge.profile = r.at("profile").get<std::string>();
    ridge.penalty = r.at("penalty").get<double>();
    ridge.validation_mse = r.at("validation_mse").get<double>();
    ridge.condition = m.architecture.condition;
    ridge.outputs = m.architecture.outputs;
  }
}

Result<ModelFile> model_of(TensorFile file, const std::string& where) {
  ModelFile m;
  MIEN_TRY_ASSIGN(m.architecture,
                  architecture_of(file, "mien-model", kVersion, "a model of blendshape weights", where));
  try {
    read_metadata(file, m);
    read_ridges(file, m);
    read_correction(file, m);
  } catch (const Json::exception& error) {
    return wrong_description(error, where);
  }
  MIEN_TRY_ASSIGN(m.confidence, take_confidence(file, where));
  MIEN_TRY_ASSIGN(m.network, take_network(m.architecture, file, where));

  const auto take = [&](const std::string& name, std::vector<float>& into) {
    // What is missing is left empty, which check_model reports.
    if (auto values = take_tensor(name, file)) into = *std::move(values);
  };
  take("features.mean", m.normalisation.mean);
  take("features.scale", m.normalisation.scale);
  take("mean_pose", m.mean_pose);
  for (RidgeBaseline& ridge : m.ridge) take(std::string(kRidgePrefix) + ridge.profile, ridge.matrix);
  if (auto standard = take_tensor(kStandardSkin, file)) {
    m.skin.emplace().standard = *std::move(standard);
    take(kWeightCovariance, m.skin->covariance);
    take(kWearerSkin, m.skin->wearer);
  }
  if (m.correction) {
    take(kCorrection, m.correction->weights);
    take(kCorrectionBias, m.correction->bias);
  }
  MIEN_TRY(check_all_taken(file, where));
  MIEN_TRY(check_model(m, where));
  return m;
}

}  // namespace

const RidgeBaseline* ModelFile::ridge_for(std::string_view profile) const {
  for (const RidgeBaseline& candidate : ridge)
    if (candidate.profile == profile) return &candidate;
  return nullptr;
}

Result<ModelFile> parse_model(std::span<const std::byte> bytes, std::string_view where) {
  MIEN_TRY_ASSIGN(TensorFile file, parse_safetensors(bytes, where));
  return model_of(std::move(file), std::string(where));
}

Result<ModelFile> read_model(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(TensorFile file, read_safetensors(path));
  return model_of(std::move(file), path.string());
}

Result<std::vector<std::byte>> format_model(const ModelFile& m) {
  MIEN_TRY(check_model(m, "model"));
  const bool causal = m.architecture.kind == NetworkKind::causal;
  Json ridges = Json::array();
  for (const RidgeBaseline& r : m.ridge)
    ridges.push_back({{"profile", r.profile}, {"penalty", r.penalty}, {"validation_mse", r.validation_mse}});

  TensorFile file;
  file.metadata = {
      {"format", "mien-model"},
      {"version", std::string(kVersion)},
      {"architecture", format_architecture(m.architecture)},
      {"features",
       Json{{"sensors", m.features.sensors}, {"presence_flags", m.features.presence_flags}}.dump()},
      {"shapes", Json(m.shapes).dump()},
      {"ridge", ridges.dump()},
      {"rig", m.rig},
      {"recipe", m.recipe},
      {"results", m.results},
  };
  if (!causal) {
    file.metadata["schedule"] =
        Json{{"kind", "cosine"}, {"levels", m.schedule.levels}, {"offset", m.schedule.offset}}.dump();
    file.metadata["sampler"] = Json{{"kind", m.sampler.kind == SamplerKind::ddpm ? "ddpm" : "ddim"},
                                    {"steps", m.sampler.steps},
                                    {"seed", m.sampler.seed},
                                    {"first_noise", m.sampler.first_noise},
                                    {"hold", m.sampler.hold == OverlapHold::clean ? "clean" : "noised"}}
                                   .dump();
  }
  const auto add = [&](std::string name, std::vector<std::size_t> shape, const std::vector<float>& values) {
    file.tensors.push_back({.name = std::move(name), .shape = std::move(shape), .values = values});
  };
  add_network(m.network, file);
  add("features.mean", {m.normalisation.mean.size()}, m.normalisation.mean);
  add("features.scale", {m.normalisation.scale.size()}, m.normalisation.scale);
  add("mean_pose", {m.mean_pose.size()}, m.mean_pose);
  for (const RidgeBaseline& r : m.ridge)
    add(std::string(kRidgePrefix) + r.profile, {r.outputs, r.condition + 1}, r.matrix);
  if (m.skin) {
    const std::size_t shapes = m.shapes.size(), rows = 3 * m.features.sensors.size();
    add(kStandardSkin, {rows, shapes}, m.skin->standard);
    add(kWeightCovariance, {shapes, shapes}, m.skin->covariance);
    if (!m.skin->wearer.empty()) add(kWearerSkin, {rows, shapes}, m.skin->wearer);
  }
  if (m.correction) {
    file.metadata["correction"] = Json{{"network", m.correction->network}}.dump();
    add(kCorrection, {m.shapes.size(), m.architecture.d_model}, m.correction->weights);
    add(kCorrectionBias, {m.shapes.size()}, m.correction->bias);
  }
  if (m.confidence) add_confidence(*m.confidence, m.shapes.size(), file);
  return write_safetensors(file);
}

Result<void> write_model(const std::filesystem::path& path, const ModelFile& model) {
  MIEN_TRY_ASSIGN(const std::vector<std::byte> bytes, format_model(model));
  return write_file(path, bytes);
}

}  // namespace mien::model
