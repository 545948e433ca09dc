#include "mien/core/toml.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace mien::toml_test {
namespace {

std::string refusal(const std::string& text) {
  const auto parsed = parse_toml(text, "rig.toml");
  return parsed ? "" : parsed.error().message();
}

TEST(Toml, RepeatsAtMostFortyLettersOfIt) {
  const std::string key(10'000, 'k');
  const std::string said = refusal("[" + key + "]\n[" + key + "]\n");
  EXPECT_NE(said.find("'" + std::string(40, 'k') + "...'"), std::string::npos) << said.substr(0, 300);
  EXPECT_LT(said.size(), 200U);
}

TEST(Toml, TextsInDoubleQuotesMayBeOfAnyLanguage) {
  const auto parsed = parse_toml(R"(# Grüße
a = "Größe ¿qué? 🙂 \u00e4\\"
b = """\
  un été,
  l'œil"""
c = ["", "ß"]
)",
                                 "here");
  ASSERT_TRUE(parsed) << parsed.error().message();
  EXPECT_EQ((*parsed)["a"].value<std::string>(), "Größe ¿qué? 🙂 ä\\");
  EXPECT_EQ((*parsed)["b"].value<std::string>(), "un été,\n  l'œil");
  EXPECT_EQ((*parsed)["c"][1].value<std::string>(), "ß");
  for (const char* text : {"ä = 1", "a = ä", "a = 'ä'", "a = \"\xff\"", "a = \"\xc3\"", R"(a = "\ä")"}) {
    const std::string said = refusal(text);
    EXPECT_TRUE(said.starts_with("rig.toml, line ")) << text << ": " << said;
  }
}

TEST(Toml, AnErrorIsOneLineThatNoTerminalObeys) {
  for (const char* text :
       {"a = \"one\ntwo\"", "\x1b]0;pwned\x07 = 1", "a\nb", "a = 1 \x1b[2J", "a = '\x07'",
        "[\"\x1b[2J\"]\n[\"\x1b[2J\"]", "a = \"\\e\"", "\"a\\u001b[2J\" = 1\n\"a\\u001b[2J\" = 2"}) {
    const std::string said = refusal(text);
    EXPECT_TRUE(said.starts_with("rig.toml, line ")) << said;
    EXPECT_TRUE(std::ranges::none_of(said, [](char c) { return (c >= 0 && c < ' ') || c == 0x7F; })) << said;
    EXPECT_LT(said.size(), 200U) << said;
  }
}

}  // namespace
}  // namespace mien::toml_test
