#include "mien/train/recipe.h"

#include <limits>
#include <numbers>
#include <sstream>

#include "mien/core/toml.h"
#include "mien/synthetic/recipe_table.h"

namespace mien::train {

Result<Recipe> parse_recipe(std::string_view text, std::string_view where_view) {
  const std::string where(where_view);
  MIEN_TRY_ASSIGN(const toml::table root, parse_toml(text, where));
  constexpr std::int64_t kMany = 1'000'000'000;
  Recipe r;
  r.text = text;

  synthetic::RecipeTable top(root, "", where);
  top.number("seed", r.seed, 0, std::numeric_limits<std::int64_t>::max());
  const toml::table network = top.inner("network"), optimiser = top.inner("optimiser"),
                    noise = top.inner("noise"), augmentation = top.inner("augmentation"),
                    validation = top.inner("validation"), sampler = top.inner("sampler"),
                    budget = top.inner("budget"), takes = top.inner("takes");
  std::ostringstream data;
  data << top.inner("data");
  r.data = data.str();
  MIEN_TRY(top.finish());

  synthetic::RecipeTable n(network, "network.", where);
  const std::string name =
      n.choice("architecture", {"light", "faithful", "causal", "views"}).value_or("light");
  const bool known =
      name == "faithful" || name == "causal" || name == "views";  // The choice reports another in finish().
  MIEN_TRY_ASSIGN(r.architecture, model::named_architecture(known ? name : "light", 1));
  const bool causal = r.architecture.kind == model::NetworkKind::causal;
  const bool views = r.architecture.kind == model::NetworkKind::views;
  r.presence_flags = name != "faithful";
  n.number("d_model", r.architecture.d_model, 32, 4096);
  if (views) {
    n.number("side", r.architecture.side, 16, 256);
    n.number("features", r.architecture.features, 1, 4096);
    n.numbers("widths", r.architecture.widths, 1, 1024);
    r.architecture.layers = r.architecture.widths.size();
    r.architecture.condition = model::views_condition(r.architecture.side);
  } else {
    n.number("layers", r.architecture.layers, 1, 32);
  }
  if (!causal && !views) {
    n.number("heads", r.architecture.heads, 1, 64);
    n.number("d_head", r.architecture.d_head, 32, 1024);
    n.number("ffn", r.architecture.ffn, 32, 16384);
    n.flag("near_first", r.near_first);
  }
  n.number("window", r.architecture.window, 2, 1024);
  n.flag("presence_flags", r.presence_flags);
  n.number("dropout", r.dropout, 0, 0.9);
  MIEN_TRY(n.finish());
  if (const auto ok = model::check(r.architecture); !ok) return fail(ok.error().code, ok.error().what, where);

  synthetic::RecipeTable o(optimiser, "optimiser.", where);
  o.number("learning_rate", r.learning_rate, 1e-8, 1);
  o.number("batch", r.batch, 1, 65536);
  o.number("warm_up_steps", r.warm_up_steps, 0, kMany);
  o.flag("cosine_decay", r.cosine_decay);
  o.number("clip_norm", r.clip_norm, 0, 1e6);
  o.number("ema", r.ema, 0, 0.99999);
  o.number("ema_every", r.ema_every, 1, 100000);
  if (const auto precision = o.choice("precision", {"bf16", "fp32"})) r.bf16 = *precision == "bf16";
  if (const auto loss = o.choice("loss", {"l1", "l2", "points"}))
    r.loss = *loss == "l1" ? LossKind::l1 : *loss == "l2" ? LossKind::l2 : LossKind::points;
  if (causal) o.number("difference_weight", r.difference_weight, 0, 1e6);
  if (r.architecture.kind == model::NetworkKind::views) o.flag("muon", r.muon);
  if (causal || r.architecture.kind == model::NetworkKind::views)
    o.number("gaze_weight", r.gaze_weight, 0, 1e6);
  MIEN_TRY(o.finish());

  synthetic::RecipeTable s(noise, "noise.", where);
  s.number("levels", r.schedule.levels, 1, 100000);
  s.number("offset", r.schedule.offset, 0, 1);
  s.number("t_bias", r.t_bias, 0, 100);
  s.number("t_weight", r.t_weight, 0, 10);
  s.number("held_overlap", r.held_overlap, 0, 1);
  MIEN_TRY(s.finish());

  synthetic::RecipeTable a(augmentation, "augmentation.", where);
  double lab_noise_deg = r.lab_noise_rad * 180 / std::numbers::pi;
  a.number("lab_noise_deg", lab_noise_deg, 0, 45);
  r.lab_noise_rad = lab_noise_deg * std::numbers::pi / 180;
  a.number("sensor_loss", r.sensor_loss, 0, 1);
  a.number("many_lost", r.many_lost, 0, 1);
  a.number("acceleration_loss", r.acceleration_loss, 0, 1);
  a.number("stretch_loss", r.stretch_loss, 0, 1);
  a.number("held_readings", r.held_readings, 0, 1);
  a.number("heading_drift", r.heading_drift, 0, 1);
  double heading_drift_deg = r.heading_drift_rad * 180 / std::numbers::pi;
  a.number("heading_drift_deg", heading_drift_deg, 0, 45);
  r.heading_drift_rad = heading_drift_deg * std::numbers::pi / 180;
  a.number("known_skin", r.known_skin, 0, 1);
  a.number("skin_gain_error", r.skin_gain_error, 0, 1);
  a.number("skin_slope_error", r.skin_slope_error, 0, 1);
  MIEN_TRY(a.finish());

  synthetic::RecipeTable v(validation, "validation.", where);
  v.number("windows", r.windows, 1, kMany);
  v.number("every_s", r.every_s, 1, 1e9);
  v.number("every_steps", r.every_steps, 0, kMany);
  if (const auto score = v.choice("score", {"mse", "loss"}))
    r.score = *score == "mse" ? Score::mse : Score::loss;
  MIEN_TRY(v.finish());

  synthetic::RecipeTable d(sampler, "sampler.", where);
  d.numbers("steps", r.sampler_steps, 1, static_cast<std::int64_t>(r.schedule.levels));
  d.number("frames", r.sampler_frames, 1, kMany);
  MIEN_TRY(d.finish());

  if (root.contains("takes")) r.takes_share = kUsualTakesShare;
  synthetic::RecipeTable t(takes, "takes.", where);
  if (r.takes_share) t.number("share", *r.takes_share, 0, 1);
  MIEN_TRY(t.finish());

  synthetic::RecipeTable b(budget, "budget.", where);
  b.number("steps", r.steps, 0, kMany);
  b.number("seconds", r.seconds, 0, 1e9);
  MIEN_TRY(b.finish());
  if (r.steps == 0 && r.seconds == 0)
    return fail(ErrorCode::bad_usage, "the recipe has no budget", where,
                "give budget.steps or budget.seconds");
  return r;
}

}  // namespace mien::train
