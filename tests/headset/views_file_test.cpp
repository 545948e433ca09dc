#include "mien/headset/views_file.h"

#include <gtest/gtest.h>

#include "mien/headset/answer.h"
#include "tests/headset/small_model.h"

namespace mien::headset::views_file_test {
namespace {

ViewsFile small() {
  ViewsFile file = test::small_views_file();
  file.mean_answer.assign(kAnswerOutputs, 0.25F);
  file.rig = "name = \"r\"";
  file.recipe = "seed = 1";
  file.memory = test::small_memory();
  file.memory->recipe = "seed = 2";
  file.memory->judgements[1] = {.offset = 0.25F, .slope = -2};
  file.memory->mirrored_eye = {.weight = std::vector<float>(file.architecture.features, 0.5F), .bias = -3};
  return file;
}

TEST(ViewsFile, ReadsWhatItWrites) {
  const ViewsFile file = small();
  const auto bytes = format_views_file(file);
  ASSERT_TRUE(bytes) << bytes.error().message();
  const auto back = parse_views_file(*bytes, "file");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_TRUE(back->architecture == file.architecture);
  EXPECT_EQ(back->mean_answer, file.mean_answer);
  EXPECT_EQ(back->rig, file.rig);
  EXPECT_EQ(back->recipe, file.recipe);
  ASSERT_EQ(back->network.size(), file.network.size());
  for (std::size_t i = 0; i < file.network.size(); ++i)
    EXPECT_EQ(back->network[i].values, file.network[i].values);
  ASSERT_TRUE(back->memory);
  EXPECT_TRUE(back->memory->architecture == file.memory->architecture);
  EXPECT_EQ(back->memory->judgements, file.memory->judgements);
  EXPECT_EQ(back->memory->mirrored_eye.weight, file.memory->mirrored_eye.weight);
  EXPECT_EQ(back->memory->mirrored_eye.bias, -3);
  EXPECT_EQ(back->memory->recipe, "seed = 2");
  for (std::size_t i = 0; i < file.memory->network.size(); ++i)
    EXPECT_EQ(back->memory->network[i].values, file.memory->network[i].values);

  ViewsFile without = small();
  without.memory.reset();
  EXPECT_FALSE(parse_views_file(format_views_file(without).value(), "file")->memory);
}

TEST(ViewsFile, RefusesWhatDoesNotBelong) {
  const auto refused = [](const auto& change) {
    ViewsFile file = small();
    change(file);
    return !format_views_file(file).has_value();
  };
  EXPECT_TRUE(refused([](ViewsFile& f) { f.mean_answer.pop_back(); }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.mean_answer[0] = 1e9F; }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.network.pop_back(); }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.memory->network.pop_back(); }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.memory->judgements[0].slope = 1e30F; }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.memory->mirrored_eye.weight.pop_back(); }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.memory->mirrored_eye.bias = NAN; }));
  EXPECT_FALSE(refused([](ViewsFile& f) { f.memory->mirrored_eye = {}; }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.memory->architecture.condition = 7; }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.memory->architecture = f.architecture; }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.architecture.outputs = 53; }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.architecture.widths.push_back(8); }));
  EXPECT_TRUE(refused([](ViewsFile& f) { f.architecture.side = 100'000; }));
  EXPECT_FALSE(parse_views_file({}, "nothing"));
  const auto bytes = format_views_file(small()).value();
  for (std::size_t size = 0; size < bytes.size(); size += bytes.size() / 61)
    EXPECT_FALSE(parse_views_file(std::span(bytes).first(size), "cut")) << size;
}

}  // namespace
}  // namespace mien::headset::views_file_test
