#include "mien/face/livelink_csv.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <numbers>

#include "mien/core/files.h"
#include "mien/core/random.h"
#include "tests/folder.h"
#include "tests/project_path.h"

namespace mien::face::livelink_csv_test {
namespace {

using ::testing::HasSubstr;

constexpr std::array<std::string_view, 9> kAngles = {"HeadYaw",     "HeadPitch",     "HeadRoll",
                                                     "LeftEyeYaw",  "LeftEyePitch",  "LeftEyeRoll",
                                                     "RightEyeYaw", "RightEyePitch", "RightEyeRoll"};

std::string header(ArkitOrder order, bool pascal, const std::string& count = "BlendShapeCount") {
  std::string line = "Timecode," + count;
  for (std::string name : arkit52(order).shapes) {
    if (pascal) name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
    line += "," + name;
  }
  for (const std::string_view angle : kAngles) line += fmt::format(",{}", angle);
  return line + "\n";
}

/// A row in which the column of the ARKit index i (live_link_udp) holds i / 100, and angle j holds j / 10 -
/// 0.4.
std::string row(const std::string& timecode, ArkitOrder order) {
  std::string line = timecode + ",61";
  for (const std::string& name : arkit52(order).shapes)
    line += fmt::format(",{:.10f}", static_cast<double>(arkit_index(name)) / 100);
  for (std::size_t j = 0; j < 9; ++j) line += fmt::format(",{:.10f}", static_cast<double>(j) / 10 - 0.4);
  return line + "\n";
}

std::string take(const std::vector<std::string>& timecodes) {
  std::string text = header(ArkitOrder::live_link_csv, true);
  for (const std::string& timecode : timecodes)
    text +=
        timecode.find(',') == std::string::npos ? row(timecode, ArkitOrder::live_link_csv) : timecode + "\n";
  return text;
}

LiveLinkCsv parsed(const std::string& text) {
  auto csv = parse_livelink_csv(text, "test.csv");
  EXPECT_TRUE(csv) << csv.error().message();
  return csv ? *csv : LiveLinkCsv{};
}

TEST(LiveLinkCsv, ReadsEveryHeaderByItsNames) {
  struct Variant {
    ArkitOrder order;
    bool pascal;
    const char* count;
    bool right_first;
  };
  for (const Variant& v : {Variant{ArkitOrder::live_link_csv, true, "BlendShapeCount", false},
                           Variant{ArkitOrder::live_link_csv, true, "BlendshapeCount", false},
                           Variant{ArkitOrder::live_link_csv_right, false, "BlendShapeCount", true},
                           Variant{ArkitOrder::alphabetical, false, "blendshapecount", false}}) {
    const LiveLinkCsv csv = parsed(header(v.order, v.pascal, v.count) + row("00:00:01:02.500", v.order));
    ASSERT_EQ(csv.rows.size(), 1U);
    EXPECT_EQ(csv.right_first, v.right_first);
    EXPECT_TRUE(csv.warnings.empty());
    for (std::size_t i = 0; i < 52; ++i) EXPECT_EQ(csv.rows[0].values[i], static_cast<double>(i) / 100) << i;
    EXPECT_NEAR(csv.rows[0].values[52], -0.4, 1e-10);
    EXPECT_NEAR(csv.rows[0].values[60], 0.4, 1e-10);
    EXPECT_EQ(csv.rows[0].timecode, (Timecode{0, 0, 1, 2500}));
  }
}

TEST(LiveLinkCsv, SurvivesLineEndsMarksSpacesAndBlankLines) {
  std::string text = "\xEF\xBB\xBF" + take({"00:00:00:00.000", "00:00:00:02.000"});
  std::string windows;
  for (const char c : text)
    windows += c == '\n' ? std::string("\r\n") : c == ',' ? std::string(" , ") : std::string(1, c);
  windows += "\r\n\r\n";
  EXPECT_EQ(parsed(windows).rows.size(), 2U);
  text.pop_back();
  EXPECT_EQ(parsed(text).rows.size(), 2U) << "a last row without a line end";
  EXPECT_EQ(
      parsed(take({"00:00:00:00.000"}) + row("00:00:00:02.000", ArkitOrder::live_link_csv).insert(0, ""))
          .rows.size(),
      2U);
}

TEST(LiveLinkCsv, ALostFaceIsARowOfTwoCells) {
  const LiveLinkCsv csv = parsed(take({"16:48:52:27.134", "16:48:52:29.134,0", "16:48:52:31.134"}));
  ASSERT_EQ(csv.rows.size(), 3U);
  EXPECT_TRUE(csv.rows[0].has_face());
  EXPECT_FALSE(csv.rows[1].has_face());
  const LiveLinkMotion loaded = motion_from_livelink(csv, "lost");
  ASSERT_EQ(loaded.motion.frames.size(), 3U);
  EXPECT_FALSE(loaded.motion.frames[1].has_face);
  EXPECT_NEAR(loaded.motion.frames[2].time_s, 4 / 60.0, 1e-9) << "31 is beyond 30: the base is 60";
  // Counting none in a full row says the same.
  std::string zero = row("16:48:52:33.134", ArkitOrder::live_link_csv);
  zero.replace(zero.find(",61,"), 4, ",0,");
  EXPECT_FALSE(parsed(take({"16:48:52:31.134"}) + zero).rows[1].has_face());
}

TEST(LiveLinkCsv, ARecordingThatEndsInTheMiddleOfARowIsGoodUpToThere) {
  const std::string whole = take({"00:00:00:00.000", "00:00:00:02.000"});
  const std::size_t second = whole.rfind("00:00:00:02.000");
  for (std::size_t end = second + 1; end + 4 < whole.size(); ++end) {
    const auto csv = parse_livelink_csv(std::string_view(whole).substr(0, end), "cut.csv");
    ASSERT_TRUE(csv) << end << ": " << csv.error().message();
    // A row whose last cell is there may have lost only its decimals' end.
    if (csv->rows.size() == 1U) {
      EXPECT_EQ(csv->warnings.size(), 1U) << end;
    }
  }
  EXPECT_EQ(parsed(take({"00:00:00:00.000"}) + "00:00:00:02.000,61").rows.size(), 1U);
  EXPECT_EQ(parsed(take({"00:00:00:00.000"}) + "00:00:00:02.000,0").rows.size(), 2U);
}

TEST(LiveLinkCsv, MissingAndUnknownColumnsAreTold) {
  const LiveLinkCsv csv = parsed("Timecode,BlendShapeCount,JawOpen,Mood\n00:00:00:00.000,2,0.5,0.9\n");
  ASSERT_EQ(csv.rows.size(), 1U);
  EXPECT_EQ(csv.rows[0].values[arkit_index("jawOpen")], 0.5);
  EXPECT_EQ(csv.rows[0].values[arkit_index("mouthClose")], 0);
  ASSERT_EQ(csv.warnings.size(), 2U);
  EXPECT_THAT(csv.warnings[0], HasSubstr("51 blendshapes"));
  EXPECT_EQ(csv.warnings[1], "the unknown column 'Mood' is left out");
}

TEST(LiveLinkCsv, AMisspeltColumnIsNamedAndSoIsWhatItLacks) {
  std::string text = take({"00:00:00:00.000"});
  text.replace(text.find("JawOpen"), 7, "Jaw\x1bpne");
  EXPECT_THAT(parsed(text).warnings,
              ::testing::ElementsAre("the blendshape jawOpen has no column and is taken as 0",
                                     "the unknown column 'Jaw?pne' is left out"));
}

TEST(LiveLinkCsv, ALastRowThatIsWholeIsHeldToWhatEveryRowIs) {
  const std::string begin = "Timecode,BlendShapeCount,JawOpen,MouthClose\n00:00:00:00.000,2,0.5,0\n";
  for (const char* last :
       {"00:00:00:02.000,2,0.5,nan", "00:00:00:02.000,2,0.5,inf", "00:00:00:02.000,2,0.5,1e30",
        "00:00:00:02.000,2,0.5,\x1b[31m", "00:00:00:02.000,2,nan,0.5", "00:00:00,2,0.5,0.5",
        "00:00:00:02.000,2,nan,-", "00:00:00:02.000,2,0.5,0.5,0.5"}) {
    const auto csv = parse_livelink_csv(begin + last, "bad.csv");
    ASSERT_FALSE(csv) << last;
    EXPECT_THAT(csv.error().where, HasSubstr("bad.csv, line 3")) << last;
  }
  for (const char* last : {"00:00:00:02.000,2,0.5,-", "00:00:00:02.000,2,0.5,1e", "00:00:00:02.000,2,0.5,1e-",
                           "00:00:00:02.000,2,0.5,", "00:00:00:02.000,2,0.5", "00:00:00:02.000,2", "00:0"}) {
    const LiveLinkCsv csv = parsed(begin + last);
    EXPECT_EQ(csv.rows.size(), 1U) << last;
    EXPECT_THAT(csv.warnings, ::testing::Contains("the last row, line 3, is cut short and left out")) << last;
  }
  EXPECT_EQ(parsed(begin + "00:00:00:02.000,2,0.5,0.5").rows.size(), 2U);
}

struct BadCsv {
  const char* what;
  std::string text;
  ErrorCode code;
  const char* place;
};

class LiveLinkCsvRefuses : public ::testing::TestWithParam<BadCsv> {};

TEST_P(LiveLinkCsvRefuses, WithOneLineThatNamesThePlace) {
  const auto csv = parse_livelink_csv(GetParam().text, "bad.csv");
  ASSERT_FALSE(csv);
  EXPECT_EQ(csv.error().code, GetParam().code) << csv.error().message();
  EXPECT_THAT(csv.error().where, HasSubstr(GetParam().place));
  EXPECT_EQ(csv.error().message().find('\n'), std::string::npos);
}

std::string with_value(const std::string& value) {
  return "Timecode,BlendShapeCount,JawOpen,MouthClose\n00:00:00:00.000,2,0.5," + value +
         "\n00:00:00:02.000,2,0,0\n";
}

INSTANTIATE_TEST_SUITE_P(
    LiveLinkCsv, LiveLinkCsvRefuses,
    ::testing::Values(
        BadCsv{"empty", "", ErrorCode::truncated, "bad.csv"},
        BadCsv{"blank", "\n\n\n", ErrorCode::truncated, "bad.csv"},
        BadCsv{"header_alone", header(ArkitOrder::live_link_csv, true), ErrorCode::truncated, "bad.csv"},
        BadCsv{"no_timecode", "BlendShapeCount,JawOpen\n61,0.5\n", ErrorCode::malformed, "line 1"},
        BadCsv{"no_shape", "Timecode,BlendShapeCount,HeadYaw\n00:00:00:00.000,1,0\n", ErrorCode::malformed,
               "line 1"},
        BadCsv{"doubled_column", "Timecode,JawOpen,jawopen\n00:00:00:00.000,0,0\n", ErrorCode::malformed,
               "line 1"},
        BadCsv{"something_else", "<html>\n<body>\n", ErrorCode::malformed, "line 1"},
        BadCsv{"too_many_columns", std::string(5000, ',') + "\n", ErrorCode::out_of_range, "bad.csv"},
        BadCsv{"nan", with_value("nan"), ErrorCode::out_of_range, "line 2, column 4"},
        BadCsv{"infinite", with_value("-inf"), ErrorCode::out_of_range, "line 2, column 4"},
        BadCsv{"huge", with_value("1e300"), ErrorCode::out_of_range, "line 2, column 4"},
        BadCsv{"beyond_a_double", with_value("1e999"), ErrorCode::out_of_range, "line 2, column 4"},
        BadCsv{"text", with_value("open"), ErrorCode::out_of_range, "line 2, column 4"},
        BadCsv{"two_numbers", with_value("0.5 0.5"), ErrorCode::out_of_range, "line 2, column 4"},
        BadCsv{"hole", "Timecode,JawOpen,MouthClose\n00:00:00:00.000,,0\n00:00:00:02.000,0,0\n",
               ErrorCode::out_of_range, "line 2, column 2"},
        BadCsv{"short_row", take({"00:00:00:00.000"}) + "00:00:00:02.000,61,0.5\n", ErrorCode::malformed,
               "line 3"},
        BadCsv{"long_row", with_value("0,0,0"), ErrorCode::malformed, "line 2"},
        BadCsv{"bad_count", "Timecode,BlendShapeCount,JawOpen\n00:00:00:00.000,-1,0\nx", ErrorCode::malformed,
               "line 2"},
        BadCsv{"minute_60", take({"00:60:00:00.000"}), ErrorCode::malformed, "line 2"},
        BadCsv{"no_frames", take({"00:00:00"}), ErrorCode::malformed, "line 2"},
        BadCsv{"negative_time", take({"00:00:-1:00.000"}), ErrorCode::malformed, "line 2"}),
    [](const auto& one) { return std::string(one.param.what); });

TEST(LiveLinkCsv, NoCellIsRepeatedWholeOrObeyed) {
  const auto refusal = [](const std::string& cell, std::size_t column) {
    std::string line = row("00:00:00:00.000", ArkitOrder::live_link_csv);
    std::size_t at = 0;
    for (std::size_t i = 0; i < column; ++i) at = line.find(',', at) + 1;
    line.replace(at, line.find(',', at) - at, cell);
    const auto csv = parse_livelink_csv(header(ArkitOrder::live_link_csv, true) + line + line, "test.csv");
    return csv ? std::string() : csv.error().message();
  };
  for (const std::size_t column : {0U, 5U}) {
    const std::string escape = refusal("\x1b]0;pwned\x07", column);
    EXPECT_THAT(escape, HasSubstr("'?]0;pwned?'"));
    std::string binary;
    for (int i = 0; i < 10'000; ++i) binary += static_cast<char>(i % 2 == 0 ? 0x80 + i % 64 : 1 + i % 8);
    const std::string cut = refusal(binary, column);
    EXPECT_THAT(cut, HasSubstr("'" + std::string(40, '?') + "...'"));
    EXPECT_LT(cut.size(), 150U);
  }
}

TEST(Timecode, TextAndNumbersAreTheSame) {
  for (const char* text : {"00:32:09:07.867", "23:59:59:59.999", "99:00:00:00.000"}) {
    const auto timecode = parse_timecode(text);
    ASSERT_TRUE(timecode);
    EXPECT_EQ(format_timecode(*timecode), text);
  }
  EXPECT_EQ(*parse_timecode("1:2:3:4"), (Timecode{1, 2, 3, 4000}));
  EXPECT_EQ(*parse_timecode("01:02:03;04.5"), (Timecode{1, 2, 3, 4500}));
  EXPECT_EQ(*parse_timecode("01:02:03:04.123999"), (Timecode{1, 2, 3, 4123}));
  for (const char* bad :
       {"", ":::", "1:2:3", "1:2:3:4:5", "a:b:c:d", "1:2:3:4.x", "100:0:0:0", "1:2:3:240", "+1:2:3:4"})
    EXPECT_FALSE(parse_timecode(bad)) << bad;
}

TEST(Timecode, TheBaseIs60UnlessTheFramesSayOtherwise) {
  const auto base = [](int largest) {
    LiveLinkCsv csv;
    for (int ff = 0; ff <= largest; ++ff) csv.rows.push_back({"", {0, 0, 0, 1000 * ff}, {}});
    return timecode_base(csv);
  };
  EXPECT_EQ(base(59), 60);
  EXPECT_EQ(base(58), 60);
  EXPECT_EQ(base(31), 60);
  EXPECT_EQ(base(29), 30);
  EXPECT_EQ(base(24), 25);
  EXPECT_EQ(base(23), 24);
  EXPECT_EQ(base(8), 60) << "a take of a few frames shows no whole second";
}

TEST(LiveLinkMotion, DroppedFramesKeepTheirTrueTime) {
  const LiveLinkMotion loaded =
      motion_from_livelink(parsed(take({"10:00:00:52.000", "10:00:00:54.010", "10:00:00:58.000",
                                        "10:00:01:00.000", "10:00:01:01.990"})),
                           "x");
  ASSERT_EQ(loaded.motion.frames.size(), 5U);
  EXPECT_TRUE(loaded.warnings.empty());
  EXPECT_EQ(loaded.motion.frames[0].time_s, 0);
  EXPECT_NEAR(loaded.motion.frames[1].time_s, 2.01 / 60, 1e-9);
  EXPECT_NEAR(loaded.motion.frames[2].time_s, 6 / 60.0, 1e-9) << "a frame is missing before it";
  EXPECT_NEAR(loaded.motion.frames[4].time_s, 9.99 / 60, 1e-9);
  EXPECT_NEAR(loaded.rate_hz, 30, 0.2);
}

TEST(LiveLinkMotion, CrossesMidnight) {
  const LiveLinkMotion loaded =
      motion_from_livelink(parsed(take({"23:59:59:58.000", "00:00:00:00.000", "00:00:00:02.000"})), "x");
  ASSERT_EQ(loaded.motion.frames.size(), 3U);
  EXPECT_NEAR(loaded.motion.frames[2].time_s, 4 / 60.0, 1e-6);
}

TEST(LiveLinkMotion, DoubledAndMisorderedRowsAreDroppedAndCounted) {
  const LiveLinkMotion loaded = motion_from_livelink(
      parsed(take({"00:00:00:00.000", "00:00:00:32.000", "00:00:00:32.000", "00:00:00:04.000",
                   "00:00:00:34.000", "05:00:00:00.000", "00:00:00:36.000", "00:00:00:38.000"})),
      "x");
  ASSERT_EQ(loaded.motion.frames.size(), 5U) << "one wrong row, even hours ahead, costs one row";
  for (std::size_t i = 1; i < 5; ++i)
    EXPECT_GT(loaded.motion.frames[i].time_s, loaded.motion.frames[i - 1].time_s);
  EXPECT_NEAR(loaded.motion.frames.back().time_s, 38 / 60.0, 1e-9);
  ASSERT_EQ(loaded.warnings.size(), 1U);
  EXPECT_THAT(loaded.warnings[0], HasSubstr("3 rows"));
}

TEST(LiveLinkMotion, HasAHeadOnlyWhereItsColumnsAreNotAllZero) {
  std::string text = "Timecode,BlendShapeCount,JawOpen,HeadYaw,HeadPitch,HeadRoll\n";
  EXPECT_FALSE(motion_from_livelink(parsed(text + "00:00:00:00.000,61,0.5,0,0,0\n"), "x").motion.has_head);
  EXPECT_TRUE(motion_from_livelink(parsed(text + "00:00:00:00.000,61,0.5,0,0.1,0\n"), "x").motion.has_head);
}

TEST(LiveLinkHead, AnglesAndQuaternionsAreInverse) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const Vec3 angles{random.uniform(-3, 3), random.uniform(-1.5, 1.5), random.uniform(-3, 3)};
    EXPECT_TRUE(livelink_from_head(head_from_livelink(angles)).isApprox(angles, 1e-9)) << angles.transpose();
  }
  for (const double pitch : {-std::numbers::pi / 2, std::numbers::pi / 2}) {
    const Quat q = head_from_livelink({0.3, pitch, 0.2});
    EXPECT_LT(angle_between(head_from_livelink(livelink_from_head(q)), q), 1e-6) << "straight up and down";
  }
}

TEST(LiveLinkHead, TurnsRightDownAndToTheRightShoulder) {
  EXPECT_LT((head_from_livelink({0.3, 0, 0}) * Vec3::UnitZ()).x(), -0.2);
  EXPECT_LT((head_from_livelink({0, 0.3, 0}) * Vec3::UnitZ()).y(), -0.2);
  EXPECT_LT((head_from_livelink({0, 0, 0.3}) * Vec3::UnitY()).x(), -0.2);
}

TEST(LiveLinkExport, AMotionComesBackAsItWas) {
  Random random(9);
  Motion motion;
  motion.has_head = true;
  for (int i = 0; i < 400; ++i) {
    MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = i / 60.0;
    frame.has_face = i < 100 || i > 130;
    if (!frame.has_face) continue;
    for (std::size_t k = 0; k < kShapeCount; ++k)
      frame.weights[k] = static_cast<float>(random.uniform(0, 1.1));
    frame.weights[shape("browInnerUp_R")] = frame.weights[shape("browInnerUp_L")];
    frame.weights[shape("cheekPuff_R")] = frame.weights[shape("cheekPuff_L")];
    frame.tongue_out = static_cast<float>(random.uniform());
    frame.head = head_from_livelink({random.normal(0, 0.3), random.normal(0, 0.2), random.normal(0, 0.1)});
  }
  EXPECT_EQ(format_livelink_csv(motion), format_livelink_csv(livelink_from_motion(motion)));
  const std::string text = format_livelink_csv(livelink_from_motion(motion, false));
  const LiveLinkMotion back = motion_from_livelink(parsed(text), "back");
  ASSERT_EQ(back.motion.frames.size(), motion.frames.size());
  EXPECT_TRUE(back.warnings.empty());
  EXPECT_TRUE(back.motion.has_head);
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    const MotionFrame& a = motion.frames[i];
    const MotionFrame& b = back.motion.frames[i];
    EXPECT_NEAR(b.time_s, a.time_s, 1e-9) << "60 Hz falls on whole time codes";
    ASSERT_EQ(b.has_face, a.has_face);
    if (!a.has_face) continue;
    EXPECT_LT(angle_between(a.head, b.head), 1e-8);
    for (std::size_t k = 0; k < kShapeCount; ++k)
      EXPECT_NEAR(b.weights[k], a.weights[k], 1e-9) << kShapeNames[k];
  }
}

TEST(LiveLinkExport, ClampsMouthCloseAndDerivesTheEyes) {
  Motion motion;
  MotionFrame& frame = motion.frames.emplace_back();
  frame.time_s = 59.9999999;  // Rounds up into the next minute, never to 59:60.
  frame.weights[shape("mouthClose")] = 0.5F;
  frame.weights[shape("jawOpen")] = 0.25F;
  frame.weights[shape("eyeLookIn_L")] = 1;
  frame.weights[shape("eyeLookDown_R")] = 0.5F;
  const LiveLinkCsv csv = livelink_from_motion(motion);
  EXPECT_EQ(csv.rows[0].timecode_text, "00:01:00:00.000");
  EXPECT_EQ(csv.rows[0].values[arkit_index("mouthClose")], 0.25);
  EXPECT_NEAR(csv.rows[0].values[55], 0.611, 1e-6);
  EXPECT_NEAR(csv.rows[0].values[59], 0.3055, 1e-6);
  EXPECT_EQ(livelink_from_motion(motion, false).rows[0].values[arkit_index("mouthClose")], 0.5);
}

class RealPerformance : public ::testing::TestWithParam<const char*> {
 protected:
  std::filesystem::path path() const {
    return std::filesystem::path(project_path("../shared/data/performances")) / GetParam();
  }
};

TEST_P(RealPerformance, ComesBackByteForByteAndHoldsItsTime) {
  if (!std::filesystem::exists(path()))
    GTEST_SKIP() << "no " << path() << ": the real performance is not here";
  const auto text = read_text(path());
  ASSERT_TRUE(text);
  const LiveLinkCsv csv = parsed(*text);
  EXPECT_TRUE(format_livelink_csv(csv) == *text) << "not the same bytes";
  EXPECT_EQ(timecode_base(csv), 60);
  const LiveLinkMotion loaded = motion_from_livelink(csv, "real");
  EXPECT_EQ(loaded.motion.frames.size(), csv.rows.size());
  EXPECT_FALSE(loaded.motion.has_head);
  EXPECT_NEAR(loaded.rate_hz, 30, 0.05);
  EXPECT_NEAR(loaded.motion.duration_s(), csv.rows.size() > 4000 ? 134.35 : 63.83, 0.2);
  double longest_s = 0;
  for (std::size_t i = 1; i < loaded.motion.frames.size(); ++i)
    longest_s = std::max(longest_s, loaded.motion.frames[i].time_s - loaded.motion.frames[i - 1].time_s);
  if (csv.rows.size() > 4000) {
    EXPECT_NEAR(longest_s, 0.0667, 0.002) << "dropped frames";
  }
}

INSTANTIATE_TEST_SUITE_P(LiveLinkCsv, RealPerformance,
                         ::testing::Values("alex_rom_3.csv", "second_person.csv"),
                         [](const auto& one) { return std::string(one.param).substr(0, 4); });

TEST(LoadMotion, TellsWhatIsWrongInOneLine) {
  EXPECT_EQ(load_motion("/nowhere/take.csv").error().code, ErrorCode::not_found);
  const mien::test::Folder folder;
  const auto file = folder / "mien_load_motion.csv";
  ASSERT_TRUE(write_file(file, take({"00:00:00:00.000,0", "00:00:00:02.000,0"})));
  EXPECT_EQ(load_motion(file).error().code, ErrorCode::not_found) << "a face in no row";
  ASSERT_TRUE(write_file(file, take({"00:00:00:00.000", "00:00:00:00.000"})));
  std::vector<std::string> warnings;
  const auto motion = load_motion(file, &warnings);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->name, "mien_load_motion");
  EXPECT_EQ(warnings.size(), 1U);
}

}  // namespace
}  // namespace mien::face::livelink_csv_test
