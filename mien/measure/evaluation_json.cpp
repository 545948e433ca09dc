#include "mien/measure/evaluation_json.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace mien::measure {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson to_json(const MeanStd& value) {
  return {{"mean", value.mean}, {"std", value.std}};
}

OrderedJson to_json(const EyesAndLips::Angle& value) {
  return {{"median", value.median}, {"p90", value.p90}};
}

OrderedJson to_json(double value) {
  return value;
}

OrderedJson to_json(const MotionErrors& value) {
  return {{"mse", value.mse}, {"pve_mm", value.pve_mm}};
}

OrderedJson to_json(const Interval& value) {
  return {{"mean", value.mean}, {"low", value.low}, {"high", value.high}};
}

OrderedJson to_json(const Wears& value) {
  return {
      {"count", value.count},
      {"pve_mm", to_json(value.pve_mm)},
      {"mse", to_json(value.mse)},
      {"about_rest", {{"pve_mm", to_json(value.pve_about_rest_mm)}, {"mse", to_json(value.mse_about_rest)}}}};
}

template <class T>
OrderedJson or_null(const std::optional<T>& value) {
  return value ? to_json(*value) : OrderedJson(nullptr);
}

OrderedJson to_json(const Metrics& metrics) {
  OrderedJson out;
  out["mse"] = metrics.mse;
  out["mse_observed"] = metrics.mse_observed;
  out["pve_mm"] = to_json(metrics.pve_mm);
  out["pve_face_mm"] = or_null(metrics.pve_face_mm);
  out["lmk_mm"] = or_null(metrics.lmk_mm);
  out["jitter_ratio"] = or_null(metrics.jitter_ratio);
  out["blink_f1"] = or_null(metrics.blink_f1);
  out["shut"] = metrics.shut;
  if (metrics.about_rest) out["about_rest"] = to_json(*metrics.about_rest);
  if (metrics.eyes_and_lips) {
    const EyesAndLips& eyes_and_lips = *metrics.eyes_and_lips;
    out["gaze_deg"] = or_null(eyes_and_lips.gaze_deg);
    out["openness_pearson"] = or_null(eyes_and_lips.openness_pearson);
    out["lip_gap_f1"] = or_null(eyes_and_lips.lip_gap_f1);
  }
  OrderedJson shapes = OrderedJson::object();
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    shapes[std::string(face::kShapeNames[k])] = {{"mae", metrics.per_shape[k].mae},
                                                 {"pearson", or_null(metrics.per_shape[k].pearson)}};
  out["per_shape"] = std::move(shapes);
  return out;
}

/// Of each shape the ways in which it came about at all, by name, with their shares of the frames.
OrderedJson to_json(const ProvenanceShares& shares) {
  OrderedJson out = OrderedJson::object();
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    OrderedJson& shape = out[std::string(face::kShapeNames[k])] = OrderedJson::object();
    for (std::size_t p = 0; p < kProvenanceCount; ++p)
      if (shares[k][p] > 0)
        shape[std::string(provenance_name(static_cast<face::Provenance>(p)))] = shares[k][p];
  }
  return out;
}

}  // namespace

std::string asked_how(const EvaluationContext& context) {
  if (context.steps == 0) return context.adapted ? "frame by frame, for the wearer" : "frame by frame";
  return fmt::format("{} denoising step{}", context.steps, context.steps == 1 ? "" : "s");
}

std::vector<std::string> caveats(const EvaluationContext& context) {
  std::vector<std::string> sentences;
  for (const ToldTruth& told : context.told)
    sentences.push_back(fmt::format(
        "The truth of {} was told by {}, {:.1f} s of it; its time is known to {:.1f} ms (agreement {:.2f}), "
        "and {}.",
        told.take, told.by, told.known_s, told.offset_sigma_ms, told.agreement,
        told.rest_known ? "what it told of the neutral face is taken off"
                        : "it did not see the neutral face, so that its resting offset is in it"));
  if (!sentences.empty())
    sentences.emplace_back(
        "A phone errs, too: its own errors count as the model's here, and its delay as nobody's; it smooths, "
        "so that jitter looks larger.");
  for (const std::string& name : context.trained_on)
    sentences.push_back(fmt::format(
        "The model was trained on {}: its error there is no measure of people whom it has not seen.", name));
  return sentences;
}

std::string evaluation_json(const Evaluation& evaluation, const EvaluationContext& context) {
  OrderedJson out;
  out["frames"] = evaluation.frames;
  out["takes"] = evaluation.takes;
  out["face"] = context.face;
  out["devices"] = context.devices;
  out["model_file"] = context.model;
  out["steps"] = context.steps > 0 ? OrderedJson(context.steps) : OrderedJson(nullptr);
  out["adapted"] = context.adapted;
  out["adapt_s"] = context.adapt_s;
  out["trained_on"] = context.trained_on;
  out["truth"] = context.told.empty() ? "own" : "told";
  OrderedJson& all_told = out["told"] = OrderedJson::array();
  for (const ToldTruth& told : context.told)
    all_told.push_back({{"take", told.take},
                        {"by", told.by},
                        {"known_s", told.known_s},
                        {"rest_known", told.rest_known},
                        {"agreement", told.agreement},
                        {"offset_ms", told.offset_ms},
                        {"offset_sigma_ms", told.offset_sigma_ms}});
  out["model"] = to_json(evaluation.model);
  out["model"]["ece"] = or_null(evaluation.ece);
  out["provenance"] = evaluation.provenance ? to_json(*evaluation.provenance) : OrderedJson(nullptr);
  out["baselines"]["mean_pose"] = to_json(evaluation.mean_pose);
  out["baselines"]["hold_last"] = to_json(evaluation.hold_last);
  out["baselines"]["ridge"] = evaluation.ridge ? to_json(*evaluation.ridge) : OrderedJson(nullptr);
  out["truth_shut"] = evaluation.model.truth_shut;
  if (evaluation.blinking) out["blinking"] = to_json(*evaluation.blinking);
  if (evaluation.wears) out["wears"] = to_json(*evaluation.wears);
  if (!evaluation.ablations.empty()) {
    OrderedJson& ablations = out["ablations"] = OrderedJson::array();
    for (const Ablation& one : evaluation.ablations)
      ablations.push_back(
          {{"without", one.without}, {"changed", one.changed}, {"metrics", to_json(one.metrics)}});
  }
  if (!evaluation.pieces.empty()) {
    OrderedJson& takes = out["pieces"] = OrderedJson::array();
    for (const TakePieces& of : evaluation.pieces) {
      OrderedJson rows = OrderedJson::array();
      for (const Piece& piece : of.pieces)
        rows.push_back({{"begin_s", piece.begin_s},
                        {"frames", piece.frames},
                        {"mse", piece.mse},
                        {"mean_pose_mse", piece.mean_pose_mse},
                        {"ratio", piece.ratio},
                        {"biased_shape",
                         piece.biased_shape ? OrderedJson(std::string(face::kShapeNames[*piece.biased_shape]))
                                            : OrderedJson(nullptr)},
                        {"bias", piece.bias}});
      takes.push_back({{"take", of.take}, {"pieces", std::move(rows)}});
    }
  }
  // A path may be any bytes: what is no UTF-8 is replaced.
  return out.dump(2, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace mien::measure
