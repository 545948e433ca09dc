#include "lab/trackers/tracker_curves.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "lab/trackers/mediapipe_scores.h"
#include "lab/trackers/openseeface_log.h"
#include "mien/core/files.h"
#include "mien/face/livelink_csv.h"
#include "tests/folder.h"
#include "tests/performer/talking.h"

namespace mien::lab::tracker_curves_test {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kJaw = face::shape("jawOpen");

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

Result<TrackerCurves> parse(std::string_view text) {
  return parse_tracker_curves(bytes_of(text), "x");
}

/// The text is refused with this code, and words that the message has.
void expect_refused(std::string_view text, ErrorCode code, const std::string& words) {
  const auto read = parse(text);
  ASSERT_FALSE(read) << text.substr(0, 200);
  EXPECT_EQ(read.error().code, code) << read.error().message();
  EXPECT_THAT(read.error().message(), HasSubstr(words));
}

// --- MediaPipe ---------------------------------------------------------------------------------------------

TEST(MediapipeLines, AreReadAsPeopleDumpThem) {
  const auto read = parse(
      R"({"timestamp_ms": 33, "face_blendshapes": [[{"index": 0, "category_name": "_neutral", "score": 1e-5},)"
      R"({"category_name": "jawOpen", "score": 0.5}, {"category_name": "browInnerUp", "score": 0.25}]]})"
      "\n"
      R"({"timestampMs": 66, "faceBlendshapes": [{"categories": [{"categoryName": "jawOpen", "score": 1},)"
      R"({"categoryName": "browInnerUp", "score": 0}]}], "faceLandmarks": [[{"x": 1}]]})"
      "\n"
      R"({"timestamp_ms": 99, "face_blendshapes": []})"
      "\r\n\n"
      R"({"time_s": 0.132, "face_blendshapes": [{"jawOpen": 0.75, "browInnerUp": 0.5}, {"nobody": 2}]})"
      "\n"
      R"({"timestamp_ms": 165, "face_blendshapes": null})");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->rows.size(), 5U);
  EXPECT_DOUBLE_EQ(read->rows[0].time_s, 0.033);
  EXPECT_EQ(read->told.count(), 3U) << "browInnerUp is both sides";
  EXPECT_EQ((*read->rows[0].weights)[kJaw], 0.5F);
  EXPECT_EQ((*read->rows[0].weights)[face::shape("browInnerUp_R")], 0.25F);
  EXPECT_EQ((*read->rows[1].weights)[kJaw], 1.0F);
  EXPECT_FALSE(read->rows[2].weights);
  EXPECT_EQ((*read->rows[3].weights)[kJaw], 0.75F) << "the first face counts";
  EXPECT_FALSE(read->rows[4].weights);
  EXPECT_NEAR(read->period_s(), 0.033, 1e-9);
}

TEST(MediapipeLines, SayWhatIsWrongAndWhere) {
  const std::string good = R"({"timestamp_ms": 1, "face_blendshapes": [{"jawOpen": 0.5}]})";
  expect_refused(R"({"timestamp_ms": 1, "face_blendshapes": [{"jawOpn": 0.5}]})", ErrorCode::malformed,
                 "did you mean jawOpen?");
  expect_refused(good + "\n" + good + "\n", ErrorCode::malformed,
                 "line 2: the time 0.001000 s does not rise");
  expect_refused(R"({"timestamp_ms": 1, "face_blendshapes": [{"jawOpen": 50}]})", ErrorCode::out_of_range,
                 "divide percent by 100");
  expect_refused(R"({"timestamp_ms": 1, "face_blendshapes": [{"jawOpen": NaN}]})", ErrorCode::malformed,
                 "no JSON object");
  expect_refused(R"({"face_blendshapes": []})", ErrorCode::malformed, "no time");
  expect_refused(R"({"timestamp_ms": "1", "face_blendshapes": []})", ErrorCode::malformed, "is no number");
  expect_refused(R"({"timestamp_ms": 1e300, "face_blendshapes": []})", ErrorCode::out_of_range, "the time");
  expect_refused(R"({"timestamp_ms": 1})", ErrorCode::malformed, "face_blendshapes");
  expect_refused(R"({"timestamp_ms": 1, "face_blendshapes": [7]})", ErrorCode::malformed, "no list");
  expect_refused(R"({"timestamp_ms": 1, "face_blendshapes": [[]]})", ErrorCode::malformed, "no blendshape");
  expect_refused(R"({"timestamp_ms": 1, "face_blendshapes": [[{"category_name": "jawOpen"}]]})",
                 ErrorCode::malformed, "no score");
  expect_refused(R"({"timestamp_ms": 1, "face_blendshapes": [[{"category_name": "jawOpen", "score": 0},)"
                 R"({"category_name": "JawOpen", "score": 0}]]})",
                 ErrorCode::malformed, "told twice");
  expect_refused(good + "\n" + R"({"timestamp_ms": 2, "face_blendshapes": [{"mouthPucker": 0.5}]})" + "\n",
                 ErrorCode::malformed, "the same names");
  expect_refused(good + "\nnothing\n" + good, ErrorCode::malformed, "line 2");
  expect_refused(
      R"({"timestamp_ms": 1, "face_blendshapes": )" + std::string(100, '[') + std::string(100, ']') + "}",
      ErrorCode::malformed, "no JSON object");
}

TEST(MediapipeLines, ALastLineThatIsCutShortIsLeftOut) {
  const std::string good = R"({"timestamp_ms": 1, "face_blendshapes": [{"jawOpen": 0.5}]})";
  const auto read = parse(good + "\n" + R"({"timestamp_ms": 2, "face_bl)");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->rows.size(), 1U);
  EXPECT_EQ(read->warnings.size(), 1U);
}

// --- Tables of scores --------------------------------------------------------------------------------------

TEST(ScoresCsv, HasItsTimeInSecondsOrMilliseconds) {
  const auto read = parse("frame,timestamp_ms,jawOpen,_neutral,cheekPuff\n0,10,0.5,0,0.25\n1,20,,,\n");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->rows.size(), 2U);
  EXPECT_DOUBLE_EQ(read->rows[0].time_s, 0.01);
  EXPECT_EQ(read->told.count(), 3U);
  EXPECT_EQ((*read->rows[0].weights)[face::shape("cheekPuff_L")], 0.25F);
  EXPECT_FALSE(read->rows[1].weights) << "no score is a gap";
  EXPECT_DOUBLE_EQ(parse("Time_s,JawOpen\n2.5,1\n")->rows[0].time_s, 2.5);
}

TEST(ScoresCsv, SaysWhatIsWrongAndWhere) {
  expect_refused("time_s,jawOpn\n0,1\n", ErrorCode::malformed, "line 1: no shape is called 'jawOpn'");
  expect_refused("time_s,jawOpn\n0,1\n", ErrorCode::malformed, "did you mean jawOpen?");
  expect_refused("time_s,timestamp_ms,jawOpen\n0,1,1\n", ErrorCode::malformed, "two columns are times");
  expect_refused("time_s,frame\n0,1\n", ErrorCode::malformed, "no column is a shape");
  expect_refused("time_s,jawOpen,jawOpen\n0,1,1\n", ErrorCode::malformed, "told twice");
  expect_refused("time_s,jawOpen\n0,1,1\n", ErrorCode::malformed, "line 2: the row has 3 cells");
  expect_refused("time_s,jawOpen\n0,nan\n", ErrorCode::out_of_range, "line 2, column 2");
  expect_refused("time_s,jawOpen\n0,inf\n", ErrorCode::out_of_range, "no score");
  expect_refused("time_s,jawOpen,jawLeft\n0,1,\n", ErrorCode::malformed, "some scores");
  expect_refused("time_s,jawOpen\n,1\n", ErrorCode::malformed, "no time");
  expect_refused("time_s,jawOpen\n1,1\n0,1\n", ErrorCode::malformed, "does not rise");
  expect_refused("time_s,jawOpen\n", ErrorCode::truncated, "no row");
}

TEST(ScoresCsv, ComesBackToTheBit) {
  TrackerCurves curves{.name = "x", .rows = {}, .told = {}, .warnings = {}};
  curves.told.set(kJaw);
  curves.told.set(face::shape("eyeBlink_L"));
  for (int f = 0; f < 20; ++f) {
    TrackerRow row{.time_s = 1e9 + f / 30.0, .weights = {}};
    if (f % 7 != 3) {
      row.weights.emplace();
      (*row.weights)[kJaw] = 0.1F * static_cast<float>(std::sin(f));
      (*row.weights)[face::shape("eyeBlink_L")] = static_cast<float>(f) / 19;
    }
    curves.rows.push_back(row);
  }
  const auto again = parse(format_scores_csv(curves));
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(again->told, curves.told);
  ASSERT_EQ(again->rows.size(), curves.rows.size());
  for (std::size_t i = 0; i < curves.rows.size(); ++i) {
    EXPECT_EQ(again->rows[i].time_s, curves.rows[i].time_s);
    EXPECT_EQ(again->rows[i].weights, curves.rows[i].weights);
  }
}

// --- OpenSeeFace -------------------------------------------------------------------------------------------

OpenSeeFace smiling() {
  OpenSeeFace face;
  face.left_open = 0.25F;
  face[OpenSeeFeature::mouth_corner_updown_l] = -0.75F;
  face[OpenSeeFeature::mouth_corner_updown_r] = 0.5F;
  face[OpenSeeFeature::mouth_open] = 0.5F;
  face[OpenSeeFeature::mouth_wide] = -1.5F;
  face[OpenSeeFeature::eyebrow_updown_l] = 0.25F;
  face[OpenSeeFeature::eyebrow_updown_r] = -0.25F;
  return face;
}

std::vector<std::byte> recording(std::initializer_list<std::vector<std::byte>> blocks) {
  std::vector<std::byte> out;
  for (const auto& block : blocks) out.insert(out.end(), block.begin(), block.end());
  return out;
}

TEST(OpenSeeFaceShapes, AreThoseThatItsFeaturesTell) {
  const face::BlendshapeWeights weights = weights_of(smiling());
  const auto is = [&](const char* name, float weight) {
    EXPECT_FLOAT_EQ(weights[face::shape_index(name)], weight) << name;
    EXPECT_TRUE(openseeface_told()[face::shape_index(name)]) << name;
  };
  is("eyeBlink_L", 0.75F);
  is("eyeBlink_R", 0);
  is("mouthSmile_L", 0.75F);
  is("mouthFrown_L", 0);
  is("mouthSmile_R", 0);
  is("mouthFrown_R", 0.5F);
  is("jawOpen", 0.5F);
  is("mouthPucker", 1);
  is("mouthStretch_L", 0);
  is("browInnerUp_L", 0.25F);
  is("browOuterUp_L", 0.25F);
  is("browDown_R", 0.25F);
  EXPECT_EQ(openseeface_told().count(), 16U);
}

TEST(OpenSeeFaceBlocks, AreFacesAndGapsOfTheLowestId) {
  const OpenSeeFace smile = smiling();
  EXPECT_EQ(openseeface_block(0, 0, true, smile).size(), kOpenSeeFaceBlockBytes);
  const auto read = parse_tracker_curves(
      recording({openseeface_block(1.7e9, 1, true, smile), openseeface_block(1.7e9, 0, true, smile),
                 openseeface_block(1.7e9 + 0.04, 0, false, smile),
                 openseeface_block(1.7e9 + 0.08, 0, true, OpenSeeFace())}),
      "x");
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->rows.size(), 3U);
  EXPECT_EQ(read->rows[0].time_s, 1.7e9);
  EXPECT_EQ(read->rows[0].weights, weights_of(smile));
  EXPECT_FALSE(read->rows[1].weights);
  EXPECT_EQ(read->told, openseeface_told());
  ASSERT_EQ(read->warnings.size(), 1U);
  EXPECT_THAT(read->warnings[0], HasSubstr("id 0"));
}

TEST(OpenSeeFaceBlocks, SayWhatIsWrongAndWhere) {
  const OpenSeeFace smile = smiling();
  const auto refused = [](std::vector<std::byte> bytes, ErrorCode code, const char* words) {
    const auto read = parse_openseeface_blocks(bytes, "x");
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, code);
    EXPECT_THAT(read.error().message(), HasSubstr(words));
  };
  refused({}, ErrorCode::truncated, "1785");
  auto block = openseeface_block(1, 0, true, smile);
  block.pop_back();
  refused(block, ErrorCode::truncated, "1784");
  block = openseeface_block(1, 0, true, smile);
  block[28] = std::byte{2};
  refused(block, ErrorCode::malformed, "block 1: success is 2");
  OpenSeeFace broken = smile;
  broken[OpenSeeFeature::mouth_wide] = std::numeric_limits<float>::quiet_NaN();
  refused(openseeface_block(1, 0, true, broken), ErrorCode::out_of_range, "mouth_wide");
  broken = smile;
  broken.right_open = std::numeric_limits<float>::infinity();
  refused(openseeface_block(1, 0, true, broken), ErrorCode::out_of_range, "an eye");
  refused(openseeface_block(std::numeric_limits<double>::quiet_NaN(), 0, true, smile),
          ErrorCode::out_of_range, "the time");
  refused(recording({openseeface_block(2, 0, true, smile), openseeface_block(1, 0, true, smile)}),
          ErrorCode::malformed, "block 2");

  auto cut = recording({openseeface_block(1, 0, true, smile), openseeface_block(2, 0, true, smile)});
  cut.resize(cut.size() - 1);
  const auto read = parse_openseeface_blocks(cut, "x");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->rows.size(), 1U);
  EXPECT_EQ(read->warnings.size(), 1U);
}

/// As facetracker.py writes it: the header has fewer points than the rows.
std::string log_header(bool features) {
  std::string out =
      "Frame,Time,Width,Height,FPS,Face,FaceID,RightOpen,LeftOpen,AverageConfidence,Success3D,PnPError";
  for (int i = 12; i < 25 + 66 * 6; ++i) out += ",c" + std::to_string(i);
  for (std::size_t i = 0; features && i < kOpenSeeFeatureCount; ++i)
    out += "," + std::string(kOpenSeeFeatureNames[i]);
  return out + "\r\n";
}
std::string log_row(double time_s, const char* success, bool features) {
  std::string out = "7," + std::to_string(time_s) + ",640,360,24,0,0,1.0,0.25,0.9," + success + ",3.5";
  for (int i = 12; i < 25 + 68 * 3 + 70 * 3; ++i) out += ",0.5";
  for (std::size_t i = 0; features && i < kOpenSeeFeatureCount; ++i)
    out += "," + std::to_string(smiling().features[i]);
  return out + "\r\n";
}

TEST(OpenSeeFaceCsv, HasFeaturesInTheLastCellsOrNone) {
  const auto read = parse(log_header(true) + log_row(10, "True", true) + log_row(10.04, "False", true));
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->rows.size(), 2U);
  EXPECT_EQ(read->rows[0].weights, weights_of(smiling()));
  EXPECT_FALSE(read->rows[1].weights);
  EXPECT_EQ(read->told, openseeface_told());

  const auto older = parse(log_header(false) + log_row(10, "True", false));
  ASSERT_TRUE(older) << older.error().message();
  EXPECT_EQ(older->told, openseeface_lids());
  EXPECT_FLOAT_EQ((*older->rows[0].weights)[face::shape("eyeBlink_L")], 0.75F);
}

TEST(OpenSeeFaceCsv, SaysWhatIsWrongAndWhere) {
  expect_refused("Frame,RightOpen,LeftOpen\n1,1,1\n", ErrorCode::malformed, "no Time column");
  expect_refused(log_header(true), ErrorCode::truncated, "no row");
  expect_refused(log_header(true) + log_row(1, "True", false), ErrorCode::malformed, "line 2: the row has");
  expect_refused(log_header(true) + log_row(1, "Perhaps", true), ErrorCode::malformed, "Success3D");
  expect_refused(log_header(true) + log_row(2, "True", true) + log_row(1, "True", true), ErrorCode::malformed,
                 "does not rise");
  std::string wrong = log_row(1, "True", true);
  wrong.replace(wrong.find("0.25"), 4, "none");
  expect_refused(log_header(true) + wrong, ErrorCode::malformed, "LeftOpen is 'none'");
}

// --- Live Link, and all of them ----------------------------------------------------------------------------

TEST(LiveLinkCurves, TellWhatHasAColumnAtItsTimeCode) {
  face::Motion motion = performer::test::talking(6);
  motion.frames[3].has_face = false;
  const auto read = parse(face::format_livelink_csv(face::livelink_from_motion(motion)));
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->rows.size(), 6U);
  EXPECT_FALSE(read->rows[3].weights);
  EXPECT_NEAR((*read->rows[4].weights)[kJaw], motion.frames[4].weights[kJaw], 1e-6);
  EXPECT_EQ(read->told.count(), face::kShapeCount);

  const auto few = parse("Timecode,BlendshapeCount,JawOpen,BrowInnerUp\n00:00:02:00.000,2,0.5,0.25\n");
  ASSERT_TRUE(few) << few.error().message();
  EXPECT_EQ(few->told.count(), 3U);
  EXPECT_DOUBLE_EQ(few->rows[0].time_s, 2);
  EXPECT_EQ(counted_from_start(*few).rows[0].time_s, 0);
}

TEST(TrackerCurvesFile, IsReadByItsContent) {
  const mien::test::Folder folder;
  ASSERT_TRUE(write_file(folder / "webcam.txt", "time_s,jawOpen\n0,1\n"));
  const auto read = read_tracker_curves(folder / "webcam.txt");
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->name, "webcam");

  ASSERT_TRUE(write_file(folder / "lost.csv", "time_s,jawOpen\n0,\n"));
  EXPECT_EQ(read_tracker_curves(folder / "lost.csv").error().code, ErrorCode::not_found);
  EXPECT_EQ(read_tracker_curves(folder / "none.csv").error().code, ErrorCode::not_found);
  EXPECT_EQ(read_tracker_curves(folder.path()).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(read_tracker_curves("a.mien").error().code, ErrorCode::bad_usage);
  expect_refused("", ErrorCode::truncated, "nothing in it");
  expect_refused("hello, world\n", ErrorCode::unsupported, "time_s");
}

}  // namespace
}  // namespace mien::lab::tracker_curves_test
