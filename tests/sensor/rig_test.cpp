#include "mien/sensor/rig.h"
#include "tests/project_path.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <tuple>
#include <vector>

#include "mien/sensor/bindings.h"
#include "mien/sensor/rig_part.h"

namespace mien::sensor::rig_test {
namespace {

const std::string kSmall = R"(name = "small"
reference = "ear"
[[sensor]]
name = "chin"
kind = "imu"
site = "mentalis"
side = "M"
role = "face"
device = "a1b2/0"
ict_vertex = 963
position_m = [0.0, -0.05, 0.09]
outward = [0, 0, 1]
aim = [0.6, 0, -0.8]
[[sensor]]
name = "ear"
kind = "imu"
role = "head"
[faults]
gyro_bias_dps = 1.0
adhesive_lag_ms = [5.0, 20.0]
[skin]
sensors = ["chin"]
mean_deg = [-4, 0.1, -0.0]
factor_deg = [[9.5], [0.25, 2], [-1e-3, 0.3, 1.5]]
)";

std::string with(const std::string& from, const std::string& to) {
  std::string text = kSmall;
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Rig, ReadsTheDefaultRig) {
  const auto rig = read_rig(project_path("rigs/default.toml"));
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_EQ(rig->name, "default");
  EXPECT_EQ(rig->sensors.size(), 12u);
  EXPECT_EQ(rig->face_sensors().size(), 11u);
  EXPECT_EQ(rig->head_sensor(), rig->find("mastoid_L"));
  EXPECT_EQ(rig->sensors[0].ict_vertex, 2127);
  EXPECT_NE(rig->faults_toml.find("gyro_bias_dps"), std::string::npos);
}

TEST(Rig, TheRigOfBothHasTheSensorsOfEach) {
  const auto both = read_rig(project_path("rigs/imu_eyewear.toml"));
  ASSERT_TRUE(both) << both.error().message();
  const Rig imus = read_rig(project_path("rigs/default.toml")).value();
  const Rig glasses = read_rig(project_path("rigs/eyewear.toml")).value();
  EXPECT_EQ(both->sensors.size(), 28u);
  EXPECT_EQ(both->reference, imus.reference);
  for (std::size_t i = 0; i < both->sensors.size(); ++i) {
    const Mount& mount = both->sensors[i];
    const Mount& original = i < 12 ? imus.sensors[i] : glasses.sensors[i - 12];
    EXPECT_EQ(mount.name, original.name);
    EXPECT_EQ(mount.kind, i < 12 ? "imu" : "eyewear");
    EXPECT_EQ(mount.device, original.device);
    EXPECT_EQ(mount.role, original.role);
    EXPECT_EQ(mount.site, original.site);
    EXPECT_EQ(mount.side, original.side);
    EXPECT_EQ(mount.ict_vertex, original.ict_vertex);
    EXPECT_TRUE(mount.position_m == original.position_m);
    EXPECT_TRUE(mount.aim == original.aim);
  }
}

TEST(Rig, WritesWhatItReads) {
  std::string quoted = kSmall;
  for (std::size_t at = 0; (at = quoted.find("\"chin\"", at)) != std::string::npos;)
    quoted.replace(at, 6, R"("a \"quoted\" \\ name")");
  for (const std::string& text : {kSmall, quoted}) {
    const auto first = parse_rig(text, "t");
    ASSERT_TRUE(first) << first.error().message();
    const auto second = parse_rig(write_rig(*first), "again");
    ASSERT_TRUE(second) << second.error().message() << write_rig(*first);
    EXPECT_EQ(write_rig(*first), write_rig(*second));
    EXPECT_EQ(first->faults_toml, second->faults_toml);
    ASSERT_TRUE(first->skin && second->skin);
    EXPECT_EQ(first->skin->sensors, second->skin->sensors);
    EXPECT_EQ(first->skin->mean_deg, second->skin->mean_deg);
    EXPECT_EQ(first->skin->factor_deg, second->skin->factor_deg);
    ASSERT_EQ(first->sensors.size(), second->sensors.size());
    for (std::size_t i = 0; i < first->sensors.size(); ++i) {
      const Mount& a = first->sensors[i];
      const Mount& b = second->sensors[i];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(a.kind, b.kind);
      EXPECT_EQ(a.site, b.site);
      EXPECT_EQ(a.side, b.side);
      EXPECT_EQ(a.role, b.role);
      EXPECT_EQ(a.device, b.device);
      EXPECT_EQ(a.ict_vertex, b.ict_vertex);
      EXPECT_EQ(a.position_m.has_value(), b.position_m.has_value());
      EXPECT_TRUE(a.position_m == b.position_m);
      EXPECT_TRUE(a.outward == b.outward);
      EXPECT_TRUE(a.aim == b.aim);
      EXPECT_EQ(a.recentre, b.recentre);
      EXPECT_EQ(a.hears_by, b.hears_by);
    }
  }
}

TEST(Rig, LightMayBeRecentred) {
  const std::string light = with("kind = \"imu\"\nsite", "kind = \"eyewear\"\nrecentre = true\nsite");
  const auto rig = parse_rig(light, "t");
  ASSERT_TRUE(rig) << rig.error().message();
  EXPECT_TRUE(rig->sensors[0].recentre);
  EXPECT_FALSE(rig->sensors[1].recentre);
  EXPECT_TRUE(parse_rig(write_rig(*rig), "again")->sensors[0].recentre);
  const std::string phones = with("kind = \"imu\"\nsite", "kind = \"speech\"\nhears_by = \"phones\"\nsite");
  const auto hearing = parse_rig(phones, "rig");
  ASSERT_TRUE(hearing) << hearing.error().message();
  EXPECT_EQ(parse_rig(write_rig(*hearing), "again")->sensors[0].hears_by, "phones");
  EXPECT_FALSE(parse_rig(with("kind = \"imu\"\nsite", "kind = \"imu\"\nhears_by = \"phones\"\nsite"), "rig"));
  EXPECT_FALSE(parse_rig(with("kind = \"imu\"\nsite", "kind = \"speech\"\nhears_by = \"ear\"\nsite"), "rig"));
}

TEST(Rig, HeadsetsOfThisProjectAreRead) {
  for (const auto& [name, cameras, mouths] : {std::tuple{"headset", 4, 2}, std::tuple{"headset_diy", 3, 1}}) {
    const auto rig = read_rig(project_path(fmt::format("rigs/{}.toml", name)));
    ASSERT_TRUE(rig) << rig.error().message();
    ASSERT_EQ(rig->sensors.size(), static_cast<std::size_t>(cameras));
    int of_mouth = 0;
    for (const Mount& mount : rig->sensors) {
      ASSERT_TRUE(mount.camera) << mount.name;
      EXPECT_EQ(mount.camera->mirror, mount.side == 'R') << mount.name;
      EXPECT_EQ(mount.camera->size, (std::array{240, 240}));
      of_mouth += mount.site == "mouth" ? 1 : 0;
    }
    EXPECT_EQ(of_mouth, mouths);
    const auto again = parse_rig(write_rig(*rig), "again");
    ASSERT_TRUE(again) << again.error().message();
    for (std::size_t i = 0; i < rig->sensors.size(); ++i)
      EXPECT_TRUE(again->sensors[i].camera == rig->sensors[i].camera) << rig->sensors[i].name;
  }
}

TEST(Rig, RefusesCamerasThatNoneIs) {
  const auto rig_with = [](std::string_view sensor, std::string_view camera) {
    return parse_rig(fmt::format("name = \"r\"\nreference = \"eye\"\n[[sensor]]\nname = \"eye\"\n{}\n"
                                 "role = \"face\"\n[sensor.camera]\n{}\n",
                                 sensor, camera),
                     "r");
  };
  constexpr std::string_view kSensor = "kind = \"camera\"\nsite = \"eye\"\nposition_m = [0.05, 0, 0.1]";
  constexpr std::string_view kLooks = "look_at_m = [0, 0, 0]\nup = [0, 1, 0]\n";
  const auto good = rig_with(kSensor, kLooks);
  ASSERT_TRUE(good) << good.error().message();
  EXPECT_EQ(good->sensors[0].camera->size, (std::array{240, 240}));

  for (const std::string_view sensor :
       {"kind = \"camera\"\nsite = \"eye\"", "kind = \"camera\"\nsite = \"ear\"\nposition_m = [0.05, 0, 0.1]",
        "kind = \"imu\"\nsite = \"eye\"\nposition_m = [0.05, 0, 0.1]"})
    EXPECT_FALSE(rig_with(sensor, kLooks)) << sensor;
  for (const std::string_view camera :
       {"look_at_m = [0, 0, 0]", "up = [0, 1, 0]", "look_at_m = [0.05, 0, 0.1]\nup = [0, 1, 0]",
        "look_at_m = [0.05, 1, 0.1]\nup = [0, 1, 0]"})
    EXPECT_FALSE(rig_with(kSensor, camera)) << camera;
  for (const std::string_view more :
       {"field_of_view_deg = 180",
        "field_of_view_deg = nan",
        "radial_k1 = 2",
        "size = [240]",
        "size = [8, 8]",
        "size = [240.5, 240]",
        "size = [2000, 240]",
        "rate_hz = 0",
        "rate_hz = 1000",
        "rate_hz = 100\nexposure_ms = 11",
        "crop = [0, 0, 1, 1.1]",
        "crop = [-0.1, 0, 1, 1]",
        "crop = [0, 0, 0, 1]",
        "turn_deg = 45",
        "turn_deg = 360",
        "mirror = 1",
        "lamps = 1",
        "lamps = [1]",
        "lamps = [{}]",
        "lamps = [{ position_m = [0, 0, 0.1], aim = [0, 0, 3] }]",
        "lamps = [{ position_m = [0, 0, 0.1], aim = [0, 0, 1], half_angle_deg = 90 }]",
        "zoom = 2"}) {
    const auto rig = rig_with(kSensor, fmt::format("{}{}", kLooks, more));
    ASSERT_FALSE(rig) << more;
    EXPECT_NE(rig.error().message().find("r, line"), std::string::npos) << rig.error().message();
  }
  std::string lamps = "lamps = [";
  for (int i = 0; i < 9; ++i) lamps += "{ position_m = [0, 0, 0.1], aim = [0, 0, 1] },";
  EXPECT_FALSE(rig_with(kSensor, fmt::format("{}{}]", kLooks, lamps)));
}

struct Wrong {
  const char* from;
  const char* to;
  ErrorCode code;
};

class WrongRig : public testing::TestWithParam<Wrong> {};

TEST_P(WrongRig, IsRefusedWithOneLine) {
  const auto rig = parse_rig(with(GetParam().from, GetParam().to), "wrong.toml");
  ASSERT_FALSE(rig);
  EXPECT_EQ(rig.error().code, GetParam().code) << rig.error().message();
  EXPECT_EQ(rig.error().message().find('\n'), std::string::npos);
  EXPECT_NE(rig.error().where.find("wrong.toml"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Rig, WrongRig,
    testing::Values(Wrong{"name = \"small\"", "name = ", ErrorCode::malformed},
                    Wrong{"name = \"small\"", "", ErrorCode::malformed},
                    Wrong{"name = \"small\"", "name = 3", ErrorCode::malformed},
                    Wrong{"name = \"small\"", "name = \"\"", ErrorCode::malformed},
                    Wrong{"name = \"small\"", "title = \"small\"", ErrorCode::malformed},
                    Wrong{"reference = \"ear\"", "reference = \"nose\"", ErrorCode::malformed},
                    Wrong{"name = \"chin\"", "name = \"ear\"", ErrorCode::malformed},
                    Wrong{"[\"chin\"]", "[\"ear\"]", ErrorCode::malformed},
                    Wrong{"[\"chin\"]", "[\"chin\", \"chin\"]", ErrorCode::malformed},
                    Wrong{"[\"chin\"]", "[]", ErrorCode::malformed},
                    Wrong{"[\"chin\"]", "[3]", ErrorCode::malformed},
                    Wrong{"[skin]", "[[skin]]", ErrorCode::malformed},
                    Wrong{"[-4, 0.1, -0.0]", "[-4, 0.1]", ErrorCode::malformed},
                    Wrong{"[-4, 0.1, -0.0]", "[-4, 0.1, 200]", ErrorCode::out_of_range},
                    Wrong{"[0.25, 2]", "[0.25, 2, 1]", ErrorCode::malformed},
                    Wrong{"[0.25, 2]", "[0.25, nan]", ErrorCode::out_of_range},
                    Wrong{", [-1e-3, 0.3, 1.5]", "", ErrorCode::malformed},
                    Wrong{"factor_deg", "spread_deg", ErrorCode::malformed},
                    Wrong{"name = \"chin\"", "name = \"chin\"\ncolour = \"red\"", ErrorCode::malformed},
                    Wrong{"side = \"M\"", "side = \"left\"", ErrorCode::malformed},
                    Wrong{"role = \"face\"", "role = \"head\"", ErrorCode::malformed},
                    Wrong{"role = \"face\"", "role = \"foot\"", ErrorCode::malformed},
                    Wrong{"ict_vertex = 963", "ict_vertex = -2", ErrorCode::out_of_range},
                    Wrong{"ict_vertex = 963", "ict_vertex = 1e3", ErrorCode::out_of_range},
                    Wrong{"[0.0, -0.05, 0.09]", "[0.0, nan, 0.09]", ErrorCode::out_of_range},
                    Wrong{"[0.0, -0.05, 0.09]", "[0.0, -50.0, 90.0]", ErrorCode::out_of_range},
                    Wrong{"[0.0, -0.05, 0.09]", "[0.0, 0.1]", ErrorCode::malformed},
                    Wrong{"[0, 0, 1]", "[0, 0, 0]", ErrorCode::out_of_range},
                    Wrong{"[0.6, 0, -0.8]", "[0.6, 0, -8]", ErrorCode::out_of_range},
                    Wrong{"role = \"face\"", "role = \"face\"\nrecentre = 1", ErrorCode::malformed},
                    Wrong{"role = \"face\"", "role = \"face\"\nrecentre = true", ErrorCode::malformed},
                    Wrong{"[0.6, 0, -0.8]", "\"down\"", ErrorCode::malformed},
                    Wrong{"[0.6, 0, -0.8]", "[0.6, inf, -0.8]", ErrorCode::out_of_range},
                    Wrong{"gyro_bias_dps = 1.0", "gyro_bias_dps = inf", ErrorCode::out_of_range}));

TEST(Rig, RefusesNoSensorsAndTooMany) {
  EXPECT_FALSE(parse_rig("name = \"a\"\nreference = \"b\"\n", "t"));
  EXPECT_FALSE(parse_rig("name = \"a\"\nreference = \"b\"\nsensor = []\n", "t"));
  EXPECT_FALSE(parse_rig("", "t"));
  std::string many = "name = \"a\"\nreference = \"s0\"\n";
  for (int i = 0; i < 257; ++i)
    many += "[[sensor]]\nname = \"s" + std::to_string(i) + "\"\nkind = \"imu\"\nrole = \"face\"\n";
  EXPECT_FALSE(parse_rig(many, "t"));
}

TEST(Rig, RefusesWhatTheTomlLibraryOnlyAsserts) {
  EXPECT_FALSE(parse_rig("name = \"a\"\n[# no key\nx = 1\n", "t"));
  EXPECT_FALSE(parse_rig("[", "t"));
  EXPECT_FALSE(parse_rig("[[", "t"));
  EXPECT_FALSE(parse_rig("[+]\n", "t"));
  const auto stray = parse_rig(with("[faults]", "n\xC3\xA4me = 1\n[faults]"), "t");
  ASSERT_FALSE(stray);
  EXPECT_EQ(stray.error().where, "t, line 18");
  EXPECT_FALSE(parse_rig(with("\"small\"", "\"m\xC3\xA4\""), "t"));
  EXPECT_FALSE(parse_rig(with("\"small\"", "\"m\\u00e4\""), "t"));
  // In comments every letter may stand; a hash in quotes begins none.
  EXPECT_TRUE(parse_rig(with("\"small\"", "\"sm # \\\" all\" # \xC3\xBC"), "t"));
  EXPECT_TRUE(parse_rig("\xEF\xBB\xBF" + kSmall, "t"));
  EXPECT_FALSE(parse_rig(with("\"small\"", "\"sm # \xC3\xBC\""), "t"));
}

TEST(Rig, KeepsNestedFaults) {
  const auto rig = parse_rig(kSmall + "[faults.deep]\n\"odd key\" = [1, [2.5, 'x']]\n", "t");
  ASSERT_TRUE(rig) << rig.error().message();
  const auto again = parse_rig(write_rig(*rig), "again");
  ASSERT_TRUE(again) << again.error().message() << rig->faults_toml;
  EXPECT_EQ(rig->faults_toml, again->faults_toml);
  EXPECT_NE(rig->faults_toml.find("odd key"), std::string::npos);
}

TEST(Rig, NamesTheLine) {
  const auto rig = parse_rig(with("side = \"M\"", "side = \"M\"\ncolour = 1"), "r.toml");
  ASSERT_FALSE(rig);
  EXPECT_NE(rig.error().where.find("line 8"), std::string::npos) << rig.error().message();
}

std::string rig_with_truth(const std::string& kind, const std::string& reference) {
  return "name = \"a\"\nreference = \"" + reference +
         "\"\n[[sensor]]\nname = \"chin\"\nkind = \"imu\"\nrole = \"face\"\n[[sensor]]\nname = "
         "\"phone\"\nkind = \"" +
         kind + "\"\nrole = \"truth\"\n";
}

TEST(Rig, ATruthIsOfWeightsAloneAndNoReference) {
  const Rig rig = parse_rig(rig_with_truth("weights", "chin"), "t").value();
  EXPECT_TRUE(rig.sensors[1].is_truth());
  EXPECT_TRUE(parse_rig(write_rig(rig), "t")->sensors[1].is_truth());
  EXPECT_EQ(kinds_of(rig), std::vector<std::string>{"imu"});
  EXPECT_TRUE(sensors_of(rig, "weights").empty());
  EXPECT_EQ(truths_of(rig), std::vector<std::uint16_t>{1});
  EXPECT_EQ(rig.face_sensors(), std::vector<std::uint16_t>{0});
  EXPECT_FALSE(parse_rig(rig_with_truth("imu", "chin"), "t"));
  EXPECT_FALSE(parse_rig(rig_with_truth("weights", "phone"), "t"));
}

TEST(Rig, BindingsThatAreWrittenStayWhenOneMoreIsBound) {
  Rig rig = with_bindings(parse_rig(rig_with_truth("weights", "chin"), "t").value()).value();
  EXPECT_EQ(rig.sensors[0].device, format_device({virtual_device(0), 0}));
  rig.sensors[1].device = "02:4D:49:50:48:00";
  EXPECT_EQ(bindings(rig)->front().first.device, virtual_device(0));
}

}  // namespace
}  // namespace mien::sensor::rig_test
