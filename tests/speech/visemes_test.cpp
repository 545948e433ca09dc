#include "mien/speech/visemes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mien/core/files.h"
#include "tests/project_path.h"

namespace mien::speech::visemes_test {
namespace {

using testing::HasSubstr;

const std::string& table() {
  static const std::string text = read_text(project_path("rigs/visemes.toml")).value();
  return text;
}

std::string with(const std::string& from, const std::string& to) {
  std::string text = table();
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string_view only(VisemeParts parts) {
  return parts.size() == 1 ? kVisemeNames[parts[0].viseme] : "not one";
}

TEST(Visemes, KnowThe39SoundsOfEnglish) {
  const Visemes& visemes = Visemes::standard();
  for (const char* symbol : {"AA", "AE", "AH", "AO", "AW", "AY", "B",  "CH", "D", "DH", "EH", "ER", "EY",
                             "F",  "G",  "IH", "IY", "JH", "K",  "L",  "M",  "N", "NG", "OW", "OY", "P",
                             "R",  "S",  "SH", "T",  "TH", "UH", "UW", "V",  "W", "Y",  "Z",  "ZH"})
    EXPECT_FALSE(visemes.of_arpabet(symbol).empty()) << symbol;
  EXPECT_EQ(only(visemes.of_arpabet("M")), "PP");
  EXPECT_EQ(only(visemes.of_arpabet("V")), "FF");
  EXPECT_EQ(only(visemes.of_arpabet("IY")), "ih");
  // A breath and silence leave the mouth as it is.
  for (const char* symbol : {"HH", "SIL", "+NSN+", "", "m", "QQ"})
    EXPECT_TRUE(visemes.of_arpabet(symbol).empty()) << symbol;
}

TEST(Visemes, ADiphthongIsTwoInTurn) {
  const VisemeParts parts = Visemes::standard().of_arpabet("AW");
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(kVisemeNames[parts[0].viseme], "aa");
  EXPECT_EQ(kVisemeNames[parts[1].viseme], "ou");
  EXPECT_DOUBLE_EQ(parts[0].share, 0.6);
  EXPECT_DOUBLE_EQ(parts[0].share + parts[1].share, 1);
}

TEST(Visemes, KnowOtherLanguagesByTheirLetters) {
  const Visemes& visemes = Visemes::standard();
  EXPECT_EQ(only(visemes.of_ipa("\u03b2")), "FF") << "Spanish's b between vowels";
  EXPECT_EQ(only(visemes.of_ipa("\u0281")), "kk") << "German's r";
  EXPECT_EQ(only(visemes.of_ipa("\u00f8")), "oh") << "French's eu";
  EXPECT_EQ(only(visemes.of_ipa("m")), "PP");
  EXPECT_TRUE(visemes.of_ipa("\u02c8").empty()) << "a mark of stress";
}

TEST(Visemes, MoveMouthAndJawAlone) {
  const Visemes& visemes = Visemes::standard();
  for (std::size_t v = 0; v < kVisemeCount; ++v)
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (visemes[v].weights[k] != 0) {
        EXPECT_TRUE(face::kShapeNames[k].starts_with("mouth") || face::kShapeNames[k].starts_with("jaw"))
            << kVisemeNames[v] << " moves " << face::kShapeNames[k];
      }
  for (std::size_t v = 0; v < kVisemeCount; ++v) EXPECT_EQ(visemes[v].closes, kVisemeNames[v] == "PP");
  EXPECT_EQ(visemes[kSilence].weights, (std::array<float, face::kShapeCount>{}));
  // What is open is open, what is shut is not.
  const auto jaw = [&](std::string_view symbol) {
    return visemes[visemes.of_arpabet(symbol)[0].viseme].weights[face::shape("jawOpen")];
  };
  EXPECT_GT(jaw("AA"), 3 * jaw("IY"));
  EXPECT_GT(jaw("IY"), jaw("S"));
}

struct Wrong {
  const char* from;
  const char* to;
  const char* said;
};
class WrongVisemes : public testing::TestWithParam<Wrong> {};
TEST_P(WrongVisemes, AreRefusedWithTheirLine) {
  const auto visemes = Visemes::parse(with(GetParam().from, GetParam().to), "own.toml");
  ASSERT_FALSE(visemes);
  EXPECT_THAT(visemes.error().message(), HasSubstr(GetParam().said));
  EXPECT_THAT(visemes.error().message(), HasSubstr("own.toml"));
}
INSTANTIATE_TEST_SUITE_P(
    Visemes, WrongVisemes,
    testing::Values(Wrong{"name = \"PP\"", "name = \"BB\"", "no viseme is called 'BB'"},
                    Wrong{"name = \"PP\"", "name = \"sil\"", "no viseme is called 'sil'"},
                    Wrong{"name = \"PP\"", "name = \"FF\"", "FF is told twice"},
                    Wrong{"class = \"closed\"", "class = \"shut\"", "'class' names no class of sounds"},
                    Wrong{"closes = true", "close = true", "close"},
                    Wrong{"closes = true", "closes = \"yes\"", "'closes' is neither true nor false"},
                    Wrong{"mouthPress = 0.35", "mouthPress = 0.35, mouthPress_L = 0.3", "is told twice"},
                    Wrong{"mouthPress = 0.35", "browDown = 0.35", "sound does not tell of 'browDown'"},
                    Wrong{"mouthPress = 0.35", "mouthClose = 0.35", "sound does not tell of 'mouthClose'"},
                    Wrong{"\"P\", \"B\"", "\"F\", \"B\"", "'F' belongs to two visemes"},
                    Wrong{"\"P\", \"B\"", "3, \"B\"", "'arpabet' holds what is no name"},
                    Wrong{"mouthPress = 0.35", "mouthPres = 0.35", "no shape is called 'mouthPres'"},
                    Wrong{"mouthPress = 0.35", "mouthPress = 1.35", "'mouthPress' is 1.35"},
                    Wrong{"mouthPress = 0.35", "mouthPress = nan", "'mouthPress' is nan"},
                    Wrong{"onset_ms = 45", "onset_ms = 0", "'onset_ms' is 0"},
                    Wrong{"onset_ms = 45", "", "'onset_ms' is missing"},
                    Wrong{"AY = [\"aa\", \"ih\"]", "AY = [\"aa\"]", "a diphthong is of two visemes"},
                    Wrong{"AY = [\"aa\", \"ih\"]", "AY = [\"aa\", \"iy\"]", "no viseme is called 'iy'"}));

TEST(Visemes, AllFifteenAreTold) {
  const std::string& text = table();
  const auto last = text.rfind("[[viseme]]");
  const auto visemes = Visemes::parse(text.substr(0, last), "own.toml");
  ASSERT_FALSE(visemes);
  EXPECT_THAT(visemes.error().message(), HasSubstr("ou is not told"));
  EXPECT_FALSE(Visemes::parse("", "t"));
  EXPECT_FALSE(Visemes::parse("[class]\n[[viseme]]\n", "t"));
  EXPECT_FALSE(Visemes::parse("class = 1\n", "t"));
  EXPECT_FALSE(Visemes::parse("diphthong = 3\n" + text, "t"));
}

}  // namespace
}  // namespace mien::speech::visemes_test
