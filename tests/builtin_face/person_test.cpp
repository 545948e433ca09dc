// Who --face names, and which values people may have.
#include "mien/builtin_face/person.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <set>

#include "mien/builtin_face/held.h"

namespace mien::builtin_face::person_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Person, TenPerformersHaveNamesByTheAlphabetAndValuesThatPeopleHave) {
  const auto all = named_performers();
  ASSERT_EQ(all.size(), 10U);
  std::set<std::string_view> names;
  for (const NamedPerformer& performer : all) {
    EXPECT_TRUE(names.empty() || *names.rbegin() < performer.name);
    names.insert(performer.name);
    std::vector<std::string> said;
    (void)held(performer.parameters, &said);
    EXPECT_THAT(said, IsEmpty()) << performer.name;
    const auto person = find_person("builtin:" + performer.name);
    ASSERT_TRUE(person.has_value());
    EXPECT_EQ(person->parameters.age_years, performer.parameters.age_years);
    EXPECT_NE(performer.parameters.asymmetry_seed, 0U);
  }
  EXPECT_EQ(names.size(), all.size());
}

TEST(Person, TakesValuesOfItsOwn) {
  EXPECT_EQ(find_person("builtin")->parameters.hair, HairStyle::crop);
  const auto person = find_person("builtin:ada,age_years=70,hair=tied");
  ASSERT_TRUE(person.has_value());
  EXPECT_EQ(person->parameters.age_years, 70);
  EXPECT_EQ(person->parameters.hair, HairStyle::tied);
  EXPECT_EQ(person->parameters.hair_red, find_person("builtin:ada")->parameters.hair_red);
  EXPECT_EQ(find_person("builtin:hair=bob,sex=1")->parameters.sex, 1);
  EXPECT_EQ(find_person("builtin:7,nose_width=1")->parameters.jaw_width,
            find_person("builtin:7")->parameters.jaw_width);
}

TEST(Person, WhatNobodyHasIsHeldAndSaid) {
  const auto person = find_person("builtin:ada,nose_width=7,age_years=-4,sex=0.5");
  ASSERT_TRUE(person.has_value());
  EXPECT_EQ(person->parameters.nose_width, 3);
  EXPECT_EQ(person->parameters.age_years, 18);
  EXPECT_THAT(person->said, ElementsAre("nose_width 7 is beyond what people have, held to 3",
                                        "age_years -4 is beyond what people have, held to 18"));
  BuiltinParameters broken;
  broken.jaw_width = std::numeric_limits<double>::quiet_NaN();
  broken.eye_slant = std::numeric_limits<double>::infinity();
  EXPECT_EQ(held(broken).jaw_width, 0);
  EXPECT_EQ(held(broken).eye_slant, 3);
}

TEST(Person, RefusesWhatItDoesNotKnow) {
  const auto error = [](const char* what) { return find_person(what).error().message(); };
  EXPECT_THAT(error("builtin:haan"), HasSubstr("did you mean hana?"));
  EXPECT_THAT(error("builtin:xyzzyx"), HasSubstr("there are ada, bruno"));
  EXPECT_THAT(error("builtin:"), HasSubstr("there is no performer ''"));
  for (const char* seed : {"-1", "1.5", "7x", "+7", "18446744073709551616"})
    EXPECT_THAT(error((std::string("builtin:") + seed).c_str()),
                AllOf(HasSubstr(std::string("'") + seed + "' is no seed of a person"),
                      HasSubstr("a whole number from 0 to 18446744073709551615")));
  EXPECT_THAT(error("builtin:ada,nose_widht=1"), HasSubstr("did you mean nose_width?"));
  EXPECT_THAT(error("builtin:ada,nose_width"), HasSubstr("has no number"));
  EXPECT_THAT(error("builtin:ada,nose_width=nan"), HasSubstr("has no number"));
  EXPECT_THAT(error("builtin:ada,nose_width=inf"), HasSubstr("has no number"));
  EXPECT_THAT(error("builtin:ada,nose_width=1x"), HasSubstr("has no number"));
  EXPECT_THAT(error("builtin:ada,hair=bbo"), HasSubstr("did you mean bob?"));
  EXPECT_THAT(error("builtin:ada,sex=1,age_years=7,sex=1"), HasSubstr("sex is given twice"));
  EXPECT_THAT(error("builtin:hair=bob,hair=none"), HasSubstr("hair is given twice"));
  EXPECT_TRUE(names_person("builtin,hair=none"));
  EXPECT_FALSE(names_person("builtinish"));
  EXPECT_FALSE(names_person("face.glb"));
}

TEST(Strangers, KeepTheEighteenNumbersOfTheirSeed) {
  Random random(7), before(7);
  const BuiltinParameters p = random_identity(random);
  for (std::size_t i = 0; i < 18; ++i)
    EXPECT_EQ(p.*parameter_ranges()[i].value, std::clamp(before.normal(), -2.5, 2.5))
        << parameter_ranges()[i].name;
  EXPECT_EQ(p.asymmetry, before.uniform(0.4, 1.6));
  EXPECT_EQ(p.asymmetry_seed, before.bits() | 1U);
  for (int i = 0; i < 3; ++i) before.uniform();
  EXPECT_EQ(random.bits(), before.bits()) << "who draws on gets what they got";
}

TEST(Strangers, SpreadAsPeopleDo) {
  constexpr int kPeople = 2000;
  int women = 0, grey_young = 0, young = 0, grey_old = 0, old = 0, light_eyes_of_deep_skin = 0;
  std::array<double, kIdentityNumbers> sum{}, square{};
  double tone = 0, tone_square = 0;
  Random random(3);
  for (int i = 0; i < kPeople; ++i) {
    const BuiltinParameters p = random_identity(random);
    std::vector<std::string> said;
    (void)held(p, &said);
    ASSERT_THAT(said, IsEmpty());
    for (std::size_t k = 0; k < kIdentityNumbers; ++k) {
      const double value = p.*parameter_ranges()[k].value;
      sum[k] += value / kPeople;
      square[k] += value * value / kPeople;
    }
    women += p.sex < 0 ? 1 : 0;
    EXPECT_TRUE(p.sex > 0 || p.beard == 0);
    (p.age_years < 35 ? young : old) += 1;
    if (p.hair_grey > 0.1) (p.age_years < 35 ? grey_young : grey_old) += 1;
    light_eyes_of_deep_skin += p.skin_tone > 0.7 && p.eye_tone < 0.5 ? 1 : 0;
    tone += p.skin_tone / kPeople;
    tone_square += p.skin_tone * p.skin_tone / kPeople;
  }
  EXPECT_NEAR(women, kPeople / 2, 100);
  EXPECT_LT(grey_young, 0.03 * young);
  EXPECT_GT(grey_old, 0.25 * old);
  EXPECT_LT(light_eyes_of_deep_skin, kPeople / 50);
  EXPECT_GT(std::sqrt(tone_square - tone * tone), 0.2) << "skin tones differ";
  for (std::size_t k = 0; k < kIdentityNumbers; ++k)
    EXPECT_NEAR(std::sqrt(square[k] - sum[k] * sum[k]), 1.0, 0.4) << parameter_ranges()[k].name;
}

}  // namespace
}  // namespace mien::builtin_face::person_test
