#include "mien/train/recipe.h"

#include <gtest/gtest.h>

#include "mien/core/files.h"
#include "tests/project_path.h"

namespace mien::train::recipe_test {
namespace {

TEST(Recipe, ReadsWhatItIsGiven) {
  const auto r = parse_recipe(
      "seed = 9\n[network]\narchitecture = \"faithful\"\ndropout = 0.2\nnear_first = "
      "true\n[data]\nperformers = 3\nname = "
      "\"x\"\n"
      "[optimiser]\nprecision = \"fp32\"\nloss = \"l2\"\nbatch = 8\n[noise]\nt_bias = "
      "1.5\n[augmentation]\nlab_noise_deg = "
      "2\n"
      "[validation]\nscore = \"loss\"\n[sampler]\nsteps = [1, 10]\n[budget]\nseconds = 60\n",
      "test");
  ASSERT_TRUE(r) << r.error().message();
  EXPECT_EQ(r->seed, 9U);
  EXPECT_EQ(r->architecture.d_model, 512U);
  EXPECT_FALSE(r->presence_flags);
  EXPECT_EQ(r->dropout, 0.2);
  EXPECT_NE(r->data.find("performers = 3"), std::string::npos);
  EXPECT_TRUE(r->near_first);
  EXPECT_FALSE(r->bf16);
  EXPECT_EQ(r->loss, LossKind::l2);
  EXPECT_EQ(r->batch, 8U);
  EXPECT_EQ(r->t_bias, 1.5);
  EXPECT_NEAR(r->lab_noise_rad, 0.0349, 1e-4);
  EXPECT_EQ(r->score, Score::loss);
  EXPECT_EQ(r->sampler_steps, (std::vector<std::size_t>{1, 10}));
  EXPECT_EQ(r->seconds, 60);
}

TEST(Recipe, LightIsTheDefault) {
  const auto r = parse_recipe("[budget]\nsteps = 1\n", "test");
  ASSERT_TRUE(r);
  EXPECT_EQ(r->architecture.name, "light");
  EXPECT_TRUE(r->presence_flags);
  EXPECT_TRUE(r->bf16);
  EXPECT_FALSE(r->near_first);
  EXPECT_EQ(r->loss, LossKind::l1) << "as published";
}

TEST(Recipe, ACausalOneHasKeysOfItsOwn) {
  const auto r = parse_recipe(
      "[network]\narchitecture = \"causal\"\nd_model = 128\nwindow = 300\n"
      "[optimiser]\ndifference_weight = 7\n[augmentation]\nstretch_loss = 0.1\nheld_readings = 0.2\n"
      "heading_drift = 0.5\nheading_drift_deg = 9\n"
      "[budget]\nsteps = 1\n",
      "test");
  ASSERT_TRUE(r) << r.error().message();
  EXPECT_EQ(r->architecture.kind, model::NetworkKind::causal);
  EXPECT_EQ(r->architecture.layers, 2U);
  EXPECT_EQ(r->architecture.d_model, 128U);
  EXPECT_EQ(r->architecture.window, 300U);
  EXPECT_TRUE(r->presence_flags);
  EXPECT_EQ(r->difference_weight, 7);
  EXPECT_EQ(r->stretch_loss, 0.1);
  EXPECT_EQ(r->held_readings, 0.2);
  EXPECT_EQ(r->heading_drift, 0.5);
  EXPECT_NEAR(r->heading_drift_rad, 0.157, 1e-3);
  for (const char* name : {"live.toml", "placement.toml"})
    EXPECT_TRUE(parse_recipe(*read_text(project_path(std::string("models/recipes/") + name)), name));
}

TEST(Recipe, AsksForTakesByATableOfTheirOwn) {
  const auto share = [](const std::string& table) {
    const auto r = parse_recipe("[budget]\nsteps = 1\n" + table, "test");
    EXPECT_TRUE(r) << r.error().message();
    return r->takes_share;
  };
  EXPECT_EQ(share(""), std::nullopt);
  EXPECT_EQ(share("[takes]\n"), kUsualTakesShare);
  EXPECT_EQ(share("[takes]\nshare = 0.25\n"), 0.25);
  EXPECT_EQ(share("[takes]\nshare = 1\n"), 1) << "takes alone";
  EXPECT_EQ(share("[takes]\nshare = 0\n"), 0);
}

TEST(Recipe, RefusesEachWrongThingInOneLine) {
  const std::string budget = "[budget]\nsteps = 1\n";
  for (const std::string& text : {std::string("seed = 1\n"),
                                  "sead = 1\n" + budget,
                                  budget + "[network]\nlayers = 0\n",
                                  budget + "[network]\nd_model = 33\n",
                                  budget + "[network]\narchitecture = \"heavy\"\n",
                                  budget + "[network]\nlayers = \"four\"\n",
                                  budget + "[optimiser]\nbatch = -1\n",
                                  budget + "[optimiser]\nlearning_rate = nan\n",
                                  budget + "[optimiser]\nprecision = \"fp8\"\n",
                                  budget + "[optimiser]\nloss = \"l3\"\n",
                                  budget + "[noise]\nbias = 1\n",
                                  budget + "[network]\narchitecture = \"causal\"\nheads = 4\n",
                                  budget + "[network]\narchitecture = \"causal\"\nnear_first = true\n",
                                  budget + "[optimiser]\ndifference_weight = 7\n",
                                  budget + "[augmentation]\nstretch_loss = 2\n",
                                  budget + "[augmentation]\nheld_readings = -1\n",
                                  budget + "[augmentation]\nheading_drift_deg = 90\n",
                                  budget + "[sampler]\nsteps = []\n",
                                  budget + "[sampler]\nsteps = [0]\n",
                                  budget + "[sampler]\nsteps = [1.5]\n",
                                  budget + "[sampler]\nsteps = [2000]\n",
                                  budget + "[takes]\nshare = 1.1\n",
                                  budget + "[takes]\nshare = nan\n",
                                  budget + "[takes]\nshare = \"half\"\n",
                                  budget + "[takes]\npeople = 3\n",
                                  "takes = 0.5\n" + budget,
                                  "network = 3\n" + budget,
                                  std::string("[budget\n"),
                                  std::string()}) {
    const auto r = parse_recipe(text, "test");
    ASSERT_FALSE(r) << text;
    EXPECT_TRUE(is_bad_input(r.error().code)) << text;
    EXPECT_EQ(r.error().message().find('\n'), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace mien::train::recipe_test
