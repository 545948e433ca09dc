#include "mien/headset/headset_model.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tests/headset/small_model.h"

namespace mien::headset::test::headset_model_test {
namespace {

TEST(HeadsetModel, ItsHashIsOfEverythingThatItsAnswersDependOn) {
  ViewsFile file = small_views_file();
  file.memory = small_memory();
  const auto hash = [](const ViewsFile& of, model::Precision precision = kHeadsetPrecision) {
    return HeadsetModel::create(of, precision).value()->hash();
  };
  EXPECT_EQ(hash(file), hash(file));
  std::set<std::string> hashes = {hash(file), hash(file, model::Precision::fp32)};
  const auto changed = [&](auto change) {
    ViewsFile other = file;
    change(other);
    hashes.insert(hash(other));
  };
  changed([](ViewsFile& f) { f.network.back().values.front() += 0.5F; });
  changed([](ViewsFile& f) { f.memory->network.back().values.front() += 0.5F; });
  changed([](ViewsFile& f) { f.memory->judgements[0].offset += 0.5F; });
  changed([](ViewsFile& f) { f.memory->judgements[2].slope += 0.5F; });
  changed([](ViewsFile& f) { f.memory->mirrored_eye.bias += 0.5F; });
  changed([](ViewsFile& f) { f.memory.reset(); });
  EXPECT_EQ(hashes.size(), 8U);
}

}  // namespace
}  // namespace mien::headset::test::headset_model_test
